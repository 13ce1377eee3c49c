/// Who is coupled with whom in a team of many, in one line.
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

#include "sightline/ocp/team.hpp"

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

}  // namespace sightline
