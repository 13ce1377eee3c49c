#include "bridges/dds/links/px4_release.hpp"

#include <fmt/format.h>

#include <cctype>
#include <charconv>
#include <stdexcept>

namespace sightline::dds {
namespace {

constexpr int versions_since = 16;

/// First release in which a message has a version.
struct Versioned {
  std::string_view message;
  int release, version;
};
constexpr std::array<Versioned, 5> versioned = {{{"VehicleStatus", 16, 1},
                                                 {"VehicleStatus", 18, 4},
                                                 {"VehicleLocalPosition", 17, 1},
                                                 {"VehicleCommandAck", 18, 1},
                                                 {"BatteryStatus", 17, 1}}};

/// First release of messages that are newer than px4_first.
struct Since {
  std::string_view message;
  int release;
};
constexpr std::array<Since, 9> since = {{{"GotoSetpoint", 15},
                                         {"MessageFormatRequest", 15},
                                         {"MessageFormatResponse", 15},
                                         {"RoverAttitudeSetpoint", 16},
                                         {"RoverPositionSetpoint", 16},
                                         {"RoverRateSetpoint", 16},
                                         {"RoverSteeringSetpoint", 16},
                                         {"RoverThrottleSetpoint", 16},
                                         {"RoverSpeedSetpoint", 17}}};

/// The release suffix of the IDL name; px4_first without one.
int layout_since(std::string_view idl_name) {
  idl_name.remove_suffix(1);
  int release = px4_first;
  const std::size_t bar = idl_name.rfind('_');
  if (bar != std::string_view::npos)
    std::from_chars(idl_name.data() + bar + 1, idl_name.data() + idl_name.size(), release);
  return release;
}

}  // namespace

const MessageType& px4_type(std::string_view message, int release) {
  const std::string name = fmt::format("px4_msgs/msg/{}", message);
  bool there = true;
  for (const Since& one : since) there = there && (one.message != message || one.release <= release);
  const MessageType* newest = nullptr;
  for (const MessageType& type : message_types()) {
    if (there && type.name == name && layout_since(type.idl_name) <= release) newest = &type;
  }
  if (newest == nullptr) throw std::invalid_argument(fmt::format("PX4 1.{} has no {}", release, message));
  return *newest;
}

int px4_version(std::string_view message, int release) {
  int version = 0;
  for (const Versioned& one : versioned) {
    if (one.message == message && one.release <= release) version = one.version;
  }
  return version;
}

std::string px4_topic(std::string_view name_space, Px4Side side, std::string_view message, int release) {
  std::string topic = fmt::format("{}/fmu/{}", name_space, side == Px4Side::out ? "out" : "in");
  bool first = true;
  for (const char c : message) {
    if (std::isupper(static_cast<unsigned char>(c)) != 0) topic += first ? "/" : "_";
    topic += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    first = false;
  }
  const int version = px4_version(message, release);
  if (release >= versions_since && version > 0) topic += fmt::format("_v{}", version);
  return topic;
}

}  // namespace sightline::dds
