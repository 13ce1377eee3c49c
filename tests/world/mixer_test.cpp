#include "sightline/world/mixer.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "tests/support/hexacopter.hpp"
#include "tests/support/wrench.hpp"

namespace sightline {
namespace {

using test::RotorWrench;
using test::wrench;

std::vector<Vehicle> mixed_vehicles() {
  std::vector<Vehicle> all = all_vehicles();
  // Neither symmetric nor on a circle.
  Vehicle odd = Vehicle::x500();
  odd.rotor_x = {0.3, -0.2, 0.1, -0.2}, odd.rotor_y = {-0.25, 0.2, 0.2, -0.15};
  odd.check();
  all.push_back(odd);
  return all;
}

TEST(Mixer, GivesTheThrustAndTheTorqueWhereNoRotorIsAtItsEnd) {
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> within(-1, 1);
  for (const Vehicle& v : mixed_vehicles()) {
    const Mixer mix(v);
    const double f = v.weight() / static_cast<double>(v.rotors()), arm = 0.2 * v.radius;
    for (int k = 0; k < 1000; ++k) {
      const double thrust = v.weight() * (1 + 0.1 * within(random));
      const Vec3<double> torque = {0.5 * f * arm * within(random), 0.5 * f * arm * within(random),
                                   0.1 * f * v.k_m * within(random)};
      const RotorWrench w = wrench(v, mix(thrust, torque));
      EXPECT_NEAR(w.thrust, thrust, 1e-12 * v.weight());
      EXPECT_LT(norm(w.torque - torque), 1e-12 * v.weight());
    }
  }
}

TEST(Mixer, KeepsTheTiltWhateverYawIsAskedForAndGivesYawWhatIsLeft) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> within(-1, 1);
  for (const Vehicle& v : mixed_vehicles()) {
    const Mixer mix(v);
    const double most = v.thrust_max() / static_cast<double>(v.rotors());
    for (int k = 0; k < 1000; ++k) {
      const Vec3<double> tilt = {0.4 * most * v.radius * within(random),
                                 0.4 * most * v.radius * within(random), 0};
      const double yaw = 20 * most * v.k_m * within(random);
      const Thrusts without = mix(v.weight(), tilt), with = mix(v.weight(), tilt + Vec3<double>{0, 0, yaw});
      const RotorWrench calm = wrench(v, without), turning = wrench(v, with);
      EXPECT_NEAR(turning.torque.x, calm.torque.x, 1e-12 * v.weight());
      EXPECT_NEAR(turning.torque.y, calm.torque.y, 1e-12 * v.weight());
      EXPECT_NEAR(turning.thrust, calm.thrust, 1e-12 * v.weight());
      EXPECT_GE(turning.torque.z * yaw, -1e-12);
      EXPECT_LE(std::abs(turning.torque.z - calm.torque.z), std::abs(yaw) * (1 + 1e-12));
      for (std::size_t i = 0; i < v.rotors(); ++i) {
        EXPECT_GE(with[i], 0.0);
        EXPECT_LE(with[i], most);
      }
    }
  }
}

TEST(Mixer, MovesTheCollectiveToMakeRoomForTheTilt) {
  const Vehicle v = Vehicle::x500();
  const Mixer mix(v);
  const double most = v.thrust_max() / 4;
  const Vec3<double> tilt = {1.2 * most * 0.174, 0, 0};
  for (const double thrust : {0.0, v.weight(), 2 * v.thrust_max()}) {
    const RotorWrench w = wrench(v, mix(thrust, tilt));
    EXPECT_NEAR(w.torque.x, tilt.x, 1e-12);
    EXPECT_NEAR(w.torque.y, 0.0, 1e-12);
  }
  EXPECT_LT(wrench(v, mix(2 * v.thrust_max(), tilt)).thrust, v.thrust_max());
  EXPECT_GT(wrench(v, mix(0.0, tilt)).thrust, 0.0);
}

TEST(Mixer, ATiltBeyondAllRotorsIsScaledAndKeepsItsDirection) {
  for (const Vehicle& v : mixed_vehicles()) {
    const Vec3<double> tilt = {100.0, 50.0, 0.0};
    const RotorWrench w = wrench(v, Mixer(v)(v.weight(), tilt));
    EXPECT_GT(w.torque.x, 0.0);
    EXPECT_NEAR(w.torque.y, 0.5 * w.torque.x, 1e-9 * w.torque.x);
  }
}

}  // namespace
}  // namespace sightline
