/// Makes the default solver, of teams of one horizon.
#pragma once

#include "sightline/solvers.hpp"

namespace sightline {

inline MakeSolver newton_riccati_of(const Horizon& horizon, const NewtonRiccatiOptions& options = {}) {
  return [horizon, options](Team team) {
    return std::make_unique<NewtonRiccati>(Ocp(std::move(team), horizon), options);
  };
}

}  // namespace sightline
