#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "sightline/world.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

TEST(Disturbances, EachFieldOutOfItsRangeIsNamed) {
  const std::vector<std::pair<std::string, std::function<void(Disturbances&)>>> wrong = {
      {"wind", [](Disturbances& d) { d.wind.y = not_a_number; }},
      {"gust.sigma", [](Disturbances& d) { d.gust_sigma = -0.1; }},
      {"gust.time", [](Disturbances& d) { d.gust_time = 0; }},
      {"odometry.position_walk", [](Disturbances& d) { d.odometry.position_walk = -1; }},
      {"input_delay", [](Disturbances& d) { d.input_delay = 1.5; }},
      {"yaw_lag", [](Disturbances& d) { d.yaw_lag = 1e-4; }},
      {"input_gain", [](Disturbances& d) { d.input_gain = 0; }},
      {"noise.heading", [](Disturbances& d) { d.noise.heading = infinite; }},
  };
  for (const auto& [field, spoil] : wrong) {
    Disturbances d;
    spoil(d);
    EXPECT_THAT(refusal_of([&] { d.check(); }), testing::StartsWith("disturbance." + field + " = "));
  }
}

TEST(RandomStream, NormalNumbersHaveMeanZeroVarianceOneAndKurtosisThree) {
  RandomStream stream(5, StreamId::gust, 0);
  constexpr int n = 400'000;
  double first = 0, second = 0, fourth = 0;
  for (int i = 0; i < n; ++i) {
    const double v = stream.normal();
    first += v / n, second += v * v / n, fourth += v * v * v * v / n;
  }
  EXPECT_NEAR(first, 0.0, 0.01);
  EXPECT_NEAR(second, 1.0, 0.01);
  EXPECT_NEAR(fourth, 3.0, 0.1);
}

