/// Data of a model fit from the recordings of other programs.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "sightline/analysis/identification/flown_motion.hpp"
#include "sightline/readers/recorded_motion.hpp"
#include "sightline/readers/ros_bag.hpp"
#include "sightline/readers/ulog.hpp"
#include "sightline/scenario/csv_lists.hpp"
#include "sightline/scenario/file_kind.hpp"

namespace sightline {

/// Motion of a multirotor under velocity commands, at periods of 20 ms from the first command to the
/// last. Positions, velocities and headings are interpolated; where samples are more than 0.2 s apart,
/// nothing was measured. Commands stay in force until the next; where they were recorded at less than
/// 20 Hz, they are samples of a faster stream and are interpolated. The limits of the inputs are the
/// greatest commanded ones, at least 0.1.
/// @param robot  its name
/// @param truth  empty if unknown
/// @throws std::invalid_argument for fewer than two commands, and for a motion without velocity or
///   heading
FlownMotion motion_of(const std::string& robot, const std::vector<VelocityCommand>& commands,
                      const RecordedMotion& measured, const RecordedMotion& truth);

/// The same from a log of PX4: its set-points of velocity, its estimated pose, and the true motion of
/// a simulation.
/// @throws std::invalid_argument as above, and for a log without set-points of velocity
FlownMotion motion_of(const ULog& log, const std::string& robot);

/// The same from a text file: columns t, x, y, z, heading, vx, vy, vz of the motion, and ux, uy, uz,
/// ur of the commands (velocity in the axes of x, y, z [m/s], yaw rate [rad/s]).
/// @throws std::invalid_argument as above, for a missing column, and for times that do not rise
FlownMotion motion_of(const CsvColumns& table, const std::string& robot);

/// The same from a bag of ROS 2; its commands are in the axes of the heading, as cmd_vel is.
/// @param body      as RosBag::motion(); empty: the only one
/// @param commands  a topic of velocities; empty: the only one
/// @throws std::invalid_argument as above and as RosBag, and for an empty name of several
FlownMotion motion_of(const RosBag& bag, const std::string& robot, std::string body, std::string commands);

/// What is taken of a recording, and what it is called.
struct RecordedRobot {
  std::string name{};                  ///< empty: that of the file
  std::vector<std::string> columns{};  ///< of a table, as read_csv(); empty: from its first line
  std::string body{}, commands{};      ///< of a bag
};

/// The flight in a recording by its kind; logs of PX4 and tables may be packed.
/// @throws std::invalid_argument as above and as the readers, and for what the recording lacks
FlownMotion recorded_motion(const std::filesystem::path& file, RecordingKind kind, RecordedRobot robot);

}  // namespace sightline
