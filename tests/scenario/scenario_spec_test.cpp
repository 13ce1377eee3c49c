#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "sightline/registry.hpp"
#include "sightline/scenario.hpp"
#include "sightline/worlds.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

namespace fs = std::filesystem;

const fs::path scenarios = SIGHTLINE_SOURCE_DIR "/scenarios";

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

TEST(Scenario, ReadingAndCheckingMakesNoWorld) {
  const Registry registry = parts_without_world("never");
  for (const std::string name : {"localize.toml", "cooperative_localization.toml", "swarm32.toml"}) {
    const Scenario scenario = read_scenario(scenarios / "rotors" / name, registry, {"world.kind=\"never\""});
    EXPECT_EQ(scenario.world, "never");
    EXPECT_FALSE(scenario.vehicles.empty());
    check_solvers(scenario);
  }
}

TEST(Scenario, AWorldChecksWhatItSupportsWithoutBeingMade) {
  Registry registry;
  registry.worlds.add("calm", registry.worlds.find("model")->make, MovedBy::models, {}, {},
                      [](const Scenario& spec) {
                        if (spec.team.bodies() > 2)
                          throw_invalid("{} bodies, expected at most 2", spec.team.bodies());
                      });
  const auto read = [&] {
    (void)read_scenario(scenarios / "third_robot.toml", registry, {"world.kind=\"calm\""});
  };
  EXPECT_THAT(refusal_of<ScenarioError>(read), testing::HasSubstr("3 bodies, expected at most 2"));
}

}  // namespace
}  // namespace sightline
