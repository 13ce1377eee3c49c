#include "bridges/dds/topics/message_type.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstddef>
#include <fstream>
#include <sstream>

#include "bridges/dds/links/px4_release.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/tree.hpp"

extern "C" {
#include "px4.h"
}

namespace sightline::dds {
namespace {

/// The lines of a section of layouts.txt, each cut at " | ".
std::vector<std::vector<std::string>> section(std::string_view title) {
  std::ifstream file(test::tree / "tests/dds/layouts.txt");
  std::vector<std::vector<std::string>> rows;
  bool inside = false;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("## ")) inside = line.starts_with("## " + std::string(title));
    if (!inside || line.empty() || line.starts_with("#")) continue;
    std::vector<std::string> cells(1);
    for (std::size_t at = 0; at < line.size(); ++at) {
      if (line.compare(at, 3, " | ") == 0) {
        cells.emplace_back();
        at += 2;
      } else {
        cells.back() += line[at];
      }
    }
    rows.push_back(cells);
  }
  return rows;
}

std::vector<std::string> words_of(const std::string& text, char gap) {
  std::vector<std::string> words;
  std::istringstream stream(text);
  for (std::string word; std::getline(stream, word, gap);)
    if (!word.empty()) words.push_back(word);
  return words;
}

/// A message's fields as layouts.txt has them: "u64 timestamp, f32[3] position velocity".
std::vector<Field> fields_of(const std::string& text) {
  const std::map<std::string, std::string> words = {
      {"u8", "uint8"},  {"i8", "int8"},    {"u16", "uint16"}, {"i16", "int16"}, {"u32", "uint32"},
      {"i32", "int32"}, {"u64", "uint64"}, {"i64", "int64"},  {"f32", "float"}, {"f64", "double"},
      {"b", "boolean"}, {"char", "char"},  {"byte", "octet"}, {"s", "string"}};
  std::vector<Field> fields;
  for (const std::string& group : words_of(text, ',')) {
    std::vector<std::string> names = words_of(group, ' ');
    if (names.empty()) continue;
    std::string type = names[0];
    Field field;
    if (const std::size_t bracket = type.find('['); bracket != std::string::npos) {
      field.many = type.ends_with("[]") ? Many::sequence : Many::array;
      if (field.many == Many::array) field.length = std::stoul(type.substr(bracket + 1));
      type.resize(bracket);
    }
    field.type = words.contains(type) ? words.at(type) : type;
    if (const std::size_t slash = field.type.find('/'); slash != std::string::npos)
      field.type.replace(slash, 1, "/msg/");
    for (std::size_t i = 1; i < names.size(); ++i) {
      field.name = names[i];
      fields.push_back(field);
    }
  }
  if (fields.empty()) fields.push_back({"uint8", "structure_needs_at_least_one_member"});
  return fields;
}

/// Releases of "14(v0) 16(v1)", "14,15" or "16/17", with versions where they are given.
std::vector<std::pair<int, int>> releases_of(std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == ',' || c == '/'; }, ' ');
  std::vector<std::pair<int, int>> releases;
  for (const std::string& word : words_of(text, ' ')) {
    const std::size_t v = word.find("(v");
    releases.emplace_back(std::stoi(word), v == std::string::npos ? -1 : std::stoi(word.substr(v + 2)));
  }
  return releases;
}

const MessageType& ros(const std::string& name) {
  const auto& all = message_types();
  return *std::find_if(all.begin(), all.end(), [&](const MessageType& t) { return t.name == name; });
}

TEST(MessageType, EachLayoutOfPx4HasItsFieldsSizeAndTopicInEachRelease) {
  const auto rows = section("PX4 layouts");
  ASSERT_EQ(rows.size(), 38u);
  for (const auto& row : rows) {
    for (const auto& [release, version] : releases_of(row[1])) {
      const MessageType& type = px4_type(row[0], release);
      EXPECT_EQ(type.fields, fields_of(row[3])) << row[0] << " 1." << release;
      EXPECT_EQ(payload_size(type), std::stoul(row[2])) << row[0] << " 1." << release;
      EXPECT_EQ(px4_version(row[0], release), version) << row[0] << " 1." << release;
    }
  }
}

TEST(MessageType, EachMessageOfPx4HasTheHashesOfItsRelease) {
  for (const auto& row : section("RIHS01 of PX4 messages")) {
    const std::vector<std::string> words = words_of(row[0], ' ');
    for (const auto& [release, version] : releases_of(words[1]))
      EXPECT_EQ(type_hash(px4_type(words[0], release)), "RIHS01_" + words[2]) << words[0] << " 1." << release;
  }
  int hashes = 0;
  for (const auto& row : section("PX4 message hash")) {
    const std::vector<std::string> words = words_of(row[0], ' ');
    for (std::size_t i = 1; i < words.size(); ++i) {
      const std::size_t colon = words[i].find(':');
      for (const auto& [release, version] : releases_of(words[i].substr(0, colon))) {
        EXPECT_EQ(fmt::format("{:08x}", px4_hash(px4_type(words[0], release))), words[i].substr(colon + 1))
            << words[0] << " 1." << release;
        ++hashes;
      }
    }
  }
  EXPECT_GT(hashes, 80);
}

