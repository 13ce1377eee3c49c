/// All that a program needs to plan and fly in simulation: robots, potentials, teams, solvers, the barrier and worlds.
/// Logs, scenarios and the loop have headers of their own: loop.hpp, scenario.hpp, log.hpp.
#pragma once

#include "sightline/barrier.hpp"
#include "sightline/model.hpp"
#include "sightline/potentials.hpp"
#include "sightline/robots.hpp"
#include "sightline/sensors.hpp"
#include "sightline/solvers.hpp"
#include "sightline/team.hpp"
#include "sightline/worlds.hpp"
