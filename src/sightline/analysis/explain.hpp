/// Analysis of a team's limits before a flight: which limits can hold together, each pair's
/// equilibrium, and the cost of each limit compared with the others.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sightline/ocp/team.hpp"

namespace sightline {

struct Scenario;

/// What a limit requires of the distance of its two bodies.
enum class LimitKind {
  apart,     ///< broken at small distances, in any direction
  together,  ///< broken at large distances
  view,      ///< depends on the direction
  none,      ///< states no limit
};

/// Distances at which a limit, or several limits at once, can hold [m].
struct DistanceBand {
  double low, high;
};

/// A coupling's limit and its greatest weighted cost.
struct LimitWorth {
  std::size_t coupling;  ///< in the order of the team
  LimitKind kind{};
  std::vector<DistanceBand> holds;  ///< ascending; empty: it can hold at no distance
  bool in_world = false;            ///< it depends on the places in G; sampled around the starts
  double worst = 0.0;               ///< weight times the greatest l within `explain_reach`
};

/// Equilibrium of two bodies under their couplings alone; each coupling moves the bodies it acts
/// on.
struct PairRest {
  double distance, across, height;  ///< of the first body above the second [m]
  double cost;                      ///< weighted
  DistanceBand within;              ///< distances [m] where the cost is at most `explain_margin` higher
  std::vector<std::size_t> broken;  ///< indices of the couplings whose limits do not hold there
};

/// All couplings of two bodies.
struct PairAdvice {
  BodyId first, second;                ///< in the order of the pair's first coupling
  std::optional<std::size_t> same_as;  ///< an earlier pair whose couplings and weights are the same
  std::vector<LimitWorth> limits;
  std::vector<DistanceBand> holds;  ///< all limits at once, ascending; empty: they contradict each other
  std::vector<std::pair<std::size_t, std::size_t>> contradictions;  ///< indices of two couplings
  std::optional<PairRest> rest;
  std::optional<Vec3<double>> drift;  ///< direction in which both move without bound, each by its own cost
};

/// Cost of a collision for a robot, compared with all other limits that it would break by evading.
struct HitCost {
  std::size_t coupling;          ///< the coupling that keeps the robot apart from another body
  AgentId agent;                 ///< the robot it acts on
  double hit, others;            ///< greatest cost of this limit; sum over the robot's other limits that
                                 ///< keep no bodies apart
  std::optional<double> weight;  ///< weight at which a collision costs more than the others; none:
                                 ///< it does already
};

inline constexpr double explain_reach = 6.0;    ///< [m]
inline constexpr double explain_margin = 0.01;  ///< of the weighted cost [-]

struct Explanation {
  std::vector<PairAdvice> pairs;
  std::vector<HitCost> hits;
};

/// Samples the relative poses of each pair. Set-up: allocates.
/// @param x0  states of all bodies at the start (team.nx()); empty: all are at the origin
Explanation explain(const Team& team, std::span<const double> x0 = {});

/// The explanation as text, one sentence a line.
std::string to_string(const Explanation& explanation, const Team& team);

/// Text of `sightline explain`: the limits, cycles of observation, how cameras see tags, and which
/// robots' sensors do not determine their poses. Takes seconds if robots have cameras.
std::string explain_text(const Scenario& scenario);

}  // namespace sightline
