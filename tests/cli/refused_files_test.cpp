// Files that are no scenarios, and names that are no files.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "tests/support/command.hpp"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using test::fresh_folder;

// Whatever command a log, a calibration or a table is given to.
TEST(RefusedFiles, AFileThatIsNoScenarioIsRefusedWithWhatItIs) {
  const fs::path folder = fresh_folder();
  const auto write = [&](const char* name, std::string_view text) {
    std::ofstream(folder / name, std::ios::binary) << text;
    return (folder / name).string();
  };
  const std::vector<std::pair<std::string, std::string>> files = {
      {write("flight.ulg", "ULog\x01\x12\x35\x01"), "a PX4 ULog"},
      {write("bag.mcap", "\x89MCAP0\r\n\x01"), "an MCAP recording, as of rosbag2"},
      {write("crazyflies.yaml", "robots:\n  cf1:\n    initial_position: [0, 0, 0]\n"),
       "a crazyflies.yaml of Crazyswarm2"},
      {write("camera.yaml", "image_width: 640\ncamera_matrix:\n  rows: 3\n"),
       "the calibration of a camera (YAML)"},
      {write("path.csv", "t,x,y,z\n0,0,0,1\n"), "a table of values (CSV)"}};
  for (const auto& [file, what] : files) {
    for (const char* command : {"check", "run", "view", "explain", "campaign", "potential"}) {
      EXPECT_THAT(test::refused(std::string(command) + " " + file, folder),
                  testing::StartsWith(file + ":1: this is " + what + ", expected a scenario file"));
    }
    for (const char* command : {"replay", "report"}) {
      EXPECT_EQ(test::refused(std::string(command) + " " + file, folder),
                file + ": this is " + what + ", expected the folder of a run\n");
    }
    EXPECT_THAT(test::refused("localize " + file, folder),
                testing::StartsWith(file + ": this is " + what + ", expected a folder of MRCLAM"));
  }
  // Those that identify reads lack what it needs.
  const auto identified = [&](std::size_t i) {
    const std::string sentence = test::refused("identify " + files[i].first, folder);
    EXPECT_THAT(sentence, testing::StartsWith(files[i].first + ":"));
    return sentence.substr(files[i].first.size() + 1);
  };
  EXPECT_THAT(identified(0), testing::StartsWith(" no set-points of velocity"));
  EXPECT_EQ(identified(1), " --body is missing, expected a bag with one\n");
  EXPECT_THAT(identified(2),
              testing::StartsWith("1: this is a crazyflies.yaml of Crazyswarm2, expected a scen"));
  EXPECT_THAT(identified(4),
              testing::StartsWith(" no column \"heading\", expected the columns t, x, y, z, "));
}

TEST(RefusedFiles, ALoopOfLinksIsRefusedByASentence) {
  const fs::path folder = fresh_folder();
  fs::create_symlink("b", folder / "a");
  fs::create_symlink("a", folder / "b");
  const std::string loop = (folder / "a").string(),
                    scenario = SIGHTLINE_SOURCE_DIR "/scenarios/paper_7_1.toml";
  const auto refused = [&](const std::string& arguments) {
    EXPECT_THAT(test::refused(arguments, folder),
                testing::AllOf(testing::HasSubstr(loop), testing::HasSubstr("expected"),
                               testing::Not(testing::HasSubstr("filesystem error"))))
        << arguments;
  };
  for (const char* command :
       {"check ", "run ", "view ", "identify ", "explain ", "campaign ", "potential ", "replay ", "report "})
    refused(command + loop);
  for (const char* command : {"run ", "campaign ", "identify --agent uav0 ", "potential "})
    refused(command + scenario + " -o " + loop);
  refused("view " + scenario + " --tune --port 0 --seconds 1 -o " + loop);
}

}  // namespace
}  // namespace sightline
