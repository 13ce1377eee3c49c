/// What a vehicle of PX4 says beside what it is flown by: which release it is, what it takes, its battery, why it does not fly.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bridges/dds/channel.hpp"
#include "bridges/dds/conversion.hpp"
#include "bridges/dds/mailbox.hpp"
#include "bridges/dds/px4_layout.hpp"
#include "bridges/dds/surroundings.hpp"
#include "sightline/scenario/link.hpp"

namespace sightline::dds {

/// What it says of its battery; `arrived` 0: nothing yet.
struct Px4Battery {
  Nanoseconds arrived = 0;
  float remaining = 0.0F, voltage = 0.0F;  ///< of 1, [V]
  std::uint8_t warning = 0;
  bool connected = false;
};

/// Its readers take nothing from the control thread. All else is of one thread, before a flight.
class Px4Diagnostics {
 public:
  /// @throws std::runtime_error where a topic cannot be had
  Px4Diagnostics(dds_entity_t participant, const Px4Link& link);

  /// Adds release, battery and pilot. Each time it asks which layouts the vehicle takes, five times in all: nothing that it obeys.
  void examine(const Surroundings& around, const Px4Battery& battery, FindingList& to);
  /// The flags of its failsafe that are set, " (mag_invalid, ..)"; empty: none.
  std::string failing() const;

 private:
  static constexpr std::size_t flags_most = 48;
  static constexpr std::array<std::string_view, 3> sent = {"TrajectorySetpoint", "OffboardControlMode",
                                                           "VehicleCommand"};

  struct Flags {
    Nanoseconds arrived = 0;
    std::array<bool, flags_most> set{};  // in the order of their names
  };
  struct Answer {
    bool came = false, success = false;
    std::uint32_t hash = 0;
  };
  /// A topic by which a release is known, of messages of any size.
  struct Sign {
    std::string message;
    int version;
    dds_topic_descriptor_t descriptor;
    std::atomic<std::uint32_t> size{0};  // of the last one [bytes]; 0: none came
    std::unique_ptr<RawReader> reader{};
  };
  struct Looks {
    std::string release, by;  // "1.16", "vehicle_status_v1"; empty: nothing came
  };

  void read_signs(dds_entity_t participant);
  void read_formats(dds_entity_t participant);
  void request_formats();
  std::string topic_of(std::string_view message, int release) const;
  const Sign& sign(std::string_view message, int version) const;
  Looks looks_like(const Surroundings& around) const;
  void examine_release(const Surroundings& around, FindingList& to) const;
  void examine_formats(FindingList& to) const;
  void examine_battery(const Px4Battery& battery, FindingList& to) const;

  Px4Link link_;
  int release_;
  Px4Layout flags_layout_;
  std::vector<std::string> flag_names_;
  std::vector<std::size_t> flag_places_;
  std::size_t transmitter_ = 0;  // its place among the flags
  int requested_ = 0;

  // Filled by the thread that receives.
  Mailbox<Flags> flags_;
  std::array<Mailbox<Answer>, sent.size()> answers_;
  std::vector<std::unique_ptr<Sign>> signs_;

  std::unique_ptr<RawWriter> request_;
  std::vector<std::unique_ptr<RawReader>> readers_;  // last: they end before what they fill
};

}  // namespace sightline::dds
