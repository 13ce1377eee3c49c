#include <gtest/gtest.h>

#include <cmath>

#include "sightline/model.hpp"
#include "sightline/robots.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

TEST(OmniRover, TheRateIsThatOfTheMultirotorThatDoesNotClimb) {
  Random random(1);
  for (int k = 0; k < 1000; ++k) {
    const auto c = uniform_array<5>(random, -2, 2);
    const OmniRover rover{.b_psi = c[0], .a_f = c[1], .b_f = c[2], .a_s = c[3], .b_s = c[4]};
    const Multirotor flying{.b_psi = c[0], .a_f = c[1], .b_f = c[2], .a_s = c[3], .b_s = c[4]};
    const auto x = uniform_array<7>(random, -2, 2);
    const auto u = uniform_array<3>(random, -1, 1);
    EXPECT_EQ(rover.f(x, u), flying.f(x, {u[0], u[1], 0.0, u[2]}));
  }
}

TEST(Unicycle, MovesAsTheOmniRoverThatNeverDrivesSideward) {
  Random random(2);
  for (int k = 0; k < 1000; ++k) {
    const auto c = uniform_array<3>(random, -2, 2);
    const Unicycle one{.b_psi = c[0], .a_f = c[1], .b_f = c[2]};
    const OmniRover omni{.b_psi = c[0], .a_f = c[1], .b_f = c[2]};
    const auto x = uniform_array<6>(random, -2, 2);
    const auto u = uniform_array<2>(random, -1, 1);
    const auto rate = one.f(x, u);
    const auto expected = omni.f<double>({x[0], x[1], x[2], x[3], x[4], x[5], 0.0}, {u[0], 0.0, u[1]});
    for (std::size_t i = 0; i < rate.size(); ++i) EXPECT_EQ(rate[i], expected[i]) << i;
  }
}

TEST(GroundRobots, TheHeightIsThatOfTheStartForEver) {
  Random random(4);
  for (const Model& model : {Model(OmniRover{}), Model(Unicycle{})}) {
    const Pose<double> start = random_pose(random, 2);
    std::vector<double> x(static_cast<std::size_t>(model.nx()));
    model.at_rest(start, x.data());
    for (int k = 0; k < 1000; ++k) {
      const auto u = uniform_array<3>(random, -1, 1);
      model.step(x.data(), u.data(), 0.01);
      ASSERT_TRUE(model.normalise(x.data()));
      EXPECT_EQ(model.sight(x.data(), u.data()).p.z, start.p.z);
      EXPECT_EQ(model.sight(x.data(), u.data()).v.z, 0.0);
    }
    EXPECT_GT(std::hypot(x[0] - start.p.x, x[1] - start.p.y), 0.01);
  }
}

TEST(GroundRobots, FullCommandEndsInOneMetrePerSecond) {
  for (const Model& model : {Model(OmniRover{}), Model(Unicycle{})}) {
    std::vector<double> x(static_cast<std::size_t>(model.nx()));
    model.at_rest({{}, {0.6, 0.8}}, x.data());
    const std::array<double, 3> forward = {1, 0, 0};
    for (int k = 0; k < 1500; ++k) model.step(x.data(), forward.data(), 0.01);
    const Vec3<double> v = model.sight(x.data(), forward.data()).v;
    EXPECT_NEAR(v.x, 0.6, 1e-9);
    EXPECT_NEAR(v.y, 0.8, 1e-9);
  }
}

}  // namespace
}  // namespace sightline