TEST(RandomStream, UniformNumbersFillTheUnitIntervalEvenly) {
  RandomStream stream(5, StreamId::wake, 0);
  std::vector<int> counts(20, 0);
  for (int i = 0; i < 200'000; ++i) {
    const double v = stream.uniform();
    ASSERT_GT(v, 0.0);
    ASSERT_LE(v, 1.0);
    ++counts[std::min<std::size_t>(19, static_cast<std::size_t>(v * 20))];
  }
  for (const int count : counts) EXPECT_NEAR(count, 10'000, 500);
}

TEST(RandomStream, SeedPurposeAndBodyEachNameAStreamOfItsOwn) {
  const auto correlation = [](RandomStream a, RandomStream b) {
    double sum = 0;
    for (int i = 0; i < 100'000; ++i) sum += a.normal() * b.normal() / 100'000;
    return sum;
  };
  const RandomStream stream(1, StreamId::gust, 0);
  EXPECT_NEAR(correlation(stream, stream), 1.0, 0.02);
  EXPECT_NEAR(correlation(stream, {2, StreamId::gust, 0}), 0.0, 0.02);
  EXPECT_NEAR(correlation(stream, {1, StreamId::wake, 0}), 0.0, 0.02);
  EXPECT_NEAR(correlation(stream, {1, StreamId::gust, 1}), 0.0, 0.02);
}

TEST(Gusts, HaveTheVarianceAndTheCorrelationOfTheProcessForAnyStep) {
  constexpr double sigma = 0.3, time = 0.5;
  for (const double s : {0.01, 0.05, 0.3}) {
    Gusts gusts(sigma, time, 40, 7);
    constexpr int lag = 3, steps = 4000;
    std::vector<std::vector<Vec3<double>>> past;
    double variance = 0, correlation = 0, crossed = 0;
    for (int k = 0; k < steps; ++k) {
      for (int i = 0; i < 40; ++i) {
        const Vec3<double> a = gusts.acceleration(i);
        variance += dot(a, a) / (3 * 40 * steps);
        crossed += a.x * a.y / (40 * steps);
      }
      std::vector<Vec3<double>>& now = past.emplace_back();
      for (int i = 0; i < 40; ++i) now.push_back(gusts.acceleration(i));
      if (k >= lag) {
        for (std::size_t i = 0; i < 40; ++i) {
          correlation += dot(now[i], past[static_cast<std::size_t>(k - lag)][i]) / (3 * 40 * (steps - lag));
        }
      }
      gusts.advance(s);
    }
    EXPECT_NEAR(variance, sigma * sigma, 0.05 * sigma * sigma) << s;
    EXPECT_NEAR(correlation / variance, std::exp(-lag * s / time), 0.05) << s;
    EXPECT_NEAR(crossed, 0.0, 0.05 * sigma * sigma) << s;
  }
}

TEST(Gusts, OneMoreRobotLeavesTheOthersGustsAsTheyWere) {
  Gusts three(0.2, 1.0, 3, 11), four(0.2, 1.0, 4, 11);
  for (int k = 0; k < 100; ++k) {
    for (int i = 0; i < 3; ++i) ASSERT_EQ(three.acceleration(i).x, four.acceleration(i).x);
    three.advance(0.01);
    four.advance(0.01);
  }
}

// The largest push on the first of two robots over 20 s.
Vec3<double> largest_push(const Airflow& airflow, const Vec3<double>& offset) {
  Wakes wakes(airflow, 2, 4);
  const std::vector<Vec3<double>> p = {{1, 2, 3}, Vec3<double>{1, 2, 3} + offset};
  Vec3<double> largest{};
  for (int k = 0; k < 2000; ++k) {
    std::vector<Vec3<double>> a(2);
    wakes.push(p, a);
    largest = {std::max(largest.x, std::abs(a[0].x)), std::max(largest.y, std::abs(a[0].y)),
               std::max(largest.z, std::abs(a[0].z))};
    wakes.advance(0.01);
  }
  return largest;
}

TEST(Wakes, PushAcrossTheLineWithTheAmplitudeGivenAtTheDistance) {
  const Airflow airflow{.amplitude = 0.15, .distance = 1.5};
  const Vec3<double> level = largest_push(airflow, {1.5, 0, 0});
  EXPECT_NEAR(level.y, 0.15, 1e-3);
  EXPECT_EQ(level.x, 0.0);
  EXPECT_EQ(level.z, 0.0);
  const Vec3<double> slanted = largest_push(airflow, {0, 1.2, 0.9});
  EXPECT_NEAR(slanted.x, 0.15, 1e-3);
  EXPECT_EQ(slanted.y, 0.0);
}

TEST(Wakes, GrowWithTheInverseSquareOfTheDistanceUpToTheirCap) {
  const Airflow airflow{.amplitude = 0.15, .distance = 1.5};
  double previous = 0.0;
  for (const double D : {6.0, 3.0, 1.5, 1.0, 0.76}) {
    const double push = largest_push(airflow, {D, 0, 0}).y;
    EXPECT_NEAR(push, 0.15 * square(1.5 / D), 0.01 * push) << D;
    EXPECT_GT(push, previous);
    previous = push;
  }
  for (const double D : {0.75, 0.1, 1e-9}) EXPECT_NEAR(largest_push(airflow, {D, 0, 0}).y, 0.6, 0.01) << D;
  EXPECT_EQ(largest_push(airflow, {0, 0, 1}).y, 0.0) << "right above";
}

TEST(Wakes, SwingAtTheirFrequency) {
  // Falls from above one half to below minus one half, once in a period of 2 s.
  const Airflow airflow{.amplitude = 1.0, .distance = 1.0, .frequency = 0.5};
  int falls = 0;
  for (std::uint64_t seed = 0; seed < 20; ++seed) {
    Wakes wakes(airflow, 2, seed);
    bool high = false;
    for (int k = 0; k < 10'000; ++k) {
      std::vector<Vec3<double>> a(2);
      wakes.push(std::vector<Vec3<double>>{{0, 0, 0}, {1, 0, 0}}, a);
      if (high && a[0].y < -0.5) {
        ++falls;
        high = false;
      }
      high = high || a[0].y > 0.5;
      wakes.advance(0.01);
    }
  }
  EXPECT_NEAR(falls, 20 * 50, 20);
}

TEST(InputDelay, ACommandComesIntoForceItsDelayAfterItWasGiven) {
  const std::vector<double> initial = {-1.0};
  for (const double delay : {0.0, 0.004, 0.06, 0.0625}) {
    InputDelay line(delay, 0.01, initial);
    for (int k = 0; k < 100; ++k) {
      const double t = 0.01 * k;
      line.give(t, std::vector<double>{static_cast<double>(k)});
      const double expected = std::max(-1.0, std::floor((t - delay) / 0.01 + 1e-6));
      ASSERT_EQ(line.at(t)[0], t + 1e-9 < delay ? -1.0 : expected) << "delay " << delay << " at " << t;
      ASSERT_GT(line.next_arrival(), t);
    }
  }
}

TEST(InputDelay, OfCommandsFasterThanItsPeriodItKeepsTheLatestAndStaysInOrder) {
  InputDelay line(0.05, 0.01, std::vector<double>{-1.0});
  double previous = -1.0;
  for (int k = 0; k < 1000; ++k) {
    const double t = 0.001 * k;
    line.give(t, std::vector<double>{static_cast<double>(k)});
    const double now = line.at(t)[0];
    ASSERT_GE(now, previous);
    ASSERT_LE(now, std::max(-1.0, k - 49.0));
    previous = now;
  }
  EXPECT_EQ(line.at(2.0)[0], 999.0);
}

TEST(Disturbances, SpoilMeasurementsByNoiseDriftAndDelayAlone) {
  for (const Disturbances& d :
       {Disturbances{.noise = {.position = 0.1}}, Disturbances{.noise = {.heading = 0.1}},
        Disturbances{.noise = {.velocity = 0.1}}, Disturbances{.odometry = {.heading_walk = 0.1}},
        Disturbances{.measurement_delay = 0.1}})
    EXPECT_TRUE(d.spoil_measurements());
  EXPECT_FALSE(Disturbances{}.spoil_measurements());
  EXPECT_FALSE((Disturbances{.wind = {1, 0, 0}, .gust_sigma = 0.1, .input_delay = 0.1}.spoil_measurements()));
}

constexpr Odometry drifting = {.position_bias = 0.1,
                               .position_walk = 0.02,
                               .heading_bias = 0.05,
                               .heading_walk = 0.01,
                               .velocity_bias = 0.03,
                               .velocity_walk = 0.004,
                               .velocity_scale = 0.08};

TEST(OdometryErrors, WhatIsDrawnOfManyFlightsHasItsStandardDeviation) {
  constexpr int flights = 5000;
  double position = 0, heading = 0, velocity = 0, scale = 0;
  for (int seed = 0; seed < flights; ++seed) {
    const OdometryErrors off(drifting, 2, static_cast<std::uint64_t>(seed), 1);
    position += dot(off.position(), off.position()) / (3 * flights);
    heading += square(off.heading()) / flights;
    velocity += (square(off.velocity(0, 0)) + square(off.velocity(1, 0))) / (2 * flights);
    scale += square((off.velocity(1, 3) - off.velocity(1, 1)) / 2) / flights;
  }
  EXPECT_NEAR(std::sqrt(position), 0.1, 0.03 * 0.1);
  EXPECT_NEAR(std::sqrt(heading), 0.05, 0.03 * 0.05);
  EXPECT_NEAR(std::sqrt(velocity), 0.03, 0.03 * 0.03);
  EXPECT_NEAR(std::sqrt(scale), 0.08, 0.03 * 0.08);
}

// The law by which a random walk shows in an Allan plot, for any step.
TEST(OdometryErrors, AWalkMovesByItsDensityTimesTheRootOfTheTime) {
  for (const double step : {0.01, 0.1}) {
    for (const double lag : {0.2, 2.0}) {
      double position = 0, heading = 0, velocity = 0;
      constexpr int flights = 200, parts = 20;
      for (int seed = 0; seed < flights; ++seed) {
        OdometryErrors off(drifting, 1, static_cast<std::uint64_t>(seed), 0);
        for (int part = 0; part < parts; ++part) {
          const OdometryErrors before = off;
          for (int k = 0; k < std::lround(lag / step); ++k) off.advance(step);
          const Vec3<double> moved = off.position() - before.position();
          position += dot(moved, moved) / (3 * flights * parts);
          heading += square(off.heading() - before.heading()) / (flights * parts);
          velocity += square(off.velocity(0, 0) - before.velocity(0, 0)) / (flights * parts);
        }
      }
      const auto near = [&](double variance, double density) {
        EXPECT_NEAR(variance, square(density) * lag, 0.1 * square(density) * lag) << step << ' ' << lag;
      };
      near(position, 0.02), near(heading, 0.01), near(velocity, 0.004);
    }
  }
}

TEST(OdometryErrors, WithoutWalkTheyStayAsTheyWereDrawn) {
  Odometry fixed = drifting;
  fixed.position_walk = fixed.heading_walk = fixed.velocity_walk = 0;
  OdometryErrors off(fixed, 1, 3, 0), walking(drifting, 1, 3, 0);
  EXPECT_EQ(off.position().x, walking.position().x) << "a walk leaves the start as it was";
  for (int k = 0; k < 100; ++k) off.advance(0.01), walking.advance(0.01);
  const OdometryErrors fresh(fixed, 1, 3, 0);
  EXPECT_EQ(norm(off.position() - fresh.position()), 0.0);
  EXPECT_EQ(off.heading(), fresh.heading());
  EXPECT_EQ(off.velocity(0, 1.5), fresh.velocity(0, 1.5));
  EXPECT_NE(walking.position().x, off.position().x);
}

}  // namespace
}  // namespace sightline
