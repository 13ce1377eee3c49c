#include "sightline/judge/sampled_motion.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "sightline/model.hpp"
#include "sightline/robots.hpp"
#include "sightline/safety/zone.hpp"
#include "sightline/world.hpp"
#include "tests/support/random_zone.hpp"

namespace sightline {
namespace {

/// Two robots and an obstacle that move by their models, and a motion that sees them at the samples
/// alone.
class Flown {
 public:
  explicit Flown(Team team, double input_delay = 0.0)
      : team_(std::move(team)),
        motion_(team_, input_delay, 0.001),
        sights_(static_cast<std::size_t>(team_.bodies())) {
    sample.x.resize(static_cast<std::size_t>(team_.nx()));
    sample.u.resize(static_cast<std::size_t>(team_.nu()));
    sample.presence.assign(sights_.size(), Presence::steered);
  }

  void look() {
    for (int i = 0; i < team_.bodies(); ++i) sights_[at(BodyId{i})] = true_sight(team_, BodyId{i}, sample);
    motion_.follow(sample, sights_);
  }
  double* state(int body) { return sample.x.data() + team_.state_offset(BodyId{body}); }
  double* input(int body) { return sample.u.data() + team_.input_offset(BodyId{body}); }

  /// What small steps find: least distance of the first two, greatest height of the first, and its
  /// places.
  struct Truth {
    double least, highest;
    std::vector<Vec3<double>> places{};
    double farthest_from(const Vec3<double>& p) const {
      double most = 0.0;
      for (const Vec3<double>& one : places) most = std::max(most, norm(one - p));
      return most;
    }
  };

  /// Moves all bodies by their models for T, the first one also with a wind [m/s]. Where its states
  /// 3 to 5 are its velocity, the wind pushes it [m/s^2].
  Truth fly(double T, const Vec3<double>& wind = {}, const Vec3<double>& push = {}) {
    const int steps = 2000;
    Truth truth{distance(), place(0).z, {place(0)}};
    for (int k = 0; k < steps; ++k) {
      for (int i = 0; i < team_.bodies(); ++i) {
        team_.model(BodyId{i}).step(state(i), input(i), T / steps);
      }
      const std::array w = {wind.x, wind.y, wind.z}, a = {push.x, push.y, push.z};
      for (int axis = 0; axis < 3; ++axis) {
        const double h = T / steps, by = a[static_cast<std::size_t>(axis)];
        state(0)[axis] += h * w[static_cast<std::size_t>(axis)] + 0.5 * h * h * by;
        if (by != 0) state(0)[3 + axis] += h * by;
      }
      truth.least = std::min(truth.least, distance());
      truth.highest = std::max(truth.highest, place(0).z);
      truth.places.push_back(place(0));
    }
    sample.time += T;
    return truth;
  }
  double distance() const { return norm(place(0) - place(1)); }
  double found() {
    Extreme least{std::numeric_limits<double>::infinity(), 0.0};
    least.value = distance();
    motion_.find_least_distance(BodyId{0}, BodyId{1}, least);
    return least.value;
  }
  double highest() {
    Extreme most{place(0).z, 0.0};
    const auto knots = motion_.knots(BodyId{0});
    for (std::size_t k = 0; k + 1 < knots.size(); ++k) find_greatest(knots[k], knots[k + 1], {0, 0, 1}, most);
    return most.value;
  }
  Vec3<double> place(int i) const {
    return team_.model(BodyId{i})
        .sight(sample.x.data() + team_.state_offset(BodyId{i}),
               sample.u.data() + team_.input_offset(BodyId{i}))
        .p;
  }
  SampledMotion& motion() { return motion_; }

  Sample sample;

