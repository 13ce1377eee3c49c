#include "bridges/dds/simulators/ros2_odometry.hpp"

#include "sightline/base/now.hpp"

extern "C" {
#include "ros.h"
}

namespace sightline::dds {
namespace {

std::string or_else(const std::string& text, const char* fallback) { return text.empty() ? fallback : text; }

}  // namespace

Ros2Odometry::Ros2Odometry(dds_entity_t participant, const Ros2Link& link, const LinkOrigin& origin,
                           Faults& faults)
    : origin_(origin),
      faults_(faults),
      frame_(or_else(link.frame, "odom")),
      body_frame_(or_else(link.body_frame, "base_link")) {
  if (!link.odometry.empty())
    writer_ = std::make_unique<FaultyWriter>(participant, nav_msgs_msg_dds__Odometry__desc, link.odometry,
                                             Quality{.reliable = true, .depth = 1}, faults);
}

void Ros2Odometry::send(const Motion& motion) {
  if (!writer_) return;
  const Motion local = in_local(origin_, faults_.distorted(motion));
  const Vec3<double> v = rotation(local.q).to_B(local.v);
  const RosTime now = to_ros(realtime_now());
  nav_msgs_msg_dds__Odometry_ m{};
  m.header.stamp.sec = now.sec, m.header.stamp.nanosec = now.nanosec;
  m.header.frame_id = frame_.data(), m.child_frame_id = body_frame_.data();
  m.pose.pose.position = {local.p.x, local.p.y, local.p.z};
  m.pose.pose.orientation = {local.q.x, local.q.y, local.q.z, local.q.w};
  m.twist.twist.linear = {v.x, v.y, v.z};
  m.twist.twist.angular = {0, 0, motion.r};
  writer_->write(&m);
}

}  // namespace sightline::dds
