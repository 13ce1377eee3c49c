/// Prints the compiled functions of models and potentials: kernels.cpp OUT.
///
/// What is printed holds no parameter values, so one function serves all robots of a model. Where a parameter
/// is such that an operation falls away (a factor of one, two equal constants) the structure is another: each
/// is printed for its defaults and for parameters that have nothing in common.
#include <fmt/format.h>

#include <cstdio>
#include <set>
#include <string>

#include "sightline/model/robots.hpp"
#include "sightline/potential/distance.hpp"
#include "sightline/potential/limits.hpp"
#include "sightline/potential/sensor_cone.hpp"
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
  }
  for (const double bound : {1.0, 0.83}) {
    generator.add(Multirotor{}, Seen::pose, {RelaxedBarrier{SpeedLimit{bound}, 0.013, 0.17}});
    generator.add(Multirotor{}, Seen::pose, {RelaxedBarrier{InputDisc{bound}, 0.013, 0.17}});
  }
  const SensorCone cone{
      .alpha = 0.52, .kappa_G = 0.013, .kappa_A = 2.1, .form = ConeForm::sine, .mount = {0.47, 0.16}};
  const KeepOut keep_out{.d_min = 1.13, .kappa_H = 4.7, .kappa_G = 0.0017, .kappa_A = 3.3};
  const Cohesion cohesion{.d_max = 2.3, .kappa_H = 1.7, .kappa_G = 0.0011, .kappa_A = 3.7};
  generator.add({0.4 * SensorCone{}, 0.4 * KeepOut{}, 0.4 * Cohesion{}});
  generator.add({0.4 * SensorCone{}, 0.4 * Cohesion{}, 0.4 * KeepOut{}});
  generator.add({0.4 * SensorCone{}});
  generator.add({0.4 * KeepOut{}});
  generator.add({0.4 * Cohesion{}});
  generator.add({0.4 * KeepOut{}, 0.4 * Cohesion{}});
  generator.add({0.41 * cone, 0.43 * keep_out, 0.47 * cohesion});
  generator.add({0.41 * cone});
  generator.add({0.41 * keep_out});
  generator.add({0.41 * cohesion});
  generator.add({0.41 * keep_out, 0.43 * cohesion});
  return generator.write(argv[1]) ? 0 : 1;
}