 private:
  Team team_;
  SampledMotion motion_;
  std::vector<Sight<double>> sights_;
};

template <class A, class B>
Team two() {
  Team team;
  team.add(A{}, {.name = "a"});
  team.add(B{}, {.name = "b"});
  return team;
}

TEST(SampledMotion, TwoThatPassEachOtherBetweenSamplesMeet) {
  Knot from{0.0, {-1.5, 0.3, 0}, {6, 0, 0}}, to{0.5, {1.5, 0.3, 0}, {6, 0, 0}};
  Extreme least{1.5, 0.0};
  find_least_distance(from, to, least);
  EXPECT_NEAR(least.value, 0.3, 1e-9);
  EXPECT_NEAR(least.time, 0.25, 1e-9);
}

TEST(SampledMotion, OnACurveTheLeastDistanceIsThatOfTheCurve) {
  // (x, y) = (-3 + 4 s, (1 - 2 s)^2), and the same backwards.
  const auto at_time = [](double s) { return Vec3<double>{-3 + 4 * s, square(1 - 2 * s), 0}; };
  const auto speed = [](double s) { return Vec3<double>{4, -4 * (1 - 2 * s), 0}; };
  double least_found = std::numeric_limits<double>::infinity();
  for (int k = 0; k <= 100'000; ++k) least_found = std::min(least_found, norm(at_time(k / 100'000.0)));
  const Knot from{0.0, at_time(0), speed(0)}, to{1.0, at_time(1), speed(1)};
  const Knot back_from{0.0, at_time(1), -1.0 * speed(1)}, back_to{1.0, at_time(0), -1.0 * speed(0)};
  for (const auto& [a, b] : {std::pair{from, to}, {back_from, back_to}}) {
    Extreme least{std::min(norm(a.p), norm(b.p)), 0.0};
    find_least_distance(a, b, least);
    EXPECT_NEAR(least.value, least_found, 1e-4);
  }
}

TEST(SampledMotion, AQuickTurnIsFollowedByTheModelInShortSteps) {
  Team team;
  team.add(Multirotor{.b_psi = 6.0}, {.name = "turns"});
  team.add(Multirotor{}, {.name = "rests"});
  Flown flown(std::move(team));
  Model(Multirotor{}).at_rest({{0, 0, 1}, {1, 0}}, flown.state(0));
  Model(Multirotor{}).at_rest({{0, 0.33, 1}, {1, 0}}, flown.state(1));
  flown.state(0)[5] = 2.0;
  flown.input(0)[3] = 1.0;
  flown.look();
  const Flown::Truth truth = flown.fly(0.5);
  flown.look();
  EXPECT_NEAR(flown.found(), truth.least, 1e-3);
}

TEST(SampledMotion, ATurnBetweenSamplesIsFollowedToItsSummit) {
  const Knot from{0.0, {0, 0, 1}, {0, 0, 2}}, to{1.0, {0, 0, 1}, {0, 0, -2}};
  Extreme most{1.0, 0.0};
  find_greatest(from, to, {0, 0, 1}, most);
  EXPECT_NEAR(most.value, 1.5, 1e-5);
  EXPECT_NEAR(most.time, 0.5, 1e-2);
}

// Random straight and curved motions, of states that hold the velocity and of states that do not.
template <class A, class B>
void agrees_with_small_steps(const Vec3<double>& wind = {}, const Vec3<double>& push = {}) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  double worst = 0.0;
  for (int run = 0; run < 300; ++run) {
    Flown flown(two<A, B>());
    const double T = 0.001 * std::pow(500.0, 0.5 + 0.5 * any(random));
    for (int i = 0; i < 2; ++i) {
      const double psi = 3 * any(random);
      (i == 0 ? Model(A{}) : Model(B{}))
          .at_rest(
              {{0.4 * any(random), 0.4 * any(random), 1 + 0.2 * any(random)}, {std::cos(psi), std::sin(psi)}},
              flown.state(i));
    }
    for (double& u : flown.sample.u) u = any(random);
    flown.fly(0.3);  // away from rest
    flown.look();
    for (double& u : flown.sample.u) u = any(random);
    flown.look();  // the same time with the inputs that come: no motion
    const Flown::Truth truth = flown.fly(T, wind, push);
    for (double& u : flown.sample.u) u = any(random);  // of the next update
    flown.look();
    ASSERT_TRUE(flown.motion().moved(BodyId{0}) && flown.motion().moved(BodyId{1}));
    worst =
        std::max({worst, std::abs(flown.found() - truth.least), std::abs(flown.highest() - truth.highest)});
    ASSERT_GE(flown.motion().reach(BodyId{0}), truth.farthest_from(flown.place(0)) - 1e-3);
  }
  EXPECT_LT(worst, 1e-3);
}

