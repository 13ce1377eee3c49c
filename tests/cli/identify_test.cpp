#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>

#include "sightline/vehicle.hpp"
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

/// Two vehicles, the upper one to and fro above the other, which the air pushes; their tables.
/// @param rate  of its way to and fro [rad/s]
std::string crossing_tables(const fs::path& folder, double rate = 1.0) {
  fs::create_directories(folder);
  std::ofstream lower(folder / "lower.csv"), upper(folder / "upper.csv");
  constexpr std::string_view names = "t,x,y,z,vx,vy,vz,az,qx,qy,qz,qw,pwm1\n";
  lower << names, upper << names;
  const Vehicle vehicle = Vehicle::crazyflie();
  for (int k = 0; k < 1500; ++k) {
    const double t = 0.01 * k, x = 0.4 * std::sin(rate * t), v = 0.4 * rate * std::cos(rate * t);
    const Jet jet{.p = {x, 0, 0.9},
                  .thrust = vehicle.weight(),
                  .radius2 = 4 * square(vehicle.rotor_radius),
                  .v = {v, 0, 0}};
    const double push = 0.9 * vehicle.drag.z / vehicle.mass * jet.air({0, 0, 0.5}).z;
    lower << fmt::format("{},0,0,0.5,0,0,0,{},0,0,0,1,0.7\n", t, gravity + push + 0.01 * std::sin(40 * t));
    upper << fmt::format("{},{},0,0.9,{},0,0,{},0,0,0,1,0.7\n", t, x, v, gravity);
  }
  return (folder / "lower.csv").string() + "," + (folder / "upper.csv").string();
}

TEST(IdentifyCommand, FitsTheDownwashOfVehiclesAboveOneAnother) {
  const fs::path folder = fresh_folder();
  const std::string flight = crossing_tables(folder), second = crossing_tables(folder / "second", 0.9),
                    third = crossing_tables(folder / "third", 1.2);
  std::ofstream(folder / "small.toml") << "preset = \"crazyflie\"\n";
  const std::string vehicles = " --vehicle crazyflie," + (folder / "small.toml").string(),
                    out = " -o " + (folder / "out").string();
  const auto done = sightline("identify " + flight + vehicles + out, folder);
  EXPECT_EQ(done.code, 0) << done.err;
  EXPECT_THAT(done.out, HasSubstr("[world]\nkind = \"rotors\"\ndownwash = 0.9"));
  const json alone = json::parse(read_file(folder / "out/identify.json"));
  EXPECT_NEAR(alone.at("downwash").get<double>(), 0.9, 0.01);
  const auto judged = sightline(
      "identify " + flight + vehicles + out + " --json --flight " + second + " --held-out " + third, folder);
  EXPECT_EQ(judged.code, 0) << judged.err;
  EXPECT_EQ(json::parse(judged.out).at("judged_on"), "held-out flights");

  EXPECT_THAT(test::refused("identify " + flight, folder), HasSubstr("--vehicle is missing"));
  for (const std::string option : {"--agent uav0", "--set duration=3", "--excitation steps", "--seconds 20",
                                   "--height 2", "--radius 3", "--seed 1", "--body cf1", "--commands /cmd"})
    EXPECT_THAT(test::refused("identify " + flight + vehicles + " " + option, folder),
                HasSubstr(option.substr(0, option.find(' ')) +
                          " of recordings of a flight (FILE,FILE), expected only for"));
  const std::string same = (folder / "second/../lower.csv").string() + "," + (folder / "upper.csv").string();
  for (const std::string option : {"--flight ", "--held-out "})
    EXPECT_THAT(
        test::refused("identify " + flight + vehicles + " " + option + same, folder),
        AllOf(HasSubstr(option + "= " + same), HasSubstr("second/../lower.csv was given before, expected")));
  EXPECT_THAT(test::refused("identify " + flight + vehicles + " --flight " + second + " --held-out " + second,
                            folder),
              HasSubstr("--held-out = "));
  EXPECT_THAT(test::refused("identify " + scenario(folder).string() + vehicles, folder),
              HasSubstr("--vehicle of a scenario, expected only for recordings of a flight (FILE,FILE)"));
  EXPECT_THAT(test::refused("identify " + scenario(folder).string() + " --body cf1", folder),
              HasSubstr("--body of a scenario, expected only for a recording"));
  std::ofstream(folder / "small.toml") << "mas = 1.0\n";
  EXPECT_THAT(test::refused("identify " + flight + vehicles, folder),
              HasSubstr("small.toml:1: mas = 1, expected a known key, the nearest is \"mass\""));
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
  EXPECT_THAT(test::refused("identify " + out.string() + " --agent uav0 --seconds 9", folder),
              HasSubstr("--seconds of a run, expected only for a scenario"));
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
              HasSubstr("--set of a recording, expected only for a scenario, a run"));
  EXPECT_THAT(test::refused("identify " + log.string() + " --seed 3", folder),
              HasSubstr("--seed of a recording, expected only for a scenario"));
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
