/// Motion and commanded velocities of a vehicle in a log of PX4. G is x east, y north, z up, with the
/// origin of the vehicle's local frame.
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include "sightline/readers/recorded_motion.hpp"
#include "sightline/readers/ulog.hpp"

namespace sightline {

/// Topics that have a motion.
inline constexpr std::array<std::string_view, 3> px4_motions = {
    "vehicle_local_position", "vehicle_local_position_groundtruth", "vehicle_odometry"};

/// The motion of a topic; samples that the estimator marks as not valid are left out.
/// @throws std::invalid_argument for a topic that is none of px4_motions, was not logged, lacks a
///   field, or is not in NED
RecordedMotion px4_motion(const ULog& log, std::string_view topic);

/// Set-points of velocity alone (trajectory_setpoint without a position): the longest stretch without
/// a gap of more than 0.5 s and without a reset of the estimated pose, in which the vehicle was armed
/// and in the mode Offboard as far as the log has its mode. Empty if there is none.
std::vector<VelocityCommand> px4_velocity_commands(const ULog& log);

}  // namespace sightline
