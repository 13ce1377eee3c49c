#include "sightline/scenario/read_action.hpp"

#include <gtest/gtest.h>

#include "sightline/potential/bounds.hpp"
#include "sightline/potential/distance.hpp"
#include "sightline/potential/sensor_cone.hpp"

namespace sightline {
namespace {

/// Two robots, the first with a sensor, a rock; a named coupling and a named constraint.
struct Scene {
  Team team;
  AgentId uav0 = team.add(Multirotor{});
  AgentId uav1 = team.add(Multirotor{}, {.u_min = {-1, -1, -1, -1}, .u_max = {2, 2, 2, 2}});
  BodyId rock = team.add(Obstacle{"rock"});
  Observers observers = {{"uav0", SensorMount{.pitch = 0.25, .offset = 0.125}}, {"uav1", {}}};
  Simulation simulation{};
  std::vector<NamedTerm> terms = {{"apart", uav0, true}, {"band", uav1, false}};

  std::vector<Action> read(const std::string& text) const {
    const EventScope scope{team, observers, simulation, {}, terms};
    const TomlDocument document = parse_toml(text, "a");
    const TomlTable at(document);
    return read_actions(at, at.keys().at(0), scope);
  }
  template <class A>
  A one(const std::string& text) const {
    const std::vector<Action> actions = read(text);
    EXPECT_EQ(actions.size(), 1U);
    return std::get<A>(actions.at(0));
  }
};

TEST(ReadAction, a_body_is_removed_by_its_name_or_by_its_kind_and_name) {
  const Scene scene;
  EXPECT_EQ(scene.one<RemoveBody>("remove = \"rock\"").body, scene.rock);
  EXPECT_EQ(scene.one<RemoveBody>("remove = { obstacle = \"rock\" }").body, scene.rock);
  const auto plain = scene.one<RemoveBody>("remove = { agent = \"uav1\" }");
  EXPECT_EQ(plain.body, scene.uav1);
  EXPECT_EQ(plain.afterwards, Afterwards::vanish);
}

TEST(ReadAction, each_word_says_what_a_robot_does_afterwards) {
  const Scene scene;
  const auto afterwards = [&](const std::string& word) {
    return scene.one<RemoveBody>("remove = { agent = \"uav1\", then = \"" + word + "\" }").afterwards;
  };
  EXPECT_EQ(afterwards("vanish"), Afterwards::vanish);
  EXPECT_EQ(afterwards("hold"), Afterwards::hold);
  EXPECT_EQ(afterwards("land"), Afterwards::land);
}

TEST(ReadAction, what_is_added_is_as_in_its_own_table) {
  const Scene scene;
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

TEST(ReadAction, a_term_is_spoken_of_by_its_name) {
  const Scene scene;
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

TEST(ReadAction, what_is_left_out_of_a_robot_s_tuning_stays) {
  const Scene scene;
  const auto R = scene.one<RetuneAgent>("retune = { agent = \"uav0\", R = [1.0, 2.0, 3.0, 4.0] }");
  EXPECT_EQ(R.agent, scene.uav0);
  EXPECT_EQ(R.R, (std::vector<double>{1, 2, 3, 4}));
  EXPECT_FALSE(R.Q || R.Q_f || R.u_ref || R.limits);
  const auto slow = scene.one<RetuneAgent>("retune = { agent = \"uav1\", u_min = [-0.5, -0.5, -0.5, -0.5] }");
  EXPECT_EQ(slow.limits->u_min().front(), (std::vector<double>(4, -0.5)));
  EXPECT_EQ(slow.limits->u_max().front(), (std::vector<double>(4, 2.0)));
  EXPECT_FALSE(slow.Q || slow.R || slow.Q_f || slow.u_ref);
}

TEST(ReadAction, a_reference_is_of_the_robot_s_own_state) {
  const Scene scene;
  const auto change = scene.one<SetReference>(
      "reference = { agent = \"uav1\", reference = { state = [1, 2, 3, 1, 0, 0, 0] } }");
  EXPECT_EQ(change.agent, scene.uav1);
  std::vector<double> x(7);
  change.reference(0.0, scene.team.model(scene.uav1), x);
  EXPECT_EQ(x, (std::vector<double>{1, 2, 3, 1, 0, 0, 0}));
}

TEST(ReadAction, an_array_is_several_actions_in_their_order) {
  const Scene scene;
  const auto actions = scene.read("remove = [ \"uav1\", { couple = \"apart\" }, \"rock\" ]");
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
