#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "sightline/model.hpp"
#include "sightline/scenario.hpp"

namespace sightline {
namespace {

std::shared_ptr<GoalTrack> track_of(const Reference& own, double speed = 0.5) {
  return std::make_shared<GoalTrack>(Multirotor{}, own, speed);
}

/// Where a reference is, and its heading.
struct Tracked {
  Vec3<double> p;
  Vec2<double> d;
};
Tracked tracked(const Reference& reference, double t) {
  const Model model{Multirotor{}};
  std::vector<double> x(static_cast<std::size_t>(model.nx())), u(static_cast<std::size_t>(model.nu()));
  reference(t, model, x);
  const Sight<double> s = model.sight(x.data(), u.data());
  return {s.p, s.d};
}

/// All of it, to be compared to the bit.
std::array<double, 5> bits_of(const Tracked& s) { return {s.p.x, s.p.y, s.p.z, s.d.x, s.d.y}; }

const Circle own_circle = {.centre = {0, 0, 1}, .radius = 0.5, .rate = 0.3};

TEST(GoalTrack, UntilTheFirstMessageItIsTheRobotsOwnBitForBit) {
  const Reference own(own_circle);
  const Reference reference = GoalTrack::reference(track_of(own));
  for (double t = 0; t < 10; t += 0.37) {
    EXPECT_EQ(bits_of(tracked(reference, t)), bits_of(tracked(own, t)));
  }
}

TEST(GoalTrack, AGoalIsReachedAtItsSpeedAndHeld) {
  const auto track = track_of(Constant{{0, 0, 1}, 0.0});
  const Reference reference = GoalTrack::reference(track);
  ASSERT_EQ(track->add(2.0, std::vector{Waypoint{.p = {3, 4, 1}, .heading = 0.5}}), GoalAnswer::taken);
  const double arrival = 2.0 + 1.5 * 5.0 / 0.5;
  EXPECT_NEAR(norm(tracked(reference, arrival).p - Vec3<double>{3, 4, 1}), 0.0, 1e-12);
  EXPECT_NEAR(norm(tracked(reference, arrival + 50).p - Vec3<double>{3, 4, 1}), 0.0, 1e-12);
  EXPECT_NEAR(std::atan2(tracked(reference, 60).d.y, tracked(reference, 60).d.x), 0.5, 1e-12);
  double fastest = 0.0;
  for (double t = 2.0; t < arrival; t += 0.01)
    fastest = std::max(fastest, norm(tracked(reference, t + 0.01).p - tracked(reference, t).p) / 0.01);
  EXPECT_NEAR(fastest, 0.5, 1e-3);
}

// Goals and paths at any time, whatever is under way: place and velocity go on without a jump.
TEST(GoalTrack, NoMessageMakesTheReferenceJump) {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> any(-3.0, 3.0), wait(0.1, 3.0);
  for (int flight = 0; flight < 20; ++flight) {
    const auto track = track_of(own_circle);
    const Reference reference = GoalTrack::reference(track);
    double t = 1.0;
    for (int message = 0; message < 20; ++message, t += wait(random)) {
      const Vec3<double> before = tracked(reference, t).p;
      constexpr double h = 1e-5;
      const Vec3<double> v_before = (1 / h) * (before - tracked(reference, t - h).p);
      std::vector<Waypoint> waypoints = {
          {.after = 0, .p = {any(random), any(random), 1 + 0.2 * any(random)}, .heading = any(random)}};
      if (message % 2 == 1) {
        waypoints[0].after = 4.0;
        for (int i = 1; i < 4; ++i)
          waypoints.push_back({4.0 + 2.0 * i, {any(random), any(random), 1.0}, any(random)});
      }
      ASSERT_EQ(track->add(t, waypoints), GoalAnswer::taken);
      EXPECT_NEAR(norm(tracked(reference, t).p - before), 0.0, 1e-12);
      EXPECT_NEAR(norm((1 / h) * (tracked(reference, t + h).p - before) - v_before), 0.0, 1e-3);
    }
  }
}

TEST(GoalTrack, APathIsWhereItsWaypointsSayWhenTheySay) {
  const auto track = track_of(Constant{{0, 0, 1}, 3.0});
  const Reference reference = GoalTrack::reference(track);
  const std::vector<Waypoint> path = {{2, {1, 0, 1}, 3.0}, {4, {1, 2, 1}, -3.0}, {5, {1, 2, 2}, 0.0}};
  ASSERT_EQ(track->add(10.0, path), GoalAnswer::taken);
  for (const Waypoint& w : path) {
    EXPECT_NEAR(norm(tracked(reference, 10.0 + w.after).p - w.p), 0.0, 1e-12);
    EXPECT_NEAR(tracked(reference, 10.0 + w.after).d.x, std::cos(w.heading), 1e-12);
  }
  EXPECT_NEAR(norm(tracked(reference, 13.0).p - Vec3<double>{1, 1, 1}), 0.0, 1e-12);
  // The shorter way round, over pi.
  EXPECT_LT(tracked(reference, 13.0).d.x, -0.99);
  EXPECT_NEAR(norm(tracked(reference, 99.0).p - Vec3<double>{1, 2, 2}), 0.0, 1e-12);
}

// What a log evaluates later is what the controller saw.
TEST(GoalTrack, LaterMessagesChangeNothingOfThePast) {
  const auto track = track_of(own_circle), copy = track_of(own_circle);
  const Reference reference = GoalTrack::reference(track), again = GoalTrack::reference(copy);
  std::vector<std::array<double, 5>> then;
  std::vector<Waypoint> said;
  for (int k = 0; k < 1000; ++k) {
    const double t = 0.01 * k;
    if (k % 130 == 70) (void)track->add(t, std::vector{Waypoint{.p = {0.01 * k, -1, 1}, .heading = 1.0}});
    then.push_back(bits_of(tracked(reference, t)));
  }
  for (std::size_t i = 0; i < track->messages(); ++i) {
    track->waypoints(i, said);
    EXPECT_EQ(copy->add(track->time(i), said), GoalAnswer::taken);
  }
  for (int k = 0; k < 1000; ++k) {
    EXPECT_EQ(bits_of(tracked(reference, 0.01 * k)), then[static_cast<std::size_t>(k)]) << k;
    EXPECT_EQ(bits_of(tracked(again, 0.01 * k)), then[static_cast<std::size_t>(k)]) << k;
  }
  track->clear();
  EXPECT_EQ(bits_of(tracked(reference, 9.0)), bits_of(tracked(Reference(own_circle), 9.0)));
}

TEST(GoalTrack, WhatIsTooFastOrTooMuchChangesNothing) {
  const auto track = track_of(Constant{{0, 0, 1}, 0.0});
  const Reference reference = GoalTrack::reference(track);
  EXPECT_EQ(track->add(1.0, std::vector<Waypoint>{{1.0, {6, 0, 1}, 0.0}}), GoalAnswer::too_fast);
  EXPECT_EQ(track->add(1.0, std::vector<Waypoint>{{2.0, {1, 0, 1}, 0.0}, {2.1, {2, 0, 1}, 0.0}}),
            GoalAnswer::too_fast);
  EXPECT_EQ(norm(tracked(reference, 5.0).p - Vec3<double>{0, 0, 1}), 0.0);
  const std::vector<Waypoint> goal = {{0.0, {0, 0, 1}, 0.0}};
  for (std::size_t i = 0; i < GoalTrack::messages_most; ++i)
    ASSERT_EQ(track->add(static_cast<double>(i), goal), GoalAnswer::taken);
  EXPECT_EQ(track->add(1e9, goal), GoalAnswer::full);
}

}  // namespace
}  // namespace sightline
