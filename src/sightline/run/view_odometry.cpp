#include "sightline/run/view_odometry.hpp"

#include <algorithm>
#include <cmath>

#include "sightline/base.hpp"
#include "sightline/model/state_roles.hpp"

namespace sightline {

OdometryFrame::OdometryFrame(const Model& model, const ViewTask& task)
    : model_(model),
      limits_(task.odometry),
      is_level_(task.motion.is_level),
      x_(size(model.nx())),
      no_inputs_(size(model.nu())) {
  const double drag = task.motion.drags().x, delay = limits_.delay;
  keeps_ = std::exp(-drag * delay);
  moves_ = drag > 0 ? (1 - keeps_) / drag : delay;
  const StateRoles roles = roles_of(model);
  position_ = roles.position, direction_ = roles.direction, angle_ = roles.angle;
  velocity_V_ = roles.velocity_V;
}

void OdometryFrame::begin(const PoseEstimate& pose) noexcept {
  turn_ = lift_ = 0.0;
  last_ = pose;
}

void OdometryFrame::follow(const PoseEstimate& pose) noexcept {
  const double elapsed = pose.stamp - last_.stamp;
  turn_ = wrap(turn_ - (pose.psi - last_.psi) + elapsed * pose.yaw_rate);
  lift_ += elapsed * pose.v.z - (pose.p.z - last_.p.z);  // its mean over the period that ended
  last_ = pose;
}

std::span<const double> OdometryFrame::carry(const PoseEstimate& pose, std::span<const double> now,
                                             std::span<const double> later) noexcept {
  const Sight<double> here = model_.sight(now.data(), no_inputs_.data()),
                      there = model_.sight(later.data(), no_inputs_.data());
  // What the velocity of the state lacks, in V of the prediction: it turns with V, or stays in G.
  Vec2<double> lacks = {pose.v.x - here.v.x, pose.v.y - here.v.y};
  if (!is_level_) lacks = rotate(there.d, rotate<double>({here.d.x, -here.d.y}, lacks));
  own_ = {there.p.x + moves_ * lacks.x, there.p.y + moves_ * lacks.y};
  const Vec2<double> lacks_V = rotate<double>({there.d.x, -there.d.y}, lacks);
  std::copy(later.begin(), later.end(), x_.begin());
  const auto add = [&](int state, double value) {
    if (state >= 0) x_[size(state)] += value;
  };
  add(velocity_V_[0], keeps_ * lacks_V.x), add(velocity_V_[1], keeps_ * lacks_V.y);
  add(position_[2], lift_), add(angle_, turn_);
  if (direction_[0] < 0) return x_;
  const Vec2<double> d =
      rotate<double>({std::cos(turn_), std::sin(turn_)}, {x_[size(direction_[0])], x_[size(direction_[1])]});
  x_[size(direction_[0])] = d.x, x_[size(direction_[1])] = d.y;
  return x_;
}

Vec3<double> OdometryFrame::place(const Vec3<double>& p, const Vec2<double>& slow) const noexcept {
  const Vec2<double> off = rotate<double>({std::cos(turn_), std::sin(turn_)}, {p.x - own_.x, p.y - own_.y});
  return {slow.x + off.x, slow.y + off.y, p.z + lift_};
}

double relative_sigma(const PoseEstimate& robot, const Vec3<double>& body) noexcept {
  const double x = body.x - robot.p.x, y = body.y - robot.p.y;
  const Mat<4, 4>& P = robot.P;
  const double variance =
      P(0, 0) + P(1, 1) + P(2, 2) + (x * x + y * y) * P(3, 3) + 2 * (x * P(1, 3) - y * P(0, 3));
  return std::sqrt(std::max(0.0, variance));
}

}  // namespace sightline
