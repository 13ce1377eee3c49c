#include "sightline/scenario/read_trigger.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "sightline/ocp/watch.hpp"
#include "sightline/potential/sensor_cone.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

/// Two robots, the first with a sensor on the second, and a rock.
struct Scene {
  Team team;
  AgentId uav0 = team.add(Multirotor{});
  AgentId uav1 = team.add(Multirotor{});
  BodyId rock = team.add(Obstacle{"rock"});
  Observers observers = {{"uav0", SensorMount{.pitch = 0.25, .offset = 0.125}}, {"uav1", {}}};
  Simulation simulation{.duration = 30.0, .signals = {{12.0, "go"}, {13.0, "stop"}}};

  Trigger read(const std::string& text) const {
    EventScope scope{team, observers, simulation};
    scope.couplings = team.couplings();
    const TomlDocument document = parse_toml(text, "a");
    return read_trigger(TomlTable(document), scope, {"enter"});
  }
  Condition condition(const std::string& text) const { return std::get<Condition>(read(text)); }
  std::string refusal(const std::string& text) const {
    try {
      (void)read(text);
    } catch (const ScenarioError& error) {
      return error.what();
    }
    return "not refused";
  }
  /// Whether the condition holds at these states, as a flight would find.
  bool holds(const Condition& when, const std::vector<double>& x) const {
    Condition at_once = when;
    at_once.dwell = 0.0;
    const Script script{{{.name = "it", .trigger = at_once, .enter = "next"}}};
    Watch watch(script, team);
    const std::vector<double> u(static_cast<std::size_t>(team.nu()));
    return !watch.look({.t = 0.0, .x = x, .u = u, .ages = {}, .presence = {}}).empty();
  }
};

/// Places and headings of Scene's bodies.
std::vector<double> scattered(Random& random, const Scene& scene) {
  std::vector<double> x(static_cast<std::size_t>(scene.team.nx()));
  for (int i = 0; i < scene.team.bodies(); ++i) {
    const BodyId body{i};
    const double psi = uniform(random, -3.0, 3.0);
    scene.team.model(body).at_rest({random_point(random, 3.0), {std::cos(psi), std::sin(psi)}},
                                   x.data() + scene.team.state_offset(body));
  }
  return x;
}

Vec3<double> place(const Scene& scene, BodyId body, const std::vector<double>& x) {
  const double* const p = x.data() + scene.team.state_offset(body);
  return {p[0], p[1], p[2]};
}

TEST(ReadTrigger, times_and_signals_are_as_written) {
  const Scene scene;
  EXPECT_EQ(std::get<AtTime>(scene.read("at = 20.5")).t, 20.5);
  EXPECT_EQ(std::get<AfterTime>(scene.read("after = 2")).delay, 2.0);
  EXPECT_EQ(std::get<Signal>(scene.read("signal = \"stop\"")).name, "stop");
}

TEST(ReadTrigger, a_distance_holds_where_the_positions_say_so) {
  const Scene scene;
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

TEST(ReadTrigger, the_text_of_a_formula_or_a_region_says_the_same_as_the_measure) {
  const Scene scene;
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

TEST(ReadTrigger, what_is_not_seen_is_lost) {
  Scene scene;
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

TEST(ReadTrigger, hysteresis_and_dwell_belong_to_the_condition) {
  const Scene scene;
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

TEST(ReadTrigger, a_view_needs_the_observer_s_sensor) {
  const Scene scene;
  EXPECT_EQ(
      scene.refusal("when = { region = \"range < 2 m\", between = [\"uav1\", \"uav0\"] }"),
      "a:1: when.between = [\"uav1\", \"uav0\"], expected a robot with a sensor as observer, there is no "
      "[agent.uav1.sensor]");
  EXPECT_EQ(scene.refusal("when = { region = \"distance < 2 m\", between = [\"uav1\", \"uav0\"] }"),
            "not refused");
}

}  // namespace
}  // namespace sightline
