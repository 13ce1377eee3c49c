/// Image-based visual servoing of one point, with its apparent size.
///
/// Chaumette, Hutchinson, "Visual servo control, part I", IEEE RAM 13 (2006): v = -lambda L^+ (s - s*), here with the
/// four velocities of a multirotor, and without knowledge of the target's velocity. The features are the image
/// coordinates and the logarithm of the depth, by the apparent size a of a target of size D: x = D / a.
#pragma once

#include "benchmark/controllers/observer_solver.hpp"
#include "benchmark/controllers/velocity_loop.hpp"

namespace sightline::benchmark {

struct VisualServoOptions {
  double lambda = 1.0, field = 0.8, turn = 1.0, sideward = 4.0, tau = 0.3, v_max = 3.0;

  static constexpr auto parameters() {
    using O = VisualServoOptions;
    return Parameters{
        parameter("lambda", &O::lambda, "1/s", above_zero, "decay rate of the features"),
        parameter("field", &O::field, "rad", acute_angle,
                  "half angle of the picture; beyond it the robot searches"),
        parameter("turn", &O::turn, "rad/s", above_zero, "yaw rate of the search, to the side last seen"),
        parameter("sideward", &O::sideward, "", above_zero,
                  "weight of the sideward velocity in L^+; of others 1"),
        parameter("tau", &O::tau, "s", above_zero, "time constant of the velocities"),
        parameter("v_max", &O::v_max, "m/s", above_zero, "greatest commanded velocity")};
  }
};

/// Features s = (y / x, z / x, ln x) of a point p_S in S.
Vec3<double> features(const Vec3<double>& p_S);
/// ds/dt = J v at a target at rest, v = (forward, left, up, yaw rate); from features and mount alone.
Mat<3, 4> interaction(const SensorMount& mount, const Vec3<double>& s);

class VisualServoLaw final : public ViewLaw {
 public:
  VisualServoLaw(const Team& team, const ViewTask& task, const VisualServoOptions& options);
  Status inputs(const double* x, std::span<const Sight<double>> bodies,
                std::span<double> u) noexcept override;
  void restart() noexcept override { side_ = 1.0; }

 private:
  ViewTask task_;
  VisualServoOptions options_;
  VelocityLoop loop_;
  Vec3<double> wanted_;  // s*
  double side_ = 1.0;    // of the target when it was last seen, 1: left
};

}  // namespace sightline::benchmark
