#include "bridges/dds/simulators/ros2_rover.hpp"

#include <fmt/format.h>

#include <cmath>

#include "sightline/base/now.hpp"

extern "C" {
#include "ros.h"
}

namespace sightline::dds {
namespace {

constexpr double rover_lag = 0.1;                        // [s]
constexpr std::int64_t patience_of_rover = 500'000'000;  // [ns]
constexpr double fastest_rover = 10.0;                   // limit of a command [m/s]

}  // namespace

Ros2Rover::Ros2Rover(dds_entity_t participant, const Ros2Link& link, const Setup& setup, Faults& faults)
    : link_(link), setup_(setup), motion_(setup.start), odometry_(participant, link, setup.origin, faults) {
  const dds_topic_descriptor_t& type =
      link.stamped ? geometry_msgs_msg_dds__TwistStamped__desc : geometry_msgs_msg_dds__Twist__desc;
  cmd_vel_ = std::make_unique<RawReader>(
      participant, type, link.cmd_vel, of_ros_commands, std::nullopt, Writers::all,
      [this](const void* m, const Arrival&) {
        on_twist(link_.stamped ? &static_cast<const geometry_msgs_msg_dds__TwistStamped_*>(m)->twist : m);
      });
}

void Ros2Rover::on_twist(const void* twist) {
  const auto& t = *static_cast<const geometry_msgs_msg_dds__Twist_*>(twist);
  const std::scoped_lock lock(lock_);
  ++commands_;
  if (!(std::abs(t.linear.x) + std::abs(t.linear.y) + std::abs(t.angular.z) < fastest_rover)) {
    ++bad_;
    return;
  }
  v_wanted_ = {t.linear.x, setup_.sideward ? t.linear.y : 0.0};
  r_wanted_ = t.angular.z;
  commanded_at_ = monotonic_now();
}

void Ros2Rover::step(std::int64_t) {
  const std::scoped_lock lock(lock_);
  if (commanded_at_ > 0 && monotonic_now() - commanded_at_ > patience_of_rover) {
    stopped_itself_ = stopped_itself_ || norm(v_wanted_.x, v_wanted_.y) > 0;
    v_wanted_ = {}, r_wanted_ = 0.0;
  }
  const auto follow = [](double& now, double to) { now += period / rover_lag * (to - now); };
  follow(v_.x, v_wanted_.x), follow(v_.y, v_wanted_.y), follow(motion_.r, r_wanted_);
  const double turn = period * motion_.r;
  motion_.q = Quaternion{std::cos(turn / 2), 0, 0, std::sin(turn / 2)} * motion_.q;
  motion_.v = rotation(motion_.q).to_G({v_.x, v_.y, 0});
  motion_.p = motion_.p + period * motion_.v;
  odometry_.send(motion_);
}

Motion Ros2Rover::motion() const {
  const std::scoped_lock lock(lock_);
  return motion_;
}
std::int64_t Ros2Rover::commands() const {
  const std::scoped_lock lock(lock_);
  return commands_;
}
bool Ros2Rover::stopped_itself() const {
  const std::scoped_lock lock(lock_);
  return stopped_itself_;
}

std::string Ros2Rover::counts() const {
  const Motion m = motion();
  const std::scoped_lock lock(lock_);
  return fmt::format("{} cmd_vel ({} bad), at [{:.2f}, {:.2f}, {:.2f}] m{}", commands_, bad_, m.p.x, m.p.y,
                     m.p.z, stopped_itself_ ? ", stopped by itself" : "");
}

}  // namespace sightline::dds
