#include <gtest/gtest.h>

#include <cmath>

#include "sightline/events.hpp"
#include "tests/support/counted_new.hpp"
#include "tests/support/random.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

/// As r^2, up to 5 m.
ViewVariance square_variance() {
  ViewVariance variance;
  for (int i = 0; i <= 50; ++i) variance.values.push_back(1e-4 * square(0.1 * i));
  return variance;
}

/// Robots in a plane that a chooser looks at: the first ones are anchors.
struct Plane {
  Team team;
  ViewChoice choice{.name = "who", .margin = 0.0, .dwell = 1.0};
  std::vector<double> x, u;
  std::vector<Presence> presence;
  double t = 0.0;

  Plane(int robots, int anchors) {
    for (int i = 0; i < robots; ++i) {
      team.add(Multirotor{});
      choice.targets.push_back(BodyId{i});
      if (i >= anchors) choice.observers.push_back(AgentId{{i}});
      x.insert(x.end(), {0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 0.0});
    }
    u.resize(static_cast<std::size_t>(team.nu()));
    presence.assign(static_cast<std::size_t>(robots), Presence::steered);
    choice.variances.assign(choice.observers.size() * choice.targets.size(), square_variance());
    choice.first.assign(choice.observers.size(), ViewChoice::nobody);
  }
  void put(int robot, double px, double py, double heading = 0.0) {
    double* const to = &x[static_cast<std::size_t>(team.state_offset(BodyId{robot}))];
    to[0] = px, to[1] = py, to[3] = std::cos(heading), to[4] = std::sin(heading);
  }
  void look(ViewChooser& chooser, double dt = 0.1) {
    ConditionState none;
    const EventContext known{.t = t, .x = x, .u = u, .ages = {}, .presence = presence};
    chooser.look({team, known, 0.0, false, none});
    t += dt;
  }
};

TEST(ViewChoice, AVarianceIsInterpolatedAndInfiniteBeyondItsEnd) {
  const ViewVariance v{.step = 0.5, .values = {1.0, 2.0, 4.0}};
  EXPECT_EQ(v.at(0.0), 1.0);
  EXPECT_EQ(v.at(0.25), 1.5);
  EXPECT_EQ(v.at(1.0), 4.0);
  EXPECT_EQ(v.at(1.01), infinite);
  EXPECT_EQ(v.at(not_a_number), infinite);
  EXPECT_EQ(ViewVariance{}.at(0.0), infinite);
}

TEST(ViewChoice, ATurnCostsTheVarianceThatIsGainedBlind) {
  const TurnPrice price;
  const double t = 0.2 + 1.0 / 1.2;
  EXPECT_DOUBLE_EQ(price(1.0), 0.25 * (0.0025 * t + 0.0064 * t * t));
}

TEST(ViewChoice, AtFirstEachLooksWhereItKnowsItsPlaceBest) {
  // 2 is far from both anchors, and 1 is on the way.
  Plane plane(3, 1);
  plane.put(1, 3.0, 0.0, 3.14);
  plane.put(2, 6.0, 0.0, 3.14);
  const std::vector<int> first = ViewChooser::first(
      plane.choice, plane.team, {.t = 0.0, .x = plane.x, .u = plane.u, .ages = {}, .presence = {}});
  EXPECT_EQ(first, (std::vector<int>{0, 1}));
}

TEST(ViewChoice, ATurnHasToBeWorthItForAsLongAsTheDwell) {
  // Two anchors ahead and behind; the observer goes from one to the other.
  Plane plane(3, 2);
  plane.put(0, 0.0, 0.0), plane.put(1, 4.0, 0.0), plane.put(2, 1.0, 0.0, 3.1416);
  plane.choice.first = {0};
  ViewChooser chooser(plane.choice);
  // 2.2 m is worse than 1.8 m, by less than the turn.
  plane.put(2, 2.2, 0.0, 3.1416);
  for (int k = 0; k < 50; ++k) plane.look(chooser);
  EXPECT_EQ(chooser.target(0), 0);
  // The turn costs 0.013 m^2, and views add 0.0015 at most. Of a hundred times the variance it is
  // worth it.
  for (ViewVariance& v : plane.choice.variances)
    for (double& value : v.values) value *= 100;
  plane.t = 0.0;
  ViewChooser noisy(plane.choice);
  plane.put(2, 3.5, 0.0, 3.1416);
  for (int k = 0; k < 10; ++k) {
    plane.look(noisy);
    EXPECT_EQ(noisy.target(0), 0) << k;
  }
  plane.look(noisy);
  EXPECT_EQ(noisy.target(0), 1);
  EXPECT_TRUE(noisy.changed(0));
  plane.look(noisy);
  EXPECT_FALSE(noisy.changed(0));
}

TEST(ViewChoice, WhoIsGoneIsLeftAndWhoHasNobodyLooksAtOnce) {
  Plane plane(3, 2);
  plane.put(0, 1.0, 0.0), plane.put(1, 0.0, 3.0), plane.put(2, 0.0, 0.0);
  ViewChooser chooser(plane.choice);
  plane.look(chooser);
  EXPECT_EQ(chooser.target(0), 0);
  for (int k = 0; k < 20; ++k) plane.look(chooser);
  plane.presence[0] = Presence::absent;
  plane.look(chooser);
  EXPECT_EQ(chooser.target(0), 1) << "its last change is longer ago than the dwell";
  plane.presence[1] = Presence::absent;
  for (int k = 0; k < 30; ++k) plane.look(chooser);
  EXPECT_EQ(chooser.target(0), 1) << "there is nobody else";
  plane.presence[2] = Presence::hold;
  plane.presence[0] = Presence::hold;
  for (int k = 0; k < 30; ++k) plane.look(chooser);
  EXPECT_EQ(chooser.target(0), 1) << "it is not steered";
  plane.presence[2] = Presence::steered;
  plane.look(chooser);
  EXPECT_EQ(chooser.target(0), 0) << "a robot on hold still knows its place";
}

