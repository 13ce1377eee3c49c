#include "bridges/dds/links/px4_layout.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <stdexcept>

#include "bridges/dds/links/px4_release.hpp"

extern "C" {
#include "px4.h"
}

namespace sightline::dds {

std::span<const dds_topic_descriptor_t* const> px4_descriptors() {
#define LAYOUT(message) &px4_msgs_msg_dds__##message##_desc
  static const std::array<const dds_topic_descriptor_t*, 33> all = {
      LAYOUT(TrajectorySetpoint_),      LAYOUT(OffboardControlMode_14_),  LAYOUT(OffboardControlMode_15_),
      LAYOUT(VehicleCommand_14_),       LAYOUT(VehicleCommand_15_),       LAYOUT(VehicleCommandAck_14_),
      LAYOUT(VehicleCommandAck_15_),    LAYOUT(VehicleStatus_14_),        LAYOUT(VehicleStatus_15_),
      LAYOUT(VehicleStatus_16_),        LAYOUT(VehicleStatus_18_),        LAYOUT(VehicleOdometry_),
      LAYOUT(VehicleLocalPosition_14_), LAYOUT(VehicleLocalPosition_15_), LAYOUT(VehicleLocalPosition_16_),
      LAYOUT(VehicleAttitude_),         LAYOUT(SensorCombined_),          LAYOUT(VehicleLandDetected_),
      LAYOUT(TimesyncStatus_),          LAYOUT(FailsafeFlags_14_),        LAYOUT(FailsafeFlags_15_),
      LAYOUT(FailsafeFlags_16_),        LAYOUT(FailsafeFlags_17_),        LAYOUT(FailsafeFlags_18_),
      LAYOUT(BatteryStatus_14_),        LAYOUT(BatteryStatus_16_),        LAYOUT(BatteryStatus_17_),
      LAYOUT(MessageFormatRequest_),    LAYOUT(MessageFormatResponse_),   LAYOUT(RoverSpeedSetpoint_),
      LAYOUT(RoverRateSetpoint_),       LAYOUT(RoverThrottleSetpoint_),   LAYOUT(EstimatorStatusFlags_)};
#undef LAYOUT
  return all;
}

namespace {

const dds_topic_descriptor_t& descriptor_of(const MessageType& type) {
  const auto all = px4_descriptors();
  const auto found = std::find_if(all.begin(), all.end(), [&](const dds_topic_descriptor_t* descriptor) {
    return type.idl_name == descriptor->m_typename;
  });
  if (found == all.end()) throw std::invalid_argument(fmt::format("{} has no descriptor", type.idl_name));
  return **found;
}

}  // namespace

Px4Layout::Px4Layout(std::string_view message, int release)
    : type_(px4_type(message, release)), descriptor_(descriptor_of(type_)), places_(*payload_layout(type_)) {}

bool Px4Layout::has(std::string_view field) const {
  return std::any_of(type_.fields.begin(), type_.fields.end(),
                     [&](const Field& one) { return one.name == field; });
}

std::size_t Px4Layout::place(std::string_view field) const {
  for (std::size_t i = 0; i < type_.fields.size(); ++i)
    if (type_.fields[i].name == field) return places_[i];
  throw std::invalid_argument(fmt::format("{} has no field {}", type_.idl_name, field));
}

}  // namespace sightline::dds
