/// Teams and flights that the tests of the MuJoCo world share.
#pragma once

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "sightline/mujoco.hpp"
#include "sightline/worlds.hpp"
#include "tests/support/applied.hpp"
#include "tests/support/mixed_fleet.hpp"

namespace sightline::test {

using Numbers = std::vector<double>;

/// Where a mixed_fleet() starts: far from each other.
inline const Numbers mixed_start = {0,  0,  40, 0.6, 0.8, 0.3, 0.1, /**/ 300, 0,   0,      1, 0, 0.2, 0, /**/
                                    60, 60, 43, 1,   0,   0,   0,   0.2,      0.1, /**/ 9, 0, 1, 0.1, 0, 0};
inline std::vector<RobotVehicle> fleet_of(const Vehicle& first, const Vehicle& second) {
  return {{BodyId{0}, first}, {BodyId{2}, second}};
}

/// Commands of all of them that swing.
inline Numbers swinging(double t) {
  const auto s = [t](double rate, double phase) { return std::sin(rate * t + phase); };
  return {0.8 * s(1.1, 0.0), 0.7 * s(0.9, 1.0), 0.3 * s(0.4, 2.0), 0.5 * s(0.5, 0.5), 0.5, 0.1, -0.2,
          s(0.8, 0.3),       s(1.0, 1.3),       0.4 * s(0.6, 0.0), 0.6 * s(0.3, 1.0)};
}

/// All that is measured and true in so many periods of 10 ms.
inline Numbers fly(World& world, int periods, const std::function<Numbers(double)>& u, int first = 0) {
  Numbers seen;
  for (int k = first; k < first + periods; ++k) {
    const double t = 0.01 * k;
    const Measured now = world.measure(t);
    seen.insert(seen.end(), now.measured.begin(), now.measured.end());
    seen.insert(seen.end(), now.truth.begin(), now.truth.end());
    if (!test::apply(world, t, now.measured, u(t), 0.01, 1)) break;
  }
  return seen;
}

/// One vehicle, and another body where `gap` is given, a post or a vehicle.
enum class Other { none, post, vehicle };
struct Scene {
  Team team;
  Numbers x0;
  std::vector<RobotVehicle> vehicles;
};
inline Scene scene(const Vehicle& vehicle, double z, Other other = Other::none, double gap = 0.0) {
  Scene made;
  made.team.add(VelocityMultirotor{}, {.name = "uav"});
  made.x0 = {0, 0, z, 1, 0, 0, 0, 0, 0};
  made.vehicles = {{BodyId{0}, vehicle}};
  if (other == Other::post) {
    made.team.add(Obstacle{.name = "other"});
    made.x0.insert(made.x0.end(), {gap, 0, z, 0, 0, 0});
  } else if (other == Other::vehicle) {
    made.team.add(VelocityMultirotor{}, {.name = "other"});
    made.x0.insert(made.x0.end(), {gap, 0, z, 1, 0, 0, 0, 0, 0});
    made.vehicles.push_back({BodyId{1}, vehicle});
  }
  return made;
}

/// When and why it ended under the same velocity of the first vehicle; "" where it flew on for so
/// long.
struct End {
  double t = 0.0;
  std::string why;
};
inline End end_of(World& world, const Vec3<double>& v, double duration = 5.0) {
  Numbers u(static_cast<std::size_t>(world.team().nu()));
  u[0] = v.x, u[1] = v.y, u[2] = v.z;
  for (int k = 0; k < std::lround(duration / 0.01); ++k) {
    if (!test::apply(world, 0.01 * k, {}, u, 0.01, 1)) return {0.01 * (k + 1), world.ended()};
  }
  return {duration, ""};
}

}  // namespace sightline::test