TEST(MessageType, EachMessageAndServiceOfRosHasItsFieldsAndItsHash) {
  const auto rows = section("ROS 2 messages, RIHS01");
  ASSERT_GT(rows.size(), 40u);
  for (const auto& row : rows) {
    std::string name = row[0];
    name.replace(name.find('/'), 1, "/msg/");
    EXPECT_EQ(ros(name).fields, fields_of(row[1])) << name;
    EXPECT_EQ(type_hash(ros(name)), "RIHS01_" + row[2]) << name;
  }
  for (const auto& row : section("Services")) {
    std::string name = row[0];
    name.replace(name.find('/'), 1, "/srv/");
    const std::size_t cut = row[1].find("---");
    EXPECT_EQ(ros(name + "_Request").fields, fields_of(row[1].substr(0, cut))) << name;
    EXPECT_EQ(ros(name + "_Response").fields, fields_of(row[1].substr(cut + 3))) << name;
    const std::vector<std::string> hashes = words_of(row[2], ' ');
    EXPECT_EQ(type_hash(ros(name + "_Request")), "RIHS01_" + hashes[1]) << name;
    EXPECT_EQ(type_hash(ros(name + "_Response")), "RIHS01_" + hashes[2]) << name;
  }
}

TEST(MessageType, AFixedMessageLiesInMemoryAsOnTheWire) {
  const auto places = [](std::string_view message, int release) {
    return *payload_layout(px4_type(message, release));
  };
  using Status = px4_msgs_msg_dds__VehicleStatus_18_;
  EXPECT_EQ(places("VehicleStatus", 18)[5], offsetof(Status, latest_disarming_reason));
  EXPECT_EQ(places("VehicleStatus", 18)[6], offsetof(Status, nav_state_timestamp));
  EXPECT_EQ(places("VehicleStatus", 18).back() - 1, offsetof(Status, pre_flight_checks_pass));
  using OdometryLayout = px4_msgs_msg_dds__VehicleOdometry_;
  EXPECT_EQ(places("VehicleOdometry", 16)[3], offsetof(OdometryLayout, position));
  EXPECT_EQ(places("VehicleOdometry", 16).back() - 1, offsetof(OdometryLayout, quality));
  using ImuLayout = px4_msgs_msg_dds__SensorCombined_;
  EXPECT_EQ(places("SensorCombined", 14)[4], offsetof(ImuLayout, accelerometer_m_s2));
  EXPECT_EQ(places("SensorCombined", 18).back() - 1, offsetof(ImuLayout, gyro_calibration_count));
  using Command = px4_msgs_msg_dds__VehicleCommand_15_;
  EXPECT_EQ(places("VehicleCommand", 15)[5], offsetof(Command, param5));
  EXPECT_EQ(places("VehicleCommand", 15).back() - 1, offsetof(Command, from_external));
  EXPECT_FALSE(payload_size(ros("nav_msgs/msg/Odometry")));
}

TEST(MessageType, NamesOnTheWireAreThoseOfRos) {
  EXPECT_EQ(wire_topic("/a/b"), "rt/a/b");
  EXPECT_EQ(wire_request("/a/s"), "rq/a/sRequest");
  EXPECT_EQ(wire_reply("/a/s"), "rr/a/sReply");
  EXPECT_EQ(wire_type("px4_msgs::msg::dds_::VehicleStatus_16_"), "px4_msgs::msg::dds_::VehicleStatus_");
  EXPECT_EQ(wire_type("std_srvs::srv::dds_::Trigger_Request_"), "std_srvs::srv::dds_::Trigger_Request_");
  EXPECT_EQ(px4_topic("/px4_1", Px4Side::out, "VehicleStatus", 15), "/px4_1/fmu/out/vehicle_status");
  EXPECT_EQ(px4_topic("", Px4Side::out, "VehicleStatus", 17), "/fmu/out/vehicle_status_v1");
  EXPECT_EQ(px4_topic("", Px4Side::in, "OffboardControlMode", 18), "/fmu/in/offboard_control_mode");
}

TEST(MessageType, OneThatTheIdlLacksIsRefused) {
  EXPECT_THROW((void)message_type("a::msg::dds_::B_"), std::invalid_argument);
  EXPECT_THROW((void)px4_type("MessageFormatRequest", 14), std::invalid_argument);
}

}  // namespace
}  // namespace sightline::dds
