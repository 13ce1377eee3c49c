#include "sightline/readers/ros_bag.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <vector>

#include "tests/support/folder.hpp"
#include "tests/support/mutated_bags.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/ros_bag.hpp"

namespace sightline::test {
namespace {

using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
namespace fs = std::filesystem;

fs::path bag_file(const fs::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
  return file;
}

TEST(RosBag, EachTypeOfMessageGivesTheSameMotion) {
  const LaggingFlight flight(6.0);
  for (const char* compression : {"", "zstd", "lz4"}) {
    const RosBag bag(bag_file(fresh_folder() / "a.mcap", bag_of(flight).bytes(compression)));
    EXPECT_THAT(bag.topics().bodies, ElementsAre("/odom", "/pose", "/poses:cf1", "/tf:tag", "/tf:uav0"));
    EXPECT_THAT(bag.topics().commands, ElementsAre("/cmd"));
    for (const char* body : {"/odom", "/pose", "/poses:cf1", "/tf:uav0"}) {
      const RecordedMotion motion = bag.motion(body);
      ASSERT_EQ(motion.size(), flight.rows.size() / 5 + 1);
      for (std::size_t k = 0; k < motion.size(); ++k) {
        const LaggingFlight::Row& row = flight.rows[5 * k];
        EXPECT_NEAR(motion[k].t, row.t, 1e-6);
        EXPECT_LE(norm(motion[k].p - row.p), 1e-12) << body;
        EXPECT_NEAR(motion[k].heading, row.psi, 1e-9) << "without jumps";
        // Of poses alone the velocity is a slope over 0.1 s, whose error is that of the
        // acceleration.
        EXPECT_LE(norm(motion[k].v - row.v), std::string(body) == "/odom" ? 1e-12 : 0.35) << body;
      }
    }
    const std::vector<VelocityCommand> commands = bag.commands("/cmd");
    EXPECT_EQ(commands.size(), flight.rows.size() / 5 + 1);
    EXPECT_NEAR(commands[50].yaw_rate, flight.rows[250].u_psi, 1e-12);
  }
}

TEST(RosBag, UncertainPosesAndTransformsAreMotionsAndAChannelWithoutSchemaIsNoFault) {
  BagWriter writer;
  for (int k = 0; k < 20; ++k) {
    const double t = 1 + 0.01 * k;
    const Vec3<double> p = {0.02 * k, 1, 2};
    Cdr plain, pose, transform;
    plain << 1.0;
    pose.stamp(t).pose(p, 0.5);
    for (int i = 0; i < 36; ++i) pose << 0.1;
    transform.stamp(t) << "cf7";
    transform.pose(p, 0.5);
    writer.add("/plain", "", t, plain);
    writer.add("/estimate", "geometry_msgs/msg/PoseWithCovarianceStamped", t, pose);
    writer.add("/vicon/cf7", "geometry_msgs/msg/TransformStamped", t, transform);
  }
  const RosBag bag(bag_file(fresh_folder() / "a.mcap", writer.bytes("zstd")));
  EXPECT_THAT(bag.topics().bodies, ElementsAre("/estimate", "/vicon/cf7:cf7"));
  for (const char* body : {"/estimate", "cf7"}) {
    const RecordedMotion motion = bag.motion(body);
    ASSERT_EQ(motion.size(), 20U) << body;
    for (const RecordedSample& one : motion) {
      EXPECT_NEAR(one.p.x, 2.0 * (one.t - 1), 1e-6);
      EXPECT_NEAR(one.v.x, 2.0, 1e-6);
      EXPECT_NEAR(one.heading, 0.5, 1e-12);
    }
  }
}

TEST(RosBag, ANameStandsForTheOnlyBodyThatHasIt) {
  const LaggingFlight flight(1.0);
  BagWriter writer = bag_of(flight);
  Cdr pose;
  pose.stamp(0.0).pose({1, 2, 3}, 0);
  writer.add("/cf2/pose", "geometry_msgs/msg/PoseStamped", 0.0, pose);
  const auto refused = [&](const RosBag& bag, const char* body) {
    return refusal_of([&] { (void)bag.motion(body); });
  };
  const fs::path file = fresh_folder() / "a.mcap";
  const RosBag bag(bag_file(file, writer.bytes("lz4")));
  EXPECT_EQ(bag.motion("cf1").size(), bag.motion("/poses:cf1").size());
  EXPECT_EQ(bag.motion("cf2").front().p.y, 2.0);
  EXPECT_THAT(refused(bag, "cf3"), HasSubstr("no body cf3, expected one of /cf2/pose, /odom, "));
  writer.add("/uav0/pose", "geometry_msgs/msg/PoseStamped", 0.0, pose);
  EXPECT_THAT(refused(RosBag(bag_file(file, writer.bytes(""))), "uav0"),
              EndsWith("no body uav0, expected one of /tf:uav0, /uav0/pose"));
}

TEST(RosBag, AFolderIsReadWhollyAndInOrder) {
  const fs::path folder = fresh_folder();
  LaggingFlight first(2.0), second(4.0);
  second.rows.erase(second.rows.begin(), second.rows.begin() + 1005);
  bag_file(folder / "bag_2.mcap", bag_of(first).bytes("zstd"));
  bag_file(folder / "bag_10.mcap", bag_of(second).bytes("zstd"));
  bag_file(folder / "metadata.yaml", "rosbag2_bagfile_information:\n");
  EXPECT_EQ(RosBag(folder).motion("/pose").size(), 401U);
  bag_file(folder / "run.mcap", bag_of(first).bytes(""));
  EXPECT_EQ(RosBag(folder).motion("/pose").size(), 201U) << "the folder of a run is its log alone";
}

/// A bag with one pose, its number ahead, and one command for each time, recorded 0.1 s apart from
/// 1e9 s on.
fs::path stamped_bag(const std::vector<double>& times) {
  BagWriter writer;
  for (std::size_t k = 0; k < times.size(); ++k) {
    const double recorded = 1e9 + 0.1 * static_cast<double>(k), ahead = static_cast<double>(k);
    Cdr pose, command;
    pose.stamp(times[k]).pose({ahead, 0, 0}, 0);
    command.stamp(times[k]) << Vec3<double>{ahead, 0, 0} << Vec3<double>{};
    writer.add("/pose", "geometry_msgs/msg/PoseStamped", recorded, pose);
    writer.add("/cmd", "geometry_msgs/msg/TwistStamped", recorded, command);
  }
  return bag_file(fresh_folder() / "a.mcap", writer.bytes(""));
}

TEST(RosBag, SimulatedTimeBeginsAtZeroAndNoTimeIsThatOfTheRecording) {
  for (const bool simulated : {true, false}) {
    std::vector<double> times(100);
    for (std::size_t k = 0; k < times.size(); ++k) times[k] = simulated ? 0.02 * static_cast<double>(k) : 0.0;
    const RosBag bag(stamped_bag(times));
    const RecordedMotion motion = bag.motion("/pose");
    const std::vector<VelocityCommand> commands = bag.commands("/cmd");
    ASSERT_EQ(motion.size(), 100U);
    ASSERT_EQ(commands.size(), 100U);
    for (std::size_t k = 0; k < 100; ++k) {
      EXPECT_NEAR(motion[k].t, simulated ? times[k] : 1e9 + 0.1 * static_cast<double>(k), 1e-6);
      EXPECT_EQ(motion[k].t, commands[k].t);
    }
  }
}

TEST(RosBag, FewMessagesOutOfOrderAreLeftOutAndManyRefused) {
  std::vector<double> times(100);
  for (std::size_t k = 0; k < times.size(); ++k) times[k] = 1.0 + 0.02 * static_cast<double>(k);
  for (std::size_t k = 0; k < 5; ++k) times[10 + 10 * k] = 0.5;
  EXPECT_EQ(RosBag(stamped_bag(times)).motion("/pose").size(), 95U);
  EXPECT_EQ(RosBag(stamped_bag(times)).commands("/cmd").size(), 95U);
  times[60] = times[59];
  EXPECT_THAT(
      refusal_of([&] { (void)RosBag(stamped_bag(times)).motion("/pose"); }),
      EndsWith("a.mcap: 6 of 100 messages of /pose are not later than those before, expected at most 5 %"));
  EXPECT_THAT(refusal_of([&] { (void)RosBag(stamped_bag(times)).commands("/cmd"); }),
              HasSubstr("6 of 100 messages of /cmd"));
  // A transform that is sent again at its time is the same sample.
  BagWriter writer;
  for (int k = 0; k < 100; ++k) {
    const int sample = k / 2;
    Cdr tf;
    tf << std::uint32_t{1};
    tf.stamp(1.0 + sample) << "uav0";
    tf.pose({static_cast<double>(sample), 0, 0}, 0);
    writer.add("/tf", "tf2_msgs/msg/TFMessage", 1.0 + k, tf);
  }
  EXPECT_EQ(RosBag(bag_file(fresh_folder() / "a.mcap", writer.bytes(""))).motion("uav0").size(), 50U);
}

TEST(RosBag, TheLengthOfAQuaternionDoesNotCountAndZeroIsUnknown) {
  const double psi = 2.5, c = std::cos(psi / 2), s = std::sin(psi / 2);
  for (const double length : {1e-3, 1.0, 3.0, 0.0, std::nan("")}) {
    BagWriter writer;
    for (int k = 0; k < 20; ++k) {
      // The first attitude is measured in any case.
      const double of = k == 0 ? 1.0 : length;
      const Vec3<double> p = {0.02 * k, 0, 0};
      Cdr pose, odometry;
      pose.stamp(1 + 0.01 * k) << p << 0.0 << 0.0 << of * s << of * c;
      odometry.stamp(1 + 0.01 * k) << "body";
      odometry << p << 0.0 << 0.0 << of * s << of * c;
      for (int i = 0; i < 36; ++i) odometry << 0.0;
      odometry << Vec3<double>{1, 0, 0} << Vec3<double>{};
      for (int i = 0; i < 36; ++i) odometry << 0.0;
      writer.add("/pose", "geometry_msgs/msg/PoseStamped", 1 + 0.01 * k, pose);
      writer.add("/odom", "nav_msgs/msg/Odometry", 1 + 0.01 * k, odometry);
    }
    const RosBag bag(bag_file(fresh_folder() / "a.mcap", writer.bytes("")));
    for (const char* body : {"/pose", "/odom"}) {
      const RecordedMotion motion = bag.motion(body);
      ASSERT_EQ(motion.size(), 20U);
      for (std::size_t k = 0; k < motion.size(); ++k) {
        const bool known = k == 0 || length > 0;
        EXPECT_EQ(std::isfinite(motion[k].heading), known) << body << k;
        EXPECT_NEAR(known ? motion[k].heading : psi, psi, 1e-12);
        // Without an attitude the velocity in its axes is unknown, and that of the positions
        // counts.
        const bool of_odometry = known && std::string(body) == "/odom";
        EXPECT_NEAR(motion[k].v.x, of_odometry ? std::cos(psi) : 2.0, 1e-9) << body << k;
        EXPECT_NEAR(motion[k].v.y, of_odometry ? std::sin(psi) : 0.0, 1e-9) << body << k;
      }
    }
  }
}

TEST(RosBag, WhatCannotBeReadIsNamed) {
  const fs::path folder = fresh_folder();
  const BagWriter writer = bag_of(LaggingFlight(0.1));
  const auto refused = [&](const std::string& bytes) {
    const fs::path file = bag_file(folder / "a.mcap", bytes);
    return refusal_of([&] { (void)RosBag(file).topics(); });
  };
  EXPECT_THAT(
      refused(writer.bytes("brotli")),
      HasSubstr("a.mcap: byte 35: a chunk compressed by an unknown method, expected zstd, lz4 or none"));
  // The frame has another head, or is longer or shorter than the chunk.
  for (const std::string packer : {"lz4", "zstd"}) {
    const std::string whole = writer.bytes(packer);
    const std::size_t frame = whole.find(packer) + packer.size() + 8, size_at = 35 + 9 + 16;
    for (const auto& [at, change] :
         {std::pair{frame, 1}, std::pair{size_at, 1}, std::pair{size_at, 8}, std::pair{size_at + 2, 1}}) {
      std::string bytes = whole;
      bytes[at] = static_cast<char>(bytes[at] ^ change);
      const std::string sentence = refused(bytes);
      EXPECT_THAT(sentence, HasSubstr("a.mcap: byte 35: a chunk whose " + packer + " frame is damaged"))
          << at;
    }
  }
  EXPECT_THAT(refused("nothing"), HasSubstr("a.mcap: byte 0: the file does not begin as MCAP logs do"));
  BagWriter damaged;
  Cdr pose;
  pose.stamp(1.0) << 1.0 << 2.0;
  damaged.add("/pose", "geometry_msgs/msg/PoseStamped", 1.0, pose);
  EXPECT_THAT(refused(damaged.bytes("")),
              EndsWith("a.mcap: message 1 on /pose is no sound geometry_msgs/msg/PoseStamped"));

  const RosBag bag(bag_file(folder / "a.mcap", writer.bytes("zstd")));
  EXPECT_THAT(
      refusal_of([&] { (void)bag.motion("/tf:uav7"); }),
      EndsWith("a.mcap: no body /tf:uav7, expected one of /odom, /pose, /poses:cf1, /tf:tag, /tf:uav0"));
  EXPECT_THAT(refusal_of([&] { (void)bag.commands("/pose"); }),
              EndsWith("a.mcap: no commands /pose, expected one of /cmd"));
  const fs::path old = folder / "old";
  fs::create_directories(old);
  EXPECT_THAT(refusal_of([&] { RosBag{old}; }), EndsWith("old: no .mcap, expected the folder of a rosbag2"));
  bag_file(old / "old_0.mcap.zstd", "");
  EXPECT_THAT(
      refusal_of([&] { RosBag{old}; }),
      EndsWith("old: a rosbag2 whose files are packed (.zstd), expected plain ones: zstd -d unpacks them"));
  bag_file(old / "old_0.db3", "SQLite format 3");
  EXPECT_THAT(
      refusal_of([&] { RosBag{old}; }),
      EndsWith(
          "a rosbag2 in SQLite (.db3), expected MCAP: ros2 bag convert with storage_id: mcap writes it"));
}

TEST(RosBag, SchemasOfEitherLanguageNameTheirTypesAndNamesAreBounded) {
  const fs::path file = fresh_folder() / "a.mcap";
  Cdr pose, transform;
  pose.stamp(1.0).pose({1, 2, 3}, 0);
  BagWriter writer("ros2idl");
  writer.add("/pose", "geometry_msgs/msg/PoseStamped", 1.0, pose);
  EXPECT_EQ(RosBag(bag_file(file, writer.bytes("zstd"))).motion("/pose").front().p.y, 2.0);

  const std::string name(2000, 'n');
  transform.stamp(1.0) << name.c_str();
  transform.pose({}, 0);
  BagWriter child, topic;
  child.add("/tf", "geometry_msgs/msg/TransformStamped", 1.0, transform);
  topic.add("/" + name, "geometry_msgs/msg/PoseStamped", 1.0, pose);
  const auto refused = [&](const BagWriter& bag) {
    return refusal_of([&] { (void)RosBag(bag_file(file, bag.bytes("zstd"))).topics(); });
  };
  EXPECT_THAT(refused(child), EndsWith("message 1 on /tf is no sound geometry_msgs/msg/TransformStamped"));
  EXPECT_THAT(refused(topic),
              EndsWith("message 1 on a topic with a name of 2001 bytes, expected at most 1024"));
}

TEST(RosBag, ChannelsWithALongSchemaEncodingAreRefused) {
  const fs::path file = fresh_folder() / "a.mcap";
  BagWriter few, many;
  few.add_channels(3, std::string(64, 'e'));
  many.add_channels(3, std::string(65, 'e'));
  EXPECT_TRUE(RosBag(bag_file(file, few.bytes("zstd"))).topics().bodies.empty());
  EXPECT_THAT(refusal_of([&] { (void)RosBag(bag_file(file, many.bytes("zstd"))).topics(); }),
              EndsWith("a schema with an encoding of 65 bytes, expected at most 64"));
}

TEST(RosBag, MutatedBagsAreReadOrRefusedInOneSentence) {
  const int accepted = read_mutated_bags(2'000, 1, fresh_folder() / "a.mcap");
  EXPECT_GT(accepted, 20);
  EXPECT_LT(accepted, 1'990);
}

}  // namespace
}  // namespace sightline::test
