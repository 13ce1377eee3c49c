#include "bridges/dds/simulators/px4_vehicle_diagnostics.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include "bridges/dds/links/px4_link.hpp"
#include "bridges/dds/links/px4_release.hpp"
#include "sightline/base/now.hpp"

extern "C" {
#include "px4.h"
}

namespace sightline::dds {
namespace {

using FormatRequest = px4_msgs_msg_dds__MessageFormatRequest_;
using FormatResponse = px4_msgs_msg_dds__MessageFormatResponse_;

constexpr std::array<std::string_view, 3> taken_messages = {"TrajectorySetpoint", "OffboardControlMode",
                                                            "VehicleCommand"};
constexpr float low_battery = 0.05F, empty_voltage = 13.04F, full_voltage = 16.24F;

std::uint64_t real_microseconds() { return static_cast<std::uint64_t>(realtime_now() / 1000); }

}  // namespace

Px4VehicleDiagnostics::Px4VehicleDiagnostics(dds_entity_t participant, const Px4Link& link, Faults& faults)
    : release_(px4_first + static_cast<int>(link.release)),
      faults_(faults),
      takes_(release_),
      battery_("BatteryStatus", release_),
      flags_("FailsafeFlags", release_),
      estimator_("EstimatorStatusFlags", release_) {
  const auto writer = [&](const dds_topic_descriptor_t& type, std::string_view message) {
    return std::make_unique<FaultyWriter>(participant, type,
                                          px4_topic(link.name_space, Px4Side::out, message, release_),
                                          of_px4_output, faults_);
  };
  battery_writer_ = writer(battery_.descriptor(), "BatteryStatus");
  flags_writer_ = writer(flags_.descriptor(), "FailsafeFlags");
  estimator_writer_ = writer(estimator_.descriptor(), "EstimatorStatusFlags");
  if (release_ < px4_answers_formats_from) return;
  response_ = writer(px4_msgs_msg_dds__MessageFormatResponse__desc, "MessageFormatResponse");
  request_ = std::make_unique<RawReader>(
      participant, px4_msgs_msg_dds__MessageFormatRequest__desc,
      px4_topic(link.name_space, Px4Side::in, "MessageFormatRequest", release_), Quality{.depth = 8},
      payload_size(px4_type("MessageFormatRequest", release_)), Writers::all,
      [this](const void* m, const Arrival&) { answer(m); });
}

void Px4VehicleDiagnostics::send() {
  Px4Message battery(battery_), flags(flags_);
  const bool low = faults_.on(LinkFaultKind::battery_low);
  const float remaining = low ? low_battery : remaining_.load();
  const std::uint8_t warning = low ? px4_battery_critical : px4_battery_good;
  battery.set("timestamp", real_microseconds());
  battery.set("connected", true);
  battery.set("remaining", remaining);
  battery.set("voltage_v", empty_voltage + remaining * (full_voltage - empty_voltage));
  battery.set("cell_count", std::uint8_t{4});
  battery.set("warning", warning);
  battery_writer_->write(battery.data());
  flags.set("timestamp", real_microseconds());
  flags.set("manual_control_signal_lost", transmitter_lost_.load());
  flags.set(px4_global_flag, origin_lost_.load());
  flags.set("local_position_invalid", faults_.on(LinkFaultKind::estimator_invalid));
  flags.set("battery_warning", warning);
  flags.set(px4_offboard_flag, offboard_lost_.load());
  flags_writer_->write(flags.data());
  Px4Message estimator(estimator_);
  estimator.set("timestamp", real_microseconds());
  estimator.set("cs_tilt_align", tilt_.load());
  estimator.set("cs_yaw_align", heading_.load());
  estimator_writer_->write(estimator.data());
}

void Px4VehicleDiagnostics::answer(const void* request) {
  const auto& requested = *static_cast<const FormatRequest*>(request);
  FormatResponse response{};
  response.timestamp = real_microseconds();
  response.protocol_version = requested.protocol_version;
  std::copy(std::begin(requested.topic_name), std::end(requested.topic_name),
            std::begin(response.topic_name));
  std::string_view topic(requested.topic_name, sizeof requested.topic_name);
  topic = topic.substr(0, topic.find('\0'));
  for (const std::string_view message : taken_messages) {
    if (px4_topic("", Px4Side::in, message, px4_first) != topic) continue;
    response.success = true;
    response.message_hash = px4_hash(px4_type(message, takes_));
  }
  response_->write(&response);
}

}  // namespace sightline::dds
