#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>

#include "tests/support/command.hpp"
#include "tests/support/lagging_flight.hpp"
#include "tests/support/ros_bag.hpp"

namespace sightline::test {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
namespace fs = std::filesystem;

/// cooperative_localization in the world of vehicles, for so long.
fs::path scenario(const fs::path& folder, const std::string& seconds = "12.0") {
  std::string text = read_file(fs::path(SIGHTLINE_SOURCE_DIR) / "scenarios/cooperative_localization.toml");
  text = std::regex_replace(text, std::regex("\nduration = 60.0"), "\nduration = " + seconds);
  text = std::regex_replace(text, std::regex("\ncompare = [^\n]*"), "");
  const fs::path file = folder / "rotors.toml";
  std::ofstream(file) << text << "\n[world]\nkind = \"rotors\"\n";
  return file;
}

TEST(IdentifyCommand, FliesAnExcitationAndPrintsATemplate) {
  const fs::path folder = fresh_folder();
  const auto done = sightline(
      "identify " + scenario(folder).string() + " --agent uav0 -o " + (folder / "out").string(), folder);
  EXPECT_EQ(done.code, 0) << done.err;
  EXPECT_THAT(done.out, HasSubstr("\n[template.uav0]\nrobot = \"hover_multirotor\"\nparameters = { b_z = "));
  EXPECT_THAT(done.out, HasSubstr("\ncommand_delay = 0.1"));
  const json reported = json::parse(read_file(folder / "out/identify.json"));
  EXPECT_EQ(reported.at("best").at("structure"), "(24) + delay + Coriolis + lags");
  EXPECT_THAT(read_file(folder / "out/identify.html"), HasSubstr("application/json"));
}

TEST(IdentifyCommand, ReadsTheLogOfARun) {
  const fs::path folder = fresh_folder(), out = folder / "out";
  ASSERT_NE(sightline("run " + scenario(folder).string() + " -o " + out.string(), folder).code, 2);
  const auto done = sightline("identify " + out.string() + " --agent uav0 --json", folder);
  EXPECT_EQ(done.code, 0) << done.err;
  const json reported = json::parse(done.out);
  EXPECT_EQ(reported.at("robot"), "uav0");
  EXPECT_NEAR(reported.at("seconds").get<double>(), 12.0, 0.02);
  EXPECT_FALSE(reported.at("missing").empty()) << "a task is no excitation";
  EXPECT_EQ(read_file(out / "identify.json"), done.out);
}

TEST(IdentifyCommand, ReadsALogOfPx4ABagAndATable) {
  const fs::path folder = fresh_folder(), log = folder / "lagging.ulg", table = folder / "lagging.csv";
  const LaggingFlight flight(20.0);
  std::ofstream(log, std::ios::binary) << ulog_of(flight, 5);
  std::ofstream rows(table);
  for (std::size_t k = 0; k < flight.rows.size(); k += 5) {
    const LaggingFlight::Row& r = flight.rows[k];
    rows << fmt::format("{},9,{},{},{},{},{},{},{},{},{},{},{}\n", r.t, r.p.x, r.p.y, r.p.z, r.psi, r.v.x,
                        r.v.y, r.v.z, r.u.x, r.u.y, r.u.z, r.u_psi);
  }
  rows.close();
  const fs::path bag = folder / "lagging.mcap";
  std::ofstream(bag, std::ios::binary) << bag_of(flight).bytes("");
  const std::string out = " --json -o " + (folder / "out").string();
  for (const std::string& from : {log.string(), bag.string() + " --body /pose --commands /cmd",
                                  table.string() + " --columns t,-,x,y,z,heading,vx,vy,vz,ux,uy,uz,ur"}) {
    const auto done = sightline("identify " + from + out, folder);
    ASSERT_EQ(done.code, 0) << done.err;
    const json reported = json::parse(done.out);
    EXPECT_EQ(reported.at("robot"), "lagging");
    EXPECT_NEAR(reported.at("best").at("numbers").at(0).at("value").get<double>(), LaggingFlight::tau, 0.02);
    EXPECT_GT(reported.at("error").at("r2").get<double>(), 0.99);
  }
  EXPECT_THAT(test::refused("identify " + log.string() + " --columns t", folder),
              HasSubstr("lagging.ulg: --columns of a recording that has names itself, expected none"));
  EXPECT_THAT(test::refused("identify " + log.string() + " --set duration=3", folder),
              HasSubstr("--set of a recording, expected a scenario"));
  fs::resize_file(log, 4000);
  std::ofstream(log, std::ios::binary | std::ios::app) << std::string(40, '\0');
  EXPECT_THAT(test::refused("identify " + log.string(), folder), HasSubstr("lagging.ulg: byte "));
}

TEST(IdentifyCommand, RefusesInOneSentence) {
  const fs::path folder = fresh_folder();
  const std::string rotors = scenario(folder, "3.0").string();
  const auto refused = [&](const std::string& command) {
    return test::refused("identify " + command, folder);
  };
  EXPECT_THAT(refused(rotors), HasSubstr("rotors.toml: --agent is missing, expected one of uav0, uav1"));
  EXPECT_THAT(refused(rotors + " --agent uav7"), HasSubstr("--agent = uav7, expected one of uav0, uav1"));
  EXPECT_THAT(refused(rotors + " --agent uav0 --excitation doublet"),
              HasSubstr("--excitation = doublet, expected one of steps, chirp, 3211, bang_bang"));
  EXPECT_THAT(refused(rotors + " --agent uav0 --seconds 2"), HasSubstr("--seconds = 2, expected 5 to 600 s"));
  EXPECT_THAT(refused("scenarios/ground_and_air.toml --agent rover"), HasSubstr("expected"));
  EXPECT_THAT(refused(folder.string() + " --agent uav0"),
              HasSubstr("no run.mcap, expected the folder of a run"));
  const std::string out = (folder / "out").string();
  ASSERT_NE(sightline("run " + rotors + " -o " + out, folder).code, 2);
  EXPECT_THAT(refused(out + " --agent uav0"),
              AllOf(HasSubstr("/out: uav0: 3"), HasSubstr(" s of flight, expected at least 5 s")));
}

}  // namespace
}  // namespace sightline::test
