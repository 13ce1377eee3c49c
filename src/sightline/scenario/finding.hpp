/// What is looked at before a flight, and what was found: green or red, a sentence each.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace sightline {

enum class Light : std::uint8_t {
  green,
  unknown,  ///< nobody says
  red,
};
std::string_view to_string(Light light);

/// What is looked at.
enum class Aspect : std::uint8_t {
  // Of a robot.
  topics,     ///< what it is flown by comes, and it hears us
  release,    ///< its messages have the layout that the fleet says
  system,     ///< the number that it is to have
  frames,     ///< its poses are in the frames that the fleet says
  writers,    ///< nobody else speaks in its place, or commands it
  rate,       ///< of its poses, against what the supervisor takes for fresh
  clock,      ///< its clock against ours
  latency,    ///< of its poses, from their stamp to us
  place,      ///< where it is in G: within the walls
  camera,     ///< of one that is localized by view: tags that it finds, and when
  estimator,  ///< its own estimate is valid
  checks,     ///< its own checks before a flight, its failsafe
  state,      ///< disarmed, on the ground
  battery,
  pilot,  ///< it receives a pilot's transmitter
  // Of the fleet.
  distance,  ///< of robots on the ground, one from the other
  origins,   ///< of their local frames, against what they say of them
  tags,      ///< large enough for the cameras at the distances that are kept
  // Of this machine.
  timing,  ///< of the control loop
};
inline constexpr int aspects = 19;
/// A word that stays: "topics".
std::string_view to_string(Aspect aspect);
/// Whether `sightline fly` arms nothing while it is red. The others tell what a flight would be like.
bool keeps_grounded(Aspect aspect);

struct Finding {
  std::string robot;  ///< empty: of the fleet, or of this machine
  Aspect aspect{};
  Light light{};
  std::string sentence;
};

/// The worst of them; green of none.
Light worst(std::span<const Finding> findings);
/// A table for a person: a heading for each robot, in the order in which they first occur, a line for each finding.
/// @param coloured  with the colours of a terminal
std::string findings_table(std::span<const Finding> findings, bool coloured);

}  // namespace sightline
