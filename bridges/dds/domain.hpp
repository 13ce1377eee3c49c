/// DDS domain restricted to the configured network: given interfaces, unicast by default, a bounded
/// number of participants.
#pragma once

#include <dds/dds.h>

#include <cstdint>
#include <optional>
#include <string>

#include "bridges/dds/fleet/link.hpp"
#include "bridges/dds/security.hpp"

namespace sightline::dds {

/// Cyclone DDS configuration of a network. Sets every option that could send elsewhere; defaults
/// and CYCLONEDDS_URI do not apply.
/// @param receive_priority  SCHED_FIFO priority of the receive thread; none: an ordinary thread
/// @param who  program whose keys apply, if the network has keys
std::string domain_xml(const FleetNetwork& network, std::optional<int> receive_priority = {},
                       Identity who = Identity::flyer);

/// Owner of a domain and one participant in it. A program can hold one Domain per domain number at
/// a time.
class Domain {
 public:
  /// @throws std::runtime_error if the interface does not exist or the program already has this
  ///   domain
  /// @throws std::invalid_argument as check_keys(), if the network has keys
  explicit Domain(const FleetNetwork& network, std::optional<int> receive_priority = {},
                  Identity who = Identity::flyer);
  ~Domain();
  Domain(const Domain&) = delete;
  Domain& operator=(const Domain&) = delete;

  dds_entity_t participant() const { return participant_; }
  /// One more participant, as a second program would have; deleted with the domain.
  dds_entity_t another_participant() const;

 private:
  int number_;
  dds_entity_t domain_ = 0, participant_ = 0;
};

/// Number of log lines of Cyclone DDS since program start; most report unreadable messages.
std::int64_t complaints();
/// The last such line.
std::string last_complaint();

}  // namespace sightline::dds
