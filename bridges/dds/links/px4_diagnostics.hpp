/// Diagnostics of a PX4 vehicle beyond its flight topics: release, accepted message layouts,
/// battery, failsafe flags.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bridges/dds/fleet/link.hpp"
#include "bridges/dds/links/px4_layout.hpp"
#include "bridges/dds/topics/channel.hpp"
#include "bridges/dds/topics/conversion.hpp"
#include "bridges/dds/topics/mailbox.hpp"
#include "bridges/dds/topics/surroundings.hpp"

namespace sightline::dds {

/// Failsafe flag of a vehicle without a global origin.
inline constexpr std::string_view px4_global_flag = "global_position_invalid";
/// Failsafe flag without heartbeats of a flyer.
inline constexpr std::string_view px4_offboard_flag = "offboard_control_signal_lost";

/// Battery state as the vehicle reports it; `arrived` 0: nothing received yet.
struct Px4Battery {
  Nanoseconds arrived = 0;
  float remaining = 0.0F, voltage = 0.0F;  ///< fraction in [0, 1]; [V]
  std::uint8_t warning = 0;
  bool connected = false;
};

/// Its readers do not affect the control thread. All functions run on one thread, before a flight.
class Px4Diagnostics {
 public:
  /// @throws std::runtime_error if a topic cannot be created
  Px4Diagnostics(dds_entity_t participant, const Px4Link& link);

  /// Adds findings about release, battery and pilot. Each call requests the vehicle's message
  /// layouts, at most five times; the vehicle does not act on these requests.
  void examine(const Surroundings& around, const Px4Battery& battery, FindingList& to);
  /// Failsafe flags that are set, " (mag_invalid, ..)"; empty: none. Of those that are usual before
  /// a flight, only `needed`.
  std::string failing(std::string_view needed) const;
  /// Whether its checks fail for want of a global position, as without satellites. Allocates nothing.
  bool lacks_origin() const noexcept;
  /// Error of its stamps by its own time sync: how far they are behind the agent's clock [s]; 0 if
  /// unknown.
  double stamps_behind() const noexcept;

 private:
  static constexpr std::size_t flags_most = 48;
  static constexpr std::array<std::string_view, 3> sent = {"TrajectorySetpoint", "OffboardControlMode",
                                                           "VehicleCommand"};

  struct Flags {
    Nanoseconds arrived = 0;
    std::array<bool, flags_most> set{};  // in the order of flag_names_
  };
  struct Answer {
    bool came = false, success = false;
    std::uint32_t hash = 0;
  };
  /// A topic that identifies a release; accepts messages of any size.
  struct Sign {
    std::string message;
    int version;
    dds_topic_descriptor_t descriptor;
    std::atomic<std::uint32_t> size{0};  // of the last message [bytes]; 0: none received
    std::unique_ptr<RawReader> reader{};
  };
  struct Looks {
    std::string release, by;  // "1.16", "vehicle_status_v1"; empty: nothing received
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
  std::size_t transmitter_ = 0, global_ = 0;  // indices of the flags of transmitter and global position
  int requested_ = 0;

  // Filled by the receive thread.
  Mailbox<Flags> flags_;
  Mailbox<double> stamps_behind_;  // [s]
  std::array<Mailbox<Answer>, sent.size()> answers_;
  std::vector<std::unique_ptr<Sign>> signs_;

  std::unique_ptr<RawWriter> request_;
  std::vector<std::unique_ptr<RawReader>> readers_;  // last member: destroyed before the members they fill
};

}  // namespace sightline::dds
