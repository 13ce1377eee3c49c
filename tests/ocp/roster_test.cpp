#include "sightline/ocp/roster.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/potential/bearing.hpp"
#include "sightline/potential/bounds.hpp"
#include "sightline/potential/pass_right.hpp"
#include "sightline/potential/protection.hpp"
#include "sightline/potential/region.hpp"
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

const Coupling* coupling_of(const Team& team, std::string_view name) {
  for (const Coupling& c : team.couplings()) {
    if (c.name == name) return &c;
  }
  return nullptr;
}

TEST(Roster, ATeamThatNothingHappensToIsTheTeamItWasMadeOf) {
  const Team all = event_team(4);
  const Team team = Roster(all).team(0.0);
  EXPECT_EQ(names_of(team), names_of(all));
  ASSERT_EQ(team.couplings().size(), all.couplings().size());
  for (std::size_t i = 0; i < all.couplings().size(); ++i) {
    EXPECT_TRUE(alike(team.couplings()[i], all.couplings()[i]));
    EXPECT_EQ(team.couplings()[i].name, all.couplings()[i].name);
  }
}

TEST(Roster, ARobotThatVanishesTakesItsCouplingsAlongAndBringsThemBack) {
  const Team all = event_team(4);
  Roster roster(all);
  EXPECT_THAT(roster.apply(RemoveBody{BodyId{2}}, 1.0, 0.0), IsEmpty());
  const Team without = roster.team(1.0);
  EXPECT_EQ(names_of(without), (std::vector<std::string>{"uav0", "uav1", "uav3"}));
  EXPECT_EQ(without.couplings().size(), 3U);  // of uav1; those of uav2 and of uav3, which saw it, rest
  EXPECT_THAT(roster.apply(AddBody{BodyId{2}}, 2.0, 0.0), IsEmpty());
  EXPECT_EQ(roster.team(2.0).couplings().size(), all.couplings().size());
}

TEST(Roster, WhatOthersFeltOfOneThatVanishedFadesAway) {
  Roster roster(event_team(3));
  EXPECT_THAT(roster.apply(RemoveBody{BodyId{1}}, 1.0, 0.5), IsEmpty());
  const Team fading = roster.team(1.0);
  const BodyId ghost = fading.find("uav1");
  ASSERT_GE(ghost.index, 0);
  EXPECT_FALSE(fading.is_agent(ghost));
  EXPECT_EQ(fading.couplings().size(), 3U);
  for (const Coupling& c : fading.couplings()) EXPECT_EQ(c.ramp.at(1.25), 0.5);
  EXPECT_EQ(roster.at_rest_from(1.0), 1.5);
  EXPECT_EQ(roster.team(1.5).bodies(), 2);
}

TEST(Roster, ARobotThatFailsStaysAnObstacleToThoseThatFeelIt) {
  for (const Afterwards afterwards : {Afterwards::hold, Afterwards::land}) {
    Roster roster(event_team(3));
    EXPECT_THAT(roster.apply(RemoveBody{BodyId{1}, afterwards}, 1.0, 0.0), IsEmpty());
    const Team team = roster.team(1.0);
    EXPECT_EQ(team.agents().size(), 2U);
    EXPECT_EQ(team.couplings().size(), 3U);  // uav2's; what uav1 felt is over
    EXPECT_FALSE(team.is_agent(team.find("uav1")));
    EXPECT_EQ(roster.presence(BodyId{1}), afterwards == Afterwards::hold ? Presence::hold : Presence::land);
  }
}

TEST(Roster, ARetunedWeightGoesOverWithoutAStep) {
  Roster roster(event_team(2));
  EXPECT_THAT(roster.apply(RetuneTerm{.name = "sees1", .weight = 1.2}, 5.0, 2.0), IsEmpty());
  for (const double t : {5.0, 5.5, 6.0, 6.999}) {
    double weight = 0.0;
    const Team team = roster.team(t);
    for (const Coupling& c : team.couplings()) {
      if (c.term.potential.as<SensorCone>() != nullptr) weight += c.term.weight * c.ramp.at(t);
    }
    EXPECT_NEAR(weight, (Ramp{5.0, 2.0, 0.4, 1.2}.at(t)), 1e-12) << t;
  }
  const Team after = roster.team(7.0);
  EXPECT_EQ(after.couplings().size(), 3U);
  ASSERT_NE(coupling_of(after, "sees1"), nullptr);
  EXPECT_EQ(coupling_of(after, "sees1")->term.weight, 1.2);
  EXPECT_EQ(coupling_of(after, "sees1")->ramp, Ramp{});
}

