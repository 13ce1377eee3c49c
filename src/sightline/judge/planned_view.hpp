/// View angles and tilts as they were planned, against those that were flown.
#pragma once

#include <cmath>
#include <cstdint>
#include <deque>
#include <optional>

#include "sightline/judge/present_team.hpp"

namespace sightline {

/// Gives samples room for planned inputs, Sample::path_u, where a robot leans: its lean follows from them.
/// @param prototype  of sized_sample()
void make_room_for_plans(const Scenario& scenario, Sample& prototype);

/// A number of the plan against the flown one. In each sample with a predicted path the plan's for `ahead` later is kept, on a
/// line between two stages, and compared with the flown one of that time.
class PlannedAhead {
 public:
  static constexpr double ahead = 0.2;  ///< [s]

  /// @param flown     the true one at the sample
  /// @param counts    whether the sample is judged; else it is planned from alone
  /// @param at_stage  what is planned at a stage of the sample's path
  template <class AtStage>
  void add(const Sample& sample, double flown, bool counts, AtStage&& at_stage) {
    compare(sample.time, flown, counts);
    const auto place = place_in(sample);
    if (!place) return;
    const double here = at_stage(place->stage), next = at_stage(place->stage + 1);
    planned_.push_back({sample.time + ahead, here + place->share * (next - here)});
  }

  /// Of what was compared, not a number of nothing: root mean square of flown minus planned, mean and greatest planned.
  double rms() const;
  double mean() const;
  double max() const;

 private:
  struct Planned {
    double time, value;  // [s]
  };
  struct Place {
    std::size_t stage;
    double share;  // of the way to the next
  };

  void compare(double time, double flown, bool counts);
  static std::optional<Place> place_in(const Sample& sample);

  std::deque<Planned> planned_;  // not yet flown
  double squares_ = 0.0, sum_ = 0.0, max_ = 0.0;
  std::int64_t compared_ = 0;
};

/// Of one observer and its target, the view angle [rad].
class PlannedView : public PlannedAhead {
 public:
  void add(const Team& team, const Observation& pair, const Sample& sample, double flown, bool counts);
};

/// Of one robot, its tilt [rad].
class PlannedTilt : public PlannedAhead {
 public:
  void add(const Team& team, BodyId robot, const Sample& sample, double flown, bool counts);
};

}  // namespace sightline
