/// Robots that move steadily away from their task until the end of a run.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "sightline/judge/present_team.hpp"
#include "sightline/ocp/active_team.hpp"
#include "sightline/ocp/team.hpp"

namespace sightline {

/// Looks at a run once a second.
///
/// Horizontally and vertically, judged apart, a robot's task is to be at its reference where its Q weighs its
/// position. Else the robot follows the bodies of its couplings: its anchors are the bodies that it reaches
/// along couplings, from who feels them to the other, and that are no free robots themselves. Without any it
/// has to stay where it is.
///
/// It drifts where in each second of the last half of its time, 5 to 10 s, its distance grew from its
/// reference, or else from all its anchors, from where these were as from where they are: so one that follows,
/// or that is left behind, does not. What counts as growth is 0.02 m/s, twenty times the motion of a team that
/// has come to rest, and 0.3 times the speed of a reference or anchor that moves itself, about which a robot
/// swings without leaving it; in the last second also half of the mean: one that comes to rest slowly does not
/// drift.
class Drift {
 public:
  /// @param settle  nothing counts before [s]
  Drift(const Team& team, double settle);

  /// Takes the next sample: the one judge of drift. A robot that lands is not steered from then on.
  /// @param sights   of all bodies at the sample
  /// @param present  the team as it is at the sample
  void add(const Sample& sample, std::span<const Sight<double>> sights, const PresentTeam& present);

  /// Whether the next second has come.
  bool due(double time) const noexcept;
  /// @param sights    of all bodies
  /// @param presence  of all bodies
  /// @param agents    of all bodies: the robot as it is tuned now, or none where it is not steered
  void mark(double time, std::span<const Sight<double>> sights, std::span<const Presence> presence,
            std::span<const Agent* const> agents);
  /// The team is another one: what was so far does not count.
  void restart(std::span<const Coupling> couplings);

  struct Found {
    BodyId robot;
    Vec3<double> v;       ///< mean velocity of that time, in G [m/s]
    bool from_reference;  ///< it has one that it leaves
  };
  /// The fastest first. None: the run was too short to judge.
  std::optional<std::vector<Found>> found() const;

 private:
  static constexpr std::size_t seconds_min = 5, marks_max = 11;  // 10 s and the begin of the first
  enum Group { horizontal, vertical };
  struct Place {
    bool there = false, free = false;  // free: a robot that is steered
    Vec3<double> p, requested;         // [m]; asked: p along the axes that are not
    std::array<bool, 3> axes{};        // that are asked for
    bool moves = false;                // asked for a velocity
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
  std::vector<std::vector<std::size_t>> felt_;  // bodies, by who feels a coupling with them
  std::array<Mark, marks_max> marks_;
  std::size_t count_ = 0;    // of all marks there were; the last ones are kept
  std::vector<bool> lands_;  // of all bodies
  std::vector<double> x_ref_, x_;
};

}  // namespace sightline
