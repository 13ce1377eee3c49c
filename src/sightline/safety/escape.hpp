/// The best evasive plan against one neighbour, and the distance that it leaves: see barrier.hpp.
///
/// Relative to the centre of the neighbour's ball, a robot that evades with acceleration a is at
///
///   q_a(t) = r + E(t) w + L(t) s + F(t) a - t g,     r = p - c(0)
///
/// plus the height that the plan climbs, if it does. w is the robot's horizontal velocity, g the
/// velocity of the centre. L and s, the present acceleration, are 0 unless the acceleration follows
/// its commands with a lag; then F is less by L.
///
/// The neighbour is within rho(t) = rho0 + speed t + growth t^2 / 2 + spread E(t) of the
/// centre. The search maximises the least f_a(t) = |q_a(t)| - rho(t) over a in a disc |a| <= beta,
/// or over the corners sum of +-g_k of the thrusts g_k. At a given t the best a is the one farthest
/// along q_0(t) = r + E w - t g, so
///
///   max over a of min over t of f_a  <=  min over t of max over a of f_a
///
/// The a of the t that is least on the right is the optimum if both sides are equal, which is
/// checked. If not (two plans are equally good), all corners are tried, or gradient ascent improves
/// the disc's a, from it and from the direction straight away.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "sightline/base.hpp"

namespace sightline {

/// A neighbour's ball and the robot's motion for a plan. S may be a pack of numbers, for several
/// tubes at once.
template <class S>
struct TubeOf {
  Vec3<S> r{};      ///< from the centre to the robot [m]
  Vec2<S> w{};      ///< velocity subject to drag: of the robot, relative to a cooperative neighbour [m/s]
  Vec2<S> s{};      ///< acceleration that decays with the lag [m/s^2]
  Vec3<S> drift{};  ///< velocity of the centre [m/s]
  S climb{};        ///< vertical speed of the robot [m/s], until its height has
  S room{};         ///< changed by this much [m], >= 0
  S beta{};         ///< radius of the disc [m/s^2], used without thrusts
  std::array<Vec2<S>, 4> thrusts{};  ///< g_k [m/s^2]
  int thrust_count = 0;
  S rho0{};                     ///< [m]
  S speed{};                    ///< [m/s]
  S growth{};                   ///< [m/s^2]
  S spread{};                   ///< [m/s]
  Vec2<S> tie{S(1.0), S(0.0)};  ///< evasive direction if no other is defined
};
using Tube = TubeOf<double>;

/// e^(-c t), E and F at one time t, with F' = E and L = L' = 0 without a lag.
template <class S>
struct EscapeShapeOf {
  S e, E, F;
  S F_rate, L{}, L_rate{};
};
using EscapeShape = EscapeShapeOf<double>;

/// The gap of a plan at one time.
struct Touch {
  double gap;         ///< f_a(t) [m]
  double time;        ///< t [s], >= dt
  Vec3<double> n;     ///< from the centre to the robot
  EscapeShape shape;  ///< at t
  bool level;         ///< the plan has climbed or sunk by its full room
  double slope;       ///< f_a'(t) [m/s]
  double curvature;   ///< f_a''(t) [m/s^2]
};

struct Escape {
  double now;      ///< least f_a(t) over 0 <= t < dt, at times at most longest_part apart [m]
  Vec2<double> a;  ///< acceleration of the plan [m/s^2]
  /// The least f_a(t) over t >= dt, and another minimum within 0.1 m of it.
  std::array<Touch, 2> touches;
  std::size_t count;  ///< number of touches

  double later() const { return touches[0].gap; }
  /// B [m].
  double reserve() const { return now < later() ? now : later(); }
};

/// A candidate plan: an acceleration [m/s^2], and a vertical speed [m/s] until the height has
/// changed by room [m].
struct EscapeFlight {
  Vec2<double> a;
  double climb = 0.0, room = 0.0;
};

/// Searches for plans. Does not throw; allocates only during construction. The tubes of one call
/// are those of several neighbours of one robot, with the same thrusts. The results equal those of
/// single calls, bit for bit.
class EscapePlans {
 public:
  using Tubes = std::span<const Tube* const>;

