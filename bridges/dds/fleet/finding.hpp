/// Checks before a flight and their findings: a light and a sentence each.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sightline {

struct Scenario;

enum class Light : std::uint8_t {
  green,
  unknown,  ///< no data
  red,
};
std::string_view to_string(Light light);

/// Subject of a check.
enum class Aspect : std::uint8_t {
  // Of a robot.
  topics,     ///< the robot publishes the topics that a flight needs, and receives ours
  release,    ///< its messages have the layout of the fleet's release
  system,     ///< its system number is the required one
  frames,     ///< its poses are in the frames of the fleet
  writers,    ///< no other node publishes in its place, or commands it
  rate,       ///< rate of its poses, against the supervisor's limit for fresh poses
  clock,      ///< offset of its clock to ours
  latency,    ///< of its poses, from the stamp to reception
  radio,      ///< of a Crazyflie: rate, loss and latency of its packets, against the control period
  place,      ///< its position in G is within the walls
  camera,     ///< of a vision-localized robot: tags that it detects, and when
  estimator,  ///< its own estimate is valid
  checks,     ///< its own preflight checks and failsafe
  state,      ///< disarmed, on the ground
  battery,
  pilot,  ///< a pilot's transmitter is received
  // Of the fleet.
  distance,  ///< between robots on the ground
  origins,   ///< origins of local frames, against the poses that the robots report in them
  tags,      ///< tags are large enough for the cameras at the distances of the couplings
  // Of this machine.
  timing,  ///< of the control loop
};
inline constexpr int aspects = 20;
/// A stable word: "topics".
std::string_view to_string(Aspect aspect);
/// Whether `sightline fly` arms no robot while this aspect is red. Other aspects only predict the
/// quality of a flight.
bool keeps_grounded(Aspect aspect);

struct Finding {
  std::string robot;  ///< empty: of the fleet, or of this machine
  Aspect aspect{};
  Light light{};
  std::string sentence;
};

/// The worst light; green without findings.
Light worst(std::span<const Finding> findings);
/// A table for the user: a heading for each robot, in order of first occurrence, and a line for
/// each finding.
/// @param coloured  with the colours of a terminal
std::string findings_table(std::span<const Finding> findings, bool coloured);

/// Red for tags that are too small for a camera at a distance that couplings keep, else one green
/// finding with the smallest tag's pixels. Empty if no camera observes tags.
std::vector<Finding> tag_findings(const Scenario& scenario);

}  // namespace sightline
