/// Whether the hard distances and the walls were kept, and what the barrier did: gathered sample by sample.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sightline/record/time_in_force.hpp"
#include "sightline/run/sample.hpp"
#include "sightline/scenario/scenario.hpp"

namespace sightline {

class SafetySummary {
 public:
  explicit SafetySummary(const Scenario& scenario);

  /// @param sights  true ones of all bodies at `time` [s]; those that are absent do not count
  /// @param levels   of all bodies, or none; a robot that lands or is grounded has no floor
  void add(double time, std::span<const Sight<double>> sights, std::span<const Presence> presence,
           std::span<const BarrierRecord> barriers, std::span<const FallbackLevel> levels = {});

  /// Two bodies, of which one is a robot, that have a hard distance.
  struct Pair {
    BodyId a, b;
    double d_hard;           ///< [m]
    double least2;           ///< square of the least distance so far [m^2]
    double time;             ///< of it [s]
    TimeInForce in_force{};  ///< while both were there
    bool kept() const;
  };
  const std::vector<Pair>& pairs() const { return pairs_; }

  /// The floor, the ceiling or the bounds of the world for one robot. One that begins beyond it, or ceases to land, is
  /// judged from when it is within; one that never comes within has broken it.
  struct Bound {
    enum class Of { floor, ceiling, world };
    BodyId robot;
    Of of;
    double limit;         ///< [m]
    double excess;        ///< greatest since it was within [m]; negative where there always was room
    double time;          ///< of it [s]
    bool counts = false;  ///< now
    bool within = false;  ///< since it counts
    double begun = 0.0;   ///< by how much it was beyond when it began to count [m]
    bool kept() const;
    /// The height, or the greatest |p_x| and |p_y|, of the greatest excess [m].
    double worst() const;
  };
  const std::vector<Bound>& bounds() const { return bounds_; }

  /// A sentence for each hard distance and each wall that was broken; the worst first, at most eight of each.
  std::vector<std::string> broken() const;
  std::vector<std::string> broken_walls() const;

  /// Largest share of the samples in which the barrier told a conflict for one robot; not a number without a barrier.
  double conflict_share() const;

  /// The value of `safety` in summary.json; empty where the scenario asks for nothing.
  std::string json() const;

 private:
  struct Robot {
    std::int64_t active = 0, conflicts = 0;  // samples
  };
  std::vector<Pair> by_margin() const;
  std::vector<Bound> by_excess() const;
  void add_bounds(double time, std::span<const Sight<double>> sights, std::span<const Presence> presence,
                  std::span<const FallbackLevel> levels);

  std::vector<std::string> names_;  // of all bodies
  BarrierMode mode_ = BarrierMode::off;
  std::vector<Pair> pairs_;
  std::vector<Bound> bounds_;
  std::vector<Robot> robots_;
  std::int64_t samples_ = 0;
  double period_;  // [s]
};

/// `safety` of a summary.json in words: what, and its value.
/// @throws nlohmann::json::exception where it is none
std::vector<std::pair<std::string, std::string>> safety_lines(std::string_view json);

}  // namespace sightline