  /// Longest sampling step within a period; the deviation between samples is less than 1 mm [s].
  static constexpr double longest_part = 0.01;
  static constexpr int most_parts = 50;
  /// Number of steps in a period of dt [s].
  static int parts(double dt) noexcept;

  EscapePlans() = default;
  /// @param drag  c [1/s], >= 0
  /// @param dt    period [s], at most most_parts longest_part
  /// @param lag   tau of the acceleration [s], >= 0
  EscapePlans(double drag, double dt, double lag = 0.0);

  /// The best plan at constant height.
  Escape best(const Tube& tube) const noexcept;
  void best(Tubes tubes, std::span<Escape* const> plans) const noexcept;
  /// The plan with one acceleration.
  Escape with(const Tube& tube, const Vec2<double>& a) const noexcept;
  /// The plans of one flight. @return false if a plan leaves less than `wanted` [m], now or at a
  /// time of the grid; then not all plans are found. Values on the grid exceed the reserve, mostly
  /// by less than 0.1 m
  bool with(Tubes tubes, const EscapeFlight& flight, double wanted, std::span<Escape> plans) const noexcept;
  Touch touch(const Tube& tube, const Vec2<double>& a, double t) const noexcept;
  /// Whether a plan at constant height certainly leaves `wanted` [m] at all t >= 0, also between the
  /// times of the grid and after the last. With n the direction from the centre at any one time,
  ///
  ///   f_a(t) >= n . q_a(t) - rho(t),   q_a''(t) = A e^(-c t) + B e^(-t / tau)
  ///
  /// so a tangent bounds f_a from below. Parts of time that it does not show to be safe are halved.
  bool keeps(const Tube& tube, const Vec2<double>& a, double wanted) const noexcept;

  double E(double t) const noexcept;
  double F(double t) const noexcept;                              ///< without the lag
  double longest_time() const noexcept { return t_[times - 1]; }  ///< end of all plans [s]
  double E_longest() const noexcept { return E_[times - 1]; }     ///< at the end of all plans [s]
  EscapeShape shape(double t) const noexcept;
  EscapeShape shape_at_once(double t) const noexcept;  ///< without the lag
  /// Shape of the rest of the plan after the next sample, at touch.time - dt.
  EscapeShape left(const Touch& touch) const noexcept;

 private:
  static constexpr std::size_t times = 24;
  static constexpr double longest = 8.0;  // [s]
  template <class S>
  struct Search;
  /// e^(-c t) and e^(-t / tau) at a time t.
  struct Decay {
    double t, e, late;
  };

  Decay decay(double t) const noexcept;
  bool lags() const noexcept { return lag_ > 0; }
  template <class S>
  EscapeShapeOf<S> without_lag(S t) const noexcept;
  template <class S>
  EscapeShapeOf<S> shape_at(S t) const noexcept;
  /// Calls visit(search, first, count) for packs of tubes, until it returns false.
  template <class Visit>
  void in_packs(Tubes tubes, double climb, double room, Visit visit) const noexcept;
  /// The best of all candidates, for a plan that the search has not proven optimal.
  Escape best_of_all(const Search<double>& search, const Escape& plan) const noexcept;
  /// The best plan of the whole disc, by a search over its directions that includes `found`.
  Escape best_around(const Search<double>& search, const Escape& found) const noexcept;

  double c_ = 0.0, per_c_ = 0.0, dt_ = 0.0, e_back_ = 1.0, lag_ = 0.0;
  std::array<double, times> t_{}, E_{}, F_{}, L_{}, e_{}, F_rate_{}, L_rate_{};
  std::array<Decay, times + 1> ends_{};  // of the parts of [0, longest] around the times of the grid
  // At the times within the period.
  std::size_t between_ = 0;
  std::array<double, most_parts - 1> t_between_{}, E_between_{}, F_between_{}, L_between_{};
};

}  // namespace sightline
