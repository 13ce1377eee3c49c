#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "cli/allocations.hpp"
#include "sightline/potentials.hpp"
#include "sightline/solvers.hpp"
#include "tests/support/chain_team.hpp"
#include "tests/support/closed_loop.hpp"
#include "tests/support/error.hpp"
#include "tests/support/newton_riccati_of.hpp"
#include "tests/support/random_team.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

constexpr Horizon twelve_stages{.N = 12};
const MakeSolver make_subteam_solver = newton_riccati_of(twelve_stages);
const NewtonRiccatiOptions to_the_end{
    .max_newton_steps = 200, .tolerance = 1e-9, .max_krylov = 200, .krylov_stop = 0};

AgentId robot(const Team& team, const std::string& name) { return AgentId{team.find(name)}; }

TEST(Subteam, HasItsRobotsAndThoseItIsCoupledWithAndFeelsItsOwnEndsAlone) {
  const auto subteam = [](paper::Variant variant) {
    const Team whole = chain(8, variant);
    return subteam_of(whole, std::vector{robot(whole, "uav3"), robot(whole, "uav2")});
  };
  const Team masked = subteam(paper::Variant::masked), joint = subteam(paper::Variant::joint);
  EXPECT_EQ(masked.agents().size(), 2u);
  EXPECT_EQ(masked.bodies(), 3) << "uav2 observes uav1, which is not steered here";
  EXPECT_FALSE(masked.is_agent(masked.find("uav1")));
  EXPECT_EQ(masked.couplings().size(), 6u);
  EXPECT_EQ(joint.agents().size(), 2u);
  EXPECT_EQ(joint.bodies(), 4) << "and uav3 feels uav4";
  EXPECT_EQ(joint.couplings().size(), 9u);
  for (const Coupling& c : joint.couplings()) {
    for (const AgentId agent : c.felt_by) EXPECT_TRUE(joint.is_agent(agent));
  }
}

TEST(Subteam, ACouplingKeepsItsNameAndItsRampAndASwarmStaysWhole) {
  Team whole = chain(4, paper::Variant::joint);
  const AgentId uav1 = robot(whole, "uav1"), uav2 = robot(whole, "uav2");
  whole.couple(Coupling{.term = 0.3 * KeepOut{},
                        .between = {uav1, uav2},
                        .felt_by = {uav2},
                        .name = "apart",
                        .ramp = {.begin = 1.0, .duration = 2.0, .from = 0.0}});
  const Team subteam = subteam_of(whole, std::vector{uav2});
  ASSERT_FALSE(subteam.couplings().empty());
  EXPECT_EQ(subteam.couplings().back().name, "apart");
  EXPECT_EQ(subteam.couplings().back().ramp, whole.couplings().back().ramp);
  whole.keep_apart(0.3 * TooNear{}, {uav1, uav2}, 2.5, 16);
  EXPECT_EQ(subteam_of(whole, std::vector{uav1, uav2}).swarms().size(), 1u);
  EXPECT_EQ(subteam_of(whole, std::vector{robot(whole, "uav0")}).swarms().size(), 0u);
  EXPECT_EQ(refusal_of([&] { (void)subteam_of(whole, std::vector{uav2}); }),
            "too_near keeps robots of several parts apart, expected all of a swarm in one part");
}

TEST(Subteam, WhatIsNoPartIsRefusedInWords) {
  Team whole = chain(2, paper::Variant::masked);
  const BodyId tree = whole.add(Obstacle{.name = "tree"});
  EXPECT_EQ(refusal_of([&] { (void)subteam_of(whole, {}); }), "a part has no robot, expected at least one");
  EXPECT_EQ(refusal_of([&] { (void)subteam_of(whole, std::vector{AgentId{tree}}); }),
            "a part names body 2, expected a robot of the team");
  EXPECT_EQ(refusal_of([&] { (void)subteam_of(whole, std::vector{AgentId{{7}}}); }),
            "a part names body 7, expected a robot of the team");
}

