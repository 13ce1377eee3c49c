/// Detects robots that move steadily away from their task until the end of a run.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "sightline/events.hpp"
#include "sightline/judge/present_team.hpp"
#include "sightline/team.hpp"

namespace sightline {

/// Evaluates a run once per second.
///
/// Horizontal and vertical motion are judged separately. The task of a robot is to be at its
/// reference if its Q weighs its position. Otherwise the robot follows the bodies of its couplings.
/// Its anchors are the bodies that it reaches along couplings, from each affected robot to the
/// other body. An anchor is not steered, or its Q weighs a position or a velocity. The task of a
/// robot without anchors is to stay where it is. A robot whose Q weighs a velocity but no position
/// is not judged.
///
/// The window is the last half of the judged time, at least 5 s and at most 10 s. A robot drifts if
/// its distance grows in each second of the window. The distance is that to its reference, or else
/// to all of its anchors. It must grow from the anchor's previous and from its present position; so
/// a robot that follows or falls behind does not drift.
///
/// Growth must reach 0.02 m/s, twenty times the motion of a team at rest. It must also reach 0.3
/// times the speed of a moving reference or anchor, about which a robot oscillates without leaving
/// it. In the last second growth must also reach half of the mean; so a robot that slows down to
/// rest does not drift.
class Drift {
 public:
  /// @param settle  samples before this time do not count [s]
  Drift(const Team& team, double settle);

  /// Adds the next sample; the only judge of drift. A robot that lands is not steered from then on.
  /// @param sights   of all bodies at the sample
  /// @param present  the team at the sample
  void add(const Sample& sample, std::span<const Sight<double>> sights, const PresentTeam& present);

  /// True if at least 1 s has passed since the last mark.
  bool due(double time) const noexcept;
  /// Adds a mark at `time` [s].
  /// @param sights    of all bodies
  /// @param presence  of all bodies
  /// @param agents    of all bodies: the robot with its present tuning; null if it is not steered
  void mark(double time, std::span<const Sight<double>> sights, std::span<const Presence> presence,
            std::span<const Agent* const> agents);
  /// The team has changed: earlier marks do not count.
  void restart(std::span<const Coupling> couplings);

  struct Found {
    BodyId robot;
    Vec3<double> v;       ///< mean velocity over the window, in G [m/s]
    bool from_reference;  ///< Q weighs a component of the position
  };
  /// Fastest first. Empty optional: the run was too short to judge.
  std::optional<std::vector<Found>> found() const;

 private:
  static constexpr std::size_t seconds_min = 5, marks_max = 11;  // 10 s and the first mark
  enum Group { horizontal, vertical };
  struct Place {
    bool there = false, free = false;  // free: a robot that is steered
    Vec3<double> p, requested;         // [m]; requested: reference on the weighted axes, p on the others
    std::array<bool, 3> axes{};        // axes that Q weighs
    bool moves = false;                // Q weighs a velocity
  };
  struct Mark {
    double time = 0.0;
    std::vector<Place> places;  // of all bodies
  };
  const Mark& mark_of(std::size_t i) const { return marks_[i % marks_max]; }
  Mark& next_mark(double time);
  Place place_of(double time, const Sight<double>& sight, Presence presence, const Agent* agent);
  bool leaves(std::size_t robot, Group group, std::size_t begin) const;

  double settle_;
  std::vector<std::vector<std::size_t>> felt_;  // of each robot, the bodies of the couplings that affect it
  std::array<Mark, marks_max> marks_;
  std::size_t count_ = 0;    // number of all marks; the last marks_max are kept
  std::vector<bool> lands_;  // of all bodies
  std::vector<double> x_ref_, x_;
};

}  // namespace sightline
