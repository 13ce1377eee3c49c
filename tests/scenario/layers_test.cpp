#include "sightline/scenario/layers.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "sightline/scenario.hpp"
#include "sightline/scenario/templates.hpp"
#include "tests/support/command.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const std::string pair_text = R"([horizon]
stages = 10
[agent.a]
robot = "multirotor"
start = { p = [0, 0, 1], heading = 0.0 }
R = [1.0, 1.0, 1.0, 1.0]
parameters = { b_z = 0.5, b_psi = 1.0 }
[agent.b]
robot = "multirotor"
start = { p = [2, 0, 1], heading = 0.0 }
[[couple]]
potential = { keep_out = { d_min = 1.0 } }
between = ["a", "b"]
weight = 0.4
)";

/// Files that a test writes.
class Layers : public testing::Test {
 protected:
  Layers() { write("pair.toml", pair_text); }

  fs::path write(const std::string& name, const std::string& text) const {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name) << text;
    return folder_ / name;
  }
  Scenario read(const std::string& text, const std::vector<std::string>& set = {}) const {
    return read_scenario(write("upper.toml", "based_on = \"pair.toml\"\n" + text), built_in_registry(), set);
  }
  std::string refusal(const std::string& text, const std::vector<std::string>& set = {}) const {
    return refusal_of<ScenarioError>([&] { read(text, set); });
  }
  std::string in(const std::string& name) const { return (folder_ / name).native(); }

 private:
  fs::path folder_ = test::fresh_folder();
};

TEST_F(Layers, WhatIsNotSaidIsAsInTheFileBelow) {
  const Scenario below = read_scenario(in("pair.toml")), upper = read("");
  EXPECT_EQ(summary(upper).substr(summary(upper).find('\n')),
            summary(below).substr(summary(below).find('\n')));
  EXPECT_EQ(upper.x0, below.x0);
  EXPECT_EQ(upper.name, "upper");
}

TEST_F(Layers, ASectionIsFilledKeyByKeyAndAValueTakesThePlaceOfAnother) {
  const Scenario s = read(
      "[agent.a]\nparameters = { b_z = 0.7 }\n[agent.a.start]\nheading = 1.0\n[horizon]\nperiod = 0.02\n");
  EXPECT_EQ(s.horizon.N, 10);
  EXPECT_EQ(s.horizon.dt, 0.02);
  EXPECT_EQ(s.team.agents()[0].R, (std::vector<double>{1, 1, 1, 1}));
  EXPECT_EQ(s.x0[2], 1.0) << "a section fills a table that is a value below";
  EXPECT_NEAR(s.x0[4], std::sin(1.0), 1e-12);
  EXPECT_THAT(s.text, HasSubstr("parameters = { b_z = 0.7 }")) << "b_psi is the default again";
}

TEST_F(Layers, AListOfSectionsGoesOnAndAListAsAValueIsAnother) {
  const std::string more = "potential = { cohesion = { d_max = 2.0 } }\nbetween = [\"a\", \"b\"]\n";
  const Scenario longer = read("[[couple]]\n" + more);
  ASSERT_EQ(longer.team.couplings().size(), 2u);
  EXPECT_EQ(longer.team.couplings()[0].term.weight, 0.4);
  EXPECT_EQ(read("couple = [{ potential = { cohesion = { d_max = 2.0 } }, between = [\"a\", \"b\"] }]\n")
                .team.couplings()
                .size(),
            1u);
  EXPECT_EQ(read("couple = []\n").team.couplings().size(), 0u);
}

