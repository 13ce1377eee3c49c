#include "sightline/scenario/file_kind.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>
#include <zstd.h>

#include <fstream>

#include "sightline/scenario.hpp"
#include "tests/support/command.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using namespace std::string_literals;
using testing::HasSubstr;

struct Recognised {
  std::string what, head;
};

const std::vector<Recognised>& kinds() {
  static const std::vector<Recognised> all = {
      {"a PX4 ULog", "ULog\x01\x12\x35\x01\0\0"s},
      {"a dataflash log of ArduPilot", "\xa3\x95\x80\x80"s},
      {"a bag of ROS 1", "#ROSBAG V2.0\n"},
      {"an MCAP recording, as of rosbag2", "\x89MCAP0\r\n\x01\0\0\0\0\0\0\0\0ros2libmcap 0.8.0"s},
      {"the log of a run", "\x89MCAP0\r\n\x01\0\0\0\0\0\0\0\0ros2sightline 0.1"s},
      {"an SQLite database, as a rosbag2 .db3 or the table of a campaign", "SQLite format 3\0"s},
      {"a crazyflies.yaml of Crazyswarm2",
       "# named list of all robots\nfileversion: 3\nrobots:\n  cf231:\n    enabled: true\n    uri: "
       "radio://0/80/2M/E7E7E7E7E7\n    initial_position: [0.0, 0.0, 0.0]\n    type: cf21\n"},
      {"the calibration of a camera (YAML)",
       "image_width: 640\nimage_height: 480\ncamera_name: front\ncamera_matrix:\n  rows: 3\n  cols: 3\n"},
      {"the calibration of a camera (YAML)",
       "cam0:\n  cam_overlaps: []\n  camera_model: pinhole\n  distortion_coeffs: [0.1, 0.2, 0.0, 0.0]\n"},
      {"the tags of apriltag_ros (YAML)", "standalone_tags:\n  [\n    {id: 0, size: 0.1},\n  ]\n"},
      {"the metadata of a rosbag2 (YAML)", "rosbag2_bagfile_information:\n  version: 5\n"},
      {"YAML", "---\na: 1\n"},
      {"YAML", "world: \"lab\"\n"},
      {"a table of values (CSV)", "t,x,y,z\n0.0,0,0,1\n0.1,0,0,1\n"},
      {"a table of values (CSV)", "# path\n0.0;0;0;1\r\n0.1;0;0;1\r\n"},
      {"a table of values (CSV)", "0.0\t1\n0.1\t2\n"},
      {"JSON", "{\"a\": 1}"},
      {"an MJCF", "<!-- of a lab -->\n<mujoco model=\"lab\">\n"},
      {"an SDF", "<?xml version=\"1.0\"?>\n<sdf version=\"1.9\">\n"},
      {"a URDF", "<?xml version=\"1.0\"?>\n<robot name=\"cf2\">\n"},
      {"XML", "<rss>\n"},
      {"a zip archive", "PK\x03\x04"s},
      {"a program (ELF)", "\x7f\x45LF\x02"s}};
  return all;
}

TEST(FileKind, EachIsRecognisedByItsFirstBytes) {
  for (const Recognised& one : kinds()) EXPECT_EQ(file_kind(one.head).what, one.what) << one.head;
  for (const std::string& none : {""s, "# only a comment\n"s, "\0\1\2"s, "hello world\n"s})
    EXPECT_EQ(file_kind(none).what, "") << none;
}

// In one place, so that each command that reads a scenario says it.
TEST(FileKind, AScenarioThatIsAnotherKindOfFileIsRefusedWithWhatItIsAndWhatIsExpected) {
  const std::filesystem::path folder = test::fresh_folder();
  for (const Recognised& one : kinds()) {
    const std::filesystem::path file = folder / "f";
    std::ofstream(file, std::ios::binary) << one.head;
    const std::string said = refusal_of<ScenarioError>([&] { (void)read_scenario(file); });
    EXPECT_THAT(said,
                testing::StartsWith(file.native() + ":1: this is " + one.what + ", expected a scenario"));
    EXPECT_EQ(said.find('\n'), std::string::npos);
  }
}

