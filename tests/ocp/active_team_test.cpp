#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/events.hpp"
#include "sightline/potential/protection.hpp"
#include "sightline/potentials.hpp"
#include "tests/support/event_team.hpp"
#include "tests/support/random.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

std::vector<std::string> names_of(const Team& team) {
  std::vector<std::string> names;
  for (int i = 0; i < team.bodies(); ++i) names.emplace_back(team.name(BodyId{i}));
  return names;
}

TEST(ActiveTeam, ATeamThatNothingHappensToIsTheTeamItWasMadeOf) {
  const Team all = event_team(4);
  const Team team = ActiveTeam(all).team(0.0);
  EXPECT_EQ(names_of(team), names_of(all));
  ASSERT_EQ(team.couplings().size(), all.couplings().size());
  for (std::size_t i = 0; i < all.couplings().size(); ++i) {
    EXPECT_TRUE(alike(team.couplings()[i], all.couplings()[i]));
    EXPECT_EQ(team.couplings()[i].name, all.couplings()[i].name);
  }
}

/// uav0 looks at uav1 past uav2.
Team looking_past() {
  Team team = event_team(3, 3);
  team.couple({.term = 1.0 * Region("distance > third.p_x - observer.p_x"),
               .between = {BodyId{0}, BodyId{1}},
               .felt_by = {AgentId{BodyId{0}}},
               .name = "past",
               .third = BodyId{2}});
  return team;
}

TEST(ActiveTeam, WhatIsLookedPastIsThereWhileItsBodyIs) {
  ActiveTeam active_team(looking_past());
  ASSERT_EQ(active_team.team(0.0).couplings().size(), 1U);
  EXPECT_EQ(active_team.team(0.0).couplings()[0].third, BodyId{2});
  // What does not steer is looked past too.
  ASSERT_THAT(active_team.apply(RemoveBody{BodyId{2}, Afterwards::hold}, 1.0, 0.0), IsEmpty());
  const Team held = active_team.team(1.0);
  ASSERT_EQ(held.couplings().size(), 1U);
  EXPECT_EQ(held.name(held.couplings()[0].third), "uav2");
  ASSERT_THAT(active_team.apply(RemoveBody{BodyId{2}}, 2.0, 1.0), IsEmpty());
  ASSERT_EQ(active_team.team(2.5).couplings().size(), 1U);
  EXPECT_EQ(active_team.team(2.5).couplings()[0].ramp.at(2.5), 0.5) << "it fades out";
  EXPECT_TRUE(active_team.team(3.5).couplings().empty());
  ASSERT_THAT(active_team.apply(AddBody{BodyId{2}}, 4.0, 1.0), IsEmpty());
  ASSERT_EQ(active_team.team(4.5).couplings().size(), 1U);
  EXPECT_EQ(active_team.team(4.5).couplings()[0].ramp.at(4.5), 0.5) << "it fades in";
}

TEST(ActiveTeam, APotentialThatLooksPastNobodyDoesNotTakeThePlaceOfOneThatDoes) {
  ActiveTeam active_team(looking_past());
  EXPECT_EQ(active_team.apply(RetuneTerm{.name = "past", .potential = Potential(Region("distance > 1 m"))},
                              1.0, 0.0),
            "region looks past no third body, \"past\" past one, expected one that does alike");
}

TEST(ActiveTeam, ARobotThatIsLookedPastMayBeLookedAt) {
  Team team = looking_past();
  team.couple(
      {.term = 0.4 * SensorCone{}, .between = {BodyId{0}, BodyId{1}}, .felt_by = {AgentId{BodyId{0}}}});
  ActiveTeam active_team(team);
  ASSERT_THAT(active_team.apply(Observe{AgentId{BodyId{0}}, BodyId{2}}, 1.0, 1.0), IsEmpty());
  const Team then = active_team.team(3.0);
  ASSERT_EQ(then.couplings().size(), 1U) << "nothing is to be seen past what is looked at";
  EXPECT_EQ(then.couplings()[0].between.second, BodyId{2});
}

