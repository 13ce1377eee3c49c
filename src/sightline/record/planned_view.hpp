/// A view angle as it was planned, against the one that was flown.
#pragma once

#include <cstdint>
#include <deque>

#include "sightline/record/present_team.hpp"

namespace sightline {

/// Gives samples room for planned inputs, Sample::path_u, where a camera is fixed to a robot's body: its lean follows from them.
/// @param prototype  of sized_sample()
void make_room_for_plans(const Scenario& scenario, Sample& prototype);

/// Of one observer and its target. In each sample with a predicted path the plan's angle for `ahead` later is kept, on a line
/// between two stages, and compared with the flown one of that time.
class PlannedView {
 public:
  static constexpr double ahead = 0.2;  ///< [s]

  /// @param flown   the true angle at the sample [rad]
  /// @param counts  whether the sample is judged; else it is planned from alone
  void add(const Team& team, const Observation& pair, const Sample& sample, double flown, bool counts);

  /// Root mean square of flown minus planned [rad]; not a number where none was compared.
  double rms() const;

 private:
  struct Planned {
    double time, angle;  // [s], [rad]
  };

  std::deque<Planned> planned_;  // not yet flown
  double squares_ = 0.0;
  std::int64_t compared_ = 0;
};

}  // namespace sightline
