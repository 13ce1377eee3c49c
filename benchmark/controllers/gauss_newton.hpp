/// A small sequential-quadratic-programming MPC of one multirotor: Gauss-Newton steps on a sum of squares.
///
///   min over u   sum_k |r(x_k, u_k, x_{k+1})|^2   subject to   x_{k+1} = x_k + h f(x_k, u_k),  u_min <= u_k <= u_max
///
/// Each step solves the linearised problem by a Riccati sweep; the limits are handled stage by stage as in control-limited
/// DDP (Tassa, Mansard, Todorov, ICRA 2014). A line search makes the cost fall.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "benchmark/controllers/velocity_loop.hpp"
#include "sightline/solver.hpp"

namespace sightline::benchmark {

inline constexpr int residuals_max = 16;
using Residuals = std::array<double, residuals_max>;

/// The residuals of a stage; those that it does not use are 0.
class StageCost {
 public:
  virtual ~StageCost() = default;
  /// @param k  stage, for predictions at times k h and (k + 1) h
  virtual Residuals operator()(int k, const State& x, const Input& u, const State& next) const noexcept = 0;
};

class GaussNewton {
 public:
  GaussNewton(const VelocityLoop& robot, const Horizon& horizon);

  /// Makes `steps` steps from the plan of the last update.
  /// @return stepped; iteration_limit if a step did not lower the cost; not_finite
  Status update(const double* x, const StageCost& cost, const Input& u_min, const Input& u_max,
                int steps) noexcept;
  const Input& first() const noexcept { return u_.front(); }
  const std::vector<State>& states() const noexcept { return x_; }
  const std::vector<Input>& plan() const noexcept { return u_; }
  double cost() const noexcept { return value_; }
  void restart() noexcept;

 private:
  static constexpr int nz = nx + nu;
  struct Stage {
    Mat<nx, nx> A;
    Mat<nx, nu> B;
    Mat<residuals_max, nz> J;
    Mat<residuals_max, 1> r;
    Mat<nu, nx> gain;
    Mat<nu, 1> change;
  };

  State next(const State& x, const Input& u) const noexcept;
  double roll(const StageCost& cost, std::vector<State>& x, const std::vector<Input>& u) const noexcept;
  void linearise(int k, const StageCost& cost, Stage& stage) const noexcept;
  bool sweep(const Input& u_min, const Input& u_max) noexcept;

  const VelocityLoop* robot_;
  double h_;
  std::vector<State> x_, x_tried_;  // N + 1
  std::vector<Input> u_, u_tried_;  // N
  std::vector<Stage> stages_;
  double value_ = 0.0;
};

/// Minimises 1/2 d' H d + g' d within low <= d <= high by clamping: inputs at a limit that the gradient presses on are
/// fixed, the others solved again.
/// @param free  which inputs are not fixed
/// @return false if H is not positive definite
bool minimise_within(const Mat<nu, nu>& H, const Mat<nu, 1>& g, const Input& low, const Input& high,
                     Mat<nu, 1>& d, std::array<bool, nu>& free) noexcept;

}  // namespace sightline::benchmark
