#include "bridges/dds/simulators/simulated_poses.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sightline/base.hpp"
#include "sightline/base/now.hpp"
#include "sightline/scenario/starts.hpp"

extern "C" {
#include "ros.h"
}

namespace sightline::dds {
namespace {

using SentStamped = geometry_msgs_msg_dds__PoseStamped_;
using SentNamed = motion_capture_tracking_interfaces_msg_dds__NamedPose_;
using SentArray = motion_capture_tracking_interfaces_msg_dds__NamedPoseArray_;
using SentTransform = geometry_msgs_msg_dds__TransformStamped_;
using SentTransforms = tf2_msgs_msg_dds__TFMessage_;

constexpr Quality of_ros_nodes = {.reliable = true, .depth = 1};
constexpr Quality of_tf_nodes = {.reliable = true, .depth = 100}, of_static_tf_nodes = {true, true, 100};

geometry_msgs_msg_dds__Pose_ sent_pose(const Motion& m) {
  return {{m.p.x, m.p.y, m.p.z}, {m.q.x, m.q.y, m.q.z, m.q.w}};
}

std_msgs_msg_dds__Header_ sent_header(const std::string& frame, const RosTime& now) {
  return {{now.sec, now.nanosec}, const_cast<char*>(frame.c_str())};
}

SentTransform sent_transform(const std::string& parent, const std::string& child, const Motion& m,
                             const RosTime& now) {
  const geometry_msgs_msg_dds__Pose_ pose = sent_pose(m);
  return {sent_header(parent, now),
          const_cast<char*>(child.c_str()),
          {{pose.position.x, pose.position.y, pose.position.z}, pose.orientation}};
}

std::vector<BodyMotion> seen_motions(const Scenario& scenario) { return plant_options(scenario).motions; }

/// A sequence that refers to the elements of a vector.
template <class Sequence, class Item>
Sequence lent(std::vector<Item>& items) {
  Sequence sequence{};
  sequence._length = sequence._maximum = static_cast<std::uint32_t>(items.size());
  sequence._buffer = items.data();
  return sequence;
}

}  // namespace

struct SimulatedPoses::Ends {
  std::map<std::string, std::unique_ptr<RawWriter>> topics;  // of motion capture
  std::unique_ptr<RawWriter> tf, static_tf;
};

SimulatedPoses::SimulatedPoses(dds_entity_t participant, const Scenario& scenario)
    : x_(scenario.x0),
      u_(size(scenario.team.nu())),
      motions_(scenario.team, seen_motions(scenario), scenario.simulation.seed),
      ends_(std::make_unique<Ends>()) {
  const Team& team = scenario.team;
  const auto add = [&](BodyId body, int robot, const PosesFrom& from) {
    if (!from.by_others()) return;
    const std::size_t x = size(team.state_offset(body));
    seen_.push_back({std::string(team.name(body)), robot, x, from, {}});
    const Sight<double> start = sight_at_start(scenario, body);
    seen_.back().start = {start.p, upright(robot < 0 ? Vec2<double>{1, 0} : start.d), {}, 0.0};
    if (from.source == PoseSource::tf) {
      if (ends_->tf) return;
      ends_->tf =
          std::make_unique<RawWriter>(participant, tf2_msgs_msg_dds__TFMessage__desc, "/tf", of_tf_nodes);
      ends_->static_tf = std::make_unique<RawWriter>(participant, tf2_msgs_msg_dds__TFMessage__desc,
                                                     "/tf_static", of_static_tf_nodes);
      return;
    }
    std::unique_ptr<RawWriter>& writer = ends_->topics[from.topic];
    if (!writer)
      writer = std::make_unique<RawWriter>(
          participant,
          from.name.empty() ? geometry_msgs_msg_dds__PoseStamped__desc
                            : motion_capture_tracking_interfaces_msg_dds__NamedPoseArray__desc,
          from.topic, of_ros_nodes);
  };
  for (const Link& link : fleet_of(scenario).links) {
    add(link.robot, static_cast<int>(&link - fleet_of(scenario).links.data()), link.poses);
    if (motions_.empty()) continue;
    models_.emplace_back(team.model(link.robot));
    places_.push_back(size(team.state_offset(link.robot)));
  }
  for (const BodyLink& link : fleet_of(scenario).bodies) add(link.body, -1, link.poses);

  std::vector<SentTransform> starts;
  std::vector<std::string> frames;
  frames.reserve(seen_.size());
  for (const Seen& seen : seen_) {
    if (seen.from.source != PoseSource::tf) continue;
    frames.push_back(seen.name + "_start");
    starts.push_back(sent_transform(seen.from.frame, frames.back(), seen.start, to_ros(realtime_now())));
  }
  if (starts.empty()) return;
  SentTransforms message{};
  message.transforms = lent<decltype(message.transforms)>(starts);
  (void)ends_->static_tf->write(&message);
}

SimulatedPoses::~SimulatedPoses() = default;

Motion SimulatedPoses::motion_of(const Seen& seen, std::span<const Motion> robots) const {
  if (seen.robot >= 0) return robots[size(seen.robot)];
  const double* const x = &x_[seen.x];
  return {{x[0], x[1], x[2]}, upright({1, 0}), {}, 0.0};
}

void SimulatedPoses::step(double period, std::span<const Motion> robots) {
  if (seen_.empty()) return;
  for (std::size_t i = 0; i < models_.size(); ++i) models_[i].write(robots[i], &x_[places_[i]]);
  motions_.steer(time_, period, u_, x_);
  for (const Seen& seen : seen_) {
    if (seen.robot >= 0) continue;
    double* const x = &x_[seen.x];
    for (std::size_t k = 0; k < 3; ++k) x[k] += period * x[3 + k];
  }
  time_ += period;
  send(robots);
}

void SimulatedPoses::send(std::span<const Motion> robots) {
  const RosTime now = to_ros(realtime_now());
  for (const auto& [topic, writer] : ends_->topics) {
    std::vector<SentNamed> bodies;
    SentArray array{};
    for (const Seen& seen : seen_) {
      if (seen.from.topic != topic) continue;
      const auto pose = sent_pose(motion_of(seen, robots));
      if (seen.from.name.empty()) {
        const SentStamped message = {sent_header(seen.from.frame, now), pose};
        (void)writer->write(&message);
      } else {
        array.header = sent_header(seen.from.frame, now);
        bodies.push_back({const_cast<char*>(seen.from.name.c_str()), pose});
      }
    }
    array.poses = lent<decltype(array.poses)>(bodies);
    if (!bodies.empty()) (void)writer->write(&array);
  }
  std::vector<SentTransform> transforms;
  std::vector<std::string> frames;
  frames.reserve(seen_.size());
  for (const Seen& seen : seen_) {
    if (seen.from.source != PoseSource::tf) continue;
    frames.push_back(seen.name + "_start");
    // Relative to the frame of its start pose.
    const LinkOrigin start = {
        seen.start.p, std::atan2(heading(rotation(seen.start.q)).y, heading(rotation(seen.start.q)).x)};
    transforms.push_back(
        sent_transform(frames.back(), seen.from.name, in_local(start, motion_of(seen, robots)), now));
  }
  if (!transforms.empty()) {
    SentTransforms message{};
    message.transforms = lent<decltype(message.transforms)>(transforms);
    (void)ends_->tf->write(&message);
  }
  ++sent_;
}

std::string SimulatedPoses::counts() const {
  if (seen_.empty()) return {};
  std::vector<std::string> names;
  for (const Seen& seen : seen_) names.push_back(seen.name);
  return fmt::format("{} poses of each of {}", sent_, fmt::join(names, ", "));
}

}  // namespace sightline::dds
