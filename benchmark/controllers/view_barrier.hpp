/// A tracking law behind a safety filter: control barrier functions of the field of view and the distances.
///
/// Ames, Xu, Grizzle, Tabuada, "Control barrier function based quadratic programs for safety critical systems", IEEE
/// TAC 62 (2017), with velocities as commands, as leader-follower work with a field of view has them (arXiv 2605.17533).
#pragma once

#include "benchmark/controllers/barrier_qp.hpp"
#include "benchmark/controllers/observer_solver.hpp"
#include "benchmark/controllers/velocity_loop.hpp"

namespace sightline::benchmark {

struct ViewBarrierOptions {
  double k_p = 1.0, k_yaw = 2.0, gamma = 2.0, tau = 0.3, v_max = 3.0, rho = 1e3;

  static constexpr auto parameters() {
    using O = ViewBarrierOptions;
    return Parameters{parameter("k_p", &O::k_p, "1/s", above_zero, "gain of the relative position"),
                      parameter("k_yaw", &O::k_yaw, "1/s", above_zero, "gain of the bearing"),
                      parameter("gamma", &O::gamma, "1/s", above_zero, "of h' >= -gamma h"),
                      parameter("tau", &O::tau, "s", above_zero, "time constant of the velocities"),
                      parameter("v_max", &O::v_max, "m/s", above_zero, "greatest commanded velocity"),
                      parameter("rho", &O::rho, "", above_zero, "weight of the squared slack")};
  }
};

/// A barrier h >= 0 of a body at q in V: h' = gradient' q'.
struct Barrier {
  double h;
  Vec3<double> gradient;  ///< by q
};
/// View: h = x - cos(alpha) |p_S|, with p_S = (x, y, z) the target in the sensor's frame S [m].
Barrier view_barrier(const SensorMount& mount, double alpha, const Vec3<double>& q);
/// Distance: h = |q|^2 - d^2 for sign 1, d^2 - |q|^2 for sign -1 [m^2].
Barrier distance_barrier(const Vec3<double>& q, double d, double sign);

/// h' >= -gamma h as a row for v = (forward, left, up, yaw rate), by the kinematics of V
///
///   q_x' = w_x - v_f + omega q_y,   q_y' = w_y - v_l - omega q_x,   q_z' = w_z - v_z
BarrierRow row_of(const Barrier& barrier, const Relative& body, double gamma);

class ViewBarrierLaw final : public ViewLaw {
 public:
  ViewBarrierLaw(const Team& team, const ViewTask& task, const ViewBarrierOptions& options);
  Status inputs(const double* x, std::span<const Sight<double>> bodies,
                std::span<double> u) noexcept override;

 private:
  ViewTask task_;
  ViewBarrierOptions options_;
  VelocityLoop loop_;
  Vec3<double> best_;
};

}  // namespace sightline::benchmark
