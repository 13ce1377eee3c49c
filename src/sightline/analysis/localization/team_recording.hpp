/// Recorded odometry, sightings and true poses of a team of planar robots, read from the files of
/// public data sets.
#pragma once

#include <cstddef>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "sightline/estimate/team_filter.hpp"

namespace sightline {

struct TeamRecording {
  struct TruePose {
    double t;  // [s]
    PlanarPose pose{};
  };
  struct Robot {
    std::string name;
    double height = 0.0;                    ///< [m]
    std::vector<WheelOdometry> odometry{};  ///< in order of time; empty: none was recorded
    std::vector<TruePose> truth{};          ///< in order of time; empty: unknown
  };
  struct Landmark {
    std::string name;
    TeamFilter::Landmark place{};
  };

  std::string kind;  ///< "MRCLAM" or "MURP"
  std::vector<Robot> robots{};
  std::vector<Landmark> landmarks{};
  std::vector<TeamSighting> sightings{};  ///< in order of time, identified, within [start, end]
  int antennas = 0;                       ///< of each robot, of ranges
  std::size_t unknown_codes = 0;          ///< sightings of barcodes that no body has
  double start = 0.0, end = 0.0;          ///< [s]
  TeamNoise noise{};                      ///< of robots and sensors of this kind
  /// The robots have neither odometry nor landmarks, so poses are relative to the first robot.
  bool relative = false;

  /// True pose of a robot at a time, interpolated; empty where the truth has a gap of over 0.5 s,
  /// or over 1.5 s if poses are relative.
  std::optional<PlanarPose> truth(int robot, double t) const;
};

/// Longest recording [s], and most robots.
inline constexpr double recording_max = 86'400.0;
inline constexpr int recorded_robots_max = 32;

/// Reads a folder of MRCLAM (RobotN_Odometry.dat, RobotN_Measurement.dat, Barcodes.dat,
/// Landmark_Groundtruth.dat, RobotN_Groundtruth.dat where known), or the files
/// NAME_base-I_targ-J....csv(.gz) of MURP: one, or a folder of them.
/// @throws std::invalid_argument naming file, line, value and what was expected
TeamRecording read_team_recording(const std::filesystem::path& place);

/// Texts of files by their paths, for messages.
using RecordingTexts = std::map<std::string, std::string>;

/// The same from texts. Names of files are those of the data set.
/// @param place  name of the recording
TeamRecording parse_mrclam(const RecordingTexts& texts, const std::string& place);
TeamRecording parse_murp(const RecordingTexts& texts, const std::string& place);

}  // namespace sightline
