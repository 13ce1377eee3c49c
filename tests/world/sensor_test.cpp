#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <stdexcept>

#include "sightline/sensors.hpp"
#include "tests/support/robots.hpp"

namespace sightline {
namespace {

using Numbers = std::vector<double>;

Team team_of_all() {
  Team team;
  team.add(Multirotor{});
  team.add(AngleMultirotor{});
  team.add(Obstacle{.name = "wall"});
  return team;
}
const Numbers state = {1,    2,   3,    0.6,    0.8, 0.1, -0.1, /**/ 4, 5,  6,
                       3.14, 0.2, -0.2, /**/ 7, 8,   9,   0.3,  0.4,    0.5};

Numbers list(std::span<const double> values) { return {values.begin(), values.end()}; }

TEST(Sensor, WithoutNoiseAndDelayTheMeasurementIsTheStateBitForBit) {
  Sensor sensor(team_of_all());
  for (int k = 0; k < 10; ++k) EXPECT_EQ(list(sensor.measure(0.01 * k, state)), state);
}

TEST(Sensor, ADelayedMeasurementIsThePastState) {
  for (const int late : {0, 1, 6, 100}) {
    Sensor sensor(team_of_all(), {.delay = 0.01 * late});
    for (int k = 0; k < 400; ++k) {
      Numbers x = state;
      x[0] = k;
      const Numbers seen = list(sensor.measure(0.01 * k, x));
      ASSERT_EQ(seen[0], std::max(0, k - late)) << "late " << late << ", k = " << k;
    }
  }
}

TEST(Sensor, ADelayBetweenTwoMeasurementsIsRoundedUp) {
  Sensor sensor(team_of_all(), {.delay = 0.013});
  Numbers x = state;
  for (int k = 0; k < 50; ++k) {
    x[0] = k;
    ASSERT_EQ(sensor.measure(0.01 * k, x)[0], std::max(0, k - 2));
  }
}

TEST(Sensor, NoiseHasItsStandardDeviationAndMeanZero) {
  const Noise noise{.position = 0.005, .heading = 0.01, .velocity = 0.02};
  Sensor sensor(team_of_all(), {.seed = 9, .noise = noise});
  constexpr int n = 20'000;
  Numbers mean(state.size(), 0.0), square_mean(state.size(), 0.0);
  double heading_mean = 0, heading_square = 0;
  for (int k = 0; k < n; ++k) {
    const Numbers seen = list(sensor.measure(0.01 * k, state));
    for (std::size_t i = 0; i < seen.size(); ++i) {
      double error = seen[i] - state[i];
      if (i == 10) error = wrap_angle(error);
      mean[i] += error / n, square_mean[i] += error * error / n;
    }
    const double turn = wrap_angle(std::atan2(seen[4], seen[3]) - std::atan2(state[4], state[3]));
    heading_mean += turn / n, heading_square += turn * turn / n;
  }
  const auto check = [&](std::size_t i, double sigma) {
    EXPECT_NEAR(mean[i], 0.0, 0.04 * sigma) << i;
    EXPECT_NEAR(std::sqrt(square_mean[i]), sigma, 0.03 * sigma) << i;
  };
  for (const std::size_t i : {0U, 1U, 2U, 7U, 8U, 9U, 13U, 14U, 15U}) check(i, noise.position);
  for (const std::size_t i : {5U, 6U, 11U, 12U, 16U, 17U, 18U}) check(i, noise.velocity);
  check(10, noise.heading);
  EXPECT_NEAR(heading_mean, 0.0, 0.04 * noise.heading);
  EXPECT_NEAR(std::sqrt(heading_square), noise.heading, 0.03 * noise.heading);
}

TEST(Sensor, NoiseAndJumpsReachARobotWhoseStatesHaveNoNames) {
  Team team;
  team.add(test::Unicycle{});
  const Numbers x = {1.0, 2.0, 0.5, 0.3};  // p_x, p_y, psi, v
  Sensor noisy(team, {.noise = {.position = 0.1, .heading = 0.1, .velocity = 0.1}});
  const Numbers seen = list(noisy.measure(0.0, x));
  for (std::size_t i = 0; i < x.size(); ++i) EXPECT_NE(seen[i], x[i]) << i;
  Sensor jumping(team, {.faults = {{.kind = FaultKind::jump, .offset = {0.5, -0.5, 3.0}}}});
  EXPECT_EQ(list(jumping.measure(0.0, x)), (Numbers{1.5, 1.5, 0.5, 0.3}));
  Sensor blind(team, {.velocity_unknown = {BodyId{0}}});
  EXPECT_EQ(list(blind.measure(0.0, x)), (Numbers{1.0, 2.0, 0.5, 0.0}));
}

TEST(Sensor, HeadingsStayOnTheCircleUnderNoise) {
  Sensor sensor(team_of_all(), {.noise = {.heading = 1.0}});
  for (int k = 0; k < 2000; ++k) {
    const auto seen = sensor.measure(0.01 * k, state);
    ASSERT_NEAR(std::hypot(seen[3], seen[4]), 1.0, 1e-15);
    ASSERT_LE(std::abs(seen[10]), std::numbers::pi);
  }
}

TEST(Sensor, OneKindOfNoiseLeavesTheOthersAsTheyWere) {
  Sensor some(team_of_all(), {.seed = 3, .noise = {.position = 0.1}});
  Sensor all(team_of_all(), {.seed = 3, .noise = {.position = 0.1, .heading = 0.1, .velocity = 0.1}});
  for (int k = 0; k < 100; ++k) {
    const Numbers a = list(some.measure(0.01 * k, state)), b = list(all.measure(0.01 * k, state));
    for (const std::size_t i : {0U, 1U, 2U, 7U, 8U, 9U, 13U, 14U, 15U}) ASSERT_EQ(a[i], b[i]);
    ASSERT_NE(a[5], b[5]);
  }
}

TEST(Sensor, TheSameSeedSeesTheSameAndAnotherDoesNot) {
  const auto look = [](std::uint64_t seed) {
    Sensor sensor(team_of_all(), {.seed = seed, .noise = {.position = 0.1}});
    sensor.measure(0.0, state);
    return list(sensor.measure(0.01, state));
  };
  EXPECT_EQ(look(1), look(1));
  EXPECT_NE(look(1), look(2));
}

TEST(Sensor, AStateThatIsNotFiniteIsSeenAsItIs) {
  Sensor sensor(team_of_all(), {.noise = {.position = 0.1, .heading = 0.1}});
  Numbers x = state;
  x[3] = std::nan("");
  EXPECT_TRUE(std::isnan(sensor.measure(0.0, x)[3]));
}

TEST(Sensor, RefusesOptionsOutOfTheirRange) {
  EXPECT_THROW(Sensor(team_of_all(), {.noise = {.position = -1}}), std::invalid_argument);
  EXPECT_THROW(Sensor(team_of_all(), {.delay = 2}), std::invalid_argument);
  EXPECT_THROW(Sensor(team_of_all(), {.period = 0}), std::invalid_argument);
}

TEST(Sensor, OdometryIsOffByABiasThatStaysAndDiffersWithTheSeedOfRobotsAlone) {
  const Odometry odometry = {
      .position_bias = 0.1, .heading_bias = 0.05, .velocity_bias = 0.02, .velocity_scale = 0.1};
  const auto off = [&](std::uint64_t seed, int periods) {
    Sensor sensor(team_of_all(), {.seed = seed, .odometry = odometry});
    for (int k = 0; k < periods; ++k) sensor.measure(0.01 * k, state);
    return list(sensor.measure(0.01 * periods, state));
  };
  const Numbers first = off(1, 0), other = off(2, 0);
  EXPECT_EQ(first, off(1, 500));
  for (const std::size_t i : {0U, 1U, 2U, 3U, 4U, 5U, 6U, 7U, 8U, 9U, 10U, 11U, 12U}) {
    EXPECT_NE(first[i], state[i]) << i;
    EXPECT_NE(first[i], other[i]) << i;
  }
  EXPECT_NEAR(std::hypot(first[3], first[4]), 1.0, 1e-15);
  for (std::size_t i = 13; i < state.size(); ++i) EXPECT_EQ(first[i], state[i]) << "the wall's";
}

TEST(Sensor, OdometryIsAddedAsItsErrorsSay) {
  const Odometry odometry = {.position_bias = 0.1,
                             .position_walk = 0.3,
                             .heading_walk = 0.1,
                             .velocity_walk = 0.2,
                             .velocity_scale = 0.1};
  Sensor sensor(team_of_all(), {.seed = 4, .odometry = odometry});
  OdometryErrors expected(odometry, 2, 4, 0);
  double t = 0.0;
  for (int k = 0; k < 100; ++k) {
    const Numbers seen = list(sensor.measure(t, state));
    const Vec3<double>& p = expected.position();
    EXPECT_EQ((Numbers{seen[0], seen[1], seen[2]}), (Numbers{1 + p.x, 2 + p.y, 3 + p.z}));
    EXPECT_NEAR(wrap_angle(std::atan2(seen[4], seen[3]) - std::atan2(0.8, 0.6)),
                wrap_angle(expected.heading()), 1e-14);
    EXPECT_EQ(seen[5], 0.1 + expected.velocity(0, 0.1));
    EXPECT_EQ(seen[6], -0.1 + expected.velocity(1, -0.1));
    const double before = t;
    t += k % 7 == 0 ? 0.05 : 0.01;  // a period that was missed passes too
    expected.advance(t - before);
  }
}

}  // namespace
}  // namespace sightline
