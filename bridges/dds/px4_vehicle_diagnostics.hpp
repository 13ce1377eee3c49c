/// What a stand-in for a vehicle of PX4 says beside what it is flown by: battery, failsafe flags, and which layouts it takes.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "bridges/dds/channel.hpp"
#include "bridges/dds/faults.hpp"
#include "bridges/dds/px4_layout.hpp"
#include "sightline/scenario/link.hpp"

namespace sightline::dds {

/// The setters are of any thread; send() is of the one that steps.
class Px4VehicleDiagnostics {
 public:
  /// @param faults  of the vehicle; outlives it
  Px4VehicleDiagnostics(dds_entity_t participant, const Px4Link& link, Faults& faults);

  /// Once a second, and where the battery changes: battery, failsafe flags, estimator's flags.
  void send();

  void set_battery(float remaining) { remaining_ = remaining; }   ///< 0 to 1
  void lose_transmitter(bool lost) { transmitter_lost_ = lost; }  ///< of its pilot
  /// What its estimator has found: what is level, its heading.
  void set_alignment(bool tilt, bool heading) { tilt_ = tilt, heading_ = heading; }
  /// It answers as if what it takes were of that release.
  void take_layouts_of(int release) { takes_ = release; }

 private:
  void answer(const void* request);

  int release_;
  Faults& faults_;
  std::atomic<int> takes_;
  std::atomic<float> remaining_{0.8F};
  std::atomic<bool> transmitter_lost_{false}, tilt_{true}, heading_{true};
  Px4Layout battery_, flags_, estimator_;
  std::unique_ptr<FaultyWriter> battery_writer_, flags_writer_, estimator_writer_, response_;
  std::unique_ptr<RawReader> request_;  // last: it ends before what it answers by
};

}  // namespace sightline::dds
