/// Recordings of a rig of cameras that moves among AprilTags.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/sensors.hpp"

namespace sightline {

/// Frames: G of the tags' places; B of the rig; the optical frame of a camera, x right, y down, z
/// ahead; of a tag, seen from outside, x right, y up, z out of it. A pose has the coordinates of its
/// own frame in the other one.
struct RigRecording {
  struct RigCamera {
    std::string name, topic;
    Camera camera{};
    RigidPose mounting{};  ///< of the optical frame in B
  };
  struct Tag {
    int id = 0;
    double size = 0.0;  ///< side of the black square [m]
    bool known = false;
    RigidPose pose{};           ///< in G, if known
    Vec3<double> p_sigma{};     ///< of its position along the axes of G [m]
    Vec3<double> turn_sigma{};  ///< of its rotation about its own axes [rad]
  };
  struct Sighting {
    double t = 0.0;  ///< [s]
    std::size_t camera = 0, tag = 0;
    std::array<Vec2<double>, 4> corners{};  ///< distorted, from the upper left corner of the picture [px];
                                            ///< bottom left, bottom right, top right, top left of the tag
  };
  struct TimedPose {
    double t = 0.0;  ///< [s]
    RigidPose pose{};
  };
  struct TurnRate {
    double t = 0.0;        ///< [s]
    Vec3<double> omega{};  ///< about the axes of B [rad/s]
  };

  std::string name;  ///< of the rig's body
  std::vector<RigCamera> cameras{};
  std::vector<Tag> tags{};
  std::vector<Sighting> sightings{};   ///< in order of time
  std::vector<TimedPose> odometry{};   ///< of B, in a frame of its own; empty: there is none
  std::vector<TurnRate> turn_rates{};  ///< of B, by a gyroscope; empty: there is none
  std::vector<TimedPose> reference{};  ///< of B in G; empty: unknown
  double corner_noise = 1.0;           ///< of each coordinate of a corner [px]
  std::size_t left_out = 0;            ///< sightings of tags or by cameras that belong to no body used here
  double start = 0.0, end = 0.0;       ///< [s]
};

/// Longest recording of a rig [s], and numbers of tags.
inline constexpr double rig_recording_max = 86'400.0;
inline constexpr int rig_tag_id_max = 1'000'000;

/// Rows of a table of sightings and odometry, or of a reference:
///
///   tag,TOPIC,t,id,x_1,y_1,...,x_4,y_4
///   odom,TOPIC,t,x,y,z,q_x,q_y,q_z,q_w[,six numbers of velocity]
struct RigRows {
  struct TagRow {
    std::string topic;
    double t;
    int id;
    std::array<Vec2<double>, 4> corners;
  };
  struct PoseRow {
    std::string topic;
    RigRecording::TimedPose at;
  };
  struct RateRow {
    std::string topic;
    RigRecording::TurnRate at;  ///< about the axes of the sensor
  };
  std::vector<TagRow> tags{};
  std::vector<PoseRow> poses{};
  std::vector<RateRow> rates{};
};
/// @throws std::invalid_argument naming file, line, column, value and what was expected
RigRows parse_rig_rows(const std::string& file, std::string_view text);

}  // namespace sightline
