#include "bridges/dds/links/velocity_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "cli/allocations.hpp"

namespace sightline::dds {
namespace {

using Outcome = VelocityFit::Outcome;
constexpr Nanoseconds fit_ms = 1'000'000;

struct Moving {
  Vec3<double> p{}, v{};
  double heading = 0.0, rate = 0.0;
};
using Trajectory = std::function<Moving(double)>;

Quaternion facing(double heading) { return upright({std::cos(heading), std::sin(heading)}); }

/// What a fit says after poses at these stamps.
struct Fitted {
  VelocityFit fit;
  Motion motion{};
  Outcome outcome{};

  void take(const Trajectory& trajectory, Nanoseconds stamp, double noise = 0.0) {
    const Moving m = trajectory(1e-9 * static_cast<double>(stamp));
    outcome = fit.take({m.p.x + noise, m.p.y, m.p.z}, facing(m.heading), stamp, motion);
  }
};

/// v(t) = v + a t, and a heading that goes round with an acceleration too.
Trajectory parabola(const Vec3<double>& v, const Vec3<double>& a, double rate, double turn) {
  return [=](double t) {
    return Moving{t * v + 0.5 * t * t * a, v + t * a, rate * t + 0.5 * turn * t * t, rate + turn * t};
  };
}

TEST(VelocityFit, AParabolaIsGivenExactlyWhateverTheStampsJitterAndLose) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  std::uniform_int_distribution<Nanoseconds> jitter(-4 * fit_ms, 4 * fit_ms);
  std::bernoulli_distribution lost(0.2);
  for (int flight = 0; flight < 50; ++flight) {
    const Trajectory trajectory =
        parabola({3 * any(random), any(random), any(random)}, {4 * any(random), any(random), any(random)},
                 3 * any(random), 2 * any(random));
    Fitted fitted;
    int good = 0;
    for (Nanoseconds k = 1; k < 100; ++k) {
      if (lost(random)) continue;
      const Nanoseconds stamp = 10 * k * fit_ms + jitter(random);
      fitted.take(trajectory, stamp);
      ASSERT_NE(fitted.outcome, Outcome::jump) << k;
      if (fitted.outcome != Outcome::good) continue;
      ++good;
      const Moving m = trajectory(1e-9 * static_cast<double>(stamp));
      EXPECT_NEAR(fitted.motion.v.x, m.v.x, 1e-6);
      EXPECT_NEAR(fitted.motion.v.y, m.v.y, 1e-6);
      EXPECT_NEAR(fitted.motion.v.z, m.v.z, 1e-6);
      EXPECT_NEAR(fitted.motion.r, m.rate, 1e-6);
      EXPECT_EQ(fitted.motion.p.x, m.p.x);
    }
    EXPECT_GT(good, 60);
  }
}

// What the header says of lag, gain and noise.
TEST(VelocityFit, ASineComesAsLateAndAsLargeAsDocumented) {
  const auto error_at = [](double f, double gain, double late) {
    const double w = 2 * std::acos(-1.0) * f;
    const Trajectory sine = [w](double t) {
      return Moving{{0.1 * std::sin(w * t), 0, 0}, {0.1 * w * std::cos(w * t), 0, 0}, 0.0, 0.0};
    };
    Fitted fitted;
    double worst = 0.0;
    for (Nanoseconds k = 1; k < 300; ++k) {
      fitted.take(sine, 10 * k * fit_ms);
      if (k < 20) continue;
      EXPECT_EQ(fitted.outcome, Outcome::good);
      const double t = 0.01 * static_cast<double>(k);
      worst = std::max(worst, std::abs(fitted.motion.v.x - gain * sine(t - late).v.x));
    }
    return worst / (0.1 * w);
  };
  EXPECT_LT(error_at(1.0, 1.036, 1.4e-3), 2e-3);
  EXPECT_LT(error_at(3.0, 1.254, 9.0e-3), 2e-3);
}

TEST(VelocityFit, NoiseOfPosesBecomesAsMuchNoiseAsDocumented) {
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0.0, 0.3e-3);
  const Trajectory still = [](double) { return Moving{}; };
  Fitted fitted;
  double squares = 0.0;
  int n = 0;
  for (Nanoseconds k = 1; k < 5000; ++k) {
    fitted.take(still, 10 * k * fit_ms, noise(random));
    if (k < 20) continue;
    squares += fitted.motion.v.x * fitted.motion.v.x;
    ++n;
  }
  EXPECT_NEAR(std::sqrt(squares / n), 0.0106, 0.0010);
}

