#include "benchmark/controllers/velocity_loop.hpp"

#include <cmath>

#include "sightline/base.hpp"

namespace sightline::benchmark {
namespace {

/// Rate of the heading (d_x, d_y) [rad/s].
double yaw_rate(const State& x, const State& rate) { return x[3] * rate[4] - x[4] * rate[3]; }

}  // namespace

VelocityLoop::VelocityLoop(const Model& model) : model_(model) {
  if (model.nx() == nx && model.nu() == nu) {
    State x{};
    model.at_rest({{0.0, 0.0, 1.0}, {1.0, 0.0}}, x.data());
    forward_ = rate(x.data(), {1, 0, 0, 0})[5];
    left_ = rate(x.data(), {0, 1, 0, 0})[6];
    up_ = rate(x.data(), {0, 0, 1, 0})[2];
    yaw_ = yaw_rate(x, rate(x.data(), {0, 0, 0, 1}));
  }
  const double all = forward_ * left_ * up_ * yaw_;
  if (!(std::abs(all) > 0))
    throw_invalid("robot = \"{}\" observes, expected multirotor, or hover_multirotor without lags",
                  model.name());
}

State VelocityLoop::rate(const double* x, const Input& u) const noexcept {
  State rate{};
  model_.f(x, u.data(), rate.data());
  return rate;
}

Input VelocityLoop::inputs(const double* x, const VelocityCommand& command,
                           double time_constant) const noexcept {
  Input u = {0.0, 0.0, command.up / up_, command.yaw / yaw_};
  const State free = rate(x, u);
  u[0] = ((command.forward - x[5]) / time_constant - free[5]) / forward_;
  u[1] = ((command.left - x[6]) / time_constant - free[6]) / left_;
  return u;
}

}  // namespace sightline::benchmark
