/// Agents of one model side by side in lanes: roll-out, Riccati factorisation and solves with it.
///
/// Trajectories are [stage][entry][lane]. The coupled Sight components (s) and the coupling
/// derivatives (c) are one array of the team; each group owns a part.
#pragma once

#include <algorithm>
#include <array>
#include <memory>

#include "sightline/base/transpose.hpp"
#include "sightline/formula/derive.hpp"
#include "sightline/solver/kernels/kernel.hpp"

namespace sightline {

class Group {
 public:
  Group(std::shared_ptr<const StagePrograms> programs, int stages, int width)
      : programs_(std::move(programs)), sizes_(programs_->sizes), stages_(stages), width_(width) {}
  virtual ~Group() = default;
  Group(const Group&) = delete;
  Group& operator=(const Group&) = delete;

  const StageSizes& sizes() const { return sizes_; }

  /// Assigns memory: `room()` doubles, aligned as Rows; must outlive the object. Call first.
  void settle(double* memory) noexcept {
    each_row([&](Rows& rows, int n, int packs) {
      rows = Rows(n, packs * width_, memory);
      memory += Rows::room(n, packs * width_);
    });
  }
  std::ptrdiff_t room() noexcept {
    std::ptrdiff_t sum = 0;
    each_row([&](Rows&, int n, int packs) { sum += Rows::room(n, packs * width_); });
    return sum;
  }

  /// One number of one agent: state of stage k; reference of stage k; 2 h Q, 2 h R, u*, rho; Q_f.
  double x(int k, int i, int lane) const { return *(x_[0] + at(k, sizes_.nx, i, lane)); }
  double& x(int k, int i, int lane) { return *(x_[0] + at(k, sizes_.nx, i, lane)); }
  double& x_ref(int k, int i, int lane) { return *(x_ref_[0] + at(k, sizes_.nx, i, lane)); }
  /// Whether all its agents use the reference of stage 0 at all stages; the others are then not
  /// read.
  void hold_reference(bool holds) { ref_stage_ = holds ? 0 : sizes_.nx * width_; }
  double& weight(int i, int lane) { return *(weights_[0] + at(0, 0, i, lane)); }
  double& Q_f(int i, int lane) { return *(Q_f_[0] + at(0, 0, i, lane)); }
  double& rho(int lane) { return weight(sizes_.nx + 2 * sizes_.nu, lane); }

  /// Copies the states of all stages of the agents in lanes 0 .. n - 1, each stage by stage.
  virtual void copy_states(double* const* to, std::ptrdiff_t stage, int n) const noexcept = 0;

  /// Tracking cost of each lane's agent along the trajectory, times h; the x_0 part is constant.
  virtual void tracking_costs(const double* u, double* of_lanes) const noexcept = 0;

  /// x of all stages from x of stage 0 under u; s of all stages but the last.
  virtual void roll_out(const double* u, double* s) noexcept = 0;
  /// Backward sweep at the trajectory of the last roll-out, with the couplings' gradients and
  /// Hessians c.
  /// @param H_u  h times the gradient of the Hamiltonian of all stages
  /// @param k    of the step du = -(k + K y), input of forward()
  /// @return whether all pivots reached their floor; pivots_shifted() identifies the other lanes
  virtual bool backward(const double* u, const double* held, const double* c, double* H_u,
                        double* k) noexcept = 0;
  bool pivots_shifted(int lane) const { return !(pivot_shift_[0][lane] <= 0.0); }
  /// Writes du over k of the backward sweep, and the change of s along the horizon.
  virtual void forward(double* du, double* ds) noexcept = 0;
  /// Solves with the last factorisation for the right side r in s.
  virtual void precondition(const double* r, double* du, double* ds) noexcept = 0;

 protected:
  std::ptrdiff_t at(int k, int n, int i, int lane) const {
    return (static_cast<std::ptrdiff_t>(k) * n + i) * width_ + lane;
  }

  std::shared_ptr<const StagePrograms> programs_;
  StageSizes sizes_;
  int stages_, width_;
  std::ptrdiff_t ref_stage_ = sizes_.nx * width_;  // stride of the reference between stages
  Rows x_, x_ref_, weights_, Q_f_, gain_, carry_, pivot_shift_;

 private:
  /// f(rows, number of rows, packs per row)
  template <class F>
  void each_row(F&& f) {
    f(x_, 1, (stages_ + 1) * sizes_.nx);
    f(x_ref_, 1, (stages_ + 1) * sizes_.nx);
    f(weights_, 1, sizes_.weights());
    f(Q_f_, 1, sizes_.nx);
    f(gain_, 1, stages_ * sizes_.gain());
    f(carry_, 2, sizes_.carry());
    f(pivot_shift_, 1, 1);
  }
};

/// Group that calls the functions of a kernel.
template <int W, class Kernel>
class StageGroup final : public Group {
 public:
  StageGroup(std::shared_ptr<const StagePrograms> programs, int stages)
      : Group(std::move(programs), stages, W), kernel_(*programs_) {}

  void roll_out(const double* u, double* s) noexcept override {
    const StageSizes n = kernel_.sizes();
    double* x = x_[0];
    std::copy_n(x, n.nx * W, carry_[0]);
    typename Kernel::State now(carry_[0]), next(carry_[1]);
    for (int k = 0; k < stages_; ++k, u += n.nu * W, s += n.ns * W) {
      x += n.nx * W;
      kernel_.step(now.numbers(), u, next.numbers(), s);
      next.store(x, n.nx * W);
      now.take(next);
    }
  }

