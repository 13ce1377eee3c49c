#include "sightline/record/sampled_motion.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "sightline/model/robots.hpp"

namespace sightline {
namespace {

/// Two robots and an obstacle that move by their models, and a motion that sees them at the samples alone.
class Flown {
 public:
  explicit Flown(Team team)
      : team_(std::move(team)), motion_(team_), sights_(static_cast<std::size_t>(team_.bodies())) {
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

  /// Moves all bodies by their models for T in small steps. @return the least distance of the first two, and greatest height of the first
  std::pair<double, double> fly(double T, const Vec3<double>& wind = {}) {
    const int steps = 2000;
    double least = distance(), highest = place(0).z;
    for (int k = 0; k < steps; ++k) {
      for (int i = 0; i < team_.bodies(); ++i) {
        team_.model(BodyId{i}).step(state(i), input(i), T / steps);
        for (int axis = 0; axis < 3; ++axis)
          if (i == 0) state(i)[axis] += T / steps * (axis == 0 ? wind.x : axis == 1 ? wind.y : wind.z);
      }
      least = std::min(least, distance());
      highest = std::max(highest, place(0).z);
    }
    sample.time += T;
    return {least, highest};
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
  SampledMotion& motion() { return motion_; }

  Sample sample;

 private:
  Vec3<double> place(int i) const {
    return team_.model(BodyId{i})
        .sight(sample.x.data() + team_.state_offset(BodyId{i}),
               sample.u.data() + team_.input_offset(BodyId{i}))
        .p;
  }
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

TEST(SampledMotion, ATurnBetweenSamplesIsFollowedToItsSummit) {
  const Knot from{0.0, {0, 0, 1}, {0, 0, 2}}, to{1.0, {0, 0, 1}, {0, 0, -2}};
  Extreme most{1.0, 0.0};
  find_greatest(from, to, {0, 0, 1}, most);
  EXPECT_NEAR(most.value, 1.5, 1e-5);
  EXPECT_NEAR(most.time, 0.5, 1e-2);
}

// Random straight and curved motions, of states that hold the velocity and of states that do not.
template <class A, class B>
void agrees_with_small_steps(const Vec3<double>& wind = {}) {
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
    const auto [least, highest] = flown.fly(T, wind);
    flown.look();
    ASSERT_TRUE(flown.motion().moved(BodyId{0}) && flown.motion().moved(BodyId{1}));
    worst = std::max({worst, std::abs(flown.found() - least), std::abs(flown.highest() - highest)});
  }
  EXPECT_LT(worst, 1e-3);
}

TEST(SampledMotion, TheLeastDistanceAndTheGreatestHeightAreThoseOfSmallStepsToAMillimetre) {
  agrees_with_small_steps<Multirotor, Multirotor>();
  agrees_with_small_steps<AngleMultirotor, Multirotor>();
}

TEST(SampledMotion, AVelocityThatTheModelLacksIsFollowed) {
  agrees_with_small_steps<Multirotor, AngleMultirotor>({0.8, -0.5, 0.3});
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