TEST(Subteam, GivenTheVelocityThatABodyHasItFliesTheSameBits) {
  Random random(1);
  for (int trial = 0; trial < 20; ++trial) {
    Team team = random_team(random, 2, Feeling::anyone);
    team.add(Obstacle{.name = "ball"});
    team.couple(1.0 * KeepOut{}, Between{team.find("uav0"), team.find("ball")});
    NewtonRiccati plain(team, twelve_stages), predicted(team, twelve_stages);
    const std::vector<double> x = random_states(random, team, 2.0);
    for (int update = 0; update < 5; ++update) {
      const double t = 0.01 * update;
      for (int b = 0; b < team.bodies(); ++b) {
        if (team.is_agent(BodyId{b})) continue;
        Prediction prediction{.who = {b}, .time = t, .h = twelve_stages.h()};
        Sight<double> s =
            team.model(BodyId{b}).sight(&x[static_cast<std::size_t>(team.state_offset(BodyId{b}))], nullptr);
        for (int k = 0; k <= twelve_stages.N; ++k) {
          prediction.sights.push_back(s);
          s.p = s.p + twelve_stages.h() * s.v;
        }
        predicted.set_prediction(prediction);
      }
      const Solution a = plain.solve(t, x), b = predicted.solve(t, x);
      for (std::size_t i = 0; i < a.u.size(); ++i) EXPECT_TRUE(same_bits(a.u[i], b.u[i])) << trial;
      EXPECT_TRUE(same_bits(a.residual, b.residual));
    }
  }
}

/// Subteams of one robot each that plan and send what a solver of the whole team found.
std::vector<std::unique_ptr<Subteam>> subteams_at(const NewtonRiccati& whole, double time,
                                                  const std::vector<double>& x) {
  const Ocp& ocp = whole.ocp();
  std::vector<std::unique_ptr<Subteam>> subteams;
  std::vector<double> u(static_cast<std::size_t>(ocp.nu()));
  for (const BodyId body : ocp.agent_bodies()) {
    auto subteam =
        std::make_unique<Subteam>(ocp.team(), std::vector{AgentId{body}}, newton_riccati_of(ocp.horizon()));
    for (int k = 0; k < ocp.horizon().N; ++k) {
      whole.plan(k, u);
      subteam->set_plan(k, std::span(u).subspan(static_cast<std::size_t>(ocp.team().input_offset(body)),
                                                static_cast<std::size_t>(subteam->ocp().nu())));
    }
    subteam->predict(time, x);
    subteams.push_back(std::move(subteam));
  }
  for (const auto& sender : subteams) {
    for (const auto& other : subteams) {
      if (other == sender) continue;
      for (const Prediction& prediction : sender->predictions()) other->receive(prediction);
    }
  }
  return subteams;
}

TEST(Subteam, GivenTheOthersOptimalTrajectoriesItsOptimumIsThatOfTheWhole) {
  Random random(2);
  int converged = 0;
  for (int trial = 0; trial < 40; ++trial) {
    const Team team =
        random_team(random, 2 + trial % 3, trial % 2 == 0 ? Feeling::everyone : Feeling::anyone);
    NewtonRiccati whole(team, twelve_stages, to_the_end);
    const std::vector<double> x = random_states(random, team, 2.0);
    if (whole.solve(0.3, x).status != Status::converged) continue;
    ++converged;
    for (const auto& subteam : subteams_at(whole, 0.3, x)) EXPECT_LE(subteam->kkt(0.3, x), 1e-8) << trial;
  }
  EXPECT_GE(converged, 36);
}

TEST(Subteam, WithoutWordFromTheOthersItsOptimumIsAnother) {
  const Team team = chain(3, paper::Variant::joint);
  NewtonRiccati whole(team, twelve_stages, to_the_end);
  const std::vector<double> x = chain_start(3);
  ASSERT_EQ(whole.solve(0.3, x).status, Status::converged);
  const auto subteams = subteams_at(whole, 0.3, x);
  subteams[1]->restart();
  std::vector<double> u(12);
  for (int k = 0; k < twelve_stages.N; ++k) {
    whole.plan(k, u);
    subteams[1]->set_plan(k, std::span(u).subspan(4, 4));
  }
  EXPECT_GE(subteams[1]->kkt(0.3, x), 1e-3);
}

