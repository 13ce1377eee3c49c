#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "sightline/log.hpp"
#include "tests/support/command.hpp"
#include "tests/support/recorded_rig.hpp"
#include "tests/support/recorded_team.hpp"
#include "tests/support/rig_bag.hpp"
#include "tests/support/shared_data.hpp"

namespace sightline::test {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
namespace fs = std::filesystem;

fs::path recording_in(const fs::path& folder, double seconds = 30.0) {
  fs::path place = folder / "recording";
  write_mrclam(recorded({.seconds = seconds, .noise = noise_of_recordings(), .seed = 3, .start = 1000.0}),
               place);
  return place;
}

TEST(LocalizeCommand, WritesSummaryReportAndLog) {
  const fs::path folder = fresh_folder(), out = folder / "out";
  const auto done = sightline("localize " + recording_in(folder).string() + " -o " + out.string(), folder);
  EXPECT_EQ(done.code, 0) << done.err;
  EXPECT_THAT(done.out, HasSubstr("MRCLAM, 3 robots, 8 landmarks"));
  const json summary = json::parse(read_file(out / "summary.json"));
  EXPECT_LE(summary.at("rmse").get<double>(), 0.2);
  ASSERT_EQ(summary.at("robots").size(), 3U);
  for (const json& robot : summary.at("robots")) {
    EXPECT_LT(robot.at("anees_bounds").at(0).get<double>(), 3.0);
    EXPECT_GT(robot.at("anees_bounds").at(1).get<double>(), 3.0);
    EXPECT_GT(robot.at("sightings").at("accepted").get<int>(), 0);
  }
  EXPECT_THAT(summary.at("command").get<std::string>(), HasSubstr("localize "));
  EXPECT_GT(summary.at("times_real_time").get<double>(), 1.0);
  EXPECT_THAT(read_file(out / "report.html"), HasSubstr("application/json"));
  McapReader log(out / "localize.mcap");
  std::map<std::string, int> messages;
  EXPECT_TRUE(log.visit([&](const McapMessage& one) { ++messages[std::string(one.topic)]; })) << log.error();
  EXPECT_GE(messages["/robot1/estimate"], 290);
  EXPECT_GE(messages["/robot1/pose"], 290);
  EXPECT_EQ(messages["/robot1/innovation"],
            summary.at("robots").at(0).at("sightings").at("accepted").get<int>() +
                summary.at("robots").at(0).at("sightings").at("rejected").get<int>());
}

TEST(LocalizeCommand, EqualCommandsWriteEqualLogs) {
  const fs::path folder = fresh_folder(), place = recording_in(folder, 10.0);
  for (const char* out : {"a", "b"})
    ASSERT_EQ(sightline("localize " + place.string() + " -o " + (folder / out).string(), folder).code, 0);
  EXPECT_EQ(read_file(folder / "a/localize.mcap"), read_file(folder / "b/localize.mcap"));
}

TEST(LocalizeCommand, ChoosesWhatTheRobotsSee) {
  const fs::path folder = fresh_folder(), place = recording_in(folder);
  const auto summary = [&](const std::string& options) {
    const auto done =
        sightline("localize " + place.string() + " --json -o " + (folder / "out").string() + options, folder);
    EXPECT_EQ(done.code, 0) << done.err;
    return json::parse(done.out);
  };
  const json anchored = summary(" --landmarks none --anchor robot2");
  EXPECT_EQ(anchored.at("anchor"), "robot2");
  EXPECT_LE(anchored.at("robots").at(1).at("rmse").get<double>(), 0.05);
  EXPECT_EQ(summary(" --landmarks none --robots none").at("robots").at(0).at("sightings").at("accepted"), 0);
  EXPECT_FALSE(summary(" --no-identities").at("identities").get<bool>());
  EXPECT_EQ(summary(" --set bearing_noise=0.02").at("noise").at("bearing_noise"), 0.02);
}

TEST(LocalizeCommand, IdentifiedNoiseCanBeRead) {
  const fs::path folder = fresh_folder(), place = recording_in(folder, 12.0), out = folder / "out";
  const auto done = sightline("localize " + place.string() + " --identify-noise -o " + out.string(), folder);
  ASSERT_EQ(done.code, 0) << done.err;
  const json first = json::parse(read_file(out / "summary.json"));
  EXPECT_LT(first.at("identified").at("cost").get<double>(),
            first.at("identified").at("cost_before").get<double>());
  const auto again = sightline("localize " + place.string() + " --json --noise " +
                                   (out / "noise.toml").string() + " -o " + (folder / "again").string(),
                               folder);
  ASSERT_EQ(again.code, 0) << again.err;
  EXPECT_NEAR(json::parse(again.out).at("noise").at("range_error").get<double>(),
              first.at("noise").at("range_error").get<double>(), 1e-3);
}

TEST(LocalizeCommand, RefusesInOneSentence) {
  const fs::path folder = fresh_folder(), place = recording_in(folder, 2.0);
  const std::string at = place.string();
  const auto of = [&](const std::string& command) { return refused("localize " + command, folder); };
  EXPECT_THAT(
      of((folder / "none").string()),
      AllOf(HasSubstr("/none: not there, expected a folder of MRCLAM"), HasSubstr("PREFIX_tagslam.yaml")));
  EXPECT_THAT(of("scenarios/localize.toml"), HasSubstr("no recording of a known kind"));
  EXPECT_THAT(of(at + " --anchor robot9"),
              HasSubstr("--anchor = robot9, expected one of robot1, robot2, robot3"));
  EXPECT_THAT(of(at + " --landmarks robot1,robot"),
              HasSubstr("--landmarks = robot, expected all, none or some of"));
  EXPECT_THAT(of(at + " --start later"), HasSubstr("--start = later, expected known or unknown"));
  EXPECT_THAT(of(at + " --start unknown --no-identities"), HasSubstr("expected known poses at the start"));
  EXPECT_THAT(of(at + " --pixels raw"), HasSubstr("--pixels = raw, expected none"));
  EXPECT_THAT(of(at + " --set range_nois=1"), HasSubstr("range_noise"));
  EXPECT_THAT(of(at + " --set range_noise=-1"), HasSubstr("range_noise = -1"));
  EXPECT_THAT(of(at + " --noise " + (folder / "none.toml").string()), HasSubstr("none.toml"));
  std::ofstream(place / "Robot2_Odometry.dat", std::ios::app) << "1 2\n";
  EXPECT_THAT(of(at), HasSubstr("Robot2_Odometry.dat:"));
}

TEST(LocalizeCommand, KeepsItsAccuracyOnMrclam) {
  const fs::path folder = fresh_folder(), archive = of_data("mrclam/MRCLAM_Dataset6.tar.gz");
  if (archive.empty()) return;
  ASSERT_EQ(shell("tar xzf '" + archive.string() + "' -C '" + folder.string() + "'", folder).code, 0);
  const auto summary = [&](const std::string& options) {
    const auto done = sightline("localize " + (folder / "MRCLAM_Dataset6").string() + " --json -o " +
                                    (folder / "out").string() + options,
                                folder);
    EXPECT_EQ(done.code, 0) << done.err;
    return json::parse(done.out);
  };
  const json all = summary("");
  EXPECT_LE(all.at("rmse").get<double>(), 0.085);
  for (const json& robot : all.at("robots")) {
    EXPECT_GE(robot.at("anees").get<double>(), 1.5);
    EXPECT_LE(robot.at("anees").get<double>(), 5.0);
    // Barcodes in pictures: all ranges are depths.
    EXPECT_NEAR(robot.at("constants").at("range_depth").at("value").get<double>(), 1.0, 0.2);
  }
  EXPECT_LE(summary(" --no-identities").at("rmse").get<double>(), 1.3 * all.at("rmse").get<double>());
  for (int anchor = 1; anchor <= 5; ++anchor) {
    const json anchored = summary(fmt::format(" --landmarks none --anchor robot{}", anchor));
    EXPECT_LE(anchored.at("rmse_without_anchor").get<double>(), 0.16) << anchor;
    for (const json& robot : anchored.at("robots"))
      EXPECT_LE(robot.at("anees").get<double>(), 5.0) << anchor << robot.at("name");
  }
}

TEST(LocalizeCommand, KeepsItsAccuracyOnMurp) {
  const fs::path folder = fresh_folder(), place = of_data("murp");
  if (place.empty()) return;
  const auto done =
      sightline("localize " + place.string() + " --json -o " + (folder / "out").string(), folder);
  ASSERT_EQ(done.code, 0) << done.err;
  const json summary = json::parse(done.out);
  const json& relative = summary.at("relative");
  for (const std::size_t agent : {std::size_t{1}, std::size_t{2}}) {
    EXPECT_GE(summary.at("robots").at(agent).at("anees").get<double>(), 2.0);
    EXPECT_LE(summary.at("robots").at(agent).at("anees").get<double>(), 5.0);
  }
  EXPECT_LE(relative.at("position_mean_absolute").get<double>(), 0.25);
  EXPECT_LE(relative.at("heading_mean_absolute").get<double>(), 9.5 * 3.1416 / 180);
  // The first agent is the frame of the others and has no errors.
  const auto table = sightline("localize " + place.string() + " -o " + (folder / "out").string(), folder);
  EXPECT_THAT(table.out, AllOf(HasSubstr("agent1 "), Not(HasSubstr("nan"))));
}

TEST(LocalizeCommand, LocalizesACameraRig) {
  const fs::path folder = fresh_folder(), out = folder / "out";
  const SyntheticRig rig({.seconds = 5.0});
  write_rig(rig.recording, (folder / "walk_").string());
  const std::string at = "localize " + (folder / "walk").string() + " -o " + out.string();
  const auto done = sightline(at, folder);
  ASSERT_EQ(done.code, 0) << done.err;
  EXPECT_THAT(done.out, HasSubstr("camera rig rig, 2 cameras, 6 tags seen"));
  const json summary = json::parse(read_file(out / "summary.json"));
  EXPECT_LT(summary.at("rmse").get<double>(), 0.05);
  EXPECT_LT(summary.at("smoothed").at("rmse").get<double>(), 0.05);
  EXPECT_GT(summary.at("times_real_time").get<double>(), 1.0);
  EXPECT_THAT(read_file(out / "noise.toml"), HasSubstr("position_walk"));
  EXPECT_THAT(read_file(out / "report.html"), HasSubstr("application/json"));
  McapReader log(out / "localize.mcap");
  std::map<std::string, int> messages;
  EXPECT_TRUE(log.visit([&](const McapMessage& one) { ++messages[std::string(one.topic)]; })) << log.error();
  for (const char* topic : {"/rig/estimate", "/rig_smoothed/estimate", "/rig/pose"})
    EXPECT_EQ(messages[topic], static_cast<int>(rig.recording.reference.size())) << topic;
  // The same sightings in a bag that has its cameras, too.
  for (const char* name : {"walk_tag_detections.csv", "walk_cameras.yaml", "walk_camera_poses.yaml"})
    fs::remove(folder / name);
  std::ofstream(folder / "walk.mcap", std::ios::binary) << bag_with_cameras(rig.recording, {}).bytes("lz4");
  const auto bag = sightline(
      "localize " + (folder / "walk.mcap").string() + " --pixels raw --json -o " + (folder / "bag").string(),
      folder);
  ASSERT_EQ(bag.code, 0) << bag.err;
  EXPECT_EQ(json::parse(bag.out).at("sightings"), summary.at("sightings"));
  EXPECT_NEAR(json::parse(bag.out).at("rmse").get<double>(), summary.at("rmse").get<double>(), 1e-3);
}

TEST(LocalizeCommand, FitsTheWalksOfARigUnlessTheyAreGiven) {
  const fs::path folder = fresh_folder(), place = folder / "walk", out = folder / "out";
  write_rig(SyntheticRig({.seconds = 3.0}).recording, place.string() + "_");
  const auto summary = [&](const std::string& options) {
    const auto done =
        sightline("localize " + place.string() + " --json -o " + out.string() + options, folder);
    EXPECT_EQ(done.code, 0) << done.err;
    return json::parse(done.out);
  };
  const json corners = summary(" --set corner_noise=2");
  EXPECT_TRUE(corners.at("identified").get<bool>());
  EXPECT_EQ(corners.at("noise").at("corner_noise"), 2.0);
  EXPECT_NE(corners.at("noise").at("position_walk"), RigNoise{}.position_walk);
  const json walk = summary(" --set position_walk=0.03 --set corner_noise=2");
  EXPECT_FALSE(walk.at("identified").get<bool>());
  EXPECT_EQ(walk.at("noise").at("position_walk"), 0.03);
  EXPECT_EQ(walk.at("noise").at("rotation_walk"), RigNoise{}.rotation_walk);
  EXPECT_FALSE(summary(" --noise " + (out / "noise.toml").string()).at("identified").get<bool>());
}

TEST(LocalizeCommand, RefusesARigBeforeItMakesAFolder) {
  const fs::path folder = fresh_folder(), place = folder / "walk", out = folder / "out";
  RigRecording recording = SyntheticRig({.seconds = 1.0}).recording;
  write_rig(recording, place.string() + "_");
  const auto of = [&](const std::string& options) {
    return refused("localize " + place.string() + " -o " + out.string() + options, folder);
  };
  for (const char* option :
       {"--anchor robot1", "--landmarks none", "--robots none", "--start unknown", "--seed 2"}) {
    const std::string words = option, name = words.substr(0, words.find(' '));
    EXPECT_THAT(of(" " + words), HasSubstr(name + " = " + words.substr(name.size() + 1) + ", expected none"));
  }
  for (const char* option : {"--no-identities", "--identify-noise"})
    EXPECT_THAT(of(fmt::format(" {}", option)), HasSubstr(fmt::format("{} = given, expected none", option)));
  // No tag with a known pose is seen.
  std::erase_if(recording.sightings,
                [&](const RigRecording::Sighting& z) { return recording.tags[z.tag].known; });
  write_rig(recording, place.string() + "_");
  EXPECT_THAT(of(""), HasSubstr(place.string() + ": no view of a tag with a known pose"));
  EXPECT_FALSE(fs::exists(out));
}

TEST(LocalizeCommand, RefusesATeamBeforeItMakesAFolder) {
  const fs::path folder = fresh_folder(), place = recording_in(folder, 2.0), out = folder / "out";
  std::ofstream(place / "Robot2_Groundtruth.dat") << "";
  EXPECT_THAT(refused("localize " + place.string() + " -o " + out.string(), folder),
              HasSubstr(place.string() + ": the pose of robot2 at the start is unknown"));
  EXPECT_FALSE(fs::exists(out));
}

}  // namespace
}  // namespace sightline::test
