/// A domain of DDS that hears and asks no more than it is told to: loopback, unicast, a bounded number of programs.
#pragma once

#include <dds/dds.h>

#include <cstdint>
#include <optional>
#include <string>

#include "bridges/dds/security.hpp"
#include "sightline/scenario/link.hpp"

namespace sightline::dds {

/// The configuration of Cyclone DDS for a network. Nothing is left to its defaults or to CYCLONEDDS_URI that could send elsewhere.
/// @param receive_priority  of SCHED_FIFO, of the thread that receives; none: an ordinary one
/// @param who  whose keys it has, where the network has keys
std::string domain_xml(const FleetNetwork& network, std::optional<int> receive_priority = {},
                       Identity who = Identity::flyer);

/// The domain and one participant in it; both end with it. One of a number at a time in a program.
class Domain {
 public:
  /// @throws std::runtime_error where it cannot be had: no such interface, or another one of this number in the program
  /// @throws std::invalid_argument as check_keys(), where the network has keys
  explicit Domain(const FleetNetwork& network, std::optional<int> receive_priority = {},
                  Identity who = Identity::flyer);
  ~Domain();
  Domain(const Domain&) = delete;
  Domain& operator=(const Domain&) = delete;

  dds_entity_t participant() const { return participant_; }
  /// One more, as of another program; ends with the domain.
  dds_entity_t another_participant() const;

 private:
  int number_;
  dds_entity_t domain_ = 0, participant_ = 0;
};

/// What Cyclone DDS complained of since the program began: messages that could not be read, above all.
std::int64_t complaints();
/// The last of it, a line.
std::string last_complaint();

}  // namespace sightline::dds