TEST(Subteam, ItSendsWhereItsPlanLeads) {
  const Team team = chain(4, paper::Variant::joint);
  Subteam subteam(team, std::vector{robot(team, "uav1"), robot(team, "uav2")}, make_subteam_solver);
  const std::vector<double> x = chain_start(4);
  ASSERT_TRUE(gives_plan(subteam.solve(0.2, x).status));
  ASSERT_EQ(subteam.predictions().size(), 2u);
  for (std::size_t i = 0; i < 2; ++i) {
    const Prediction& sent = subteam.predictions()[i];
    EXPECT_EQ(team.name(sent.who), i == 0 ? "uav1" : "uav2");
    EXPECT_EQ(sent.time, 0.2);
    ASSERT_EQ(sent.sights.size(), 13u);
    const BodyId here = subteam.ocp().team().find(team.name(sent.who));
    const Model& model = team.model(sent.who);
    std::vector<double> u(static_cast<std::size_t>(subteam.ocp().nu())), rate(7);
    std::vector<double> state(x.begin() + team.state_offset(sent.who),
                              x.begin() + team.state_offset(sent.who) + 7);
    for (int k = 0; k < 13; ++k) {
      if (k < 12) subteam.plan(k, u);
      EXPECT_NEAR(sent.sights[static_cast<std::size_t>(k)].p.x, state[0], 1e-12);
      EXPECT_NEAR(sent.sights[static_cast<std::size_t>(k)].d.y, state[4], 1e-12);
      model.f(state.data(), &u[static_cast<std::size_t>(subteam.ocp().team().input_offset(here))],
              rate.data());
      for (std::size_t q = 0; q < 7; ++q) state[q] += twelve_stages.h() * rate[q];
    }
  }
  const double before = subteam.predictions()[0].sights[12].p.x;
  std::vector<double> moved = x;
  moved[7] += 0.5;
  subteam.predict(0.2, moved);
  EXPECT_NEAR(subteam.predictions()[0].sights[12].p.x, before + 0.5, 1e-9);
}

TEST(Subteam, AMessageThatCannotBeMeantForItIsLeft) {
  const Team team = chain(3, paper::Variant::joint);
  Subteam subteam(team, std::vector{robot(team, "uav1")}, make_subteam_solver),
      alone(team, std::vector{robot(team, "uav1")}, make_subteam_solver);
  const Sight<double> elsewhere = {{{0.3, 0.2, 0.6}, {1, 0}}, {1, 1, 1}};
  const Prediction good{
      .who = robot(team, "uav0"), .time = 0.0, .h = twelve_stages.h(), .sights = {13, elsewhere}};
  std::vector<Prediction> bad(6, good);
  bad[0].who = robot(team, "uav1");
  bad[1].who = BodyId{3};
  bad[2].who = BodyId{-1};
  bad[3].sights[4].p.y = std::numeric_limits<double>::infinity();
  bad[4].sights.resize(14);
  bad[5].h = 0.0;
  for (const Prediction& message : bad) subteam.receive(message);
  const std::vector<double> x = chain_start(3);
  const std::vector<double> a(subteam.solve(0.0, x).u.begin(), subteam.solve(0.0, x).u.end());
  const std::vector<double> b(alone.solve(0.0, x).u.begin(), alone.solve(0.0, x).u.end());
  EXPECT_EQ(a, b);
  subteam.receive(good);
  EXPECT_NE(subteam.solve(0.0, x).u[0], alone.solve(0.0, x).u[0]) << "a good one is used";
}

TEST(Subteam, SolvingSendingAndReceivingAllocateNothing) {
  const Team team = chain(4, paper::Variant::joint);
  Subteam a(team, std::vector{robot(team, "uav0"), robot(team, "uav2")}, make_subteam_solver),
      b(team, std::vector{robot(team, "uav1"), robot(team, "uav3")}, make_subteam_solver);
  const std::vector<double> x = chain_start(4);
  const std::int64_t before = cli::allocations();
  for (int k = 0; k < 20; ++k) {
    a.solve(0.01 * k, x);
    for (const Prediction& prediction : a.predictions()) b.receive(prediction);
    b.solve(0.01 * k, x);
    for (const Prediction& prediction : b.predictions()) a.receive(prediction);
  }
  EXPECT_EQ(cli::allocations() - before, 0);
}

}  // namespace
}  // namespace sightline
