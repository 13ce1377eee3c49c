#include "sightline/scenario/event_text.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "sightline/events.hpp"
#include "sightline/potentials.hpp"
#include "tests/support/random.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/scene.hpp"

namespace sightline {
namespace {

/// With the names of a coupling and of a constraint.
struct EventScene : test::Scene {
  std::vector<NamedTerm> terms = {{"apart", uav0, true}, {"band", uav1, false}};
  Simulation simulation{.duration = 30.0, .signals = {{12.0, "go"}, {13.0, "stop"}}};

  Trigger read(const std::string& text) const {
    EventScope scope{team, observers, simulation};
    scope.couplings = team.couplings();
    const TomlDocument document = parse_toml(text, "a");
    return read_trigger(TomlTable(document), scope, {"enter"});
  }
  std::vector<Action> actions(const std::string& text) const {
    const EventScope scope{team, observers, simulation, {}, terms};
    const TomlDocument document = parse_toml(text, "a");
    return read_actions(TomlTable(document), scope);
  }
  template <class A>
  A one(const std::string& text) const {
    const std::vector<Action> read = actions(text);
    EXPECT_EQ(read.size(), 1U);
    return std::get<A>(read.at(0));
  }
  Condition condition(const std::string& text) const { return std::get<Condition>(read(text)); }
  std::string refusal(const std::string& text) const {
    return refusal_of<ScenarioError>([&] { (void)read(text); });
  }
  /// Whether the condition holds at these states, as a flight would find.
  bool holds(const Condition& when, const std::vector<double>& x) const {
    Condition at_once = when;
    at_once.dwell = 0.0;
    const Script script{{{.name = "it", .trigger = at_once, .enter = "next"}}};
    EventMonitor monitor(script, team);
    const std::vector<double> u(static_cast<std::size_t>(team.nu()));
    return !monitor.look({.t = 0.0, .x = x, .u = u, .ages = {}, .presence = {}}).empty();
  }
};

/// Places and headings of a scene's bodies.
std::vector<double> scattered(Random& random, const EventScene& scene) {
  std::vector<double> x(static_cast<std::size_t>(scene.team.nx()));
  for (int i = 0; i < scene.team.bodies(); ++i) {
    const BodyId body{i};
    const double psi = uniform(random, -3.0, 3.0);
    scene.team.model(body).at_rest({random_point(random, 3.0), {std::cos(psi), std::sin(psi)}},
                                   x.data() + scene.team.state_offset(body));
  }
  return x;
}

Vec3<double> place(const EventScene& scene, BodyId body, const std::vector<double>& x) {
  const double* const p = x.data() + scene.team.state_offset(body);
  return {p[0], p[1], p[2]};
}

TEST(EventText, ADistanceHoldsWhereThePositionsSaySo) {
  const EventScene scene;
  const Condition near = scene.condition("when = { distance = [\"uav0\", \"rock\"], below = 2.5 }");
  const Condition far = scene.condition("when = { distance = [\"rock\", \"uav0\"], above = 2.5 }");
  Random random(1);
  int held = 0;
  for (int n = 0; n < 500; ++n) {
    const std::vector<double> x = scattered(random, scene);
    const bool expected = norm(place(scene, scene.uav0, x) - place(scene, scene.rock, x)) < 2.5;
    EXPECT_EQ(scene.holds(near, x), expected);
    EXPECT_EQ(scene.holds(far, x), !expected);
    held += expected;
  }
  EXPECT_GT(held, 50);
  EXPECT_LT(held, 450);
}

TEST(EventText, TheTextOfAFormulaOrARegionSaysTheSameAsTheMeasure) {
  const EventScene scene;
  const std::string between = "between = [\"uav0\", \"uav1\"]";
  const std::vector<std::pair<Condition, Condition>> same = {
      {scene.condition("when = { distance = [\"uav0\", \"uav1\"], below = 2.5 }"),
       scene.condition(fmt::format("when = {{ formula = \"distance\", {}, below = 2.5 }}", between))},
      {scene.condition("when = { distance = [\"uav0\", \"uav1\"], below = 2.5 }"),
       scene.condition(fmt::format(
           "when = {{ region = \"distance < near\", {}, parameters = {{ near = \"2.5 m\" }} }}", between))},
      {scene.condition("when = { angle = [\"uav0\", \"uav1\"], above = 1.0 }"),
       scene.condition(fmt::format("when = {{ formula = \"bearing\", {}, above = 1.0 }}", between))},
      {scene.condition("when = { angle = [\"uav0\", \"uav1\"], above = 1.0 }"),
       scene.condition(fmt::format("when = {{ region = {{ not = \"bearing < 1\" }}, {} }}", between))},
      {scene.condition("when = { formula = \"observer.p_x\", agent = \"uav1\", above = 0.5 }"),
       scene.condition("when = { formula = \"target.p_x\", between = [\"rock\", \"uav1\"], above = 0.5 }")},
  };
  Random random(2);
  for (const auto& [a, b] : same) {
    int held = 0;
    for (int n = 0; n < 300; ++n) {
      const std::vector<double> x = scattered(random, scene);
      EXPECT_EQ(scene.holds(a, x), scene.holds(b, x));
      held += scene.holds(a, x);
    }
    EXPECT_GT(held, 20);
    EXPECT_LT(held, 280);
  }
}

TEST(EventText, WhatIsNotSeenIsLost) {
  EventScene scene;
  const SensorCone cone{.alpha = 0.8, .mount = *scene.observers[0].mount};
  scene.team.couple(1.0 * cone, Between{scene.uav0, scene.uav1}, felt_by(scene.uav0));
  const std::string view = "{ observer = \"uav0\", target = \"uav1\"";
  const Condition lost = scene.condition(fmt::format("lost = {} }}", view)),
                  seen = scene.condition(fmt::format("seen = {} }}", view)),
                  by_angle = scene.condition(fmt::format("lost = {}, alpha = 0.8 }}", view));
  Random random(3);
  int held = 0;
  for (int n = 0; n < 500; ++n) {
    const std::vector<double> x = scattered(random, scene);
    EXPECT_NE(scene.holds(lost, x), scene.holds(seen, x));
    EXPECT_EQ(scene.holds(lost, x), scene.holds(by_angle, x));
    held += scene.holds(seen, x);
  }
  EXPECT_GT(held, 10);
}

TEST(EventText, HysteresisAndDwellBelongToTheCondition) {
  const EventScene scene;
  for (const char* text :
       {"when = { distance = [\"uav0\", \"uav1\"], below = 2.0, hysteresis = 0.25, dwell = 1.5 }",
        "when = { age = \"rock\", above = 0.5, hysteresis = 0.25, dwell = 1.5 }",
        "when = { region = \"t > 3 s\", agent = \"uav1\", hysteresis = 0.25, dwell = 1.5 }",
        "seen = { observer = \"uav0\", target = \"rock\", alpha = 0.5, hysteresis = 0.25, "
        "dwell = 1.5 }"}) {
    const Condition when = scene.condition(text);
    EXPECT_EQ(when.hysteresis, 0.25);
    EXPECT_EQ(when.dwell, 1.5);
  }
}

TEST(EventText, AViewNeedsTheObserverSSensor) {
  const EventScene scene;
  EXPECT_EQ(
      scene.refusal("when = { region = \"range < 2 m\", between = [\"uav1\", \"uav0\"] }"),
      "a:1: when.between = [\"uav1\", \"uav0\"], expected a robot with a sensor as observer, there is no "
      "[agent.uav1.sensor]");
  EXPECT_EQ(scene.refusal("when = { region = \"distance < 2 m\", between = [\"uav1\", \"uav0\"] }"), "");
}

TEST(EventText, AConditionLooksPastNoThirdBody) {
  const EventScene scene;
  EXPECT_EQ(scene.refusal("when = { region = \"third.p_x < 2 m\", between = [\"uav1\", \"uav0\"] }"),
            "a:1: when.region = \"third.p_x < 2 m\", expected a formula of two bodies, a third is known to a "
            "coupling alone");
}

TEST(EventText, ABodyIsRemovedByItsNameOrByItsKindAndName) {
  const EventScene scene;
  EXPECT_EQ(scene.one<RemoveBody>("remove = \"rock\"").body, scene.rock);
  EXPECT_EQ(scene.one<RemoveBody>("remove = { obstacle = \"rock\" }").body, scene.rock);
  const auto plain = scene.one<RemoveBody>("remove = { agent = \"uav1\" }");
  EXPECT_EQ(plain.body, scene.uav1);
  EXPECT_EQ(plain.afterwards, Afterwards::vanish);
}

TEST(EventText, WhatIsAddedIsAsInItsOwnTable) {
  const EventScene scene;
  EXPECT_EQ(scene.one<AddBody>("add = \"uav1\"").body, scene.uav1);
  EXPECT_EQ(scene.one<AddBody>("add = { target = \"rock\" }").body, scene.rock);
  const Coupling coupling =
      scene
          .one<AddCoupling>(
              "add = { couple = { name = \"look\", weight = 2.5, potential = { sensor_cone "
              "= { alpha = 0.75 } }, between = [\"uav0\", \"rock\"] } }")
          .coupling;
  EXPECT_EQ(coupling.name, "look");
  EXPECT_EQ(coupling.term.weight, 2.5);
  EXPECT_EQ(coupling.term.potential.as<SensorCone>()->alpha, 0.75);
  EXPECT_EQ(coupling.term.potential.mount()->pitch, 0.25);
  EXPECT_EQ(coupling.felt_by, std::vector{scene.uav0});
  const Constraint constraint =
      scene
          .one<AddConstraint>(
              "add = { constrain = { agent = \"uav1\", potential = { altitude_band = { z_max = 4.5 } } } }")
          .constraint;
  EXPECT_EQ(constraint.agent, scene.uav1);
  EXPECT_EQ(constraint.term.potential.as<AltitudeBand>()->z_max, 4.5);
}

TEST(EventText, ATermIsSpokenOfByItsName) {
  const EventScene scene;
  EXPECT_EQ(scene.one<RemoveTerm>("remove = { couple = \"apart\" }").name, "apart");
  EXPECT_EQ(scene.one<RemoveTerm>("remove = { constrain = \"band\" }").name, "band");
  const auto weight = scene.one<RetuneTerm>("retune = { couple = \"apart\", weight = 0.25 }");
  EXPECT_EQ(weight.name, "apart");
  EXPECT_EQ(weight.weight, 0.25);
  EXPECT_FALSE(weight.potential.has_value());
  const auto potential = scene.one<RetuneTerm>(
      "retune = { couple = \"apart\", potential = { sensor_cone = { alpha = 0.25 } } }");
  EXPECT_FALSE(potential.weight.has_value());
  EXPECT_EQ(potential.potential->as<SensorCone>()->alpha, 0.25);
  EXPECT_EQ(potential.potential->mount()->pitch, 0.25);
  const auto band =
      scene.one<RetuneTerm>("retune = { constrain = \"band\", potential = { altitude_band = {} } }");
  EXPECT_FALSE(band.potential->is_pair());
}

TEST(EventText, WhatIsLeftOutOfARobotSTuningStays) {
  const EventScene scene;
  const auto R = scene.one<RetuneAgent>("retune = { agent = \"uav0\", R = [1.0, 2.0, 3.0, 4.0] }");
  EXPECT_EQ(R.agent, scene.uav0);
  EXPECT_EQ(R.R, (std::vector<double>{1, 2, 3, 4}));
  EXPECT_FALSE(R.Q || R.Q_f || R.u_ref || R.limits);
  const auto slow = scene.one<RetuneAgent>("retune = { agent = \"uav1\", u_min = [-0.5, -0.5, -0.5, -0.5] }");
  EXPECT_EQ(slow.limits->u_min().front(), (std::vector<double>(4, -0.5)));
  EXPECT_EQ(slow.limits->u_max().front(), (std::vector<double>(4, 2.0)));
  EXPECT_FALSE(slow.Q || slow.R || slow.Q_f || slow.u_ref);
}

TEST(EventText, AnArrayIsSeveralActionsInTheirOrder) {
  const EventScene scene;
  const auto actions = scene.actions("remove = [ \"uav1\", { couple = \"apart\" }, \"rock\" ]");
  ASSERT_EQ(actions.size(), 3U);
  EXPECT_EQ(std::get<RemoveBody>(actions[0]).body, scene.uav1);
  EXPECT_EQ(std::get<RemoveTerm>(actions[1]).name, "apart");
  EXPECT_EQ(std::get<RemoveBody>(actions[2]).body, scene.rock);
  const auto observe = scene.one<Observe>("observe = { observer = \"uav0\", target = \"rock\" }");
  EXPECT_EQ(observe.observer, scene.uav0);
  EXPECT_EQ(observe.target, scene.rock);
}

}  // namespace
}  // namespace sightline
