#include "bridges/dds/links/ros2_link.hpp"

#include <fmt/format.h>

#include <cmath>
#include <string_view>

#include "bridges/dds/topics/seen_poses.hpp"
#include "sightline/base/now.hpp"

extern "C" {
#include "ros.h"
}

namespace sightline::dds {
namespace {

using RosOdometry = nav_msgs_msg_dds__Odometry_;

constexpr Nanoseconds ros_odometry_old = 500'000'000;
constexpr double stands = 0.05;  // slower is at rest [m/s], [rad/s]

bool is_wanted(const std::string& wanted, const char* frame) {
  return wanted.empty() || wanted == text_in(frame);
}

}  // namespace

Ros2LinkEnd::Ros2LinkEnd(Port participant, const Link& link)
    : ros2_(std::get<Ros2Link>(link.kind)), from_(link.poses), poses_(link.origin) {
  cmd_vel_ = std::make_unique<RawWriter>(
      participant,
      ros2_.stamped ? geometry_msgs_msg_dds__TwistStamped__desc : geometry_msgs_msg_dds__Twist__desc,
      ros2_.cmd_vel, of_ros_commands);
  if (from_.by_others()) {
    read_seen_poses(poses_, participant, from_, Attitude::needed);
    return;
  }
  if (from_.estimated()) poses_.keep_each(kept_motions);
  poses_.read_by(std::make_unique<RawReader>(participant, nav_msgs_msg_dds__Odometry__desc, ros2_.odometry,
                                             of_sensors, std::nullopt, Writers::first,
                                             [this](const void* m, const Arrival& a) { on_odometry(m, a); }));
}

void Ros2LinkEnd::on_odometry(const void* message, const Arrival& arrival) {
  const auto& m = *static_cast<const RosOdometry*>(message);
  if (!is_wanted(ros2_.frame, m.header.frame_id) || !is_wanted(ros2_.body_frame, m.child_frame_id)) {
    poses_.take_other_frame();
    return;
  }
  const auto& p = m.pose.pose.position;
  const auto& o = m.pose.pose.orientation;
  const auto& v = m.twist.twist.linear;  // in the body frame
  Motion local = {{p.x, p.y, p.z}, normalised({o.w, o.x, o.y, o.z}), {}, m.twist.twist.angular.z};
  local.v = rotation(local.q).to_G({v.x, v.y, v.z});
  const Nanoseconds sampled = of_ros(m.header.stamp.sec, m.header.stamp.nanosec);
  poses_.take(local, sampled, arrival.monotonic);
}

LinkFacts Ros2LinkEnd::facts(Nanoseconds now) noexcept {
  const Motion& m = poses_.newest().motion;
  const bool rests = norm(m.v) < stands && std::abs(m.r) < stands;
  if (stops_ && rests) ours_ = false;
  LinkFacts facts;
  facts.there = poses_.is_fresh(now, ros_odometry_old);
  facts.checked = received_ && !poses_.of_second_writer() && !poses_.in_other_frames();
  facts.armed = facts.airborne = ours_;
  facts.landed = !ours_;
  facts.contested = rivals_ > 0;
  facts.mode = ours_ ? AutopilotMode::offboard : AutopilotMode::other;
  return facts;
}

void Ros2LinkEnd::send(const LinkOutput& output, const Command& c, Nanoseconds) noexcept {
  if (output.request == Request::arm) ours_ = true;
  if (output.request == Request::land) stops_ = true;
  if (output.setpoint == Setpoint::none && output.request != Request::emergency) return;
  if (output.setpoint == Setpoint::task)
    steer({c.d.x * c.v_end.x + c.d.y * c.v_end.y, c.d.x * c.v_end.y - c.d.y * c.v_end.x, 0.0}, c.r);
  else
    steer({}, 0.0);
}

void Ros2LinkEnd::steer(const Vec3<double>& v, double r) noexcept {
  geometry_msgs_msg_dds__Twist_ twist{};
  twist.linear = {v.x, v.y, v.z};
  twist.angular.z = r;
  if (!ros2_.stamped) {
    (void)cmd_vel_->write(&twist);
    return;
  }
  static constexpr std::array<char, 10> frame = {"base_link"};
  const RosTime now = to_ros(realtime_now());
  geometry_msgs_msg_dds__TwistStamped_ stamped{};
  stamped.header.stamp.sec = now.sec;
  stamped.header.stamp.nanosec = now.nanosec;
  stamped.header.frame_id =
      const_cast<char*>(ros2_.body_frame.empty() ? frame.data() : ros2_.body_frame.c_str());
  stamped.twist = twist;
  (void)cmd_vel_->write(&stamped);
}

void Ros2LinkEnd::watch(std::span<const SeenWriter> writers) {
  received_ = cmd_vel_->matched() > 0;
  rivals_ = cmd_vel_->rivals(writers);
}

void Ros2LinkEnd::examine(const Surroundings& around, FindingList& to) {
  const bool own = !from_.by_others();
  if (own && poses_.reader().counts().received == 0)
    to.add(Aspect::topics, Light::red, "{}: no message, {}", poses_.reader().topic(),
           why_nothing_comes(poses_.reader(), around));
  if (!cmd_vel_->received(around.readers))
    to.add(Aspect::topics, Light::red, "{}: {}", cmd_vel_->topic(), why_stale(*cmd_vel_, around));
  if (own)
    poses_.examine("the frames that are expected", "other frames than frame, body_frame say", to);
  else
    poses_.examine("the frame that is G", other_frames_than(from_), to);
  to.add_green(Aspect::topics, "its poses arrive, it receives cmd_vel");
  if (cmd_vel_->rivals(around.writers) > 0)
    to.add(Aspect::writers, Light::red, "{}: another program writes to it", cmd_vel_->topic());
  to.add_green(Aspect::writers, "no other program publishes in its place or steers it");
}

}  // namespace sightline::dds
