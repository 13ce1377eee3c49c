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
  struct Kind {
    std::string file, what;
    // The refusal by the reader of the kind names what is missing.
    bool import = false, identify = false;
  };
  const std::vector<Kind> kinds = {
      {write("flight.ulg", "ULog\x01\x12\x35\x01"), "a PX4 ULog", false, true},
      {write("bag.mcap", "\x89MCAP0\r\n\x01"), "an MCAP recording, as of rosbag2", true, true},
      {write("old.bag", "#ROSBAG V2.0\n"), "a bag of ROS 1"},
      {write("bag.db3", std::string_view("SQLite format 3\0", 16)),
       "an SQLite database, as a rosbag2 .db3 or the table of a campaign"},
      {write("a.bin", "\xa3\x95\x80\x80"), "a dataflash log of ArduPilot"},
      {write("a.h5", "\x89HDF\r\n\x1a\n"), "an HDF5 file"},
      {write("a.zip", "PK\x03\x04"), "a zip archive"},
      {write("a.xz", "\xfd\x37zXZ"), "an xz archive"},
      {write("a.pdf", "%PDF-1.7\n"), "a PDF"},
      {write("a.png", "\x89PNG\r\n"), "a PNG picture"},
      {write("a.jpg", "\xff\xd8\xff\xe0"), "a JPEG picture"},
      {write("a.elf", "\x7f\x45LF\x02"), "a program (ELF)"},
      {write("plan.waypoints", "QGC WPL 110\n"), "a list of waypoints of QGroundControl"},
      {write("a.json", "{\"a\": 1}\n"), "JSON"},
      {write("page.xml", "<rss/>\n"), "XML", true},
      {write("model.sdf", "<?xml version='1.0'?>\n<sdf version='1.9'/>\n"), "an SDF", true},
      {write("a.urdf", "<robot name='a'/>\n"), "a URDF", true},
      {write("a.xml", "<mujoco/>\n"), "an MJCF", true},
      {write("any.yaml", "a: 1\n"), "YAML"},
      {write("metadata.yaml", "rosbag2_bagfile_information:\n  version: 5\n"),
       "the metadata of a rosbag2 (YAML)"},
      {write("tags.yaml", "standalone_tags:\n  - {id: 1}\n"), "the tags of apriltag_ros (YAML)", true},
      {write("crazyflies.yaml", "robots:\n  cf1:\n    initial_position: [0, 0, 0]\n"),
       "a crazyflies.yaml of Crazyswarm2", true},
      {write("camera.yaml", "image_width: 640\ncamera_matrix:\n  rows: 3\n"),
       "the calibration of a camera (YAML)", true},
      {write("path.csv", "t,x,y,z\n0,0,0,1\n"), "a table of values (CSV)", false, true}};
  for (const auto& [file, what, import, identify] : kinds) {
    const auto refused = [&, &file = file](const std::string& command) {
      return test::refused(command + " " + file, folder);
    };
    const std::string named = file + ":1: this is " + what + ", expected ";
    for (const char* command :
         {"check", "run", "view", "explain", "campaign", "tune --for view_angle", "potential"})
      EXPECT_THAT(refused(command), testing::StartsWith(named + "a scenario file")) << command;
    for (const char* command : {"replay", "report"})
      EXPECT_EQ(refused(command), file + ": this is " + what + ", expected the folder of a run\n");
    EXPECT_THAT(refused("localize"),
                testing::StartsWith(file + ": this is " + what + ", expected a folder of MRCLAM"));
    EXPECT_THAT(refused("identify"), testing::StartsWith(identify ? file + ": " : named + "a scenario file"));
    EXPECT_THAT(refused("import"), testing::StartsWith(import ? file + ":" : named + "a crazyflies.yaml"));
  }
  // Those that a reader knows lack what it needs.
  const auto lack = [&](const std::string& command, const char* name) {
    const std::string file = (folder / name).string(), sentence = test::refused(command + " " + file, folder);
    return sentence.substr(std::min(file.size() + 1, sentence.size()));
  };
  EXPECT_THAT(lack("identify", "flight.ulg"), testing::StartsWith(" no set-points of velocity"));
  EXPECT_EQ(lack("identify", "bag.mcap"), " --body is missing, expected a bag with one\n");
  EXPECT_THAT(lack("identify", "path.csv"),
              testing::StartsWith(" no column \"heading\", expected the columns t, x, y, z, "));
  EXPECT_THAT(lack("import", "bag.mcap"), testing::StartsWith(" no sensor_msgs/CameraInfo, expected a bag"));
  EXPECT_THAT(lack("import", "page.xml"),
              testing::StartsWith("1: <rss> = another kind of XML, expected SDF, "));
  EXPECT_THAT(lack("import", "a.urdf"),
              testing::StartsWith("1: <robot> = its links, expected 1 to 256 links"));
  EXPECT_THAT(lack("import", "tags.yaml"), testing::StartsWith("2: standalone_tags[0].size is missing"));
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
