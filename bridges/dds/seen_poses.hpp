/// Poses that others send of a body: motion capture, /tf.
#pragma once

#include "bridges/dds/pose_subscriber.hpp"
#include "sightline/scenario/link.hpp"

namespace sightline::dds {

/// Of a body whose heading nobody needs, poses may come without an attitude: single markers have none.
enum class Attitude { needed, ignored };

/// Has the intake read a topic of PoseStamped, whose frame counts where `frame` names one.
/// @throws std::runtime_error where the topic cannot be had
void read_pose_stamped(PoseSubscriber& subscriber, dds_entity_t participant, const std::string& topic,
                       const std::string& frame, Attitude attitude);

/// Has the intake read what `from` says, which is not the body's own odometry. The intake's origin is none: such poses are in G.
/// @throws std::runtime_error where a topic cannot be had
void read_seen_poses(PoseSubscriber& subscriber, dds_entity_t participant, const PosesFrom& from,
                     Attitude attitude);

/// What poses in other frames are called in a sentence of the intake.
std::string other_frames_than(const PosesFrom& from);

}  // namespace sightline::dds
