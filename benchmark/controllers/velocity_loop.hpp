/// Inner loop of a multirotor (24): inputs that follow velocities in its frame V.
#pragma once

#include <array>
#include <span>

#include "sightline/model.hpp"

namespace sightline::benchmark {

/// States and inputs of (24), as multirotor and hover_multirotor without lags have them.
inline constexpr int nx = 7, nu = 4;
using State = std::array<double, nx>;
using Input = std::array<double, nu>;

/// Velocities forward, to the left and up [m/s], and the yaw rate to the left [rad/s].
struct VelocityCommand {
  double forward = 0.0, left = 0.0, up = 0.0, yaw = 0.0;
};

/// Robot of (24), whose gains are read from its formulas: climb and yaw rate follow their inputs at once,
/// v_f' = b_f u_f + ..., v_s' = -b_s u_s + ...
class VelocityLoop {
 public:
  /// @throws std::invalid_argument for another robot, with its name
  explicit VelocityLoop(const Model& model);

  const Model& model() const { return model_; }
  State rate(const double* x, const Input& u) const noexcept;
  /// Inputs with which v_f and v_s approach the command with the time constant [s]; not limited.
  Input inputs(const double* x, const VelocityCommand& command, double time_constant) const noexcept;

 private:
  Model model_;
  double forward_ = 0.0, left_ = 0.0, up_ = 0.0, yaw_ = 0.0;  // per input
};

}  // namespace sightline::benchmark
