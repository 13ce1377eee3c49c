/// Which of a team's positions and headings its sensors do not determine.
#pragma once

#include <string>
#include <vector>

namespace sightline {

/// A robot, and what it measures of itself beside its motion: velocity in V, yaw rate, roll and pitch.
struct SensingRobot {
  std::string name;
  bool position = false;  ///< by motion capture or GNSS
  bool heading = false;   ///< by motion capture or a compass
};

/// A robot that sees another, and whether the other's heading is measured too, as by tags.
struct Sees {
  int observer = 0, target = 0;  ///< places in the team
  bool yaw = true;
};

/// What is not determined of one robot.
struct Unobservable {
  int robot = 0;
  bool heading = false;
  bool horizontal = false;  ///< its position in the plane
  bool height = false;
  int about =
      -1;  ///< a turn about this robot changes nothing that is measured; -1: more than that is unknown
};

/// Where it is at rest, in G [m], and its heading [rad].
struct PlacedRobot {
  double x = 0.0, y = 0.0, z = 0.0, heading = 0.0;
};

/// Rank test of the linearised estimation problem of all robots at once, about places where they are at rest.
///
/// States are positions, headings, and the biases of the told velocity and yaw rate. A sighting gives R_i^T (p_j - p_i), and with
/// yaw psi_j - psi_i. At rest the biases enter as the rates of positions and headings, p' = -R b_v, psi' = -b_r. So the
/// observability matrix is that of positions and headings twice, and its null space is that of the sightings, positions and
/// headings alone. A state that no vector of the null space moves is observable.
///
/// A motion of the robots relative to each other can determine more, slowly: a filter that is told biased
/// velocities can not count on it (docs/localization.md).
///
/// @throws std::invalid_argument for places of another number than robots, and for a sighting of or by no robot
std::vector<Unobservable> unobservable_states(const std::vector<SensingRobot>& robots,
                                              const std::vector<PlacedRobot>& places,
                                              const std::vector<Sees>& sightings);

/// "the heading of uav0 is not observable, nor its position in the plane: a turn about uav1 changes nothing that ..., expected ...", a
/// sentence.
std::string to_string(const Unobservable& what, const std::vector<SensingRobot>& robots);

}  // namespace sightline