TEST(Roster, AWeightThatIsRetunedOnItsWayGoesOnFromWhereItIs) {
  Roster roster(event_team(2));
  EXPECT_THAT(roster.apply(RetuneTerm{.name = "sees1", .weight = 0.0}, 0.0, 1.0), IsEmpty());
  EXPECT_THAT(roster.apply(RetuneTerm{.name = "sees1", .weight = 0.4}, 0.5, 1.0), IsEmpty());
  double weight = 0.0;
  const Team team = roster.team(0.5);
  for (const Coupling& c : team.couplings()) {
    if (c.term.potential.as<SensorCone>() != nullptr) weight += c.term.weight * c.ramp.at(0.5);
  }
  EXPECT_NEAR(weight, 0.2, 1e-12);
}

TEST(Roster, AnObserverTakesItsSensorAlongAndKeepsItsDistanceFromBoth) {
  Roster roster(event_team(3, 2));  // uav2 watches uav1
  EXPECT_THAT(roster.apply(Observe{AgentId{BodyId{2}}, BodyId{0}}, 4.0, 1.0), IsEmpty());
  const Team then = roster.team(5.0);
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
  EXPECT_THAT(roster.apply(Observe{AgentId{BodyId{2}}, BodyId{0}}, 6.0, 1.0), HasSubstr("already"));
}

TEST(Roster, WhoObservesTheObserverGoesOnWithItsOwnSensor) {
  Team team;
  for (const char* name : {"uav0", "uav1", "uav2"}) team.add(Multirotor{}, {.name = name});
  const SensorMount up = {-0.4, 0.1};
  const AgentId uav0{BodyId{0}}, uav1{BodyId{1}};
  team.couple({0.4, Bearing{}}, {uav1, uav0}, {uav1});
  team.couple({0.4, Potential(Bearing{}).seen_from(up)}, {uav0, uav1}, {uav0});
  Roster roster(team);
  ASSERT_THAT(roster.apply(Observe{uav1, BodyId{2}}, 1.0, 1.0), IsEmpty());
  const Team then = roster.team(3.0);
  int looks = 0;
  for (const Coupling& c : then.couplings()) {
    if (!watches(c.term.potential)) continue;
    ++looks;
    const bool of_uav0 = c.term.potential.mount()->pitch == up.pitch;
    EXPECT_EQ(c.between.first, of_uav0 ? BodyId(uav0) : BodyId(uav1));
    EXPECT_EQ(c.between.second, of_uav0 ? BodyId(uav1) : BodyId{2});
    EXPECT_THAT(c.felt_by, testing::ElementsAre(of_uav0 ? uav0 : uav1));
  }
  EXPECT_EQ(looks, 2);
}

