/// Checks hard distances, walls and zones, also between samples; counts the actions of the barrier and of
/// certified views.
#pragma once

#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sightline/judge.hpp"
#include "sightline/judge/sampled_motion.hpp"
#include "sightline/judge/time_in_force.hpp"
#include "sightline/loop.hpp"
#include "sightline/scenario.hpp"

namespace sightline {

/// Largest excess over one limit and its duration, over a motion given sample by sample.
class LimitRecord {
 public:
  /// @param tolerance  a smaller excess keeps the limit [m]
  explicit LimitRecord(double tolerance) : tolerance_(tolerance) {}

  /// The limit counts from this sample on, first or again.
  /// @param excess   distance beyond the limit, negative inside [m]
  /// @param excused  true: if the excess is positive, the limit is judged only after it is first
  ///   kept
  void begin(double time, double excess, bool excused) noexcept;
  /// Continues to the next sample.
  /// @param most  largest excess since the previous sample and its time; at least `excess`
  /// @return true if the limit was broken in between
  bool move(double time, double excess, const Extreme& most) noexcept;
  /// Stops until the next begin(). A limit that was exceeded at the start and never kept counts as
  /// broken.
  void cease() noexcept;
  /// Stops like cease(), but discards an excess at the start: a landing robot is expected to pass
  /// the floor.
  void pause() noexcept { counts_ = excused_ = false; }

  bool counts() const noexcept { return counts_; }
  /// False also if the limit was exceeded at the start and never kept.
  bool kept() const noexcept { return !(worst_.value > tolerance_) && !excused_; }
  /// True if the limit never counted.
  bool empty() const noexcept { return !(std::isfinite(worst().value)); }
  /// Largest judged excess and its time.
  const Extreme& worst() const noexcept { return excused_ ? start_ : worst_; }
  /// Time beyond the limit [s]: that of the violation, or that of an excused start.
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

/// Judges distances and walls over the motion between samples (SampledMotion); the only judge of
/// both.
class SafetySummary {
 public:
  /// @param d_hard_otherwise  for pairs without d_hard in the scenario [m]; 0: not judged
  /// @param start_outside     as Safety::start_outside; true overrides the scenario
  explicit SafetySummary(const Scenario& scenario, double d_hard_otherwise = 0.0, bool start_outside = false);

  /// Call before the first sample, and before a sample in which bodies join. New pairs that cannot
  /// brake in time for d_hard do not count as too close.
  /// @param braking  deceleration [m/s^2], > 0
  void look_at_brakes(std::span<const Sight<double>> sights, std::span<const Presence> presence,
                      double braking) noexcept;
  /// Adds a sample. A robot that lands or is grounded has no floor.
  /// @param sights  true states of all bodies at the sample; absent bodies do not count
  void add(const Sample& sample, std::span<const Sight<double>> sights) noexcept;

  /// A robot and another body.
  struct Pair {
    BodyId a, b;
    double d_hard;                                                ///< [m]; 0: none
    LimitRecord limit;                                            ///< of d_hard
    Extreme least{std::numeric_limits<double>::infinity(), 0.0};  ///< minimum distance so far
    TimeInForce in_force{};                                       ///< while both are present
    bool there = false, met = false, could_brake = true;          ///< of both; see look_at_brakes()
  };
  const std::vector<Pair>& pairs() const { return pairs_; }
  /// Over all pairs [m]; infinite if no two bodies were ever present together.
  double least_distance() const;

  /// Floor, ceiling, bounds of the world or a zone for one robot.
  struct Bound {
    enum class Of { floor, ceiling, world, zone };
    BodyId robot;
    Of of;
    double value;  ///< [m]; 0 for a zone
    LimitRecord limit;
    std::size_t zone = 0;  ///< index
    bool was_there = false, was_landing = false;
    /// Height, or |p_x| or |p_y|, at the largest excess [m]; the least reserve of a zone.
    double worst() const;
  };
  const std::vector<Bound>& bounds() const { return bounds_; }

  /// True if a pair that could brake came closer than d_hard: since the previous sample; ever.
  bool too_close_now() const { return too_close_now_; }
  bool too_close() const { return too_close_; }
  /// True if all pairs could brake when they were first present.
  bool could_brake() const;
  /// Least distance beyond d_hard, of the pairs that could brake at the start [m]; < 0 only if
  /// too_close(); NaN: none is judged.
  double distance_margin() const;

  /// One sentence for each broken hard distance and each broken wall or zone, worst first, at most
  /// eight of each.
  std::vector<std::string> broken() const;
  std::vector<std::string> broken_walls() const;

  /// Largest share, over the robots, of updates with a barrier conflict [-]; NaN without a barrier.
  double conflict_share() const;
  /// Of the certified views, in the order of the scenario.
  std::vector<RobotView> views() const;

  /// Value of `safety` in summary.json; empty if the scenario sets no limit and no barrier.
  std::string json() const;

 private:
  struct Robot {
    std::int64_t active = 0, conflicts = 0;  // updates
  };
  struct View {
    BodyId observer, target;
    std::size_t robot;                                       // index
    double speed;                                            // that is certified [m/s]
    std::int64_t updates = 0, certified = 0, active = 0;     // in force; and of these
    std::int64_t uncertified = 0;                            // events
    double least = std::numeric_limits<double>::infinity();  // reserve while certified [m]
    bool was_in_force = false;                               // in the last update
    bool is_in_force(const Sample& sample) const {
      return robot < sample.views.size() && sample.views[robot].target == target;
    }
    /// Whether its observer has no view any more.
    bool ends(const Sample& sample) const {
      return robot < sample.views.size() && sample.views[robot].target.index < 0;
    }
  };
  std::vector<Pair> by_margin() const;
  std::vector<Bound> by_excess() const;
  std::string broken_zone(const Bound& bound) const;
  void add_pair(Pair& pair, const Sample& sample, std::span<const Sight<double>> sights) noexcept;
  void add_bound(Bound& bound, const Sample& sample, std::span<const Sight<double>> sights) noexcept;

  std::vector<std::string> names_;  // of all bodies
  BarrierMode mode_ = BarrierMode::off;
  bool start_outside_ = false;
  SampledMotion motion_;
  std::vector<Pair> pairs_;
  std::vector<Bound> bounds_;
  std::vector<Zone> zones_, zones_to_land_;  // the latter without the floors of rooms
  std::vector<Robot> robots_;
  std::vector<View> views_;
  std::int64_t samples_ = 0, unseen_ = 0;  // updates; periods without known truth
  bool too_close_now_ = false, too_close_ = false;
  double period_;  // [s]
};

/// Describes `safety` of a summary.json: pairs of name and value.
/// @throws nlohmann::json::exception if the text is not such a value
std::vector<std::pair<std::string, std::string>> safety_lines(std::string_view json);

}  // namespace sightline
