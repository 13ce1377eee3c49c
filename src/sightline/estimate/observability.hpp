/// Observability test: positions and headings that the sensors of a team do not determine.
#pragma once

#include <string>
#include <vector>

namespace sightline {

/// A robot and its measurements of itself, in addition to velocity in V, yaw rate, roll and pitch.
struct SensingRobot {
  std::string name;
  bool position = false;  ///< by motion capture or GNSS
  bool heading = false;   ///< by motion capture or a compass
};

/// A robot that observes another one, and whether it also measures the other's heading, as by tags.
struct Sees {
  int observer = 0, target = 0;  ///< indices in the team
  bool yaw = true;
};

/// Unobservable states of one robot.
struct Unobservable {
  int robot = 0;
  bool heading = false;
  bool horizontal = false;  ///< its horizontal position
  bool height = false;
  int about = -1;  ///< a rotation about this robot changes no measurement; -1: more is unknown
};

/// Robot at rest: position in G [m] and heading [rad].
struct PlacedRobot {
  double x = 0.0, y = 0.0, z = 0.0, heading = 0.0;
};

/// Rank test of the linearised estimation problem of all robots together, about given poses at
/// rest.
///
/// States are positions, headings, and the biases of the reported velocity and yaw rate. A sighting
/// measures R_i^T (p_j - p_i), and with yaw also psi_j - psi_i. At rest the biases are the rates of
/// positions and headings, p' = -R b_v, psi' = -b_r. So the observability matrix contains that of
/// positions and headings twice. Its null space is that of the sightings, positions and headings
/// alone. A state is observable if no vector of the null space changes it.
///
/// Relative motion of the robots can determine more, slowly. A filter with biased velocities must
/// not rely on it (docs/localization.md).
///
/// @throws std::invalid_argument if the numbers of places and robots differ, or if a sighting
///   refers to a missing robot
std::vector<Unobservable> unobservable_states(const std::vector<SensingRobot>& robots,
                                              const std::vector<PlacedRobot>& places,
                                              const std::vector<Sees>& sightings);

/// Describes the result in a sentence: "the heading of uav0 is not observable, nor its position in
/// the plane: a turn about uav1 changes nothing that ..., expected ...".
std::string to_string(const Unobservable& what, const std::vector<SensingRobot>& robots);

}  // namespace sightline