TEST(Roster, WhateverKeepsApartStaysWithTheOldTargetAndComesToTheNew) {
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
        Roster roster(team);
        for (const int target : {0, 1, 0, 1, 0}) {
          ASSERT_THAT(roster.apply(Observe{observer, BodyId{target}}, 4.0 * target, 1.0), IsEmpty());
        }
        int seen[2] = {}, kept_off[2] = {};
        const Team then = roster.team(9.0);
        for (const Coupling& c : then.couplings()) {
          (c.term.potential.name() == view.name() && watches(c.term.potential)
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

TEST(Roster, OfARegionThatWatchesAndKeepsApartTheKeepOutStaysBehindOnce) {
  Team team = event_team(2, 2);
  const AgentId observer = team.add(Multirotor{}, {.name = "uav2"});
  const Potential camera = Region(all_of({"bearing < 0.4", "0.7 m < range < 6 m"})).seen_from(SensorMount{});
  team.couple({2.0, camera}, {observer, BodyId{1}}, {observer});
  Roster roster(team);
  double t = 0.0;
  for (const int target : {0, 1, 0, 1, 0}) {
    EXPECT_THAT(roster.apply(Observe{observer, BodyId{target}}, t, 1.0), IsEmpty());
    t += 2.0;
  }
  const Team then = roster.team(t);
  int views = 0, behind = 0;
  for (const Coupling& c : then.couplings()) {
    views += watches(c.term.potential) && c.between.second == BodyId{0};
    behind += keeps_apart(c.term.potential) && c.between.second == BodyId{1};
    EXPECT_EQ(c.term.weight, 2.0);
  }
  EXPECT_EQ(views, 1);
  EXPECT_EQ(behind, 1);
}

TEST(Roster, AViewThatTheTargetAloneFeltEndsWithIt) {
  Team team = event_team(2, 2);
  const AgentId observer = team.add(Multirotor{}, {.name = "uav2"});
  const BodyId lamp = team.add(Obstacle{"lamp"});
  team.couple(0.4 * Bearing{}, {observer, BodyId{1}}, felt_by(AgentId{BodyId{1}}));
  team.couple(0.4 * SensorCone{}, {observer, BodyId{1}}, {observer});
  Roster roster(team);
  EXPECT_THAT(roster.apply(Observe{observer, lamp}, 0.0, 1.0), IsEmpty());
  const Team then = roster.team(2.0);
  ASSERT_EQ(then.couplings().size(), 1U);
  EXPECT_EQ(then.couplings()[0].between.second, lamp);
}

TEST(Roster, ARobotThatBrakesOrSinksIsKeptOffByItsSwarm) {
  for (const Afterwards afterwards : {Afterwards::hold, Afterwards::land, Afterwards::vanish}) {
    Team all = event_team(4, 4);
    all.keep_apart(2.0 * PassRight{}, felt_by({AgentId{BodyId{0}}, AgentId{BodyId{1}}, AgentId{BodyId{2}}}),
                   3.0, 3);
    Roster roster(all);
    EXPECT_THAT(roster.apply(RemoveBody{BodyId{1}, afterwards}, 1.0, 0.0), IsEmpty());
    const Team team = roster.team(1.0);
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
    EXPECT_THAT(roster.apply(AddBody{BodyId{1}}, 2.0, 0.0), IsEmpty());
    EXPECT_EQ(roster.team(2.0).swarms()[0].agents.size(), 3U);
    EXPECT_TRUE(roster.team(2.0).couplings().empty());
  }
}

TEST(Roster, ARobotThatIsNotSteeredKeepsItsHeading) {
  Roster roster(event_team(3));
  EXPECT_THAT(roster.apply(RemoveBody{BodyId{1}, Afterwards::hold}, 1.0, 0.0), IsEmpty());
  const Team team = roster.team(1.0);
  const std::vector<double> x = {1, 2, 3, 0.1, 0.2, 0.3, 0.0, -1.0};
  ASSERT_EQ(team.model(team.find("uav1")).nx(), 8);
  const Sight<double> seen = team.model(team.find("uav1")).sight(x.data(), x.data());
  EXPECT_EQ(seen.d.y, -1.0);
  EXPECT_EQ(seen.v.z, 0.3);
}

TEST(Roster, TheMembershipFollowsTheTeam) {
  Team all = event_team(4, 2);  // uav2 watches uav1, uav3 uav2
  Roster roster(all);
  using Bodies = std::vector<BodyId>;
  EXPECT_EQ(roster.membership().partners, (std::vector<Bodies>{{}, {}, {BodyId{1}}, {BodyId{2}}}));
  EXPECT_THAT(roster.apply(Observe{AgentId{BodyId{3}}, BodyId{0}}, 1.0, 1.0), IsEmpty());
  EXPECT_THAT(roster.membership().partners[3], testing::UnorderedElementsAre(BodyId{0}, BodyId{2}))
      << "it goes on keeping off the one before";
  EXPECT_THAT(roster.apply(RemoveBody{BodyId{2}}, 2.0, 1.0), IsEmpty());
  EXPECT_EQ(roster.membership().partners[2], Bodies{});
  EXPECT_EQ(roster.membership().partners[3], Bodies{BodyId{0}});
  const Coupling more{.term = 1.0 * KeepOut{},
                      .between = {BodyId{0}, BodyId{1}},
                      .felt_by = {AgentId{BodyId{0}}},
                      .name = "more"};
  EXPECT_THAT(roster.apply(AddCoupling{more}, 3.0, 0.0), IsEmpty());
  EXPECT_EQ(roster.membership().partners[0], Bodies{BodyId{1}});
  EXPECT_THAT(roster.apply(RemoveTerm{"more"}, 4.0, 1.0), IsEmpty());
  EXPECT_EQ(roster.membership().partners[0], Bodies{});
  const InputLimits slow({-0.2, -0.2, -0.2, -0.2}, {0.2, 0.2, 0.2, 0.2});
  EXPECT_THAT(roster.apply(RetuneAgent{.agent = AgentId{BodyId{1}}, .limits = slow}, 5.0, 0.0), IsEmpty());
  EXPECT_EQ(roster.membership().limits[1].u_max()[0][0], 0.2);
}

TEST(Roster, AReferenceGoesOverToTheNext) {
  Roster roster(event_team(2));
  const AgentId leader{BodyId{0}};
  const std::vector<double> there = {2, 0, 1, 1, 0, 0, 0};
  const Agent before = roster.team(0.0).agent(leader);
  EXPECT_THAT(roster.apply(SetReference{leader, Reference(there)}, 3.0, 1.0), IsEmpty());
  const Team team = roster.team(3.0);
  const Agent& agent = team.agent(leader);
  std::vector<double> x(7), old(7);
  agent.x_ref(3.0, agent.model, x);
  before.x_ref(3.0, agent.model, old);
  EXPECT_EQ(x, old);
  agent.x_ref(4.0, agent.model, x);
  EXPECT_EQ(x, there);
  agent.x_ref(3.5, agent.model, x);
  before.x_ref(3.5, agent.model, old);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(x[i], (old[i] + there[i]) / 2, 1e-12);
  EXPECT_TRUE(roster.team(4.0).agent(leader).x_ref.is_constant());
}

TEST(Roster, WhatCannotBeIsRefusedInASentenceAndChangesNothing) {
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
      {RemoveBody{BodyId{2}, Afterwards::land}, "\"uav2\" is not there"},
      {AddBody{BodyId{1}}, "\"uav1\" is there already"},
      {RemoveTerm{"sees9"}, "no coupling or constraint \"sees9\""},
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
  Roster roster(all, presence);
  for (const auto& [action, sentence] : refusals) {
    EXPECT_THAT(roster.apply(action, 1.0, 1.0), HasSubstr(sentence));
  }
  EXPECT_EQ(roster.presence(), presence);
  EXPECT_EQ(roster.couplings().size(), all.couplings().size());
  EXPECT_THAT(roster.apply(RemoveBody{BodyId{1}}, 1.0, 0.0), IsEmpty());
  EXPECT_THAT(roster.apply(RemoveBody{BodyId{0}}, 1.0, 0.0), HasSubstr("the last robot"));
}

TEST(Roster, AnyOrderOfChangesGivesATeamThatIsSound) {
  Random random(7);
  for (int round = 0; round < 100; ++round) {
    Roster roster(event_team(6, 2));
    double t = 0.0;
    for (int k = 0; k < 30; ++k) {
      t += uniform(random, 0.0, 1.0);
      const BodyId body{static_cast<int>(random() % 6)}, other{static_cast<int>(random() % 6)};
      const std::string number = std::to_string(random() % 6);
      const Action any[] = {RemoveBody{body, static_cast<Afterwards>(random() % 3)}, AddBody{body},
                            Observe{AgentId{body}, other},
                            RetuneTerm{.name = "sees" + number, .weight = uniform(random, 0, 1)},
                            RemoveTerm{"near" + number}};
      (void)roster.apply(any[random() % 5], t, random() % 2 == 0 ? 0.0 : uniform(random, 0, 2));
      const Team team = roster.team(t);
      EXPECT_GE(team.agents().size(), 1U);
      for (const Coupling& c : team.couplings()) {
        EXPECT_GE(c.ramp.at(t), 0.0);
        EXPECT_LE(c.ramp.at(t), 1.0);
        for (const AgentId agent : c.felt_by) EXPECT_TRUE(team.is_agent(agent));
      }
      const double rest = roster.at_rest_from(t);
      if (rest < t) continue;
      const Team settled = roster.team(rest);
      for (const Coupling& c : settled.couplings()) EXPECT_EQ(c.ramp, Ramp{});
    }
  }
}

}  // namespace
}  // namespace sightline
