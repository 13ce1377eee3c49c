#include "bridges/dds/topics/seen_poses.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <mutex>
#include <set>

#include "bridges/dds/topics/transform_chain.hpp"

extern "C" {
#include "ros.h"
}

namespace sightline::dds {
namespace {

using RosHeader = std_msgs_msg_dds__Header_;
using RosPose = geometry_msgs_msg_dds__Pose_;
constexpr Quality of_tf = {.depth = 100}, of_static_tf = {true, true, 100};
constexpr std::size_t named_most = 16;  // names reported at most
const char* const too_seldom = "never four poses within 0.4 s";

Nanoseconds stamp_of(const RosHeader& header) { return of_ros(header.stamp.sec, header.stamp.nanosec); }

/// Accepts poses in one frame; in any frame if `frame` is empty.
struct PoseTaker {
  PoseSubscriber& subscriber;
  std::string frame;
  Attitude attitude;

  void operator()(const RosHeader& header, const RosPose& pose, const Arrival& arrival) const noexcept {
    if (!frame.empty() && frame != text_in(header.frame_id)) {
      subscriber.take_other_frame();
      return;
    }
    const auto& [p, q] = pose;
    subscriber.take_pose({p.x, p.y, p.z},
                         attitude == Attitude::ignored ? upright({1, 0}) : normalised({q.w, q.x, q.y, q.z}),
                         stamp_of(header), arrival.monotonic);
  }
};

/// Names received until the requested one arrives.
struct OtherNames {
  std::mutex lock;  // guards both
  std::set<std::string> names;
  bool found = false;
};

void read_named(PoseSubscriber& subscriber, dds_entity_t participant, const PosesFrom& from,
                Attitude attitude) {
  const auto others = std::make_shared<OtherNames>();
  subscriber.explain_by([others, name = from.name] {
    const std::scoped_lock lock(others->lock);
    if (others->found) return std::string(too_seldom);
    return others->names.empty()
               ? fmt::format("no body at all, expected \"{}\"", name)
               : fmt::format("no body \"{}\", there is {}", name, fmt::join(others->names, ", "));
  });
  using Array = motion_capture_tracking_interfaces_msg_dds__NamedPoseArray_;
  subscriber.read_by(std::make_unique<RawReader>(
      participant, motion_capture_tracking_interfaces_msg_dds__NamedPoseArray__desc, from.topic, of_sensors,
      std::nullopt, Writers::first,
      [others, name = from.name, take = PoseTaker{subscriber, from.frame, attitude}](const void* m,
                                                                                     const Arrival& a) {
        const auto& array = *static_cast<const Array*>(m);
        const std::span bodies(array.poses._buffer, array.poses._length);
        const auto body = std::find_if(bodies.begin(), bodies.end(),
                                       [&](const auto& named) { return name == text_in(named.name); });
        if (body != bodies.end()) take(array.header, body->pose, a);
        const std::scoped_lock lock(others->lock);
        others->found = others->found || body != bodies.end();
        for (std::size_t i = 0; !others->found && i < bodies.size() && others->names.size() < named_most; ++i)
          others->names.emplace(text_in(bodies[i].name));
      }));
}

/// Shared by the readers of /tf and /tf_static, which may run in different threads.
struct SeenTransforms {
  explicit SeenTransforms(const PosesFrom& from) : chain(from.name, from.frame) {}
  std::mutex lock;
  TransformChain chain;
};

FrameTransform transform_of(const geometry_msgs_msg_dds__TransformStamped_& t, const Arrival& arrival) {
  const auto& [p, q] = t.transform;
  return {text_in(t.header.frame_id), text_in(t.child_frame_id), {p.x, p.y, p.z},
          {q.w, q.x, q.y, q.z},       stamp_of(t.header),        arrival.writer};
}

void read_transforms(PoseSubscriber& subscriber, dds_entity_t participant, const PosesFrom& from,
                     Attitude attitude) {
  const auto seen = std::make_shared<SeenTransforms>(from);
  subscriber.explain_by([seen, from] {
    const std::scoped_lock lock(seen->lock);
    const std::string end = seen->chain.ends_at();
    if (end.empty()) return std::string(too_seldom);
    if (end == from.name) return fmt::format("no transform of \"{}\"", from.name);
    return fmt::format("the parents of \"{}\" end at \"{}\", expected pose_frame, \"{}\"", from.name, end,
                       from.frame);
  });
  const auto each = [](const void* m) {
    const auto& message = *static_cast<const tf2_msgs_msg_dds__TFMessage_*>(m);
    return std::span(message.transforms._buffer, message.transforms._length);
  };
  subscriber.read_by(std::make_unique<RawReader>(
      participant, tf2_msgs_msg_dds__TFMessage__desc, "/tf", of_tf, std::nullopt, Writers::all,
      [seen, each, attitude, &subscriber](const void* m, const Arrival& a) {
        const std::scoped_lock lock(seen->lock);
        bool moved = false;
        for (const auto& transform : each(m)) {
          const TransformChain::Taken taken = seen->chain.take(transform_of(transform, a));
          moved = moved || taken == TransformChain::Taken::moved;
          if (taken == TransformChain::Taken::second_writer) subscriber.take_second_writer();
        }
        const auto pose = moved ? seen->chain.pose() : std::nullopt;
        if (!pose) return;
        const Quaternion q = attitude == Attitude::ignored ? upright({1, 0}) : pose->q;
        subscriber.take_pose(pose->p, q, pose->stamp, a.monotonic);
      }));
  subscriber.read_by(std::make_unique<RawReader>(participant, tf2_msgs_msg_dds__TFMessage__desc, "/tf_static",
                                                 of_static_tf, std::nullopt, Writers::all,
                                                 [seen, each](const void* m, const Arrival& a) {
                                                   const std::scoped_lock lock(seen->lock);
                                                   for (const auto& transform : each(m))
                                                     seen->chain.take_static(transform_of(transform, a));
                                                 }));
}

}  // namespace

void read_pose_stamped(PoseSubscriber& subscriber, dds_entity_t participant, const std::string& topic,
                       const std::string& frame, Attitude attitude) {
  subscriber.read_by(std::make_unique<RawReader>(
      participant, geometry_msgs_msg_dds__PoseStamped__desc, topic, of_sensors, std::nullopt, Writers::first,
      [take = PoseTaker{subscriber, frame, attitude}](const void* m, const Arrival& a) {
        const auto& pose = *static_cast<const geometry_msgs_msg_dds__PoseStamped_*>(m);
        take(pose.header, pose.pose, a);
      }));
}

void read_seen_poses(PoseSubscriber& subscriber, dds_entity_t participant, const PosesFrom& from,
                     Attitude attitude) {
  if (from.source == PoseSource::tf) return read_transforms(subscriber, participant, from, attitude);
  if (!from.name.empty()) return read_named(subscriber, participant, from, attitude);
  subscriber.explain_by([] { return std::string(too_seldom); });
  read_pose_stamped(subscriber, participant, from.topic, from.frame, attitude);
}

std::string other_frames_than(const PosesFrom& from) {
  return fmt::format("a frame that is not pose_frame, \"{}\"", from.frame);
}

}  // namespace sightline::dds