TEST(ActiveTeam, ARobotThatBrakesOrSinksIsKeptOffByItsSwarm) {
  for (const Afterwards afterwards : {Afterwards::hold, Afterwards::land, Afterwards::vanish}) {
    Team all = event_team(4, 4);
    all.keep_apart(2.0 * PassRight{}, felt_by({AgentId{BodyId{0}}, AgentId{BodyId{1}}, AgentId{BodyId{2}}}),
                   3.0, 3);
    ActiveTeam active_team(all);
    EXPECT_THAT(active_team.apply(RemoveBody{BodyId{1}, afterwards}, 1.0, 0.0), IsEmpty());
    const Team team = active_team.team(1.0);
    ASSERT_EQ(team.swarms().size(), 1U);
    EXPECT_EQ(team.swarms()[0].agents.size(), 2U);
    if (afterwards == Afterwards::vanish) {
      EXPECT_TRUE(team.couplings().empty());
      continue;
    }
    const BodyId it = team.find("uav1");
    ASSERT_EQ(team.couplings().size(), 2U);
    for (const Coupling& c : team.couplings()) {
      EXPECT_TRUE(c.between.first == it || c.between.second == it);
      EXPECT_EQ(c.term.weight, 2.0);
      ASSERT_EQ(c.felt_by.size(), 1U);
      EXPECT_NE(c.felt_by[0], it);
    }
    EXPECT_EQ(team.couplings()[0].between.second, it) << "the earlier of the swarm first";
    EXPECT_EQ(team.couplings()[1].between.first, it);
    EXPECT_THAT(active_team.apply(AddBody{BodyId{1}}, 2.0, 0.0), IsEmpty());
    EXPECT_EQ(active_team.team(2.0).swarms()[0].agents.size(), 3U);
    EXPECT_TRUE(active_team.team(2.0).couplings().empty());
  }
}

TEST(ActiveTeam, ARobotThatIsNotSteeredKeepsItsHeading) {
  ActiveTeam active_team(event_team(3));
  EXPECT_THAT(active_team.apply(RemoveBody{BodyId{1}, Afterwards::hold}, 1.0, 0.0), IsEmpty());
  const Team team = active_team.team(1.0);
  const std::vector<double> x = {1, 2, 3, 0.1, 0.2, 0.3, 0.0, -1.0};
  ASSERT_EQ(team.model(team.find("uav1")).nx(), 8);
  const Sight<double> seen = team.model(team.find("uav1")).sight(x.data(), x.data());
  EXPECT_EQ(seen.d.y, -1.0);
  EXPECT_EQ(seen.v.z, 0.3);
}

TEST(ActiveTeam, TheMembershipFollowsTheTeam) {
  Team all = event_team(4, 2);  // uav2 observes uav1, uav3 uav2
  ActiveTeam active_team(all);
  using Bodies = std::vector<BodyId>;
  EXPECT_EQ(active_team.membership().partners, (std::vector<Bodies>{{}, {}, {BodyId{1}}, {BodyId{2}}}));
  EXPECT_THAT(active_team.apply(Observe{AgentId{BodyId{3}}, BodyId{0}}, 1.0, 1.0), IsEmpty());
  EXPECT_THAT(active_team.membership().partners[3], testing::UnorderedElementsAre(BodyId{0}, BodyId{2}))
      << "it goes on keeping off the one before";
  EXPECT_THAT(active_team.apply(RemoveBody{BodyId{2}}, 2.0, 1.0), IsEmpty());
  EXPECT_EQ(active_team.membership().partners[2], Bodies{});
  EXPECT_EQ(active_team.membership().partners[3], Bodies{BodyId{0}});
  const Coupling more{.term = 1.0 * KeepOut{},
                      .between = {BodyId{0}, BodyId{1}},
                      .felt_by = {AgentId{BodyId{0}}},
                      .name = "more"};
  EXPECT_THAT(active_team.apply(AddCoupling{more}, 3.0, 0.0), IsEmpty());
  EXPECT_EQ(active_team.membership().partners[0], Bodies{BodyId{1}});
  EXPECT_THAT(active_team.apply(RemoveTerm{"more"}, 4.0, 1.0), IsEmpty());
  EXPECT_EQ(active_team.membership().partners[0], Bodies{});
  const InputLimits slow({-0.2, -0.2, -0.2, -0.2}, {0.2, 0.2, 0.2, 0.2});
  EXPECT_THAT(active_team.apply(RetuneAgent{.agent = AgentId{BodyId{1}}, .limits = slow}, 5.0, 0.0),
              IsEmpty());
  EXPECT_EQ(active_team.membership().limits[1].u_max()[0][0], 0.2);
}

