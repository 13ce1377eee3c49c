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

TEST(AddBody, ARobotThatVanishesTakesItsCouplingsAlongAndBringsThemBack) {
  const Team all = event_team(4);
  ActiveTeam active_team(all);
  EXPECT_THAT(active_team.apply(RemoveBody{BodyId{2}}, 1.0, 0.0), IsEmpty());
  const Team without = active_team.team(1.0);
  EXPECT_EQ(without.agents().size(), 3U);
  EXPECT_LT(without.find("uav2").index, 0);
  EXPECT_EQ(without.couplings().size(), 3U);  // uav1's; those of uav2 and uav3, which saw it, rest
  EXPECT_THAT(active_team.apply(AddBody{BodyId{2}}, 2.0, 0.0), IsEmpty());
  EXPECT_EQ(active_team.team(2.0).couplings().size(), all.couplings().size());
}

TEST(AddTerm, FadesInUnderItsName) {
  ActiveTeam active_team(event_team(3));
  const AgentId uav2{BodyId{2}};
  const Coupling apart{
      .term = 0.5 * KeepOut{}, .between = {uav2, BodyId{0}}, .felt_by = {uav2}, .name = "apart"};
  const Constraint band{.term = 2.0 * AltitudeBand{}, .agent = uav2, .name = "band"};
  EXPECT_THAT(active_team.apply(AddCoupling{apart}, 3.0, 2.0), IsEmpty());
  EXPECT_THAT(active_team.apply(AddConstraint{band}, 3.0, 2.0), IsEmpty());
  EXPECT_TRUE(active_team.has_term("apart") && active_team.has_term("band"));
  const Team team = active_team.team(4.0);
  EXPECT_EQ(team.couplings().back().ramp.at(4.0), 0.5);
  EXPECT_EQ(team.constraints().back().ramp.at(4.0), 0.5);
  EXPECT_EQ(active_team.team(5.0).couplings().back().ramp, Ramp{});
}

HandOver turn_to(int target) {
  const AgentId self{BodyId{2}};
  HandOver change{.observer = self, .names = {"sees2"}};
  if (target >= 0)
    change.couplings = {
        {.term = 0.4 * SensorCone{}, .between = {self, BodyId{target}}, .felt_by = {self}, .name = "sees2"}};
  return change;
}

TEST(HandOver, TheCouplingsOfItsNamesGoOverAndTheOthersStay) {
  ActiveTeam active_team(event_team(3));
  EXPECT_EQ(active_team.apply(turn_to(0), 1.0, 2.0), "");
  EXPECT_EQ(active_team.team(2.0).couplings().size(), 7U) << "both are in force for a while";
  EXPECT_EQ(active_team.team(3.0).couplings().size(), 6U);
  EXPECT_TRUE(active_team.has_term("sees2"));
  EXPECT_EQ(active_team.apply(turn_to(-1), 4.0, 0.0), "");
  EXPECT_FALSE(active_team.has_term("sees2"));
  EXPECT_EQ(active_team.team(4.0).couplings().size(), 5U);
  EXPECT_EQ(active_team.apply(turn_to(1), 5.0, 0.0), "") << "from nobody";
  EXPECT_EQ(active_team.team(5.0).couplings().size(), 6U);
}

TEST(HandOver, WhatIsRefusedChangesNothing) {
  ActiveTeam active_team(event_team(3));
  EXPECT_NE(active_team.apply(turn_to(2), 1.0, 0.0), "");
  EXPECT_TRUE(active_team.has_term("sees2"));
  EXPECT_EQ(active_team.team(1.0).couplings().size(), 6U);
}

const InjectFault lost{.kind = Surroundings::FaultKind::dropout, .body = BodyId{0}, .lasts = 0.5};

TEST(InjectFault, FaultsThatAreOverMakeRoom) {
  ActiveTeam active_team(event_team(1));
  EXPECT_EQ(active_team.apply(lost, 1.0, 0.0), "");
  EXPECT_EQ(active_team.apply(lost, 1.2, 0.0), "");
  ASSERT_EQ(active_team.membership().around.faults.size(), 2U);
  EXPECT_EQ(active_team.membership().around.faults[0].until, 1.5);
  EXPECT_EQ(active_team.apply(lost, 1.6, 0.0), "");
  EXPECT_EQ(active_team.membership().around.faults.size(), 2U);
}

TEST(InjectFault, MoreThanThereIsRoomForAreRefused) {
  ActiveTeam active_team(event_team(1));
  for (std::size_t i = 0; i < Surroundings::faults_max; ++i) EXPECT_EQ(active_team.apply(lost, 1.0, 0.0), "");
  EXPECT_THAT(active_team.apply(lost, 1.0, 0.0), testing::HasSubstr("32 faults are in force already"));
}

