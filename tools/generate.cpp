/// Prints the compiled functions of models and potentials: kernels.cpp OUT.
///
/// What is printed holds no parameter values, so one function serves all robots of a model. Where a parameter
/// is such that an operation falls away (a factor of one, two equal constants) the structure is another: each
/// is printed for its defaults and for parameters that have nothing in common.
#include <fmt/format.h>

#include <cstdio>
#include <set>
#include <string>

#include "sightline/model/ground_robots.hpp"
#include "sightline/model/point_mass.hpp"
#include "sightline/model/robots.hpp"
#include "sightline/model/velocity_multirotor.hpp"
#include "sightline/potential/bearing.hpp"
#include "sightline/potential/bounds.hpp"
#include "sightline/potential/distance.hpp"
#include "sightline/potential/limits.hpp"
#include "sightline/potential/sensor_cone.hpp"
#include "sightline/potential/slope.hpp"
#include "sightline/solver/generator.hpp"

int main(int argc, char** argv) {
  using namespace sightline;
  if (argc != 2) {
    std::fputs("usage: generate FILE\n", stderr);
    return 2;
  }
  Generator generator(Generator::For::library);
  for (const Seen seen : {Seen::pose, Seen::pose_and_motion}) {
    generator.add(Multirotor{}, seen);
    generator.add(
        Multirotor{.b_z = 1.11, .b_psi = 1.62, .a_f = -0.51, .b_f = 1.43, .a_s = -0.53, .b_s = 1.47}, seen);
    generator.add(AngleMultirotor{}, seen);
    generator.add(OmniRover{}, seen);
    generator.add(OmniRover{.b_psi = 1.11, .a_f = -0.51, .b_f = 1.43, .a_s = -0.53, .b_s = 1.47}, seen);
    generator.add(OmniRover{.b_psi = 1.11, .a_f = -0.51, .b_f = 1.43, .a_s = -0.51, .b_s = 1.43}, seen);
    generator.add(Unicycle{}, seen);
    generator.add(Unicycle{.b_psi = 1.11, .a_f = -0.51, .b_f = 1.43}, seen);
    generator.add(PointMass{}, seen);
    generator.add(PointMass{.drag = 0.31}, seen);
    generator.add(VelocityMultirotor{}, seen);
    generator.add(VelocityMultirotor{.tau_f = 0.41, .tau_s = 0.41, .tau_z = 0.61, .tau_psi = 0.17}, seen);
    generator.add(VelocityMultirotor{.tau_f = 0.41, .tau_s = 0.47, .tau_z = 0.61, .tau_psi = 0.17}, seen);
  }
  for (const double bound : {1.0, 0.83}) {
    generator.add(Multirotor{}, Seen::pose, {RelaxedBarrier{SpeedLimit{bound}, 0.013, 0.17}});
    generator.add(Multirotor{}, Seen::pose, {RelaxedBarrier{InputDisc{bound}, 0.013, 0.17}});
  }
  const Weighted cone = 0.4 * SensorCone{}, keep_out = 0.4 * KeepOut{}, cohesion = 0.4 * Cohesion{};
  generator.add({cone, keep_out, cohesion});
  generator.add({cone, keep_out});
  generator.add({cone, cohesion});
  generator.add({keep_out, cohesion});
  for (const Weighted& one : {cone, keep_out, cohesion, 0.4 * AltitudeBand{}, 0.4 * Geofence{}})
    generator.add({one});
  generator.add({0.4 * AltitudeBand{}, 0.4 * Geofence{}});
  const Weighted bearing = 0.4 * Bearing{}, near = 0.4 * TooNear{}, far = 0.4 * TooFar{},
                 with = 0.4 * RelativeVelocity{};
  generator.add({bearing, near, far, with});
  generator.add({bearing, near, far});
  for (const Weighted& one : {bearing, near, far, with}) generator.add({one});
  return generator.write(argv[1]) ? 0 : 1;
}
