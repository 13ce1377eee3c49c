#include "bridges/dds/topics/goal_subscriber.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "bridges/dds/topics/conversion.hpp"
#include "sightline/base/now.hpp"
#include "sightline/safety/zone.hpp"

extern "C" {
#include "ros.h"
}

namespace sightline::dds {
namespace {

// An operator sends few messages, and none may be lost.
constexpr Quality of_goals = {.reliable = true, .depth = 1};

double seconds(const builtin_interfaces_msg_dds__Time_& from, const builtin_interfaces_msg_dds__Time_& to) {
  return to_seconds(of_ros(to.sec, to.nanosec) - of_ros(from.sec, from.nanosec));
}

/// Waypoint of a pose; its position is not finite if the pose has no valid attitude.
Waypoint waypoint_of(const geometry_msgs_msg_dds__Pose_& pose) {
  const auto& [p, o] = pose;
  const Quaternion q = normalised({o.w, o.x, o.y, o.z});
  if (q == no_attitude) return {.p = {std::nan(""), 0, 0}};
  const Vec2<double> d = heading(rotation(q));
  return {.p = {p.x, p.y, p.z}, .heading = std::atan2(d.y, d.x)};
}

bool is_finite(const Waypoint& w) { return std::isfinite(w.p.x + w.p.y + w.p.z + w.heading); }

}  // namespace

GoalSubscriber::GoalSubscriber(dds_entity_t participant, const GoalsFrom& from, const GoalSpace& space)
    : from_(from), space_(space) {
  if (!from.goal_topic.empty())
    goal_ = std::make_unique<RawReader>(participant, geometry_msgs_msg_dds__PoseStamped__desc,
                                        from.goal_topic, of_goals, std::nullopt, Writers::all,
                                        [this](const void* m, const Arrival&) { on_goal(m); });
  if (!from.path_topic.empty())
    path_ = std::make_unique<RawReader>(participant, nav_msgs_msg_dds__Path__desc, from.path_topic, of_goals,
                                        std::nullopt, Writers::all,
                                        [this](const void* m, const Arrival&) { on_path(m); });
}

bool GoalSubscriber::is_inside(const Vec3<double>& p) const noexcept {
  return std::abs(p.x) <= space_.world && std::abs(p.y) <= space_.world && p.z >= space_.floor &&
         p.z <= space_.ceiling &&
         std::all_of(space_.zones.begin(), space_.zones.end(),
                     [&](const Zone& zone) { return zone_reserve(zone, p) >= 0; });
}

void GoalSubscriber::on_goal(const void* message) {
  const auto& m = *static_cast<const geometry_msgs_msg_dds__PoseStamped_*>(message);
  if (from_.frame != text_in(m.header.frame_id)) return count_refusal(Refusal::frame);
  Message goal;
  goal.count = 1;
  goal.waypoints[0] = waypoint_of(m.pose);
  offer(goal);
}

void GoalSubscriber::on_path(const void* message) {
  const auto& m = *static_cast<const nav_msgs_msg_dds__Path_*>(message);
  if (from_.frame != text_in(m.header.frame_id)) return count_refusal(Refusal::frame);
  const std::span poses(m.poses._buffer, m.poses._length);
  if (poses.empty() || poses.size() > GoalTrack::path_most) return count_refusal(Refusal::length);
  Message path;
  for (const auto& pose : poses) {
    const std::string_view frame = text_in(pose.header.frame_id);
    if (!frame.empty() && from_.frame != frame) return count_refusal(Refusal::frame);
    Waypoint& next = path.waypoints[path.count];
    next = waypoint_of(pose.pose);
    next.after = seconds(m.header.stamp, pose.header.stamp);
    const double before = path.count > 0 ? path.waypoints[path.count - 1].after : 0.0;
    if (!(next.after > before)) return count_refusal(Refusal::times);
    ++path.count;
  }
  offer(path);
}

void GoalSubscriber::offer(const Message& message) noexcept {
  for (std::size_t i = 0; i < message.count; ++i) {
    if (!is_finite(message.waypoints[i])) return count_refusal(Refusal::not_finite);
    if (!is_inside(message.waypoints[i].p)) return count_refusal(Refusal::outside);
  }
  const std::scoped_lock lock(puts_);
  newest_.put(message);
}

void GoalSubscriber::pass_on(double t, GoalTrack& track) noexcept {
  const std::uint64_t count = newest_.count();
  if (count == passed_ || (passed_at_ >= 0 && t - passed_at_ < least_time) || !newest_.look(message_)) return;
  passed_ = count;
  passed_at_ = t;
  switch (track.add(t, std::span(message_.waypoints).first(message_.count))) {
    case GoalAnswer::taken:
      ++taken_;
      break;
    case GoalAnswer::too_fast:
      count_refusal(Refusal::too_fast);
      break;
    case GoalAnswer::full:
      count_refusal(Refusal::full);
      break;
  }
}

std::string GoalSubscriber::describe(Refusal why) const {
  switch (why) {
    case Refusal::not_finite:
      return "not finite, or without an attitude";
    case Refusal::frame:
      return fmt::format("in a frame that is not goal_frame, \"{}\"", from_.frame);
    case Refusal::outside:
      return fmt::format("outside |x|, |y| <= {} m, {} <= z <= {} m{}", space_.world, space_.floor,
                         space_.ceiling,
                         space_.zones.empty() ? "" : ", or on the wrong side of a [[safety.zone]]");
    case Refusal::times:
      return "a path whose stamps do not rise from that of its header";
    case Refusal::length:
      return fmt::format("a path that has not 1 to {} poses", GoalTrack::path_most);
    case Refusal::too_fast:
      return fmt::format("a path faster than {} m/s", GoalTrack::path_speed);
    case Refusal::full:
      return "one more than there is room for in a flight";
  }
  return {};
}

std::vector<std::string> GoalSubscriber::news() {
  std::vector<std::string> sentences;
  for (std::size_t i = 0; i < refusals; ++i) {
    const std::int64_t now = refused_[i];
    if (reported_[i] == 0 && now > 0)
      sentences.push_back(fmt::format("a goal is refused: {}", describe(static_cast<Refusal>(i))));
    reported_[i] = now;
  }
  return sentences;
}

std::string GoalSubscriber::counts() const {
  std::string text = fmt::format("{} goals taken", taken_.load());
  for (std::size_t i = 0; i < refusals; ++i)
    if (refused_[i] > 0)
      text += fmt::format(", {} refused: {}", refused_[i].load(), describe(static_cast<Refusal>(i)));
  return text;
}

}  // namespace sightline::dds