TEST(FileKind, ALogIsRecognisedHoweverLongItIs) {
  const std::filesystem::path file = test::fresh_folder() / "long.ulg";
  std::ofstream(file, std::ios::binary) << "ULog\x01\x12\x35"s + std::string(scenario_size_max + 1, '\x01');
  EXPECT_THAT(refusal_of<ScenarioError>([&] { (void)read_scenario(file); }), HasSubstr("this is a PX4 ULog"));
}

TEST(FileKind, WhatIsPackedIsNamed) {
  const std::filesystem::path folder = test::fresh_folder();
  // Of bytes that do not compress: the first block is longer than the head of the file.
  std::string log = "ULog\x01\x12\x35"s;
  for (std::uint32_t i = 1; log.size() < 200'000; i = i * 1664525U + 1013904223U)
    log.push_back(static_cast<char>(i >> 24));
  std::string packed(ZSTD_compressBound(log.size()), '\0');
  packed.resize(ZSTD_compress(packed.data(), packed.size(), log.data(), log.size(), 3));
  std::ofstream(folder / "a.zst", std::ios::binary) << packed;
  std::ofstream(folder / "b.zst", std::ios::binary) << packed.substr(0, 9);
  const auto pack = [&](const char* name, const std::string& text) {
    const gzFile to = gzopen((folder / name).c_str(), "wb");
    gzwrite(to, text.data(), static_cast<unsigned>(text.size()));
    gzclose(to);
  };
  pack("a.gz", log);
  pack("b.gz", "[agent.uav0]\n");
  EXPECT_EQ(kind_at(folder / "a.zst").shown(), "a PX4 ULog, packed by zstd");
  EXPECT_EQ(kind_at(folder / "b.zst").shown(), "a zstd archive");
  EXPECT_EQ(kind_at(folder / "a.gz").shown(), "a PX4 ULog, packed by gzip");
  EXPECT_EQ(kind_at(folder / "b.gz").shown(), "a gzip archive");
  EXPECT_THAT(refusal_of<ScenarioError>([&] { (void)read_scenario(folder / "a.zst"); }),
              HasSubstr(":1: this is a PX4 ULog, packed by zstd, expected a scenario file"));
}

TEST(FileKind, FoldersOfRecordingsAreNamed) {
  const std::filesystem::path folder = test::fresh_folder();
  EXPECT_EQ(kind_at(folder).what, "");
  std::ofstream(folder / "metadata.yaml") << "rosbag2_bagfile_information:\n";
  EXPECT_EQ(kind_at(folder).what, "the folder of a rosbag2");
  EXPECT_THAT(refusal_of<ScenarioError>([&] { (void)read_scenario(folder); }),
              HasSubstr(":1: this is the folder of a rosbag2, expected a scenario file"));
  EXPECT_EQ(refusal_of([&] { (void)log_of(folder); }),
            folder.native() + ": this is the folder of a rosbag2, expected the folder of a run");
  std::ofstream(folder / "run.mcap") << "x";
  EXPECT_EQ(kind_at(folder).what, "the folder of a run");
}

TEST(FileKind, AScenarioIsNoOther) {
  for (const auto& entry : std::filesystem::recursive_directory_iterator(SIGHTLINE_SOURCE_DIR "/scenarios"))
    EXPECT_EQ(file_kind(test::read_file(entry.path()).substr(0, file_head)).what, "") << entry.path();
}

TEST(FileKind, AFileInPlaceOfTheFolderOfARunSaysWhatItIs) {
  const std::filesystem::path folder = test::fresh_folder(), file = folder / "flight.ulg";
  std::ofstream(file, std::ios::binary) << "ULog\x01\x12\x35";
  const auto refusal = [](const std::filesystem::path& of) { return refusal_of([&] { (void)log_of(of); }); };
  EXPECT_EQ(refusal(file), file.native() + ": this is a PX4 ULog, expected the folder of a run");
  EXPECT_EQ(refusal(folder), folder.native() + ": no run.mcap, expected the folder of a run");
  std::ofstream(folder / "run.mcap") << "x";
  EXPECT_EQ(log_of(folder), folder / "run.mcap");
}

}  // namespace
}  // namespace sightline
