#include "sightline/campaign/result_file.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "sightline/campaign/table.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

namespace fs = std::filesystem;

/// A table of runs of which every fourth is lost.
CampaignTable cited_table(const fs::path& folder, const std::string& name, double energy) {
  Scenario scenario;
  scenario.name = name;
  scenario.text = "a text";
  scenario.team.add(Multirotor{}, {.name = "uav0"});
  const CampaignPlan plan;
  RunTable table(folder / (name + ".sqlite"), scenario, plan, 3);
  for (int i = 0; i < 40; ++i) {
    RunResult result;
    result.outcome = i % 4 == 0 ? Outcome::lost : Outcome::recovered;
    result.energy = energy * (1.0 + i);
    result.robots = {{.energy = result.energy, .rms_heading_error = 0.25}};
    table.add({.index = i, .seed = 7, .values = {}}, result);
  }
  table.finish();
  return {name, folder / (name + ".sqlite")};
}

TEST(ResultFile, SaysWhatAPaperCites) {
  const fs::path folder = test::fresh_folder();
  const Machine one{"a", "Linux", "one", 2};
  const auto json = nlohmann::json::parse(
      campaign_json({cited_table(folder, "mine", 1.0), cited_table(folder, "other", 0.5)}, {one}));
  EXPECT_EQ(json["scenario"], "mine");
  EXPECT_EQ(json["runs"], 40);
  EXPECT_EQ(json["seed"], 3);
  EXPECT_EQ(json["machines"][0]["processor"], "one");
  EXPECT_EQ(json["digest"].get<std::string>().size(), 16u);
  EXPECT_EQ(json["outcomes"]["recovered"]["runs"], 30);
  EXPECT_NEAR(json["outcomes"]["recovered"]["low"], 0.5981, 1e-4);
  EXPECT_EQ(json["outcomes"]["failed"]["runs"], 0);
  EXPECT_EQ(json["medians"]["energy"]["median"], 20.5);
  EXPECT_EQ(json["medians"]["uav0.energy"]["runs"], 40);
  EXPECT_EQ(json["medians"]["uav0.rms_heading_error"]["median"], 0.25);
  EXPECT_TRUE(json["medians"]["uav0.rms_position_error"].is_null()) << "no run has one";
  const auto& paired = json["beside"][0]["paired"];
  EXPECT_EQ(paired["with"], "mine");
  EXPECT_EQ(paired["mcnemar_p"], 1.0);
  EXPECT_EQ(paired["energy"]["less"], 30);
  EXPECT_EQ(paired["energy"]["ratio"]["median"], 0.5);
}

TEST(ResultFile, AMachineIsNotedOnceAndThoseOfAllFoldersAreTold) {
  const fs::path folder = test::fresh_folder();
  fs::create_directories(folder / "one");
  fs::create_directories(folder / "two");
  const Machine a{"a", "Linux", "x", 2}, b{"b", "Linux", "y", 8};
  note_machine(folder / "one", a);
  note_machine(folder / "one", b);
  note_machine(folder / "one", a);
  note_machine(folder / "two", b);
  EXPECT_EQ(machines_of({folder / "one", folder / "two", folder / "none"}), (std::vector{a, b}));
  EXPECT_GT(this_machine().cores, 0);
  EXPECT_FALSE(this_machine().name.empty());
  std::ofstream(folder / "two" / "machines.json") << "[{\"name\": 3}]";
  EXPECT_NE(refusal_of([&] { (void)machines_of({folder / "two"}); }).find("holds no list of machines"),
            std::string::npos);
}

}  // namespace
}  // namespace sightline
