#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/events.hpp"
#include "sightline/potential/protection.hpp"
#include "sightline/potentials.hpp"
#include "tests/support/event_team.hpp"

namespace sightline {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

TEST(Observe, AnObserverTakesItsSensorAlongAndKeepsItsDistanceFromBoth) {
  ActiveTeam active_team(event_team(3, 2));  // uav2 observes uav1
  EXPECT_THAT(active_team.apply(Observe{AgentId{BodyId{2}}, BodyId{0}}, 4.0, 1.0), IsEmpty());
  const Team then = active_team.team(5.0);
  int sees = 0, off = 0, near = 0;
  for (const Coupling& c : then.couplings()) {
    EXPECT_EQ(c.between.first, BodyId{2});
    EXPECT_EQ(c.felt_by, std::vector{AgentId{BodyId{2}}});
    const bool of_the_new = c.between.second == BodyId{0};
    sees += c.term.potential.as<SensorCone>() != nullptr ? (of_the_new ? 1 : 10) : 0;
    near += c.term.potential.as<Cohesion>() != nullptr ? (of_the_new ? 1 : 10) : 0;
    off += c.term.potential.as<KeepOut>() != nullptr;
  }
  EXPECT_EQ(sees, 1);
  EXPECT_EQ(near, 1);
  EXPECT_EQ(off, 2);
  EXPECT_THAT(active_team.apply(Observe{AgentId{BodyId{2}}, BodyId{0}}, 6.0, 1.0), HasSubstr("already"));
}

TEST(Observe, WhoObservesTheObserverGoesOnWithItsOwnSensor) {
  Team team;
  for (const char* name : {"uav0", "uav1", "uav2"}) team.add(Multirotor{}, {.name = name});
  const SensorMount up = {-0.4, 0.1};
  const AgentId uav0{BodyId{0}}, uav1{BodyId{1}};
  team.couple({0.4, Bearing{}}, {uav1, uav0}, {uav1});
  team.couple({0.4, Potential(Bearing{}).seen_from(up)}, {uav0, uav1}, {uav0});
  ActiveTeam active_team(team);
  ASSERT_THAT(active_team.apply(Observe{uav1, BodyId{2}}, 1.0, 1.0), IsEmpty());
  const Team then = active_team.team(3.0);
  int looks = 0;
  for (const Coupling& c : then.couplings()) {
    if (!observes(c.term.potential)) continue;
    ++looks;
    const bool of_uav0 = c.term.potential.mount()->pitch == up.pitch;
    EXPECT_EQ(c.between.first, of_uav0 ? BodyId(uav0) : BodyId(uav1));
    EXPECT_EQ(c.between.second, of_uav0 ? BodyId(uav1) : BodyId{2});
    EXPECT_THAT(c.felt_by, testing::ElementsAre(of_uav0 ? uav0 : uav1));
  }
  EXPECT_EQ(looks, 2);
}

TEST(Observe, WhateverKeepsApartStaysWithTheOldTargetAndComesToTheNew) {
  const SensorMount mount{};
  const std::vector<Potential> keep_outs = {
      KeepOut{},
      TooNear{},
      PassRight{},
      Region("range > 1 m").seen_from(mount),
      Region("distance > 1 m").slope(Softplus{}),
  };
  const std::vector<Potential> views = {SensorCone{}, Bearing{}, Region("bearing < 0.4").seen_from(mount)};
  const AgentId observer{BodyId{2}};
  for (const Potential& keep_out : keep_outs) {
    for (const Potential& view : views) {
      for (const bool first : {true, false}) {  // whichever stands first
        Team team = event_team(2, 2);
        team.add(Multirotor{}, {.name = "uav2"});
        const Weighted off{0.5, keep_out}, sees{0.4, view};
        team.couple(first ? off : sees, {observer, BodyId{1}}, {observer});
        team.couple(first ? sees : off, {observer, BodyId{1}}, {observer});
        ActiveTeam active_team(team);
        for (const int target : {0, 1, 0, 1, 0}) {
          ASSERT_THAT(active_team.apply(Observe{observer, BodyId{target}}, 4.0 * target, 1.0), IsEmpty());
        }
        int seen[2] = {}, kept_off[2] = {};
        const Team then = active_team.team(9.0);
        for (const Coupling& c : then.couplings()) {
          (c.term.potential.name() == view.name() && observes(c.term.potential)
               ? seen
               : kept_off)[c.between.second.index]++;
        }
        EXPECT_EQ(seen[0], 1) << keep_out.name();
        EXPECT_EQ(seen[1], 0) << keep_out.name();
        EXPECT_EQ(kept_off[0], 1) << keep_out.name();
        EXPECT_EQ(kept_off[1], 1) << keep_out.name();
      }
    }
  }
}

TEST(Observe, OfARegionThatWatchesAndKeepsApartTheKeepOutStaysBehindOnce) {
  Team team = event_team(2, 2);
  const AgentId observer = team.add(Multirotor{}, {.name = "uav2"});
  const Potential camera = Region(all_of({"bearing < 0.4", "0.7 m < range < 6 m"})).seen_from(SensorMount{});
  team.couple({2.0, camera}, {observer, BodyId{1}}, {observer});
  ActiveTeam active_team(team);
  double t = 0.0;
  for (const int target : {0, 1, 0, 1, 0}) {
    EXPECT_THAT(active_team.apply(Observe{observer, BodyId{target}}, t, 1.0), IsEmpty());
    t += 2.0;
  }
  const Team then = active_team.team(t);
  int views = 0, behind = 0;
  for (const Coupling& c : then.couplings()) {
    views += observes(c.term.potential) && c.between.second == BodyId{0};
    behind += keeps_apart(c.term.potential) && c.between.second == BodyId{1};
    EXPECT_EQ(c.term.weight, 2.0);
  }
  EXPECT_EQ(views, 1);
  EXPECT_EQ(behind, 1);
}

TEST(Observe, AViewThatTheTargetAloneFeltEndsWithIt) {
  Team team = event_team(2, 2);
  const AgentId observer = team.add(Multirotor{}, {.name = "uav2"});
  const BodyId lamp = team.add(Obstacle{"lamp"});
  team.couple(0.4 * Bearing{}, {observer, BodyId{1}}, felt_by(AgentId{BodyId{1}}));
  team.couple(0.4 * SensorCone{}, {observer, BodyId{1}}, {observer});
  ActiveTeam active_team(team);
  EXPECT_THAT(active_team.apply(Observe{observer, lamp}, 0.0, 1.0), IsEmpty());
  const Team then = active_team.team(2.0);
  ASSERT_EQ(then.couplings().size(), 1U);
  EXPECT_EQ(then.couplings()[0].between.second, lamp);
}

}  // namespace
}  // namespace sightline
