/// Whether the hard distances and the walls were kept, also between samples, and what the barrier did: gathered sample by sample.
#pragma once

#include <cmath>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sightline/judge/sampled_motion.hpp"
#include "sightline/judge/time_in_force.hpp"
#include "sightline/run/sample.hpp"
#include "sightline/scenario/scenario.hpp"

namespace sightline {

/// How far something was beyond a limit, and for how long, over a motion that is given from sample to sample.
class LimitRecord {
 public:
  /// @param tolerance  what is beyond by no more keeps the limit [m]
  explicit LimitRecord(double tolerance) : tolerance_(tolerance) {}

  /// At the first sample at which the limit counts, or counts again.
  /// @param excess   by how much it is beyond, negative where there is room [m]
  /// @param excused  where it begins beyond, the limit is judged from when it is first kept
  void begin(double time, double excess, bool excused) noexcept;
  /// Up to the next sample.
  /// @param most  the greatest excess since the sample before, and when; at least `excess`
  /// @return whether the limit was broken meanwhile
  bool move(double time, double excess, const Extreme& most) noexcept;
  /// Until it begins again. One that began beyond and was never kept is broken.
  void cease() noexcept;
  /// The same, and whatever it was it is forgiven: what lands is meant to come down.
  void pause() noexcept { counts_ = excused_ = false; }

  bool counts() const noexcept { return counts_; }
  /// One that began beyond and never kept it has broken it too.
  bool kept() const noexcept { return !(worst_.value > tolerance_) && !excused_; }
  /// Never counted.
  bool empty() const noexcept { return !(std::isfinite(worst().value)); }
  /// The greatest excess that is judged, and when.
  const Extreme& worst() const noexcept { return excused_ ? start_ : worst_; }
  /// Time beyond the limit: where that breaks it, and at a start that is excused [s].
  double broken_for() const noexcept { return excused_ ? outside_for_ : broken_for_; }
  double outside_at_start() const noexcept { return outside_for_; }
  bool never_within() const noexcept { return excused_; }

 private:
  bool raise(const Extreme& most) noexcept;

  double tolerance_;
  bool counts_ = false, excused_ = false;
  double time_ = 0.0, excess_ = 0.0;  // at the last sample
  Extreme worst_{-std::numeric_limits<double>::infinity(), 0.0}, start_ = worst_;
  double broken_for_ = 0.0, outside_for_ = 0.0;
};

/// What keeps apart, over the motion between samples (SampledMotion): the one judge of distances and walls.
class SafetySummary {
 public:
  /// @param d_hard_otherwise  of pairs of which the scenario asks nothing [m]; 0: those are not judged
  /// @param start_outside     as Safety::start_outside, also where the scenario does not say so
  explicit SafetySummary(const Scenario& scenario, double d_hard_otherwise = 0.0, bool start_outside = false);

  /// Before the first sample, and before one with which bodies join: pairs that are new and cannot brake in time for d_hard
  /// do not count as too close.
  /// @param braking  [m/s^2], > 0
  void look_at_brakes(std::span<const Sight<double>> sights, std::span<const Presence> presence,
                      double braking) noexcept;
  /// A robot that lands or is grounded has no floor.
  /// @param sights  true ones of all bodies at the sample; those that are absent do not count
  void add(const Sample& sample, std::span<const Sight<double>> sights) noexcept;

  /// A robot and another body.
  struct Pair {
    BodyId a, b;
    double d_hard;                                                ///< [m]; 0: none
    LimitRecord limit;                                            ///< d_hard
    Extreme least{std::numeric_limits<double>::infinity(), 0.0};  ///< distance so far
    TimeInForce in_force{};                                       ///< while both were there
    bool there = false, met = false, could_brake = true;          ///< both; see look_at_brakes()
  };
  const std::vector<Pair>& pairs() const { return pairs_; }
  /// Of all pairs [m]; infinite where no two were ever there.
  double least_distance() const;

  /// The floor, the ceiling or the bounds of the world for one robot.
  struct Bound {
    enum class Of { floor, ceiling, world };
    BodyId robot;
    Of of;
    double value;  ///< [m]
    LimitRecord limit;
    bool was_there = false;
    /// The height, or the greatest |p_x| and |p_y|, of the greatest excess [m].
    double worst() const;
  };
  const std::vector<Bound>& bounds() const { return bounds_; }

  /// A pair that could brake came nearer than d_hard: since the sample before; ever.
  bool too_close_now() const { return too_close_now_; }
  bool too_close() const { return too_close_; }
  /// All pairs, when they first were there.
  bool could_brake() const;

  /// A sentence for each hard distance and each wall that was broken; the worst first, at most eight of each.
  std::vector<std::string> broken() const;
  std::vector<std::string> broken_walls() const;

  /// Largest share of the updates in which the barrier found a conflict for one robot; not a number without a barrier.
  double conflict_share() const;

  /// The value of `safety` in summary.json; empty where the scenario asks for nothing.
  std::string json() const;

 private:
  struct Robot {
    std::int64_t active = 0, conflicts = 0;  // updates
  };
  std::vector<Pair> by_margin() const;
  std::vector<Bound> by_excess() const;
  void add_pair(Pair& pair, const Sample& sample, std::span<const Sight<double>> sights) noexcept;
  void add_bound(Bound& bound, const Sample& sample, std::span<const Sight<double>> sights) noexcept;

  std::vector<std::string> names_;  // of all bodies
  BarrierMode mode_ = BarrierMode::off;
  bool start_outside_ = false;
  SampledMotion motion_;
  std::vector<Pair> pairs_;
  std::vector<Bound> bounds_;
  std::vector<Robot> robots_;
  std::int64_t samples_ = 0, unseen_ = 0;  // updates; periods that nobody saw
  bool too_close_now_ = false, too_close_ = false;
  double period_;  // [s]
};

/// `safety` of a summary.json in words: what, and its value.
/// @throws nlohmann::json::exception where it is none
std::vector<std::pair<std::string, std::string>> safety_lines(std::string_view json);

}  // namespace sightline
