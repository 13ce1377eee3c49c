/// Cycles of observation: robots that observe each other in a cycle, and whether they come to rest.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "sightline/scenario/scenario.hpp"

namespace sightline {

/// Each has the next in the view of its sensor, the last the first.
struct ObservationCycle {
  std::vector<AgentId> robots;  ///< each once, the least index first
  std::string after{};   ///< the events that led to it, in their order; empty: it is there from the start
  Vec3<double> drift{};  ///< where they go together, a direction; 0: they come to rest
  std::vector<std::string> maneuvers{};  ///< what brings them to rest, each tried
};

/// The cycles of a team whose states are x0 (team.nx()); at most one through each pair of observer and target.
std::vector<ObservationCycle> observation_cycles(const Team& team, std::span<const double> x0);

/// Those of every team that the events of a scenario can make, each where it first comes about. Of more than
/// `teams_max` teams the first are looked at.
std::vector<ObservationCycle> observation_cycles(const Scenario& scenario);
inline constexpr std::size_t teams_max = 200;

/// "uav0 observes uav1, uav1 observes uav0: ...", a sentence.
std::string to_string(const ObservationCycle& cycle, const Team& team);

}  // namespace sightline
