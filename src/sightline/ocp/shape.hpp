/// Topologies of couplings in a team of many, in one line.
///
///   chain      b_1 observes b_0, b_2 observes b_1, ...    n - 1 pairs
///   ring       the same, and b_0 observes the last        n pairs
///   star       many observe one centre                    a pair each
///   all pairs  each body with each later one              n (n - 1) / 2 pairs
///
/// A shape is no more than a list of pairs; `couple` expands it to ordinary couplings, so that nothing else
/// knows of shapes.
#pragma once

#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "sightline/ocp/event.hpp"
#include "sightline/ocp/team.hpp"
#include "sightline/ocp/view_choice.hpp"

namespace sightline {

/// Each of these refuses a body that stands twice.
/// @throws std::invalid_argument
std::vector<Between> chain(const std::vector<BodyId>& bodies);
std::vector<Between> ring(const std::vector<BodyId>& bodies);
std::vector<Between> star(BodyId centre, const std::vector<BodyId>& observers);
std::vector<Between> all_pairs(const std::vector<BodyId>& bodies);

/// Who feels the couplings of a shape: the first of each pair, or all robots of it.
enum class FeltBy { observer, both };

/// The agents of a pair that feel its couplings.
std::vector<AgentId> feeling(const Team& team, Between pair, FeltBy felt_by);

/// The terms of a pair: an observer's potential has the mount of its own sensor.
using TermsOf = std::function<std::vector<Weighted>(Between)>;

/// Couples each pair by each of its terms, pair by pair.
/// @throws std::invalid_argument as Team::couple does
void couple(Team& team, const TermsOf& terms_of, std::span<const Between> pairs, FeltBy felt_by);
/// The same with equal terms for all pairs.
void couple(Team& team, const std::vector<Weighted>& terms, std::span<const Between> pairs, FeltBy felt_by);

/// When another robot takes over as observer.
struct RelayOptions {
  std::string name{};   ///< of the relay, its couplings, stages and events
  double margin = 0.3;  ///< it has to be nearer by so much [m], >= 0
  double dwell = 1.0;   ///< for so long [s], > 0
  double ramp = 1.0;    ///< of the weights [s], >= 0
};

/// The nearest of several robots observes a target, and feels the terms: the first of them at first. Each takes over from
/// each by an event, in stages "<name>:<robot>".
/// @throws std::invalid_argument where a name is empty or taken, or as couple()
void relay(Team& team, Script& script, const TermsOf& terms_of, const std::vector<AgentId>& observers,
           BodyId target, const RelayOptions& options);

/// Each observer of the choice looks at one of its targets, and feels the terms with it. At first those of choice.first;
/// then events "<name>: <observer> turns to <target>" follow the choice, with couplings "<name>:<observer> <number>".
/// @param ramp  of the weights [s], >= 0
/// @throws std::invalid_argument for a choice that check() refuses, an observer that another choice has already, a
/// name that is empty or taken, or as couple()
void best(Team& team, Script& script, const TermsOf& terms_of, ViewChoice choice, double ramp);

}  // namespace sightline
