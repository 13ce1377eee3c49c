/// Robots that keep out of each other's way, pair by pair.
#pragma once

#include <array>
#include <vector>

#include "sightline/potentials.hpp"
#include "sightline/team.hpp"

namespace sightline::test {

/// @param couplings  two robots, and who of them feels it; -1: both
inline Team team_with(int agents, const std::vector<std::array<int, 3>>& couplings) {
  Team team;
  std::vector<AgentId> ids;
  for (int i = 0; i < agents; ++i) ids.push_back(team.add(Multirotor{}));
  for (const auto& [a, b, who] : couplings) {
    const AgentId first = ids[static_cast<std::size_t>(a)], second = ids[static_cast<std::size_t>(b)];
    if (who < 0) {
      team.couple(0.4 * KeepOut{}, {first, second});
    } else {
      team.couple(0.4 * KeepOut{}, {first, second}, felt_by(ids[static_cast<std::size_t>(who)]));
    }
  }
  return team;
}

}  // namespace sightline::test
