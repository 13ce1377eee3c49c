// The scenarios of scenarios/rotors/, each flown by the command line.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "tests/support/command.hpp"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::fresh_folder;
using test::read_file;
using test::sightline;
using testing::HasSubstr;

struct RotorFlight {
  std::string name;
  double seconds;
  double nearest, farthest;  // each observer to its target, after settle [m]
  int views;
};

/// Flies it, replays it, and gives its summary.
json flown(const RotorFlight& flight, const std::string& more = "") {
  const fs::path folder = fresh_folder();
  const auto run = sightline(fmt::format("run scenarios/rotors/{}.toml --set simulation.duration={}{} -o {}",
                                         flight.name, flight.seconds, more, folder.string()),
                             folder);
  EXPECT_EQ(run.code, 0) << flight.name << run.err;
  const auto replay = sightline("replay " + folder.string(), folder);
  EXPECT_EQ(replay.code, 0) << replay.err;
  EXPECT_THAT(replay.out, HasSubstr(" 0 differ"));
  return json::parse(read_file(folder / "summary.json"));
}

TEST(RotorScenarios, EachKeepsItsViewsAndDistances) {
  for (const RotorFlight& flight : {RotorFlight{"cooperative_localization", 20, 1.0, 2.0, 1},
                                    {"paper_7_2", 20, 1.0, 2.0, 1},
                                    {"paper_7_3_ours", 40, 1.0, 2.0, 1},
                                    {"ground_and_air", 20, 1.0, 2.0, 2},
                                    {"localize", 20, 1.0, 2.0, 1}}) {
    const json s = flown(flight);
    EXPECT_EQ(s.at("applied_violations"), 0) << flight.name;
    EXPECT_EQ(s.at("allocations_per_update"), 0) << flight.name;
    EXPECT_EQ(s.at("pairs").size(), flight.views) << flight.name;
    for (const json& pair : s.at("pairs")) {
      EXPECT_EQ(pair.at("in_view_fraction"), 1.0) << flight.name;
      EXPECT_GE(pair.at("distance").at("min"), flight.nearest) << flight.name;
      EXPECT_LE(pair.at("distance").at("max"), flight.farthest) << flight.name;
    }
    int vehicles = 0;
    for (const json& agent : s.at("agents")) vehicles += agent.contains("tilt_max") ? 1 : 0;
    EXPECT_GE(vehicles, 1) << flight.name;
  }
}

TEST(RotorScenarios, ARoverWhoseWheelsSlipMoreIsKeptInView) {
  const json s = flown({"ground_and_air", 15, 0, 0, 2}, " --set simulation.disturbance.slip=0.4");
  for (const json& pair : s.at("pairs")) EXPECT_EQ(pair.at("in_view_fraction"), 1.0);
}

TEST(RotorScenarios, ALowerVehiclePassesBesideTheDownwashOnlyByItsCoupling) {
  const auto broken = [](const std::string& weight) {
    const json s = flown({"downwash", 6, 0, 0, 0}, " --set couple[0].weight=" + weight);
    return s.at("limits").at(0).at("fraction").get<double>();
  };
  EXPECT_EQ(broken("1.0"), 0.0);
  EXPECT_GT(broken("0.0"), 0.0);
}

TEST(RotorScenarios, ASwarmOfVehiclesMeetsInTheMiddleAndKeepsApart) {
  const json s = flown({"swarm32", 15, 0, 0, 0});
  EXPECT_GE(s.at("min_distance").get<double>(), 0.9);
  EXPECT_EQ(s.at("agents").size(), 32u);
  for (const json& agent : s.at("agents")) EXPECT_GT(agent.at("tilt_max"), 0.0);
}

}  // namespace
}  // namespace sightline
