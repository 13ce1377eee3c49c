/// Simulated PX4 diagnostics beyond the flight topics: battery, failsafe flags, layout responses.
#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "bridges/dds/fleet/link.hpp"
#include "bridges/dds/links/px4_layout.hpp"
#include "bridges/dds/simulators/faults.hpp"
#include "bridges/dds/topics/channel.hpp"

namespace sightline::dds {

/// Any thread may call the setters; only the stepping thread calls send().
class Px4VehicleDiagnostics {
 public:
  /// @param faults  of the vehicle; must outlive it
  Px4VehicleDiagnostics(dds_entity_t participant, const Px4Link& link, Faults& faults);

  /// Sends battery, failsafe and estimator flags; called once per second and when the battery
  /// changes.
  void send();

  void set_battery(float remaining) { remaining_ = remaining; }   ///< 0 to 1
  void lose_transmitter(bool lost) { transmitter_lost_ = lost; }  ///< the pilot's transmitter
  void lose_offboard(bool lost) { offboard_lost_ = lost; }        ///< the heartbeats of a flyer
  void lose_origin(bool lost) { origin_lost_ = lost; }            ///< of its estimator, without satellites
  bool has_origin() const { return !origin_lost_; }
  /// Alignment of its estimator in tilt and heading.
  void set_alignment(bool tilt, bool heading) { tilt_ = tilt, heading_ = heading; }
  /// Responds with the layouts of that release.
  void take_layouts_of(int release) { takes_ = release; }

 private:
  void answer(const void* request);

  int release_;
  Faults& faults_;
  std::atomic<int> takes_;
  std::atomic<float> remaining_{0.8F};
  std::atomic<bool> transmitter_lost_{false}, origin_lost_{false}, offboard_lost_{true}, tilt_{true},
      heading_{true};
  Px4Layout battery_, flags_, estimator_;
  std::unique_ptr<FaultyWriter> battery_writer_, flags_writer_, estimator_writer_, response_;
  std::unique_ptr<RawReader> request_;  // last member: destroyed before the writer it responds with
};

}  // namespace sightline::dds
