/// Which hard distances the barriers of a scenario guarantee, and why not the others: docs/safety.md, 5.
#pragma once

#include <string>
#include <vector>

#include "sightline/scenario.hpp"

namespace sightline {

/// Two bodies of a scenario, at least one of them a robot.
struct PairGuarantee {
  bool holds() const { return why_not.empty(); }

  BodyId first, second;
  std::string why_not;    ///< empty: guaranteed
  std::string condition;  ///< under which it is guaranteed; empty: none
};

/// All pairs with a robot, in the order of the team; none if no barrier changes the commands.
/// A pair is guaranteed if one of the two keeps away from whatever the other does, or both cooperate.
std::vector<PairGuarantee> distance_guarantees(const ScenarioSpec& scenario);

/// A line for each verdict, with its pairs.
/// @param most  pairs named in a line; of the others their number is given
std::string describe(const std::vector<PairGuarantee>& pairs, const Team& team, std::size_t most);

}  // namespace sightline
