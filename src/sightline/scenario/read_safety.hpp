/// What a scenario says of safety: [safety], [safety.supervisor], and the faults of [[simulation.fault]].
#pragma once

#include <optional>
#include <string>

#include "sightline/scenario/scenario.hpp"
#include "sightline/scenario/toml_table.hpp"

namespace sightline {

/// [safety], where there is one. What is left out of the noise that is to be reckoned with is the simulated one.
std::optional<Safety> read_safety(const TomlTable& root, const Disturbances& disturbances);

/// Refuses `start_outside` where no start is beyond a limit that is judged, unless a campaign draws starts.
/// @param scenario  whose bodies and starts are read
void check_start_outside(const TomlTable& root, const Scenario& scenario);

/// [[simulation.fault]], into the simulation.
void read_faults(const TomlTable& simulation, const Team& team, Simulation& to);

/// How fast a robot can be, by its model and limits [m/s]; infinity: without a bound.
struct RobotSpeed {
  BodyId robot;
  double speed;
  bool counts;  ///< false: the barrier reckons with BodySafety::speed_max in its place
};
/// The robots of a team under a barrier that another robot does not count as cooperative, since they move otherwise or climb late.
/// Where all climb late and move alike, their speeds do not count.
std::vector<RobotSpeed> uncooperative_robots(const Scenario& scenario);

/// What guards the scenario's loop; none without a [safety] section that switches something on.
std::optional<GuardOptions> guard_options(const Scenario& scenario);

/// The distance that is never to be fallen short of between two bodies [m]; none where nobody asks for one.
std::optional<double> hard_distance(const Scenario& scenario, BodyId a, BodyId b);

/// For how long a robot flies on without a new plan before it holds [s]; without a supervisor the default's.
double hold_after(const Scenario& scenario);

/// A line for each thing that is switched on or injected, for a person.
std::string in_words(const Safety& safety);
std::string in_words(const Simulation& simulation, const Team& team);

}  // namespace sightline
