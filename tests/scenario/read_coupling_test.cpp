#include "sightline/scenario/read_coupling.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "sightline/potentials.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/scene.hpp"

namespace sightline {
namespace {

struct CouplingScene : test::Scene {
  Coupling read(const std::string& text) const {
    const TomlDocument document = parse_toml(text, "a");
    return read_coupling(TomlTable(document), team, observers);
  }
  std::string refusal(const std::string& text) const {
    return refusal_of<ScenarioError>([&] { (void)read(text); });
  }
};

constexpr std::string_view keep_out_term = "potential = { keep_out = { d_min = 0.75 } }\n";

TEST(ReadCoupling, WithoutFeltByAllRobotsOfItFeelACoupling) {
  const CouplingScene scene;
  EXPECT_EQ(scene.read(fmt::format("{}between = [\"uav0\", \"uav1\"]", keep_out_term)).felt_by,
            (std::vector{scene.uav0, scene.uav1}));
  EXPECT_EQ(scene.read(fmt::format("{}between = [\"rock\", \"uav1\"]", keep_out_term)).felt_by,
            std::vector{scene.uav1});
}

TEST(ReadCoupling, TheFirstOfBetweenLooksWithItsOwnSensor) {
  const CouplingScene scene;
  const Coupling read = scene.read("potential = { sensor_cone = {} }\nbetween = [\"uav0\", \"rock\"]");
  EXPECT_EQ(read.term.potential.mount()->pitch, 0.25);
  EXPECT_EQ(scene.refusal("potential = { sensor_cone = {} }\nbetween = [\"rock\", \"uav0\"]"),
            "a:1: potential.sensor_cone = {}, expected a robot with a sensor as observer, there is no "
            "[agent.rock.sensor]");
}

TEST(ReadCoupling, AThirdBodyIsForFormulasThatLookPastIt) {
  const CouplingScene scene;
  const std::string past = "potential = { region = { inside = \"observer.p_x < third.p_x\" } }\n",
                    blind = "potential = { region = { inside = \"distance > 1 m\" } }\n",
                    between = "between = [\"uav0\", \"uav1\"]\n";
  EXPECT_EQ(scene.read(past + between + "third = \"rock\"").third, scene.rock);
  EXPECT_FALSE(scene.read(blind + between).has_third());
  EXPECT_EQ(scene.refusal(past + between + "third = \"rocks\""),
            "a:3: third = \"rocks\", expected the name of a body, the nearest is \"rock\"");
  EXPECT_EQ(scene.refusal(past + between + "third = \"uav1\""),
            "a:3: third = \"uav1\", expected another body than those of between");
  EXPECT_EQ(scene.refusal(blind + between + "third = \"rock\""),
            "a:3: third = \"rock\", expected no such key: region does not look past a third body, none of "
            "its formulas has third.p_x");
}

}  // namespace
}  // namespace sightline
