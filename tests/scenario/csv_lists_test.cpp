#include "sightline/scenario/csv_lists.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <zlib.h>

#include <fstream>
#include <random>

#include "sightline/log.hpp"
#include "sightline/readers/cdr.hpp"
#include "sightline/world.hpp"
#include "tests/support/campaign.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/lagging_flight.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/ros_bag.hpp"

namespace sightline {
namespace {

using Numbers = std::vector<double>;
using testing::HasSubstr;

std::string csv_refusal(const std::string& text, std::vector<std::string> names = {}) {
  try {
    (void)read_csv(text, "path.csv", std::move(names));
  } catch (const ScenarioError& error) {
    return error.what();
  }
  return "accepted";
}

/// The path that a scenario's table names, in a file with this text.
template <class Kind>
Kind path_in(const std::string& keys, const std::string& text) {
  TomlDocument document = parse_toml("file = \"path.csv\"\n" + keys, "folder/a.toml");
  document.from_disk = false;
  document.files["path.csv"] = text;
  Kind path = read_part<Kind>(ListSource(TomlTable(document)), parameter_keys<ListFile>());
  path.check();
  return path;
}

std::string path_refusal(const std::string& keys, const std::string& text) {
  try {
    (void)path_in<Waypoints>(keys, text);
  } catch (const std::exception& error) {
    return error.what();
  }
  return "accepted";
}

TEST(CsvLists, TheSameNumbersComeFromEachWayOfWritingThem) {
  const std::string rows = "0,1,2,3\n0.5,4,5,6\n";
  const std::vector<std::string> texts = {
      "t,x,y,z\n" + rows, "\xef\xbb\xbfTime, X, Y, Z\r\n0, 1, 2, 3\r\n0.5, 4, 5, 6\r\n",
      "# t x y z\n0 1 2 3\n\n# a remark\n0.5\t4  5 +6\n", "\"t\";\"x\";\"y\";\"z\"\n0;1;2;3\n0.5;4;5;6",
      "a title\nt,x,y,z\n0,1,2,3\n0.5,4,5,6\n"};
  for (const std::string& text : texts) {
    const CsvColumns columns = read_csv(text, "path.csv");
    ASSERT_EQ(columns.names, (std::vector<std::string>{"t", "x", "y", "z"})) << text;
    EXPECT_EQ(columns.values, (std::vector<Numbers>{{0, 0.5}, {1, 4}, {2, 5}, {3, 6}})) << text;
  }
  EXPECT_EQ(read_csv(rows, "path.csv", {"t", "-", "y", "z"}).values,
            (std::vector<Numbers>{{0, 0.5}, {}, {2, 5}, {3, 6}}));
}

TEST(CsvLists, EachFaultIsNamedWithItsLineAndItsValue) {
  EXPECT_EQ(csv_refusal("0,1,2,3\n"),
            "path.csv:1: no names of columns before the first row, expected a line such as t,x,y,z, or the "
            "key columns");
  EXPECT_EQ(csv_refusal("t,x\n0,1\n1,2,3\n"), "path.csv:3: 3 entries, expected 2, one for each column");
  EXPECT_EQ(csv_refusal("t,x\n0,1\n1,fast\n"), "path.csv:3: x = \"fast\", expected a number");
  EXPECT_EQ(csv_refusal("t,x\n0,1\n1,nan\n"), "path.csv:3: x = \"nan\", expected a number");
  EXPECT_EQ(csv_refusal("t,x\n0,1\n1,\n"), "path.csv:3: x = \"\", expected a number");
  EXPECT_EQ(csv_refusal("t,x,t\n0,1,2\n"), "path.csv:2: two columns are called \"t\", expected one");
  EXPECT_EQ(csv_refusal("t,x\n"), "path.csv:1: no row of numbers, expected at least one");
  EXPECT_EQ(csv_refusal(""), "path.csv: no row of numbers, expected at least one");
}

TEST(CsvLists, AFileGivesThePathOfItsLists) {
  const std::string text = "t,x,y,z,yaw,vx,vy,vz,battery\n0,1,2,3,0.5,1,0,0,9\n2,3,2,1,1.5,0,1,0,9\n";
  const auto path = path_in<Waypoints>("", text);
  const Waypoints same{
      .times = {0, 2}, .p = {{1, 2, 3}, {3, 2, 1}}, .heading = {0.5, 1.5}, .v = {{1, 0, 0}, {0, 1, 0}}};
  const auto steps = path_in<Steps>("", text);
  const auto motion = path_in<WaypointsMotion>("begin = 4.0", text);
  for (double t = -1; t < 4; t += 0.125) {
    EXPECT_EQ(norm(path(t).p - same(t).p), 0.0);
    EXPECT_EQ(path(t).d.x, same(t).d.x);
    EXPECT_EQ(norm(steps(t).p - same.p[t < 2 ? 0 : 1]), 0.0);
    EXPECT_EQ(norm(motion(t + 4).p - same(t).p), 0.0);
  }
  EXPECT_TRUE(motion.heading.empty());

  const auto timed = path_in<Waypoints>("columns = [\"x\", \"y\", \"z\", \"heading\"]\nperiod = 0.5",
                                        "16, 0, 3, 0\n15, 1, 3, 0.25\n14, 1, 3, 0.5\n");
  EXPECT_EQ(timed.times, (Numbers{0, 0.5, 1}));
  EXPECT_EQ(timed.heading, (Numbers{0, 0.25, 0.5}));
}

TEST(CsvLists, WhatAFileCannotGiveIsRefused) {
  const std::string text = "t,x,y,z\n0,1,2,3\n";
  EXPECT_EQ(path_refusal("times = [0.0]", text),
            "folder/a.toml:2: times = [0], expected no such key beside file, which gives it");
  EXPECT_EQ(path_refusal("period = 0.1", text),
            "folder/a.toml:2: period = 0.1, expected no such key beside a column t");
  EXPECT_EQ(path_refusal("", "t,x,y\n0,1,2\n"),
            "folder/path.csv:1: no column \"z\", expected the columns t, x, y, z");
  EXPECT_EQ(path_refusal("", "x,y,z\n0,1,2\n"),
            "folder/path.csv:1: no column \"t\", expected the columns t, x, y, z, or the key period");
  EXPECT_EQ(path_refusal("", "t,x,y,z\n1,0,0,0\n1,0,0,0\n"),
            "folder/path.csv:1: t = 1 in row 2 of numbers after 1, expected times that rise [s]");
  EXPECT_EQ(
      path_refusal("", "t,x,y,z\n1.7e9,0,0,0\n"),
      "folder/path.csv:1: t = 1700000000 s in the first row, expected at most 100000 s, or the key begin");
  EXPECT_EQ(path_refusal("speed = 1.0", text).substr(0, 27), "folder/a.toml:2: speed = 1,");
}

// The text that a log keeps stands for the recording.
TEST(CsvLists, AMotionIsTheSameFromARecordingAndFromTheTextThatALogKeeps) {
  const std::filesystem::path folder = test::fresh_folder();
  const test::LaggingFlight flight(6.0);
  std::ofstream(folder / "flight.ulg", std::ios::binary) << test::ulog_of(flight, 5);
  std::ofstream(folder / "flight.mcap", std::ios::binary) << test::bag_of(flight).bytes("lz4");
  const auto read = [&](const TomlDocument& document) {
    WaypointsMotion path =
        read_part<WaypointsMotion>(ListSource(TomlTable(document)), parameter_keys<ListFile>());
    path.check();
    return path;
  };
  for (const auto& [file, body] : {std::pair{"flight.ulg", "vehicle_local_position"},
                                   std::pair{"flight.mcap", "/odom"}, std::pair{"flight.mcap", "cf1"}}) {
    const std::string keys = fmt::format("file = \"{}\"\nbody = \"{}\"\n", file, body);
    const TomlDocument from_disk = parse_toml(keys, (folder / "a.toml").native());
    const WaypointsMotion path = read(from_disk);
    for (double t = 0; t < 5.9; t += 0.07) {
      const auto& row = flight.rows[static_cast<std::size_t>(std::lround(t / test::LaggingFlight::step))];
      EXPECT_LE(norm(path(t).p - row.p), 2e-3) << t;
    }
    for (std::size_t i = 1; i < path.times.size(); ++i) EXPECT_GT(path.times[i] - path.times[i - 1], 0.0199);

    TomlDocument kept = parse_toml(keys, "elsewhere/a.toml");
    kept.from_disk = false;
    kept.files = from_disk.files;
    EXPECT_EQ(read(kept).times, path.times);
    // A campaign writes the text beside the scenario.
    std::filesystem::rename(folder / file, folder / "away");
    for (const auto& [name, text] : from_disk.files) std::ofstream(folder / name) << text;
    EXPECT_EQ(read(parse_toml(keys, (folder / "a.toml").native())).times, path.times);
    std::filesystem::rename(folder / "away", folder / file);
  }
}

TEST(CsvLists, TheLogOfARunHasThePathsOfItsRobots) {
  const std::filesystem::path folder = test::fresh_folder();
  {
    McapWriter log(folder / "run.mcap", "ros2", "sightline 0.2.0");
    const RosSchema pose = pose_schema();
    McapChannel channel{log.channel(log.schema(pose.name, "ros2msg", pose.text), "/uav0/pose", "cdr", {})};
    std::vector<std::byte> bytes;
    for (std::uint64_t k = 0; k < 50; ++k) {
      encode_pose(bytes, "map", {.time = k * 100'000'000, .p = {0.5 * static_cast<double>(k), 1, 2}});
      log.message(channel.id, channel.sequence++, k * 100'000'000, bytes);
    }
    log.close();
  }
  // Its file, or its folder.
  for (const char* file : {"run.mcap", "."}) {
    const TomlDocument document =
        parse_toml(fmt::format("file = \"{}\"\nbody = \"uav0\"\n", file), (folder / "a.toml").native());
    const WaypointsMotion path =
        read_part<WaypointsMotion>(ListSource(TomlTable(document)), parameter_keys<ListFile>());
    EXPECT_EQ(path.times.size(), 50U);
    EXPECT_NEAR(path(2.0).p.x, 10.0, 1e-6) << "5 m/s";
  }
}

TEST(CsvLists, ARecordingThatGivesNoPathIsNamed) {
  const std::filesystem::path folder = test::fresh_folder();
  std::ofstream(folder / "flight.ulg", std::ios::binary) << test::ulog_of(test::LaggingFlight(1.0), 5);
  std::ofstream(folder / "cut.ulg", std::ios::binary) << "ULog\x01\x12\x35";
  std::ofstream(folder / "bad.ulg", std::ios::binary) << test::ulog_head() << std::string(9, '\1');
  std::ofstream(folder / "bag.db3", std::ios::binary) << std::string("SQLite format 3\0", 16);
  std::ofstream(folder / "flight.mcap", std::ios::binary)
      << test::bag_of(test::LaggingFlight(1.0)).bytes("zstd");
  const gzFile packed = gzopen((folder / "flight.mcap.gz").c_str(), "wb");
  ASSERT_GT(gzputs(packed, "\x89MCAP0\r\n\x01"), 0);
  gzclose(packed);
  std::ofstream(folder / "path.csv") << "t,x,y,z\n0,1,2,3\n1,1,2,3\n";
  const auto refused = [&](const std::string& keys) {
    const TomlDocument document = parse_toml(keys, (folder / "a.toml").native());
    return refusal_of<ScenarioError>([&] { (void)ListSource(TomlTable(document)); });
  };
  const std::string body = "\nbody = \"vehicle_local_position\"";
  EXPECT_THAT(refused("file = \"flight.ulg\""),
              HasSubstr("expected the key body beside a PX4 ULog: one of vehicle_local_position, "));
  EXPECT_THAT(
      refused("file = \"bag.db3\""),
      HasSubstr("expected a file of times and positions (CSV), relative to this one; this is an SQLite"));
  EXPECT_THAT(refused("file = \"path.csv\"" + body), HasSubstr("(this is a table of values (CSV))"));
  EXPECT_THAT(refused("file = \"flight.mcap\""),
              HasSubstr("expected the key body beside an MCAP recording, as of rosbag2: a topic or a name"));
  EXPECT_THAT(
      refused("file = \"flight.mcap\"\nbody = \"uav7\""),
      HasSubstr("flight.mcap: no body uav7, expected one of /odom, /pose, /poses:cf1, /tf:tag, /tf:uav0)"));
  EXPECT_THAT(refused("file = \"flight.mcap\"\nbody = \"" + std::string(81, 'a') + "\""),
              HasSubstr("expected a topic or a name of 1 to 80 bytes"));
  EXPECT_THAT(refused("file = \"flight.mcap.gz\"\nbody = \"/odom\""),
              HasSubstr("(this is an MCAP recording, as of rosbag2, packed by gzip)"));
  EXPECT_THAT(refused("file = \"bad.ulg\"" + body), HasSubstr("bad.ulg: byte 16: a message of kind 0x01"));
  EXPECT_THAT(refused("file = \"cut.ulg\"" + body), HasSubstr("cut.ulg: no topic vehicle_local_position"));
  EXPECT_THAT(refused("file = \"none.ulg\"" + body), HasSubstr("none.ulg: not there"));
  EXPECT_THAT(refused("file = \"flight.ulg\"\nbody = \"pose\""),
              HasSubstr("a.toml:2: body = \"pose\", expected one of vehicle_local_position, "));
  EXPECT_THAT(refused("file = \"flight.ulg\"\nperiod = 0.1" + body),
              HasSubstr("a.toml:2: period = 0.1, expected no such key beside body"));
  EXPECT_THAT(refused("body = \"pose\""), HasSubstr("expected the key file beside it"));
}

// The velocity is the derivative, and the bound holds on it.
TEST(CsvLists, APathWithVelocitiesHasThemAndStaysBelowItsTopSpeed) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> any(-2, 2);
  for (int trial = 0; trial < 50; ++trial) {
    Waypoints path;
    double t = 0;
    for (int i = 0; i < 6; ++i) {
      path.times.push_back(t);
      t += 0.5 + std::fabs(any(random));
      path.p.push_back({any(random), any(random), any(random)});
      path.v.push_back({any(random), any(random), any(random)});
    }
    path.check();
    const double h = 1e-6;
    const auto velocity = [&](double at) { return (0.5 / h) * (path(at + h).p - path(at - h).p); };
    for (std::size_t i = 1; i + 1 < path.times.size(); ++i) {
      EXPECT_LE(norm(path(path.times[i]).p - path.p[i]), 1e-12);
      EXPECT_LE(norm(velocity(path.times[i]) - path.v[i]), 1e-4);
    }
    for (double at = h; at < path.times.back() - h; at += 0.01)
      EXPECT_LE(norm(velocity(at)), path.top_speed() + 1e-6);
  }
}

TEST(CsvLists, NoMutatedFileDoesMoreThanBeingRefused) {
  const std::string text = "# t x y z heading\n0,1,2,3,0.5\n2,3,2,1,1.5\n3;4\t5 6,\"7\"\n";
  std::mt19937 random(3);
  int accepted = 0;
  for (int trial = 0, trials = runs(100'000, 5); trial < trials; ++trial) {
    std::string mutated = text;
    for (unsigned k = random() % 4 + 1; k > 0; --k) {
      const std::size_t at = random() % mutated.size();
      switch (random() % 3) {
        case 0:
          mutated[at] = static_cast<char>(random());
          break;
        case 1:
          mutated.erase(at, random() % 5);
          break;
        default:
          mutated.insert(at, mutated.substr(random() % mutated.size(), random() % 6));
          break;
      }
      if (mutated.empty()) mutated = ",";
    }
    try {
      const CsvColumns columns = read_csv(mutated, "path.csv");
      for (const Numbers& column : columns.values) ASSERT_EQ(column.size(), columns.values.front().size());
      ++accepted;
    } catch (const ScenarioError& error) {
      ASSERT_EQ(std::string_view(error.what()).find('\n'), std::string_view::npos);
    }
  }
  EXPECT_GT(accepted, 0);
}

}  // namespace
}  // namespace sightline
