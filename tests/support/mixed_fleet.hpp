/// A vehicle under tilt commands, a rover, a vehicle under velocity commands, a target.
#pragma once

#include "sightline/model.hpp"
#include "sightline/robots.hpp"
#include "sightline/team.hpp"

namespace sightline::test {

inline Team mixed_fleet() {
  Team team;
  team.add(Multirotor{}, {.name = "uav"});
  team.add(OmniRover{}, {.name = "rover"});
  team.add(VelocityMultirotor{}, {.name = "scout"});
  team.add(Obstacle{.name = "target"});
  return team;
}

}  // namespace sightline::test
