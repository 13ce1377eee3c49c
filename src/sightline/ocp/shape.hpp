/// Topologies of couplings in a large team, in one line.
///
///   chain      b_1 observes b_0, b_2 observes b_1, ...    n - 1 pairs
///   ring       the same, and b_0 observes the last        n pairs
///   star       many observe one centre                    a pair each
///   all pairs  each body with each later one              n (n - 1) / 2 pairs
///
/// A shape is only a list of pairs; `couple` expands it to ordinary couplings, so that no other
/// code depends on shapes.
#pragma once

#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "sightline/ocp/event.hpp"
#include "sightline/ocp/team.hpp"
#include "sightline/ocp/view_choice.hpp"

namespace sightline {

/// Each of these rejects a duplicate body.
/// @throws std::invalid_argument
std::vector<Between> chain(const std::vector<BodyId>& bodies);
std::vector<Between> ring(const std::vector<BodyId>& bodies);
std::vector<Between> star(BodyId centre, const std::vector<BodyId>& observers);
std::vector<Between> all_pairs(const std::vector<BodyId>& bodies);

/// On whom the couplings of a shape act: on the first of each pair, or on both, if they are robots.
enum class FeltBy { observer, both };

/// The agents of a pair on which its couplings act.
std::vector<AgentId> feeling(const Team& team, Between pair, FeltBy felt_by);

/// The terms of a pair: an observer's potential has the mount of its own sensor.
using TermsOf = std::function<std::vector<Weighted>(Between)>;

/// Couples each pair by each of its terms, pair by pair.
/// @throws std::invalid_argument as Team::couple does
void couple(Team& team, const TermsOf& terms_of, std::span<const Between> pairs, FeltBy felt_by);
/// The same with equal terms for all pairs.
void couple(Team& team, const std::vector<Weighted>& terms, std::span<const Between> pairs, FeltBy felt_by);

/// Condition under which another robot becomes the observer.
struct RelayOptions {
  std::string name{};   ///< of the relay, its couplings, stages and events
  double margin = 0.3;  ///< by which it must be nearer [m], >= 0
  double dwell = 1.0;   ///< for which it must be nearer [s], > 0
  double ramp = 1.0;    ///< of the weights [s], >= 0
};

/// The nearest of several robots observes a target, and the terms act on it; initially the first of
/// the list. An event for each ordered pair of robots hands over, in stages "<name>:<robot>".
/// @throws std::invalid_argument for a name that is empty or taken, or as couple()
void relay(Team& team, Script& script, const TermsOf& terms_of, const std::vector<AgentId>& observers,
           BodyId target, const RelayOptions& options);

/// Each observer of the choice views one of its targets, and the terms act on the observer.
/// Initially the targets are choice.first. Events "<name>: <observer> turns to <target>" follow the
/// choice, with couplings "<name>:<observer> <number>".
/// @param ramp  of the weights [s], >= 0
/// @throws std::invalid_argument for a choice that check() rejects, an observer of another choice,
/// a name that is empty or taken, or as couple()
void best(Team& team, Script& script, const TermsOf& terms_of, ViewChoice choice, double ramp);

}  // namespace sightline