TEST(SampledMotion, TheLeastDistanceAndTheGreatestHeightAreThoseOfSmallStepsToAMillimetre) {
  agrees_with_small_steps<Multirotor, Multirotor>();
  agrees_with_small_steps<AngleMultirotor, Multirotor>();
}

/// Commands that act late, of models whose velocity jumps with its command and whose does not:
/// extremes lie at the switch.
template <class Robot>
void follows_late_commands() {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  for (int run = 0; run < 20; ++run) {
    const double T = 0.1 + 0.08 * any(random), delay = (2.5 + 2.4 * any(random)) * T;
    Flown flown(two<Robot, Robot>(), delay);
    for (int i = 0; i < 2; ++i)
      Model(Robot{}).at_rest({{0.4 * any(random), 0.4 * any(random), 1 + 0.2 * any(random)}, {1, 0}},
                             flown.state(i));
    InputDelay late(delay, T, flown.sample.u);
    for (int k = 0; k < 12; ++k) {
      std::vector<double> command(flown.sample.u.size());
      for (double& u : command) u = any(random);
      flown.sample.u = command;
      flown.look();
      late.give(flown.sample.time, command);
      // The robots fly by what is in force.
      Flown::Truth truth{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
      for (double done = 0.0; done < T - 1e-9;) {
        const std::span<const double> held = late.at(flown.sample.time);
        std::copy(held.begin(), held.end(), flown.sample.u.begin());
        const double part = std::min(T - done, std::max(1e-9, late.next_arrival() - flown.sample.time));
        const Flown::Truth of = flown.fly(part);
        truth.least = std::min(truth.least, of.least), truth.highest = std::max(truth.highest, of.highest);
        truth.places.insert(truth.places.end(), of.places.begin(), of.places.end());
        done += part;
      }
      Flown seen = flown;
      seen.look();
      ASSERT_NEAR(seen.found(), truth.least, 1e-3) << run << ", " << k;
      ASSERT_NEAR(seen.highest(), truth.highest, 1e-3) << run << ", " << k;
      ASSERT_GE(seen.motion().reach(BodyId{0}), truth.farthest_from(seen.place(0)) - 1e-3);
    }
  }
}

TEST(SampledMotion, CommandsThatActLateDivideThePeriod) {
  follows_late_commands<Multirotor>();
  follows_late_commands<PointMass>();
  follows_late_commands<AngleMultirotor>();
}

TEST(SampledMotion, AVelocityThatTheModelLacksIsFollowed) {
  agrees_with_small_steps<Multirotor, AngleMultirotor>({0.8, -0.5, 0.3});
}

TEST(SampledMotion, AnAccelerationThatTheModelLacksIsFollowed) {
  agrees_with_small_steps<PointMass, Multirotor>({}, {4.0, -3.0, -9.81});
}

TEST(SampledMotion, WhatComesBackReachedItsSummit) {
  Flown flown(two<PointMass, Multirotor>());
  Model(Multirotor{}).at_rest({{9, 0, 0}, {1, 0}}, flown.state(1));
  flown.state(0)[5] = 3.0;
  flown.input(0)[2] = -12.0;
  flown.look();
  const Flown::Truth truth = flown.fly(0.5);
  flown.look();
  EXPECT_NEAR(flown.place(0).z, 0.0, 1e-9);
  EXPECT_NEAR(truth.highest, 0.375, 1e-3);
  EXPECT_GE(flown.motion().reach(BodyId{0}), truth.highest);
  EXPECT_NEAR(flown.highest(), truth.highest, 1e-3);
}

// In a period that others were missed in, several commands come into force: velocities at its ends
// say nothing of them.
TEST(SampledMotion, WhatComesBackByCommandsThatActLateReachedItsSummit) {
  Flown flown(two<PointMass, Multirotor>(), 0.25);
  Model(Multirotor{}).at_rest({{9, 0, 0}, {1, 0}}, flown.state(1));
  constexpr std::array<double, 3> commands = {3.0, -5.4, 1.6};
  for (std::size_t k = 0; k < commands.size(); ++k) {
    flown.input(0)[2] = commands[k];
    flown.look();
    flown.input(0)[2] = 0.0;
    flown.fly(k < 2 ? 0.1 : 0.05);
  }
  double highest = 0.0;
  for (std::size_t k = 0; k < commands.size(); ++k) {
    flown.input(0)[2] = commands[k];
    highest = std::max(highest, flown.fly(k < 2 ? 0.1 : 0.15).highest);
  }
  flown.look();
  EXPECT_NEAR(flown.place(0).z, 0.0, 1e-9);
  EXPECT_NEAR(flown.state(0)[5], 0.0, 1e-9);
  EXPECT_NEAR(highest, 0.015 + 0.09 / (2 * 5.4), 1e-6);
  EXPECT_GE(flown.motion().reach(BodyId{0}), highest - 1e-9);
  EXPECT_NEAR(flown.highest(), highest, 1e-3);
}

TEST(SampledMotion, FindsTheGreatestDistanceBeyondAZoneThatSmallStepsFind) {
  Random random(12);
  for (int trial = 0; trial < 500; ++trial) {
    const Zone zone = test::random_zone(random);
    const double T = uniform(random, 0.01, 0.1);
    const Knot a{2.0, random_point(random, 5.0), random_point(random, 3.0)},
        b{2.0 + T, a.p + T * a.v + T * T * random_point(random, 10.0), a.v + T * random_point(random, 20.0)};
    Extreme truth{-infinity, 0.0}, found = truth;
    for (int k = 0; k <= 1000; ++k) {
      const double s = k / 1000.0, r = 1 - s;
      const Vec3<double> p = (r * r * (1 + 2 * s)) * a.p + (r * r * s * T) * a.v +
                             (s * s * (3 - 2 * s)) * b.p + (-s * s * r * T) * b.v;
      if (-zone_reserve(zone, p) > truth.value) truth = {-zone_reserve(zone, p), 2.0 + s * T};
    }
    find_greatest(a, b, zone, found);
    EXPECT_GE(found.value, truth.value - 1.1e-4) << trial;
    EXPECT_LE(found.value, truth.value + 1e-3) << trial;
    EXPECT_GE(found.time, 2.0);
    EXPECT_LE(found.time, 2.0 + T + 1e-12);
    Extreme higher{truth.value + 2e-3, 1.0};
    find_greatest(a, b, zone, higher);
    EXPECT_EQ(higher.time, 1.0) << "only raised";
  }
}

TEST(SampledMotion, WhatJoinsOrIsPutElsewhereDoesNotMove) {
  Flown flown(two<Multirotor, Multirotor>());
  for (int i = 0; i < 2; ++i) Model(Multirotor{}).at_rest({{3.0 * i, 0, 1}, {1, 0}}, flown.state(i));
  flown.sample.presence[1] = Presence::absent;
  flown.look();
  flown.sample.time = 0.1;
  flown.sample.presence[1] = Presence::steered;
  flown.look();
  EXPECT_TRUE(flown.motion().moved(BodyId{0}));
  EXPECT_FALSE(flown.motion().moved(BodyId{1})) << "joined";
  flown.sample.time = 0.2;
  flown.state(1)[0] -= 6.0;
  flown.look();
  EXPECT_FALSE(flown.motion().moved(BodyId{1})) << "put elsewhere";
  EXPECT_EQ(flown.motion().reach(BodyId{1}), 0.0);
  flown.sample.time = 0.3;
  flown.sample.truth_known = false;
  flown.look();
  EXPECT_FALSE(flown.motion().moved(BodyId{0})) << "measured";
}

}  // namespace
}  // namespace sightline
