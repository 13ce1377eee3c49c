/// What one observer of a team has to keep: its target in view, and distances; read from the couplings.
#pragma once

#include <vector>

#include "sightline/solver.hpp"

namespace sightline::benchmark {

/// A body that an observer keeps away from.
struct Apart {
  BodyId body;
  double d_min;  ///< [m], > 0
};

/// The target of a robot, the limits of its view and of its distances.
struct ViewTask {
  AgentId robot;
  BodyId target;
  SensorMount mount;
  double alpha;               ///< half angle of the view [rad]
  double d_min, d_max;        ///< limits of the distance to the target [m]
  std::vector<Apart> others;  ///< bodies besides the target
};

/// The tasks of all robots that a coupling with a sensor acts on as observers, in the order of the couplings.
/// Couplings of the same two bodies give the distances; without them they are 1 m and 2 m.
/// @throws std::invalid_argument if there is none, for an observer of two targets, and for limits that exclude
/// each other
std::vector<ViewTask> view_tasks(const Team& team);

/// The same bodies, without what acts on these observers: others then move as if in the whole team.
Team without_observers(const Team& team, const std::vector<ViewTask>& tasks);

/// A body seen from an observer: position and velocity in the observer's frame V, x ahead, y left, z up.
struct Relative {
  Vec3<double> q;  ///< position [m]
  Vec3<double> w;  ///< velocity of the body, not of the observer [m/s]
};
Relative relative(const Pose<double>& robot, const Sight<double>& body);

/// The place of the target in V on the axis of the sensor, at the middle of the two distances [m].
Vec3<double> best_place(const ViewTask& task);

}  // namespace sightline::benchmark
