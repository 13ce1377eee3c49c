/// Compares planned with flown view angles and tilts.
#pragma once

#include <cmath>
#include <cstdint>
#include <deque>
#include <optional>

#include "sightline/judge/present_team.hpp"

namespace sightline {

/// Allocates Sample::path_u, the planned inputs, if a robot of the scenario tilts; its tilt depends
/// on them.
/// @param prototype  result of sized_sample()
void make_room_for_plans(const Scenario& scenario, Sample& prototype);

/// Compares a planned value with the flown one. Each sample with a predicted path stores the
/// planned value at `ahead` later, linearly interpolated between two stages. The stored value is
/// compared with the flown one at that time.
class PlannedAhead {
 public:
  static constexpr double ahead = 0.2;  ///< [s]

  /// @param flown     true value at the sample
  /// @param counts    true if the sample is judged; otherwise only its planned value is stored
  /// @param at_stage  gives the planned value at a stage of the sample's path
  template <class AtStage>
  void add(const Sample& sample, double flown, bool counts, AtStage&& at_stage) {
    compare(sample.time, flown, counts);
    const auto place = place_in(sample);
    if (!place) return;
    const double here = at_stage(place->stage), next = at_stage(place->stage + 1);
    planned_.push_back({sample.time + ahead, here + place->share * (next - here)});
  }

  /// Statistics of the comparisons, NaN if there were none: root mean square of flown minus
  /// planned; mean and maximum of planned.
  double rms() const;
  double mean() const;
  double max() const;

 private:
  struct Planned {
    double time, value;  // [s]
  };
  struct Place {
    std::size_t stage;
    double share;  // fraction of the interval to the next stage
  };

  void compare(double time, double flown, bool counts);
  static std::optional<Place> place_in(const Sample& sample);

  std::deque<Planned> planned_;  // not flown yet
  double squares_ = 0.0, sum_ = 0.0, max_ = 0.0;
  std::int64_t compared_ = 0;
};

/// View angle of one observer and its target [rad].
class PlannedView : public PlannedAhead {
 public:
  void add(const Team& team, const Observation& pair, const Sample& sample, double flown, bool counts);
};

/// Tilt of one robot [rad].
class PlannedTilt : public PlannedAhead {
 public:
  void add(const Team& team, BodyId robot, const Sample& sample, double flown, bool counts);
};

}  // namespace sightline
