/// States of a test's own as they come out of a measurement.
#pragma once

#include <span>
#include <vector>

#include "sightline/loop.hpp"

namespace sightline::test {

/// x (nx), all measured at t [s].
inline ValidStates valid(const Team& team, std::span<const double> x, double t = 0.0) {
  ValidStates states(team, std::vector<double>(static_cast<std::size_t>(team.nx())));
  (void)states.take(x, std::vector<double>(static_cast<std::size_t>(team.bodies()), t));
  return states;
}

}  // namespace sightline::test