TEST(VelocityFit, RatesFromTwentyHertzToAThousandSuit) {
  for (const Nanoseconds step :
       {Nanoseconds{1}, Nanoseconds{2}, Nanoseconds{5}, Nanoseconds{20}, Nanoseconds{50}}) {
    const Trajectory trajectory = parabola({1, 0, 0}, {0, 2, 0}, 1.0, 0.0);
    Fitted fitted;
    for (Nanoseconds k = 1; k * step < 1000; ++k) fitted.take(trajectory, k * step * fit_ms);
    EXPECT_EQ(fitted.outcome, Outcome::good) << step;
    EXPECT_NEAR(fitted.motion.v.x, 1.0, 1e-6) << step;
    EXPECT_NEAR(fitted.motion.r, 1.0, 1e-6) << step;
  }
}

TEST(VelocityFit, OneThatJumpsIsLeftOutAndABodyThatStaysElsewhereIsFollowed) {
  const Trajectory trajectory = parabola({0.5, 0, 0}, {}, 0.0, 0.0);
  const auto moved = [&](double by) {
    return [trajectory, by](double t) {
      Moving m = trajectory(t);
      m.p.x += by;
      return m;
    };
  };
  for (const double by : {0.2, -3.0, 100.0}) {
    Fitted fitted;
    Nanoseconds k = 1;
    for (; k < 30; ++k) fitted.take(trajectory, 10 * k * fit_ms);
    // Another body for two messages.
    for (int i = 0; i < 2; ++i) {
      fitted.take(moved(by), 10 * k++ * fit_ms);
      EXPECT_EQ(fitted.outcome, Outcome::jump) << by;
    }
    fitted.take(trajectory, 10 * k++ * fit_ms);
    EXPECT_EQ(fitted.outcome, Outcome::good) << by;
    EXPECT_NEAR(fitted.motion.v.x, 0.5, 1e-6) << by;
    // From now on there: after six messages with its velocity.
    for (int i = 0; i < 6; ++i) {
      fitted.take(moved(by), 10 * k++ * fit_ms);
      EXPECT_EQ(fitted.outcome == Outcome::good, i == 5) << by << " " << i;
    }
    EXPECT_NEAR(fitted.motion.v.x, 0.5, 1e-6) << by;
  }
}

TEST(VelocityFit, WhatComesAfterASilenceDoesNotCountAsMotion) {
  const Trajectory trajectory = parabola({1.0, 0, 0}, {}, 0.0, 0.0);
  Fitted fitted;
  for (Nanoseconds k = 1; k < 30; ++k) fitted.take(trajectory, 10 * k * fit_ms);
  // A fifth of a second of nothing goes on, over the gap.
  fitted.take(trajectory, 490 * fit_ms);
  EXPECT_EQ(fitted.outcome, Outcome::good);
  EXPECT_NEAR(fitted.motion.v.x, 1.0, 1e-6);
  // Longer ones begin anew.
  for (Nanoseconds k = 0; k < 4; ++k) {
    fitted.take([](double) { return Moving{{7, 0, 0}, {}, 0, 0}; }, (2000 + 10 * k) * fit_ms);
    EXPECT_EQ(fitted.outcome, k < 3 ? Outcome::too_few : Outcome::good);
  }
  EXPECT_NEAR(fitted.motion.v.x, 0.0, 1e-9);
}

TEST(VelocityFit, AHeadingGoesRoundAndABodyWithoutOneHasNoRate) {
  const Trajectory turning = parabola({}, {}, 6.0, 0.0);
  Fitted fitted;
  for (Nanoseconds k = 1; k < 1000; ++k) {
    fitted.take(turning, 10 * k * fit_ms);
    if (k < 6) continue;
    ASSERT_NEAR(fitted.motion.r, 6.0, 1e-6) << k;
  }
  VelocityFit marker;
  Motion motion;
  for (Nanoseconds k = 1; k < 10; ++k) (void)marker.take({1, 2, 3}, no_attitude, 10 * k * fit_ms, motion);
  EXPECT_EQ(motion.r, 0.0);
}

TEST(VelocityFit, NothingIsAllocated) {
  VelocityFit fit;
  Motion motion;
  const std::int64_t before = cli::allocations();
  for (Nanoseconds k = 1; k < 1000; ++k) (void)fit.take({1, 2, 3}, facing(0.1), 10 * k * fit_ms, motion);
  EXPECT_EQ(cli::allocations(), before);
}

}  // namespace
}  // namespace sightline::dds