  void copy_states(double* const* to, std::ptrdiff_t stage, int n) const noexcept override {
    const int nx = kernel_.sizes().nx, own = nx - kernel_.sizes().before;
    const double* from = x_[0];
    for (int k = 0; k <= stages_; ++k, from += nx * W) {
      if constexpr (W < 8) {  // too few lanes for a transposition
        for (int lane = 0; lane < n; ++lane)
          for (int i = 0; i < own; ++i) to[lane][k * stage + i] = from[i * W + lane];
      } else {
        for (int first = 0; first < own; first += W) {
          const int count = std::min(W, own - first);
          std::array<Lane<W>, static_cast<std::size_t>(W)> of{};
          for (int i = 0; i < count; ++i)
            of[static_cast<std::size_t>(i)] = Lane<W>::load(from + (first + i) * W);
          transpose(of);
          for (int lane = 0; lane < n; ++lane)
            store_first(of[static_cast<std::size_t>(lane)], count, to[lane] + k * stage + first);
        }
      }
    }
  }

  void tracking_costs(const double* u, double* of_lanes) const noexcept override {
    using L = Lane<W>;
    const StageSizes n = kernel_.sizes();
    const auto squares = [](const double* weights, const double* a, const double* b, int count, L sum) {
      for (int i = 0; i < count * W; i += W) {
        const L e = L::load(a + i) - L::load(b + i);
        sum += L::load(weights + i) * e * e;
      }
      return sum;
    };
    const double *const Q = weights_[0], *const R = Q + n.nx * W, *const u_ref = R + n.nu * W;
    const double *x = x_[0], *x_ref = x_ref_[0];
    L running = 0.0;
    for (int k = 0; k < stages_; ++k, x += n.nx * W, x_ref += ref_stage_, u += n.nu * W) {
      running = squares(Q, x, x_ref, n.nx, running);
      running = squares(R, u, u_ref, n.nu, running);
    }
    (L(0.5) * running + squares(Q_f_[0], x, x_ref, n.nx, 0.0)).store(of_lanes);
  }

  bool backward(const double* u, const double* held, const double* c, double* H_u,
                double* k_rows) noexcept override {
    const StageSizes n = kernel_.sizes();
    start_carry(carry_[0]);
    typename Kernel::Carry carry(carry_[0]), next(carry_[1]);
    for (int k = stages_ - 1; k > 0; --k) {
      kernel_.back(x_[0] + k * n.nx * W, u + k * n.nu * W, x_ref_[0] + k * ref_stage_, held + k * n.nu * W,
                   weights_[0], c + k * n.coupling() * W, carry.numbers(), H_u + k * n.nu * W,
                   gain_[0] + k * n.gain() * W, k_rows + k * n.nu * W, next.numbers());
      carry.take(next);
    }
    kernel_.back_first(x_[0], u, x_ref_[0], held, weights_[0], c, carry.numbers(), H_u, gain_[0], k_rows,
                       pivot_shift_[0]);
    bool sound = true;
    for (int l = 0; l < W; ++l) sound &= pivot_shift_[0][l] <= 0.0;
    return sound;
  }

  void forward(double* du, double* ds) noexcept override {
    const StageSizes n = kernel_.sizes();
    std::fill_n(carry_[0], n.nx * W, 0.0);
    typename Kernel::State y(carry_[0]), next(carry_[1]);
    for (int k = 0; k < stages_; ++k, du += n.nu * W) {
      kernel_.precondition_forward(y.numbers(), gain_[0] + k * n.gain() * W, du, du, next.numbers(),
                                   ds + k * n.ns * W);
      y.take(next);
    }
  }

  void precondition(const double* r, double* du, double* ds) noexcept override {
    const StageSizes n = kernel_.sizes();
    std::fill_n(carry_[0], n.nx * W, 0.0);
    typename Kernel::State p(carry_[0]), next(carry_[1]);
    for (int k = stages_ - 1; k >= 0; --k) {
      kernel_.precondition_back(p.numbers(), r + k * n.ns * W, gain_[0] + k * n.gain() * W, next.numbers(),
                                du + k * n.nu * W);
      p.take(next);
    }
    forward(du, ds);
  }

 private:
  /// Terminal values: lambda = 2 Q_f (x - x*), e = 0, P = 2 Q_f.
  void start_carry(double* carry) noexcept {
    const StageSizes n = kernel_.sizes();
    using L = Lane<W>;
    std::fill_n(carry, n.carry() * W, 0.0);
    double *const lambda = carry + W, *const P = carry + (1 + 2 * n.nx) * W;
    const double *const x = x_[0] + stages_ * n.nx * W, *const x_ref = x_ref_[0] + stages_ * ref_stage_;
    for (int i = 0; i < n.nx; ++i) {
      const L curvature = L(2.0) * L::load(Q_f_[0] + i * W);
      (curvature * (L::load(x + i * W) - L::load(x_ref + i * W))).store(lambda + i * W);
      curvature.store(P + upper_index(i, i, n.nx) * W);
    }
  }

  Kernel kernel_;
};

}  // namespace sightline