TEST(ActiveTeam, WhatCannotBeIsRefusedInASentenceAndChangesNothing) {
  const Team all = event_team(3);
  std::vector<Presence> presence = {Presence::steered, Presence::steered, Presence::absent};
  const AgentId uav1{BodyId{1}};
  const Coupling same_name{
      .term = 1.0 * KeepOut{}, .between = {uav1, BodyId{0}}, .felt_by = {uav1}, .name = "off1"};
  Coupling felt_by_a_stranger = same_name;
  felt_by_a_stranger.name = "new";
  felt_by_a_stranger.felt_by = {AgentId{BodyId{2}}};
  const std::vector<std::pair<Action, std::string>> refusals = {
      {RemoveBody{BodyId{2}}, "\"uav2\" is not there"},
      {AddBody{BodyId{1}}, "\"uav1\" is there already"},
      {RetuneTerm{.name = "sees9", .weight = 1.0}, "no coupling or constraint \"sees9\""},
      {RetuneTerm{.name = "sees1", .weight = -1.0}, "weight = -1, expected >= 0"},
      {RetuneTerm{.name = "sees1", .weight = not_a_number}, "expected >= 0"},
      {RetuneTerm{.name = "sees1", .potential = Potential(AltitudeBand{})}, "of another kind"},
      {RetuneAgent{.agent = uav1, .Q = std::vector<double>{1.0}}, "Q has 1 entries, expected 7"},
      {RetuneAgent{.agent = uav1, .R = std::vector<double>(4, 0.0)}, "expected > 0"},
      {SetReference{uav1, Reference(std::vector<double>{1.0})}, "x_ref has 1 numbers, expected 7"},
      {Observe{AgentId{BodyId{0}}, BodyId{1}}, "\"uav0\" has no sensor"},
      {Observe{uav1, BodyId{1}}, "cannot observe itself"},
      {Observe{uav1, BodyId{0}}, "already"},
      {AddCoupling{same_name}, "\"off1\" is there already"},
      {AddCoupling{felt_by_a_stranger}, "felt_by names"},
  };
  ActiveTeam active_team(all, presence);
  for (const auto& [action, sentence] : refusals) {
    EXPECT_THAT(active_team.apply(action, 1.0, 1.0), HasSubstr(sentence));
  }
  EXPECT_EQ(active_team.presence(), presence);
  EXPECT_EQ(active_team.couplings().size(), all.couplings().size());
  EXPECT_THAT(active_team.apply(RemoveBody{BodyId{1}}, 1.0, 0.0), IsEmpty());
  EXPECT_THAT(active_team.apply(RemoveBody{BodyId{0}}, 1.0, 0.0), HasSubstr("the last robot"));
}

TEST(ActiveTeam, AnyOrderOfChangesGivesATeamThatIsSound) {
  Random random(7);
  for (int round = 0; round < 100; ++round) {
    ActiveTeam active_team(event_team(6, 2));
    double t = 0.0;
    for (int k = 0; k < 30; ++k) {
      t += uniform(random, 0.0, 1.0);
      const BodyId body{static_cast<int>(random() % 6)}, other{static_cast<int>(random() % 6)};
      const std::string number = std::to_string(random() % 6);
      const Action any[] = {RemoveBody{body, static_cast<Afterwards>(random() % 3)}, AddBody{body},
                            Observe{AgentId{body}, other},
                            RetuneTerm{.name = "sees" + number, .weight = uniform(random, 0, 1)},
                            RemoveTerm{"near" + number}};
      (void)active_team.apply(any[random() % 5], t, random() % 2 == 0 ? 0.0 : uniform(random, 0, 2));
      const Team team = active_team.team(t);
      EXPECT_GE(team.agents().size(), 1U);
      for (const Coupling& c : team.couplings()) {
        EXPECT_GE(c.ramp.at(t), 0.0);
        EXPECT_LE(c.ramp.at(t), 1.0);
        for (const AgentId agent : c.felt_by) EXPECT_TRUE(team.is_agent(agent));
      }
      const double rest = active_team.at_rest_from(t);
      if (rest < t) continue;
      const Team settled = active_team.team(rest);
      for (const Coupling& c : settled.couplings()) EXPECT_EQ(c.ramp, Ramp{});
    }
  }
}

}  // namespace
}  // namespace sightline
