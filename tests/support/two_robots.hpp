/// Two multirotors, a and b, that do nothing with each other.
#pragma once

#include <vector>

#include "sightline/team.hpp"

namespace sightline::test {

inline Team two_robots() {
  Team team;
  team.add(Multirotor{}, {.name = "a"});
  team.add(Multirotor{}, {.name = "b"});
  return team;
}

/// Where they are when both move: a state in which no two numbers of theirs agree by chance.
inline const std::vector<double> two_robots_start = {-0.6, -0.3, 0.6, 1, 0, 0.1, 0, 2, 1, 0.5, 0, 1, 0, -0.2};

}  // namespace sightline::test
