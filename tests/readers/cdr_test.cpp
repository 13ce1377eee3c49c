#include "sightline/readers/cdr.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <random>

#include "sightline/world.hpp"

namespace sightline {
namespace {

using Bytes = std::vector<std::byte>;

StampedPose random_pose(std::mt19937_64& random) {
  std::uniform_real_distribution<double> anywhere(-50, 50), turn(-3.2, 3.2);
  const double heading = turn(random);
  return {random() % 2'000'000'000'000'000'000,
          {anywhere(random), anywhere(random), anywhere(random)},
          {std::cos(heading), std::sin(heading)}};
}

void expect_equal(const StampedPose& a, const StampedPose& b) {
  EXPECT_EQ(a.time, b.time);
  EXPECT_EQ(a.p, b.p);
  EXPECT_NEAR(a.d[0], b.d[0], 1e-15);
  EXPECT_NEAR(a.d[1], b.d[1], 1e-15);
}

TEST(Cdr, EveryNumberStandsOnAMultipleOfItsSizeBehindTheHead) {
  Bytes bytes;
  CdrEncoder(bytes)
      .put(std::uint8_t{1})
      .put(std::uint16_t{0x0302})
      .put(std::uint8_t{4})
      .put(2.0)
      .put("ab")
      .put(std::uint32_t{5});
  Bytes expected;
  for (const int byte : {0, 1, 0, 0,                                               // CDR_LE
                         1, 0, 2, 3, 4,    0,    0, 0, 0, 0, 0, 0, 0, 0, 0, 0x40,  // u8, u16, u8, f64
                         3, 0, 0, 0, 0x61, 0x62, 0, 0, 5, 0, 0, 0})                // string, u32
    expected.push_back(static_cast<std::byte>(byte));
  EXPECT_EQ(bytes, expected);
}

TEST(Cdr, WhatIsEncodedIsDecoded) {
  std::mt19937_64 random(1);
  Bytes bytes;
  for (int k = 0; k < 5000; ++k) {
    const StampedPose pose = random_pose(random);
    encode_pose(bytes, std::string(random() % 9, 'm'), pose);
    const auto decoded = decode_pose(bytes);
    ASSERT_TRUE(decoded);
    expect_equal(*decoded, pose);
  }
}

TEST(Cdr, BigEndianBytesGiveTheSameNumbers) {
  std::mt19937_64 random(5);
  Bytes bytes;
  const StampedPose pose = random_pose(random);
  encode_pose(bytes, "map", pose);
  const auto turn = [&](std::size_t at, std::size_t size) {
    std::reverse(bytes.begin() + static_cast<std::ptrdiff_t>(at),
                 bytes.begin() + static_cast<std::ptrdiff_t>(at + size));
  };
  bytes[1] = std::byte{0};
  for (const std::size_t at : {std::size_t{4}, std::size_t{8}, std::size_t{12}})
    turn(at, 4);  // time and length of the frame
  for (std::size_t at = 20; at < bytes.size(); at += 8) turn(at, 8);
  const auto decoded = decode_pose(bytes);
  ASSERT_TRUE(decoded);
  expect_equal(*decoded, pose);
  bytes[1] = std::byte{2};
  EXPECT_FALSE(decode_pose(bytes)) << "a parameter list";
}

TEST(Cdr, TwistsComeBackBitForBit) {
  std::mt19937_64 random(2);
  Bytes bytes;
  for (int k = 0; k < 1000; ++k) {
    const StampedPose a = random_pose(random), b = random_pose(random);
    encode_twist(bytes, "map", {a.time, a.p, b.p});
    const auto decoded = decode_twist(bytes);
    ASSERT_TRUE(decoded);
    EXPECT_EQ(decoded->time, a.time);
    EXPECT_EQ(decoded->linear, a.p);
    EXPECT_EQ(decoded->angular, b.p);
  }
}

TEST(Cdr, AttitudesComeBackBitForBit) {
  std::mt19937_64 random(12);
  Bytes bytes;
  for (int k = 0; k < 1000; ++k) {
    const StampedPose a = random_pose(random);
    const std::array<double, 4> q = {a.p[0], a.p[1], a.p[2], a.d[0]};
    encode_attitude(bytes, "map", {a.time, q});
    const auto decoded = decode_attitude(bytes);
    ASSERT_TRUE(decoded);
    EXPECT_EQ(decoded->time, a.time);
    EXPECT_EQ(decoded->q, q);
    bytes.pop_back();
    EXPECT_FALSE(decode_attitude(bytes));
  }
}

TEST(Cdr, APoseThatLeansComesBackAndIsItsAttitude) {
  std::mt19937_64 random(5);
  Bytes bytes, attitude;
  for (int k = 0; k < 1000; ++k) {
    StampedPose pose = random_pose(random);
    pose.lean = {0.001 * k, 0.3 - 0.0005 * k};
    encode_pose(bytes, "map", pose);
    const auto decoded = decode_pose(bytes);
    ASSERT_TRUE(decoded);
    EXPECT_EQ(decoded->p, pose.p);
    for (std::size_t i = 0; i < 2; ++i) EXPECT_NEAR(decoded->d[i], pose.d[i], 1e-12);
    for (std::size_t i = 0; i < 2; ++i) EXPECT_NEAR(decoded->lean[i], pose.lean[i], 1e-9);
    const Quaternion q = leaning({decoded->d[0], decoded->d[1]}, {pose.lean[0], pose.lean[1]});
    encode_attitude(attitude, "map", {pose.time, {q.x, q.y, q.z, q.w}});
    const auto turned = decode_attitude(attitude);
    ASSERT_TRUE(turned);
    const Rotation R = rotation({turned->q[3], turned->q[0], turned->q[1], turned->q[2]});
    EXPECT_NEAR(lean(R).x, decoded->lean[0], 1e-9);
    EXPECT_NEAR(lean(R).y, decoded->lean[1], 1e-9);
  }
}

TEST(Cdr, PathsOfAnyLengthComeBack) {
  std::mt19937_64 random(3);
  Bytes bytes;
  for (std::size_t length = 0; length < 60; ++length) {
    std::vector<StampedPose> poses(length);
    for (StampedPose& pose : poses) pose = random_pose(random);
    encode_path(bytes, std::string(length % 7, 'f'), 12, poses);
    const auto decoded = decode_path(bytes);
    ASSERT_TRUE(decoded);
    ASSERT_EQ(decoded->size(), length);
    for (std::size_t i = 0; i < length; ++i) expect_equal((*decoded)[i], poses[i]);
  }
}

TEST(Cdr, AHeadingOfAnyLengthBecomesAUnitQuaternionAboutZ) {
  std::mt19937_64 random(4);
  std::uniform_real_distribution<double> turn(-3.14159, 3.14159), logarithm(-8, 8);
  Bytes bytes;
  for (int k = 0; k < 5000; ++k) {
    const double heading = turn(random), length = std::exp(logarithm(random));
    encode_pose(bytes, "", {0, {}, {length * std::cos(heading), length * std::sin(heading)}});
    std::array<double, 4> q{};  // x y z w
    std::memcpy(q.data(), bytes.data() + bytes.size() - sizeof q, sizeof q);
    EXPECT_EQ(q[0], 0);
    EXPECT_EQ(q[1], 0);
    EXPECT_NEAR(q[2], std::sin(heading / 2), 1e-15);
    EXPECT_NEAR(q[3], std::cos(heading / 2), 1e-15);
  }
}

TEST(Cdr, AMessageCutAnywhereOrTooLongIsNoMessage) {
  std::mt19937_64 random(5);
  Bytes pose, path, twist;
  const std::vector<StampedPose> poses{random_pose(random), random_pose(random)};
  encode_pose(pose, "map", poses[0]);
  encode_twist(twist, "map", {});
  encode_path(path, "map", 1, poses);
  for (std::size_t n = 0; n < pose.size(); ++n) EXPECT_FALSE(decode_pose(std::span(pose).first(n)));
  for (std::size_t n = 0; n < twist.size(); ++n) EXPECT_FALSE(decode_twist(std::span(twist).first(n)));
  for (std::size_t n = 0; n < path.size(); ++n) EXPECT_FALSE(decode_path(std::span(path).first(n)));
  path.push_back(std::byte{0});
  EXPECT_FALSE(decode_path(path));
}

TEST(Cdr, ALengthNobodyCouldHaveWrittenAllocatesNothing) {
  Bytes bytes;
  CdrEncoder(bytes).put(std::int32_t{0}).put(std::uint32_t{0}).put("map").put(std::uint32_t{0xFFFFFFFF});
  EXPECT_FALSE(decode_path(bytes));
  CdrEncoder(bytes).put(std::int32_t{0}).put(std::uint32_t{0}).put(std::uint32_t{0xFFFFFFFF});
  EXPECT_FALSE(decode_path(bytes));
  CdrEncoder(bytes).put(std::int32_t{0}).put(std::uint32_t{0}).put(std::uint32_t{0});
  EXPECT_FALSE(decode_path(bytes));
}

TEST(Cdr, RandomBytesNeverDecodePastTheirEnd) {
  std::mt19937_64 random(6);
  Bytes bytes;
  const std::vector<StampedPose> poses(5);
  for (int k = 0; k < 20000; ++k) {
    encode_path(bytes, "map", 7, poses);
    const std::size_t length = bytes.size();
    for (int flips = 0; flips < 3; ++flips) bytes[random() % bytes.size()] = static_cast<std::byte>(random());
    const Bytes heap(bytes.begin(), bytes.end() - static_cast<std::ptrdiff_t>(random() % 60));
    const auto decoded = decode_path(heap);
    if (decoded) {
      EXPECT_LE(decoded->size() * 69, length);
    }
    EXPECT_FALSE(decode_pose(heap) && decode_twist(heap));  // 7 numbers or 6, never both
  }
}

TEST(Cdr, EverySchemaDefinesEveryTypeItNames) {
  for (const RosSchema& schema : {pose_schema(), twist_schema(), path_schema(), attitude_schema()}) {
    for (std::size_t slash = schema.text.find('/'); slash != std::string::npos;
         slash = schema.text.find('/', slash + 1)) {
      const std::size_t begin = schema.text.find_last_of(" \n", slash) + 1;  // npos + 1 = 0
      const std::string type = schema.text.substr(begin, schema.text.find_first_of(" [\n", slash) - begin);
      EXPECT_NE(schema.text.find("MSG: " + type + "\n"), std::string::npos)
          << schema.name << " names " << type;
    }
  }
}

}  // namespace
}  // namespace sightline
