/// Reads [safety], [safety.supervisor], [[safety.zone]] and [[simulation.fault]] of a scenario.
#pragma once

#include <optional>
#include <string>

#include "sightline/scenario.hpp"
#include "sightline/scenario/toml_table.hpp"

namespace sightline {

/// Reads [safety], if there is one. Noise values that it omits are those of the simulation.
std::optional<Safety> read_safety(const TomlTable& root, const Disturbances& disturbances);

/// Rejects a start on the wrong side of a zone without `start_outside`, and `start_outside` if no
/// start violates a judged limit. A campaign, which draws starts, may have both.
/// @param scenario  its bodies and starts are read
void check_starts(const TomlTable& root, const ScenarioSpec& scenario);

/// Reads [[simulation.fault]] into the simulation.
void read_faults(const TomlTable& simulation, const Team& team, Simulation& to);

/// Greatest speed of a robot, by its model and limits [m/s]; infinity: no bound.
struct RobotSpeed {
  BodyId robot;
  double speed;
  bool counts;  ///< false: the barrier uses BodySafety::speed_max instead
};
/// The robots of a team under a barrier, if they do not cooperate: their motions differ, or they
/// climb late. If all climb late with the same motion, the speeds do not count.
std::vector<RobotSpeed> uncooperative_robots(const ScenarioSpec& scenario);

/// Limits that the events of a scenario set.
std::vector<LimitsToCome> limits_to_come(const ScenarioSpec& scenario);

/// Options of the guard of the scenario's loop; none without a barrier, a supervisor, a certified view
/// or a vision-localized robot.
std::optional<GuardOptions> guard_options(const ScenarioSpec& scenario);

/// Hard minimum distance between two bodies [m]; none if neither the bodies nor [safety] state one.
std::optional<double> hard_distance(const ScenarioSpec& scenario, BodyId a, BodyId b);

/// Time without a new plan after which a robot holds [s]; without a supervisor the default.
double hold_after(const ScenarioSpec& scenario);

/// A line for each active or injected item, for the user.
std::string describe(const Safety& safety);
std::string describe(const Simulation& simulation, const Team& team);

}  // namespace sightline
