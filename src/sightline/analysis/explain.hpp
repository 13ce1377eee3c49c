/// Analysis of a team's limits before a flight: which can hold together, each pair's equilibrium, and what each limit
/// costs compared with the others.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sightline/ocp/team.hpp"

namespace sightline {

struct Scenario;

/// What a limit asks of the distance of its two bodies.
enum class LimitKind {
  apart,     ///< broken at small distances, in any direction
  together,  ///< broken at large distances
  view,      ///< depends on the direction
  none,      ///< states no limit
};

/// Distances at which a limit, or several at once, can hold [m].
struct DistanceBand {
  double low, high;
};

/// A coupling's limit, with its weight.
struct LimitWorth {
  std::size_t coupling;  ///< in the order of the team
  LimitKind kind{};
  std::vector<DistanceBand> holds;  ///< rising; empty: it can hold at no distance
  bool in_world = false;            ///< it matters where in G they are: looked at around their starts
  double worst = 0.0;               ///< weight times the greatest l within `explain_reach`
};

/// Equilibrium of two bodies under their couplings alone, each moved by those that it feels.
struct PairRest {
  double distance, across, height;  ///< of the first above the second [m]
  double cost;                      ///< weighted
  DistanceBand within;              ///< where it costs `explain_margin` more at most
  std::vector<std::size_t> broken;  ///< couplings whose limits do not hold there
};

/// All couplings of two bodies.
struct PairAdvice {
  BodyId first, second;                ///< as the first of its couplings has them
  std::optional<std::size_t> same_as;  ///< an earlier pair whose couplings and weights are the same
  std::vector<LimitWorth> limits;
  std::vector<DistanceBand> holds;  ///< all limits at once, rising; empty: they contradict each other
  std::vector<std::pair<std::size_t, std::size_t>> contradictions;  ///< of two couplings
  std::optional<PairRest> rest;
  std::optional<Vec3<double>> drift;  ///< where they go together for ever, each by what it feels; a direction
};

/// Cost of a collision for a robot, compared with all other limits that it would break by evading.
struct HitCost {
  std::size_t coupling;  ///< that keeps it apart from another
  AgentId agent;         ///< that feels it
  double hit, others;    ///< at worst: this limit, and the robot's other limits that keep nobody apart
  std::optional<double> weight;  ///< to raise it to where it costs less than the others
};

inline constexpr double explain_reach = 6.0;    ///< [m]
inline constexpr double explain_margin = 0.01;  ///< of cost

struct Explanation {
  std::vector<PairAdvice> pairs;
  std::vector<HitCost> hits;
};

/// Samples relative poses of each pair; the first stands where it starts.  Set-up: allocates.
/// @param x0  states of all bodies at the start (team.nx()); empty: all are at the origin
Explanation explain(const Team& team, std::span<const double> x0 = {});

/// The same in sentences, one a line.
std::string to_string(const Explanation& explanation, const Team& team);

/// All that `sightline explain` says of a scenario: the limits, who observes whom in a circle, how cameras see tags, and which robots
/// their sensors leave without a place. Takes seconds where there are cameras.
std::string explain_text(const Scenario& scenario);

}  // namespace sightline
