#include "sightline/vehicle.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>

#include "sightline/model.hpp"
#include "sightline/world.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using testing::HasSubstr;

std::string refusal(const std::function<void(Vehicle&)>& spoil) {
  Vehicle vehicle = Vehicle::x500();
  spoil(vehicle);
  return refusal_of([&] { vehicle.check(); });
}

TEST(Vehicle, EveryPresetPassesItsOwnCheckAndLiftsAtLeastHalfMoreThanItWeighs) {
  for (const auto& preset : Vehicle::presets()) {
    EXPECT_NO_THROW(preset.part.check()) << preset.name;
    EXPECT_GT(preset.part.thrust_max(), 1.5 * preset.part.weight()) << preset.name;
    const double hover = preset.part.k_f * square(preset.part.hover_speed());
    EXPECT_NEAR(static_cast<double>(preset.part.rotors()) * hover, preset.part.weight(), 1e-12);
  }
}

TEST(Vehicle, TheNumbersOfTheX500AreThoseOfGazebo) {
  const Vehicle v = Vehicle::x500();
  EXPECT_NEAR(v.thrust_max() / v.weight(), 1.69, 0.01);
  EXPECT_NEAR(v.k_f * square(v.speed_max), 8.549, 0.001);
  EXPECT_NEAR(v.hover_drag().x, 0.25, 0.005);
}

TEST(Vehicle, TheArDroneHasTheAccelerationAndTheTopSpeedOf24) {
  const Vehicle v = Vehicle::ar_drone();
  const Multirotor m;
  EXPECT_NEAR(gravity * std::tan(v.tilt_max), m.b_f, 1e-12);
  EXPECT_NEAR(v.hover_drag().x / v.mass, -m.a_f, 1e-12);
  EXPECT_EQ(v.climb_max, m.b_z);
  EXPECT_EQ(v.yaw_max, m.b_psi);
}

TEST(Vehicle, AirIsAsFastAsItsDragTakesToAccelerateTheHoveringVehicle) {
  for (const auto& preset : Vehicle::presets()) {
    const Vehicle& v = preset.part;
    const Vec3<double> a = {1.0, -0.5, 0.2}, air = v.air(a), drag = v.hover_drag();
    EXPECT_NEAR(drag.x * air.x / v.mass, a.x, 1e-12) << preset.name;
    EXPECT_NEAR(drag.y * air.y / v.mass, a.y, 1e-12) << preset.name;
    EXPECT_NEAR(drag.z * air.z / v.mass, a.z, 1e-12) << preset.name;
  }
}

TEST(Vehicle, RefusesWhatCannotFlyInOneSentence) {
  EXPECT_THAT(refusal([](Vehicle& v) { v.mass = 3.2; }),
              HasSubstr("vehicle.mass = 3.2 kg with 4 rotors that lift 34.19 N: thrust to weight 1.09, "
                        "expected at least 1.1"));
  EXPECT_THAT(refusal([](Vehicle& v) {
                v.rotor_x = v.rotor_y = v.spin = {0.2, -0.1, -0.1};
              }),
              HasSubstr("vehicle.rotor_x has 3 rotors, expected 4 to 8"));
  EXPECT_THAT(refusal([](Vehicle& v) { v.spin.pop_back(); }),
              HasSubstr("vehicle.spin has 3 numbers, expected 4"));
  EXPECT_THAT(refusal([](Vehicle& v) {
                v.spin = {1, 1, -1, 0.5};
              }),
              HasSubstr("vehicle.spin = 0.5, expected 1 or -1"));
  EXPECT_THAT(refusal([](Vehicle& v) {
                v.spin = {1, 1, 1, -1};
              }),
              HasSubstr("vehicle.spin sums to 2, expected 0"));
  EXPECT_THAT(refusal([](Vehicle& v) {
                v.spin = {1, -1, -1, 1};
              }),
              HasSubstr("leave an axis without torque"));
  EXPECT_THAT(refusal([](Vehicle& v) { v.rotor_x[0] = 0.3; }), HasSubstr("vehicle.rotor_x sums to"));
  EXPECT_THAT(refusal([](Vehicle& v) { v.tau_up = 0.001; }),
              HasSubstr("vehicle.tau_up = 0.001, expected 0.004 to 1 s"));
  EXPECT_THAT(refusal([](Vehicle& v) { v.tau_down = 0.1; }),
              HasSubstr("with rotors that lag by 0.1 s, expected below 5"));
  EXPECT_THAT(refusal([](Vehicle& v) { v.inertia.z = 0.1; }),
              HasSubstr("none greater than the sum of the other two"));
  EXPECT_THAT(refusal([](Vehicle& v) { v.k_f = std::nan(""); }), HasSubstr("vehicle.k_f = nan"));
}

}  // namespace
}  // namespace sightline