TEST_F(Layers, BodiesOfTheFileBelowComeFirst) {
  const std::string text =
      "[agent.c]\nrobot = \"multirotor\"\nstart = { p = [4, 0, 1], heading = 0.0 }\n[agent.a]\nR = [2, 2, 2, "
      "2]\n";
  const Scenario s = read(text, {"agent.d.robot=multirotor", "agent.d.start={ p = [6, 0, 1] }"});
  ASSERT_EQ(s.team.agents().size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(s.team.agents()[i].name, std::string(1, "abcd"[i]));
  EXPECT_EQ(s.team.agents()[0].R[0], 2.0);
}

TEST_F(Layers, TheOneTextOfAllLayersReadsAsTheSameScenario) {
  const Scenario s = read("[agent.a]\nQ = [0.1, 0, 1e-3, 0, 0, 0, 0]\n", {"couple[0].weight=0.3"});
  const Scenario again = parse_scenario(s.text, "upper.toml");
  EXPECT_EQ(summary(again), summary(s));
  EXPECT_EQ(again.x0, s.x0);
  EXPECT_EQ(again.text, s.text);
  EXPECT_EQ(again.team.couplings()[0].term.weight, 0.3);
  EXPECT_THAT(s.text, testing::Not(HasSubstr("based_on")));
}

TEST_F(Layers, TemplatesAndRangesMayBeFilledToo) {
  write("pair.toml",
        "[template.t]\nrobot = \"multirotor\"\nR = [1, 1, 1, 1]\n[agent.\"r{0..1}\"]\ninherits = \"t\"\n"
        "start = { p = { place = \"line\", from = [0.0, 0.0, 1.0], to = [3.0, 0.0, 1.0] } }\n");
  const Scenario s = read("[template.t]\nR = [3, 3, 3, 3]\n", {"agent.\"r{0..1}\".command_delay=0.1"});
  ASSERT_EQ(s.team.agents().size(), 2u);
  EXPECT_EQ(s.team.agents()[1].R[0], 3.0);
  EXPECT_EQ(s.compensations.size(), 2u);
  EXPECT_EQ(refusal("[template.t]\nR = [3]\n"),
            in("upper.toml") + ":3: agent.r0.R = [3], expected an array of 4 numbers");
}

TEST_F(Layers, ARefusalNamesTheFileInWhichTheKeyStands) {
  EXPECT_EQ(refusal("[horizon]\nstages = 0\n"),
            in("upper.toml") + ":3: horizon.stages = 0, expected an integer, 1 to 1000");
  EXPECT_THAT(refusal("[agent.a]\nRR = 1\n"),
              testing::StartsWith(in("upper.toml") + ":3: agent.a.RR = 1, expected a known key: robot, "));
  EXPECT_EQ(refusal("", {"horizon.stages=0"}),
            "--set horizon.stages=0: horizon.stages = 0, expected an integer, 1 to 1000");
  write("pair.toml", pair_text + "wieght = 1\n");
  EXPECT_EQ(refusal(""),
            in("pair.toml") + ":15: couple[0].wieght = 1, expected a known key, the nearest is \"weight\"");
  write("pair.toml",
        pair_text + "[[couple]]\npotential = { region = { inside = \"x >\" } }\nbetween = [\"a\", \"b\"]\n");
  EXPECT_THAT(refusal("[horizon]\n"),
              testing::StartsWith(in("pair.toml") + ":16:39: couple[1].potential.region.inside = \"x >\", "));
}

TEST_F(Layers, AFileThatIsMissingOrBasedOnItselfIsRefused) {
  const std::string place = in("upper.toml") + ":1: based_on = ",
                    expected = ", expected a scenario file, relative to this one";
  const auto refused = [&](const std::string& text) {
    return refusal_of<ScenarioError>([&] { read_scenario(write("upper.toml", text)); });
  };
  EXPECT_EQ(refused("based_on = 3\n"), place + "..." + expected);
  EXPECT_THAT(refused("based_on = \"none.toml\"\n"),
              testing::StartsWith(place + "\"none.toml\"" + expected + " ("));
  EXPECT_EQ(refused("based_on = \"upper.toml\"\n"),
            place + "\"upper.toml\"" + expected + " and not based on itself");
  write("other.toml", "based_on = \"./upper.toml\"\n");
  EXPECT_EQ(refused("based_on = \"other.toml\"\n"),
            in("other.toml") + ":1: based_on = \"./upper.toml\"" + expected + " and not based on itself");
}

TEST_F(Layers, FilesAreNamedRelativeToTheFileThatNamesThem) {
  write("below/region.toml", "inside = \"distance > 0.1\"\n");
  write("below/pair.toml",
        pair_text +
            "[[couple]]\npotential = { region = { file = \"region.toml\" } }\nbetween = [\"a\", \"b\"]\n");
  write("below/upper/middle.toml", "based_on = \"../pair.toml\"\n");
  const Scenario s = read_scenario(write("here/top.toml", "based_on = \"../below/upper/middle.toml\"\n"));
  EXPECT_EQ(s.team.couplings().size(), 2u);
  ASSERT_EQ(s.files.size(), 1u);
  EXPECT_EQ(s.files.begin()->first, "../below/region.toml");
  EXPECT_EQ(parse_scenario(s.text, "elsewhere.toml", built_in_registry(), {.files = s.files}).text, s.text);
}

TEST_F(Layers, ACampaignDrawsNumbersOfAllLayers) {
  const Scenario s = read(
      "[campaign]\n[[campaign.draw]]\nkey = \"couple[0].weight\"\nuniform = [0.1, 0.2]\n[[campaign.draw]]\n"
      "key = \"simulation.disturbance.input_delay\"\nuniform = [0.0, 0.1]\n",
      {"simulation.disturbance.input_delay=0.0"});
  ASSERT_TRUE(s.campaign);
  EXPECT_EQ(s.campaign->draws.size(), 2u);
  const Scenario wrong =
      read("[campaign]\n[[campaign.draw]]\nkey = \"couple[0].wieght\"\nuniform = [0.1, 0.2]\n");
  ASSERT_TRUE(wrong.campaign_refusal);
  EXPECT_EQ(std::string(wrong.campaign_refusal->what()).find(in("upper.toml") + ":4:"), 0u);
}

}  // namespace
}  // namespace sightline
