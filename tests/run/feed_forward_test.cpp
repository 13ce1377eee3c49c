#include "sightline/run/feed_forward.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "sightline/robots.hpp"

namespace sightline {
namespace {

template <RobotModel M>
Agent agent_of(const M& robot) {
  Team team;
  return team.agent(team.add(robot));
}

/// How far a robot ends from its circle after 3 s under u* alone, from a place on it at its
/// velocity.
double astray(const Agent& agent, const Circle& circle, const Vec2<double>& heading, bool fed) {
  const Model& model = agent.model;
  std::vector<double> x(agent.Q.size()), u(agent.R.size());
  const Pose<double> there = circle(0.0);
  model.at_rest({there.p, heading}, x.data());
  const Vec2<double> v_G = {0.0, circle.radius * circle.rate},
                     v = model.turns() ? rotate<double>({heading.x, -heading.y}, v_G) : v_G;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (model.states()[i] == "v_f" || model.states()[i] == "v_x") x[i] = v.x;
    if (model.states()[i] == "v_s" || model.states()[i] == "v_y") x[i] = v.y;
  }
  FeedForward feed_forward(agent);
  for (int k = 0; k < 300; ++k) {
    if (fed) feed_forward(Reference(circle), 0.01 * k, model.sight(x.data(), u.data()).d, u);
    model.step(x.data(), u.data(), 0.01);
    EXPECT_TRUE(model.normalise(x.data()));
  }
  return norm(model.sight(x.data(), u.data()).p - circle(3.0).p);
}

TEST(FeedForward, ByItAloneARobotStaysOnItsCircle) {
  const Circle circle = {.centre = {0.1, 0.2, 1.0}, .radius = 0.5, .rate = 0.4};
  for (const Agent& agent :
       {agent_of(Multirotor{}), agent_of(AngleMultirotor{}), agent_of(HoverMultirotor{}),
        agent_of(LaggingHoverMultirotor{}), agent_of(VelocityMultirotor{}),
        agent_of(LaggedMultirotor<Lags::plane>{}), agent_of(OmniRover{}), agent_of(PointMass{.drag = 0.4})}) {
    for (const Vec2<double>& heading : {Vec2<double>{1, 0}, Vec2<double>{-0.6, 0.8}}) {
      EXPECT_LT(astray(agent, circle, heading, true), 0.03) << agent.model.name();
      EXPECT_GT(astray(agent, circle, heading, false), 0.1) << agent.model.name();
    }
  }
}

TEST(FeedForward, AClimbIsFedWhetherItLagsOrNot) {
  const Reference climb([](double t) { return Pose<double>{{0, 0, 0.2 * t}, {0, 0}}; });
  for (const Agent& agent : {agent_of(Multirotor{}), agent_of(LaggingHoverMultirotor{}),
                             agent_of(PointMass{}), agent_of(VelocityMultirotor{})}) {
    std::vector<double> u(agent.R.size());
    FeedForward{agent}(climb, 1.0, {0.6, 0.8}, u);
    std::vector<double> x(agent.Q.size());
    agent.model.at_rest({{}, {0.6, 0.8}}, x.data());
    for (std::size_t i = 0; i < x.size(); ++i)
      if (agent.model.states()[i] == "v_z") x[i] = 0.2;
    for (int k = 0; k < 200; ++k) agent.model.step(x.data(), u.data(), 0.01);
    EXPECT_NEAR(agent.model.sight(x.data(), u.data()).v.z, 0.2, 1e-6) << agent.model.name();
  }
}

TEST(FeedForward, ATurnIsFedWhereAHeadingIsAsked) {
  const double rate = 0.4;
  const Reference turn([&](double t) { return Pose<double>{{}, {std::cos(rate * t), std::sin(rate * t)}}; });
  for (Agent agent : {agent_of(Multirotor{}), agent_of(LaggingHoverMultirotor{}),
                      agent_of(VelocityMultirotor{}), agent_of(OmniRover{}), agent_of(Unicycle{})}) {
    std::vector<double> u(agent.R.size());
    FeedForward{agent}(turn, 1.0, {0.6, 0.8}, u);
    EXPECT_EQ(u, agent.u_ref) << agent.model.name();
    for (std::size_t i = 0; i < agent.Q.size(); ++i)
      if (agent.model.states()[i] == "d_x" || agent.model.states()[i] == "d_y") agent.Q[i] = 1.0;
    FeedForward{agent}(turn, 1.0, {0.6, 0.8}, u);
    std::vector<double> x(agent.Q.size());
    agent.model.at_rest({{}, {1, 0}}, x.data());
    const auto heading = [&] {
      const Vec2<double> d = agent.model.sight(x.data(), u.data()).d;
      return std::atan2(d.y, d.x);
    };
    const auto fly = [&](int periods) {
      for (int k = 0; k < periods; ++k) {
        agent.model.step(x.data(), u.data(), 0.01);
        EXPECT_TRUE(agent.model.normalise(x.data()));
      }
    };
    fly(200);
    const double before = heading();
    fly(100);
    EXPECT_NEAR(heading() - before, rate, 1e-4) << agent.model.name();
    EXPECT_LT(norm(agent.model.sight(x.data(), u.data()).p), 1e-9) << agent.model.name();
  }
}

TEST(FeedForward, OfAReferenceThatStandsOrIsNoNumberIsUStarOfTheTeam) {
  Agent agent = agent_of(Multirotor{});
  agent.u_ref = {0.1, -0.2, 0.3, 0.4};
  FeedForward feed_forward(agent);
  std::vector<double> u(4);
  feed_forward(Reference(Constant{.p = {1, 2, 3}}), 5.0, {0.6, 0.8}, u);
  EXPECT_EQ(u, agent.u_ref);
  u.assign(4, 7.0);
  feed_forward(Reference([](double) -> Pose<double> { throw std::runtime_error("none"); }), 5.0, {1, 0}, u);
  EXPECT_EQ(u, agent.u_ref);
}

}  // namespace
}  // namespace sightline
