#include <gtest/gtest.h>

#include "sightline/estimator.hpp"
#include "tests/support/filter_derivatives.hpp"

namespace sightline {
namespace {

TEST(Place, ASightingMeansThePoseThatItWasMadeFrom) {
  Random random(1);
  for (int k = 0; k < 500; ++k) {
    const SensorMount mount = random_mount(random, k % 2 == 0 ? MountFrame::body : MountFrame::level);
    const Vec3<double> p = random_point(random, 3), other = random_point(random, 3);
    const double psi = uniform(random, -3, 3);
    const Vec2<double> lean = {uniform(random, -0.5, 0.5), uniform(random, -0.5, 0.5)};
    const Mat<3, 3> R_GB =
        turn_z(psi) * (mount.frame == MountFrame::body ? tilt(lean.x, lean.y) : identity<3>());
    Measurement z = test::random_sighting(random);
    z.p_other = other;
    z.z = transposed(R_GB * mount.attitude()) * (other - p - R_GB * mount.offset);
    const Place place = place_of(z, mount, lean, psi, 0.04, 1e-4);
    EXPECT_LE(norm(place.p - p), 1e-13);
    // d p / d psi, by a small turn.
    const Vec3<double> turned = place_of(z, mount, lean, psi + 1e-6, 0.04, 1e-4).p;
    EXPECT_LE(norm(1e6 * (turned - place.p) - place.per_turn), 1e-5);
    EXPECT_TRUE(Cholesky<3>(place.P - block<3, 3>(z.P_other, 0, 0)).positive);
  }
}

TEST(Place, TheSensorFrameIsThatOfTheModels) {
  Random random(2);
  for (int k = 0; k < 200; ++k) {
    const SensorMount mount = random_mount(random);
    const double psi = uniform(random, -3, 3);
    const Pose<double> robot{random_point(random, 2), {std::cos(psi), std::sin(psi)}};
    const Vec3<double> point = random_point(random, 4);
    Measurement z = test::random_sighting(random);
    z.z = mount(robot, point), z.p_other = point;
    EXPECT_LE(norm(place_of(z, mount, {}, psi, 0.0, 0.0).p - robot.p), 1e-13);
  }
}

TEST(Place, RollAndPitchGoOnWithTheGyroscope) {
  Random random(4);
  for (int k = 0; k < 200; ++k) {
    const MotionSample u = test::random_motion(random);
    const Mat<3, 3> R = tilt(u.roll, u.pitch) * turn(0.005 * u.gyro), level = turn_z(-yaw_of(R)) * R;
    const Vec2<double> later = tilt_at(u, u.t + 0.005);
    EXPECT_LE(test::greatest(level - tilt(later.x, later.y)), 5e-5);
  }
}

}  // namespace
}  // namespace sightline
