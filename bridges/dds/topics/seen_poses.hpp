/// Subscriptions to body poses that others publish: motion capture, /tf.
#pragma once

#include "bridges/dds/fleet/link.hpp"
#include "bridges/dds/topics/pose_subscriber.hpp"

namespace sightline::dds {

/// Attitude::ignored accepts poses without attitude, such as single markers, for bodies whose
/// heading is not used.
enum class Attitude { needed, ignored };

/// Subscribes to a PoseStamped topic; if `frame` is not empty, only poses in that frame count.
/// @throws std::runtime_error if the topic cannot be read
void read_pose_stamped(PoseSubscriber& subscriber, dds_entity_t participant, const std::string& topic,
                       const std::string& frame, Attitude attitude);

/// Subscribes to the pose source `from`, which is not the body's own odometry. The subscriber's
/// origin is zero, because such poses are in G.
/// @throws std::runtime_error if a topic cannot be read
void read_seen_poses(PoseSubscriber& subscriber, dds_entity_t participant, const PosesFrom& from,
                     Attitude attitude);

/// Text for poses in other frames, in the findings of the subscriber.
std::string other_frames_than(const PosesFrom& from);

}  // namespace sightline::dds
