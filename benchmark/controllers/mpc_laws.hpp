/// Two MPCs of one observer: with a perception cost, and with the view as a discrete-time control barrier function.
///
/// Perception: Falanga, Foehn, Lu, Scaramuzza, "PAMPC: Perception-aware model predictive control for quadrotors", IROS
/// 2018: costs of the projection s = (y / x, z / x) of the target and of its velocity s', beside those of tracking and
/// inputs, by one Gauss-Newton step for each update.
///
/// Barrier: Zeng, Zhang, Sreenath, "Safety-critical model predictive control with discrete-time control barrier function",
/// ACC 2021: h(x_{k+1}) >= (1 - gamma) h(x_k), here with a quadratic penalty.
///
/// Both know the target's position and velocity, and predict it with constant velocity.
#pragma once

#include "benchmark/controllers/gauss_newton.hpp"
#include "benchmark/controllers/observer_solver.hpp"

namespace sightline::benchmark {

/// What both have.
struct MpcOptions {
  double range = 4.0, height = 1.0, velocity = 0.3, input = 0.1, near = 10.0;

  template <class O>
  static constexpr auto common() {
    return Parameters{
        parameter("range", &O::range, "1/m", from_zero, "weight of the horizontal distance"),
        parameter("height", &O::height, "1/m", from_zero, "weight of the height"),
        parameter("velocity", &O::velocity, "s/m", from_zero, "weight of the relative velocity"),
        parameter("input", &O::input, "", above_zero, "weight of the inputs"),
        parameter("near", &O::near, "1/m", from_zero, "weight of distances below their limit")};
  }
};

struct PerceptionOptions : MpcOptions {
  double image = 2.0, image_velocity = 0.2, depth = 0.2;

  static constexpr auto parameters() {
    using O = PerceptionOptions;
    return common<O>() +
           Parameters{
               parameter("image", &O::image, "", from_zero, "weight of the projection s"),
               parameter("image_velocity", &O::image_velocity, "s", from_zero, "weight of s'"),
               parameter("depth", &O::depth, "m", above_zero, "width over which the depth is kept positive")};
  }
};

struct BarrierMpcOptions : MpcOptions {
  double gamma = 0.1, margin = 0.9, penalty = 20.0;

  static constexpr auto parameters() {
    using O = BarrierMpcOptions;
    return common<O>() +
           Parameters{parameter("gamma", &O::gamma, "", {1e-3, 1.0, "0.001 to 1"}, "of one stage"),
                      parameter("margin", &O::margin, "", {0.1, 1.0, "0.1 to 1"},
                                "share of the view's angle that the barrier allows"),
                      parameter("penalty", &O::penalty, "", from_zero, "weight of broken barriers")};
  }
};

/// (y / x, z / x) with the depth x replaced by (x + sqrt(x^2 + width^2)) / 2 > 0.
std::array<double, 2> projection(const Vec3<double>& p_S, double width);
/// How far h_next falls below (1 - gamma) h; 0 if it does not.
double barrier_shortfall(double h, double h_next, double gamma);

/// MPC of one observer. The weights of MpcOptions apply to both; a law adds its own residuals.
class MpcLaw : public ViewLaw, protected StageCost {
 public:
  Status inputs(const double* x, std::span<const Sight<double>> bodies,
                std::span<double> u) noexcept override;
  void restart() noexcept override { mpc_.restart(), begun_ = false; }
  const GaussNewton& mpc() const { return mpc_; }

 protected:
  MpcLaw(const Team& team, const Horizon& horizon, const ViewTask& task, const MpcOptions& options);

  /// A body (0: the target) from the state x at stage k.
  Relative seen(std::size_t body, int k, const State& x) const noexcept;
  /// The residuals 0 to 8: inputs, horizontal distance, height and relative velocity.
  Residuals tracking(int k, const Input& u, const State& next) const noexcept;

  ViewTask task_;
  std::size_t bodies() const noexcept { return bodies_.size(); }
  double h() const noexcept { return h_; }
  const MpcOptions& weights() const noexcept { return weights_; }

 private:
  MpcOptions weights_;
  VelocityLoop robot_;
  GaussNewton mpc_;
  Vec3<double> best_;
  Input u_min_{}, u_max_{};
  double h_;
  std::span<const Sight<double>> bodies_{};  // of the present update
  bool begun_ = false;
};

class PerceptionLaw final : public MpcLaw {
 public:
  PerceptionLaw(const Team& team, const Horizon& horizon, const ViewTask& task,
                const PerceptionOptions& options);

 private:
  Residuals operator()(int k, const State& x, const Input& u, const State& next) const noexcept override;
  PerceptionOptions options_;
};

class BarrierMpcLaw final : public MpcLaw {
 public:
  BarrierMpcLaw(const Team& team, const Horizon& horizon, const ViewTask& task,
                const BarrierMpcOptions& options);

 private:
  Residuals operator()(int k, const State& x, const Input& u, const State& next) const noexcept override;
  BarrierMpcOptions options_;
};

}  // namespace sightline::benchmark
