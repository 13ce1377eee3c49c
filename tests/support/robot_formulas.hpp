/// What sightline_add_formulas compiles of the robots in robots.hpp.
#pragma once

#include "sightline/kernels.hpp"
#include "tests/support/robots.hpp"

inline void sightline_formulas(sightline::Generator& generator) {
  generator.add(sightline::test::Unicycle{}, sightline::Seen::pose);
  generator.add(sightline::test::Quadrotor{}, sightline::Seen::pose);
}
