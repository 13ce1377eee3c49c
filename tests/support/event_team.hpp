/// A chain that events change: two leaders, robots that each watch the one before, all couplings
/// with names.
#pragma once

#include <string>

#include "sightline/events.hpp"
#include "sightline/potentials.hpp"
#include "tests/support/paper_team.hpp"

namespace sightline {

/// "uav0" .. : uav0 and, where there are two leaders, uav1 hold their places; each other observes
/// the one before it by "sees<i>", keeps off by "off<i>" and stays near by "near<i>".
inline Team event_team(int robots, int leaders = 1) {
  Team team;
  for (int i = 0; i < robots; ++i) {
    paper::Options options = i < leaders ? paper::target() : paper::observer();
    options.name = "uav" + std::to_string(i);
    if (i < leaders) {
      options.x_ref = Circle{.centre = {0.0, 3.0 * i, 1.0}, .radius = 0.3, .rate = 0.3};
    }
    team.add(Multirotor{}, options);
  }
  for (int i = leaders; i < robots; ++i) {
    const AgentId self{BodyId{i}};
    const Between between{self, BodyId{i - 1}};
    const std::string number = std::to_string(i);
    team.couple({.term = 0.4 * SensorCone{}, .between = between, .felt_by = {self}, .name = "sees" + number});
    team.couple({.term = 0.4 * KeepOut{}, .between = between, .felt_by = {self}, .name = "off" + number});
    team.couple({.term = 0.4 * Cohesion{}, .between = between, .felt_by = {self}, .name = "near" + number});
  }
  return team;
}

/// Each behind the one before it, where it sees it.
inline std::vector<double> event_start(const Team& team, int leaders = 1) {
  std::vector<double> x(static_cast<std::size_t>(team.nx()));
  for (int i = 0; i < team.bodies(); ++i) {
    double* const to = &x[static_cast<std::size_t>(team.state_offset(BodyId{i}))];
    const double back = i < leaders ? 0.0 : 1.5 * (i - leaders + 1);
    to[0] = -back, to[1] = i < leaders ? 3.0 * i : 3.0 * (leaders - 1), to[2] = 1.0 + 0.25 * back;
    if (team.is_agent(BodyId{i})) to[3] = 1.0;
  }
  return x;
}

}  // namespace sightline