TEST(MoveBody, TheLastMoveOfABodyCounts) {
  Team team = event_team(1);
  const BodyId post = team.add(Obstacle{"post"});
  ActiveTeam active_team(team);
  EXPECT_EQ(active_team.apply(MoveBody{post, {1, 2, 3}}, 2.0, 0.5), "");
  EXPECT_EQ(active_team.apply(MoveBody{post, {4, 5, 6}}, 3.0, 1.0), "");
  const auto moves = active_team.membership().around.moves;
  ASSERT_EQ(moves.size(), 1U);
  EXPECT_EQ(moves[0].to.x, 4.0);
  EXPECT_EQ(moves[0].begin, 3.0);
  EXPECT_EQ(moves[0].duration, 1.0);
}

TEST(MoveBody, OfARobotOrOfWhatIsNotThereIsRefused) {
  Team team = event_team(1);
  const BodyId post = team.add(Obstacle{"post"});
  ActiveTeam active_team(team, {Presence::steered, Presence::absent});
  EXPECT_THAT(active_team.apply(MoveBody{BodyId{0}, {}}, 0.0, 1.0), HasSubstr("\"uav0\" is a robot"));
  EXPECT_THAT(active_team.apply(MoveBody{post, {}}, 0.0, 1.0), HasSubstr("\"post\" is not there"));
}

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

TEST(Observe, OfTwoSensorsOnOneTargetOnlyTheFirstTurnsUnlessOneIsNamed) {
  const SensorMount left{.yaw = 1.5}, right{.yaw = -1.5};
  for (const bool is_named : {false, true}) {
    Team team = event_team(2, 2);
    const AgentId observer = team.add(Multirotor{}, {.name = "uav2"});
    for (const SensorMount& mount : {left, right})
      team.couple({1.0, Potential(Bearing{}).seen_from(mount)}, {observer, BodyId{1}}, {observer});
    ActiveTeam active_team(team);
    const auto through = is_named ? std::optional(right) : std::nullopt;
    EXPECT_THAT(active_team.apply(Observe{observer, BodyId{0}, through}, 0.0, 0.0), IsEmpty());
    const Team then = active_team.team(0.0);
    for (const Coupling& c : then.couplings()) {
      if (c.between.first != observer) continue;
      const bool turned = *c.term.potential.mount() == (is_named ? right : left);
      EXPECT_EQ(c.between.second, BodyId{turned ? 0 : 1}) << is_named;
    }
  }
}

TEST(RemoveBody, WhatOthersFeltOfOneThatVanishedFadesAway) {
  ActiveTeam active_team(event_team(3));
  EXPECT_THAT(active_team.apply(RemoveBody{BodyId{1}}, 1.0, 0.5), IsEmpty());
  const Team fading = active_team.team(1.0);
  const BodyId ghost = fading.find("uav1");
  ASSERT_GE(ghost.index, 0);
  EXPECT_FALSE(fading.is_agent(ghost));
  EXPECT_EQ(fading.couplings().size(), 3U);
  for (const Coupling& c : fading.couplings()) EXPECT_EQ(c.ramp.at(1.25), 0.5);
  EXPECT_EQ(active_team.at_rest_from(1.0), 1.5);
  EXPECT_EQ(active_team.team(1.5).bodies(), 2);
}

TEST(RemoveBody, ARobotThatFailsStaysAnObstacleToThoseThatFeelIt) {
  for (const Afterwards afterwards : {Afterwards::hold, Afterwards::land}) {
    ActiveTeam active_team(event_team(3));
    EXPECT_THAT(active_team.apply(RemoveBody{BodyId{1}, afterwards}, 1.0, 0.0), IsEmpty());
    const Team team = active_team.team(1.0);
    EXPECT_EQ(team.agents().size(), 2U);
    EXPECT_EQ(team.couplings().size(), 3U);  // uav2's; what uav1 felt is over
    EXPECT_FALSE(team.is_agent(team.find("uav1")));
    EXPECT_EQ(active_team.presence(BodyId{1}),
              afterwards == Afterwards::hold ? Presence::hold : Presence::land);
  }
}

TEST(RemoveTerm, FadesAwayAndFreesItsName) {
  ActiveTeam active_team(event_team(2));
  EXPECT_THAT(active_team.apply(RemoveTerm{"off1"}, 1.0, 2.0), IsEmpty());
  EXPECT_FALSE(active_team.has_term("off1"));
  EXPECT_EQ(active_team.team(2.0).couplings().size(), 3U) << "it fades";
  EXPECT_EQ(active_team.team(3.0).couplings().size(), 2U);
}

TEST(RetuneAgent, ChangesWhatItNamesAndLeavesTheRest) {
  ActiveTeam active_team(event_team(2));
  const AgentId uav1{BodyId{1}};
  const Agent before = active_team.agent(uav1);
  const std::vector<double> Q(7, 0.25), R(4, 2.0);
  EXPECT_THAT(active_team.apply(RetuneAgent{.agent = uav1, .Q = Q, .R = R}, 1.0, 0.0), IsEmpty());
  EXPECT_EQ(active_team.agent(uav1).Q, Q);
  EXPECT_EQ(active_team.agent(uav1).R, R);
  EXPECT_EQ(active_team.agent(uav1).Q_f, before.Q_f);
  EXPECT_EQ(active_team.agent(uav1).u_ref, before.u_ref);
  EXPECT_EQ(active_team.agent(AgentId{BodyId{0}}).Q, event_team(2).agent(AgentId{BodyId{0}}).Q);
}

