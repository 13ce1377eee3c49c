/// All of sightline that a program needs: teams, potentials, solvers, the simulated world.
#pragma once

#include "sightline/ocp/ocp.hpp"
#include "sightline/ocp/shape.hpp"
#include "sightline/potential/bearing.hpp"
#include "sightline/potential/bounds.hpp"
#include "sightline/potential/distance.hpp"
#include "sightline/potential/limits.hpp"
#include "sightline/potential/region.hpp"
#include "sightline/potential/sensor_cone.hpp"
#include "sightline/potential/slope.hpp"
#include "sightline/safety/barrier.hpp"
#include "sightline/sim/plant.hpp"
#include "sightline/sim/sensor.hpp"
#include "sightline/solver/cgmres.hpp"
#include "sightline/solver/cmscgmres.hpp"
#include "sightline/solver/newton_riccati.hpp"
