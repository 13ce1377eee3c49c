/// Cycles of observation: robots that observe each other in a cycle, and whether they come to rest.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "sightline/scenario.hpp"

namespace sightline {

/// Each robot has the next in the view of its sensor; the last robot has the first.
struct ObservationCycle {
  std::vector<AgentId> robots;  ///< each once, the least index first
  std::string after{};          ///< events that lead to it, in their order; empty: it exists from the start
  Vec3<double> drift{};         ///< direction in which the robots move together; 0: they come to rest
  std::vector<std::string> maneuvers{};  ///< changes that bring them to rest, each verified
};

/// Cycles of a team at the states x0 (team.nx()); at most one through each pair of observer and
/// target.
std::vector<ObservationCycle> observation_cycles(const Team& team, std::span<const double> x0);

/// Cycles of every team that a scenario's events can produce, each listed at its first appearance.
/// Considers at most `teams_max` teams.
std::vector<ObservationCycle> observation_cycles(const Scenario& scenario);
inline constexpr std::size_t teams_max = 200;

/// "uav0 observes uav1, uav1 observes uav0: ...", a sentence.
std::string to_string(const ObservationCycle& cycle, const Team& team);

}  // namespace sightline