TEST(ViewChoice, OneTargetOfOneObserverIsObservedByTheBest) {
  Plane plane(3, 1);
  plane.choice.targets = {BodyId{0}};
  plane.choice.variances.assign(2, square_variance());
  plane.choice.at_most = 1;
  plane.put(0, 0.0, 0.0), plane.put(1, 1.0, 0.0, 3.14), plane.put(2, 3.0, 0.0, 3.14);
  ViewChooser chooser(plane.choice);
  plane.look(chooser);
  EXPECT_EQ(chooser.target(0), 0);
  EXPECT_EQ(chooser.target(1), ViewChoice::nobody);
  plane.presence[1] = Presence::absent;
  plane.look(chooser);
  EXPECT_EQ(chooser.target(1), ViewChoice::nobody)
      << "the first still has the place, and the dwell has begun";
  for (int k = 0; k < 11; ++k) plane.look(chooser);
  EXPECT_EQ(chooser.target(1), 0);
}

/// Whether a path leads from each observer that has a target to an anchor, and no target has too
/// many.
void expect_paths(const Plane& plane, const ViewChooser& chooser, int robots, int anchors) {
  std::vector<int> count(static_cast<std::size_t>(robots));
  for (int i = anchors; i < robots; ++i) {
    int on = i;
    for (int steps = 0; on >= anchors && steps <= robots; ++steps)
      on = chooser.target(static_cast<std::size_t>(on - anchors));
    ASSERT_LT(on, anchors) << "a circle through " << i;
    const int target = chooser.target(static_cast<std::size_t>(i - anchors));
    ASSERT_NE(target, i);
    if (target >= 0) ++count[static_cast<std::size_t>(target)];
  }
  for (const int n : count) ASSERT_LE(n, plane.choice.at_most);
}

TEST(ViewChoice, NeverACircleNeverTooManyNeverWithinTheDwell) {
  long changes = 0;
  for (int draw = 0; draw < 40; ++draw) {
    Random random(static_cast<std::uint64_t>(draw + 1));
    const int robots = 3 + draw % 8, anchors = 1 + draw % 2;
    Plane plane(robots, anchors);
    plane.choice.at_most = 1 + draw % 3;
    plane.choice.dwell = 0.3;
    for (ViewVariance& v : plane.choice.variances)
      for (double& value : v.values) value *= 30;
    ViewChooser chooser(plane.choice);
    std::vector<double> turned(plane.choice.observers.size(), -1e9);
    for (int k = 0; k < 400; ++k) {
      for (int i = 0; i < robots; ++i) {
        const double a = 0.02 * k * (0.3 + 0.1 * i) + i, b = 0.02 * k * (0.5 - 0.07 * i) + 2 * i;
        plane.put(i, 4 * std::cos(a), 4 * std::sin(b), 3 * std::sin(a));
        if (uniform(random, 0.0, 1.0) < 0.01) {
          Presence& p = plane.presence[static_cast<std::size_t>(i)];
          p = p == Presence::absent ? Presence::steered : Presence::absent;
        }
      }
      const double t = plane.t;
      plane.look(chooser, 0.05);
      expect_paths(plane, chooser, robots, anchors);
      if (testing::Test::HasFatalFailure()) return;
      for (std::size_t i = 0; i < turned.size(); ++i) {
        if (!chooser.changed(i)) continue;
        EXPECT_GE(t - turned[i], plane.choice.dwell - 1e-9);
        turned[i] = t, ++changes;
      }
    }
  }
  EXPECT_GT(changes, 200);
}

TEST(ViewChoice, ALookAllocatesNothing) {
  Plane plane(8, 2);
  for (int i = 0; i < 8; ++i) plane.put(i, std::cos(1.3 * i) * 3, std::sin(2.1 * i) * 3, i);
  ViewChooser chooser(plane.choice);
  const std::int64_t before = allocations_here();
  for (int k = 0; k < 100; ++k) plane.look(chooser);
  EXPECT_EQ(allocations_here(), before);
}

TEST(ViewChoice, WhatCannotBeChosenIsRefused) {
  const auto refused = [](auto&& change) {
    Plane plane(3, 1);
    change(plane.choice);
    return refusal_of([&] { plane.choice.check(plane.team); });
  };
  EXPECT_EQ(refused([](ViewChoice&) {}), "");
  EXPECT_EQ(refused([](ViewChoice& c) { c.observers.push_back(c.observers[0]); }),
            "\"uav1\" stands twice among the observers of who, expected once");
  EXPECT_EQ(refused([](ViewChoice& c) {
              c.targets = {BodyId{1}, BodyId{2}};
            }),
            "all targets of who are observers, expected one that knows its place without looking");
  EXPECT_EQ(refused([](ViewChoice& c) { c.variances.pop_back(); }),
            "who has 5 variances, expected one of each observer and target, 6");
  EXPECT_EQ(refused([](ViewChoice& c) { c.at_most = 0; }), "who.at_most = 0, expected >= 1");
  EXPECT_EQ(refused([](ViewChoice& c) { c.dwell = 0; }), "who.dwell = 0, expected > 0 s");
  EXPECT_EQ(refused([](ViewChoice& c) { c.margin = -1; }), "who.margin = -1, expected >= 0 m");
  EXPECT_EQ(refused([](ViewChoice& c) { c.first[0] = 1; }),
            "the first target of \"uav1\" in who is 1, expected the place of another body");
}

}  // namespace
}  // namespace sightline