const Coupling* coupling_of(const Team& team, std::string_view name) {
  for (const Coupling& c : team.couplings()) {
    if (c.name == name) return &c;
  }
  return nullptr;
}

TEST(RetuneTerm, ARetunedWeightGoesOverWithoutAStep) {
  ActiveTeam active_team(event_team(2));
  EXPECT_THAT(active_team.apply(RetuneTerm{.name = "sees1", .weight = 1.2}, 5.0, 2.0), IsEmpty());
  for (const double t : {5.0, 5.5, 6.0, 6.999}) {
    double weight = 0.0;
    const Team team = active_team.team(t);
    for (const Coupling& c : team.couplings()) {
      if (c.term.potential.as<SensorCone>() != nullptr) weight += c.term.weight * c.ramp.at(t);
    }
    EXPECT_NEAR(weight, (Ramp{5.0, 2.0, 0.4, 1.2}.at(t)), 1e-12) << t;
  }
  const Team after = active_team.team(7.0);
  EXPECT_EQ(after.couplings().size(), 3U);
  ASSERT_NE(coupling_of(after, "sees1"), nullptr);
  EXPECT_EQ(coupling_of(after, "sees1")->term.weight, 1.2);
  EXPECT_EQ(coupling_of(after, "sees1")->ramp, Ramp{});
}

TEST(RetuneTerm, AWeightThatIsRetunedOnItsWayGoesOnFromWhereItIs) {
  ActiveTeam active_team(event_team(2));
  EXPECT_THAT(active_team.apply(RetuneTerm{.name = "sees1", .weight = 0.0}, 0.0, 1.0), IsEmpty());
  EXPECT_THAT(active_team.apply(RetuneTerm{.name = "sees1", .weight = 0.4}, 0.5, 1.0), IsEmpty());
  double weight = 0.0;
  const Team team = active_team.team(0.5);
  for (const Coupling& c : team.couplings()) {
    if (c.term.potential.as<SensorCone>() != nullptr) weight += c.term.weight * c.ramp.at(0.5);
  }
  EXPECT_NEAR(weight, 0.2, 1e-12);
}

TEST(SetReference, AReferenceGoesOverToTheNext) {
  ActiveTeam active_team(event_team(2));
  const AgentId leader{BodyId{0}};
  const std::vector<double> there = {2, 0, 1, 1, 0, 0, 0};
  const Agent before = active_team.team(0.0).agent(leader);
  EXPECT_THAT(active_team.apply(SetReference{leader, Reference(there)}, 3.0, 1.0), IsEmpty());
  const Team team = active_team.team(3.0);
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
  EXPECT_TRUE(active_team.team(4.0).agent(leader).x_ref.is_constant());
}

TEST(SetWind, TheLastWindCountsAndIsOfTheWorld) {
  ActiveTeam active_team(event_team(1));
  EXPECT_FALSE(active_team.membership().around.wind.has_value());
  EXPECT_EQ(active_team.apply(SetWind{{1, 0, 0}}, 2.0, 0.5), "");
  EXPECT_EQ(active_team.apply(SetWind{{0, 2, 0}}, 3.0, 1.0), "");
  const auto wind = active_team.membership().around.wind;
  ASSERT_TRUE(wind.has_value());
  EXPECT_EQ(wind->acceleration.y, 2.0);
  EXPECT_EQ(wind->begin, 3.0);
  EXPECT_TRUE(changes_surroundings({.events = {{.name = "", .trigger = AtTime{}, .actions = {SetWind{}}}}}));
  EXPECT_FALSE(
      changes_surroundings({.events = {{.name = "", .trigger = AtTime{}, .actions = {RemoveTerm{"x"}}}}}));
}

TEST(Surroundings, AChangeIsBlendedFromRestToRest) {
  EXPECT_EQ(blended(0.9, 1.0, 2.0), 0.0);
  EXPECT_EQ(blended(2.0, 1.0, 2.0), 0.5);
  EXPECT_EQ(blended(3.0, 1.0, 2.0), 1.0);
  EXPECT_EQ(blended(9.0, 1.0, 2.0), 1.0);
  EXPECT_LT(blended(1.01, 1.0, 2.0), 1e-4);
  EXPECT_GT(blended(2.99, 1.0, 2.0), 1 - 1e-4);
  EXPECT_EQ(blended(0.9, 1.0, 0.0), 0.0);
  EXPECT_EQ(blended(1.0, 1.0, 0.0), 1.0);
}

}  // namespace
}  // namespace sightline
