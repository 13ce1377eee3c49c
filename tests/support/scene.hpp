/// Two robots, uav0 with a sensor and uav1 without, and a rock: what tables of a scenario are read
/// for.
#pragma once

#include "sightline/scenario/read_coupling.hpp"

namespace sightline::test {

struct Scene {
  Team team;
  AgentId uav0 = team.add(Multirotor{});
  AgentId uav1 = team.add(Multirotor{}, {.u_min = {-1, -1, -1, -1}, .u_max = {2, 2, 2, 2}});
  BodyId rock = team.add(Obstacle{"rock"});
  Observers observers = {{"uav0", SensorMount{.pitch = 0.25, .offset = 0.125}}, {"uav1", {}}};
};

}  // namespace sightline::test
