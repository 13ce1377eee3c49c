#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "sightline/registry.hpp"
#include "sightline/scenario.hpp"
#include "sightline/worlds.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

namespace fs = std::filesystem;

const fs::path scenarios = SIGHTLINE_SOURCE_DIR "/scenarios", fleets = SIGHTLINE_SOURCE_DIR "/fleets";

/// Parts whose world of that kind, with vehicles, model files and pictures, is never made.
Registry parts_without_world(std::string_view kind) {
  Registry registry = with_links();
  const auto make = [](const Scenario&) -> std::unique_ptr<World> {
    ADD_FAILURE() << "a world is made";
    return nullptr;
  };
  const auto render = [](const Scenario&) -> std::unique_ptr<DetectionSource> {
    ADD_FAILURE() << "a renderer is made";
    return nullptr;
  };
  const auto of_model = [](const Vehicle& vehicle, const ModelBody&) { return vehicle; };
  registry.worlds.add(kind, make, MovedBy::vehicles, of_model, render);
  return registry;
}

/// The shipped scenarios; the files of the other folders hold regions and sensors.
std::vector<fs::path> shipped() {
  std::vector<fs::path> files;
  for (const fs::path& folder : {scenarios, scenarios / "mujoco", scenarios / "rotors", fleets})
    for (const auto& entry : fs::directory_iterator(folder))
      if (entry.path().extension() == ".toml") files.push_back(entry.path());
  return files;
}

TEST(ScenarioSpec, ACopyIsEqualAndTheTextReadsBackEqual) {
  const Registry registry = parts_without_world("mujoco");
  ASSERT_GT(shipped().size(), 30U);
  for (const fs::path& file : shipped()) {
    const ScenarioSpec spec = parse_spec(read_text(file), file, registry);
    const ScenarioSpec copy = spec;
    EXPECT_EQ(copy, spec) << file;
    EXPECT_EQ(parse_spec(toml_text(spec), file, registry), spec) << file;
    const ScenarioSpec layered =
        parse_spec(read_text(file), file, registry, {.files = {}, .set = {"simulation.seed=77"}});
    EXPECT_NE(layered, spec) << file;
    EXPECT_EQ(parse_spec(toml_text(layered), file, registry), layered) << file;
  }
}

TEST(ScenarioSpec, AChangedNumberMakesItUnequal) {
  const ScenarioSpec spec = read_scenario(scenarios / "paper_7_1.toml");
  for (const std::string set : {"couple[0].weight=0.123", "horizon.period=0.02", "agent.uav0.start.p[2]=1.5"})
    EXPECT_NE(spec, read_scenario(scenarios / "paper_7_1.toml", built_in_registry(), {set})) << set;
  ScenarioSpec copy = spec;
  copy.x0.back() += 1e-9;
  EXPECT_NE(copy, spec);
  copy = spec;
  copy.simulation.duration *= 2;
  EXPECT_NE(copy, spec);
}

TEST(ScenarioSpec, ReadingAndCheckingMakesNoWorld) {
  const Registry registry = parts_without_world("never");
  for (const std::string name : {"localize.toml", "cooperative_localization.toml", "swarm32.toml"}) {
    const Scenario scenario = read_scenario(scenarios / "rotors" / name, registry, {"world.kind=\"never\""});
    EXPECT_EQ(scenario.world, "never");
    EXPECT_FALSE(scenario.vehicles.empty());
    check_solvers(scenario);
  }
}

TEST(ScenarioSpec, AWorldChecksWhatItSupportsWithoutBeingMade) {
  Registry registry;
  registry.worlds.add("calm", registry.worlds.find("model")->make, MovedBy::models, {}, {},
                      [](const ScenarioSpec& spec) {
                        if (spec.team.bodies() > 2)
                          throw_invalid("{} bodies, expected at most 2", spec.team.bodies());
                      });
  const auto read = [&] {
    (void)read_scenario(scenarios / "third_robot.toml", registry, {"world.kind=\"calm\""});
  };
  EXPECT_THAT(refusal_of<ScenarioError>(read), testing::HasSubstr("3 bodies, expected at most 2"));
}

TEST(ScenarioSpec, EachBuildHasGoalsOfItsOwn) {
  const ScenarioSpec spec = parse_spec(
      "[fleet]\n[agent.a]\nrobot = \"multirotor\"\nstart = { p = [0, 0, 1] }\nQ = [1, 1, 1, 0, 0, 0, 0]\n"
      "reference = { constant = { p = [0, 0, 2] } }\n[agent.a.link]\nkind = \"px4\"\nrelease = "
      "\"1.16\"\nnamespace = \"/px4_1\"\n"
      "origin = { p = [1, 2, 3], heading = 0.0 }\ngoal_topic = \"/a/goal\"\n",
      "a.toml", with_links());
  const Scenario one = build(spec, with_links()), other = build(spec, with_links());
  const auto height = [](const ScenarioSpec& scenario) {
    std::vector<double> x(7);
    const Agent& robot = scenario.team.agents()[0];
    robot.x_ref(9.0, robot.model, x);
    return x[2];
  };
  EXPECT_EQ(one.goals.at(0).track->add(1.0, std::vector{Waypoint{.p = {0, 0, 3}}}), GoalAnswer::taken);
  EXPECT_EQ(height(one), 3.0);
  EXPECT_EQ(height(other), 2.0);
  EXPECT_EQ(height(spec), 2.0);
}

}  // namespace
}  // namespace sightline
