/// The evasive plan and the distance that it leaves: see barrier.hpp.
///
/// Seen from the centre of where the neighbour may be, the robot that flees with the acceleration a is at
///
///   q_a(t) = r + E(t) w + F(t) a - t g        r = p - c(0), w: horizontal velocity, g: that of the centre
///
/// plus the height that the plan climbs, where it does,
///
/// and the neighbour within rho(t) = rho0 + speed t + growth t^2 / 2 + spread E(t) of the centre. Sought is the a
/// that makes the least f_a(t) = |q_a(t)| - rho(t) greatest, in a disc |a| <= beta, or among the corners
/// sum of +-g_k over the thrusts g_k. At a given t the best a is the one farthest along q_0(t) = r + E w - t g, so
///
///   max over a of min over t of f_a  <=  min over t of max over a of f_a
///
/// and the a of the t that is least on the right is the optimum wherever both sides meet, which is checked;
/// where they do not (two plans are equally good), all corners are tried, or the disc's a is improved by ascent from it
/// and from the direction straight away.
#pragma once

#include <array>

#include "sightline/math/fixed.hpp"

namespace sightline {

/// A neighbour as a plan sees it.
struct Tube {
  Vec3<double> r{};      ///< from the centre to the robot [m]
  Vec2<double> w{};      ///< what drag takes off: velocity of the robot, less that of a member [m/s]
  Vec3<double> drift{};  ///< velocity of the centre [m/s]
  double climb = 0.0;    ///< vertical speed of the robot [m/s], until it has
  double room = 0.0;     ///< risen or sunk by this much [m], >= 0
  double beta = 0.0;     ///< radius of the disc [m/s^2], where there are no thrusts
  std::array<Vec2<double>, 4> thrusts{};  ///< g_k [m/s^2]
  int thrust_count = 0;
  double rho0 = 0.0;       ///< [m]
  double speed = 0.0;      ///< [m/s]
  double growth = 0.0;     ///< [m/s^2]
  double spread = 0.0;     ///< [m/s]
  Vec2<double> tie{1, 0};  ///< where to where nothing else tells it
};

/// e^(-c t), E and F at one t.
struct EscapeShape {
  double e, E, F;
};

/// A plan at one time.
struct Touch {
  double gap;         ///< f_a(t) [m]
  double time;        ///< t [s], >= dt
  Vec3<double> n;     ///< from the centre to the robot
  EscapeShape shape;  ///< at t
  bool level;         ///< the plan climbed or sank, and has done so as far as it may
  double slope;       ///< f_a'(t) [m/s]
  double curvature;   ///< f_a''(t) [m/s^2]
};

struct Escape {
  double now;      ///< f(0) [m]
  Vec2<double> a;  ///< acceleration of the plan [m/s^2]
  /// The least f_a(t) over t >= dt; another least within 0.1 m of it.
  std::array<Touch, 2> touches;
  std::size_t count;  ///< of touches

  double later() const { return touches[0].gap; }
  /// B [m].
  double reserve() const { return now < later() ? now : later(); }
};

class EscapePlans {
 public:
  EscapePlans() = default;
  /// @param drag  c [1/s], >= 0
  /// @param dt    [s], from where on plans are looked at
  EscapePlans(double drag, double dt);

  /// The best plan. Neither throws nor allocates.
  Escape best(const Tube& tube) const noexcept;
  /// The plan with one acceleration.
  Escape with(const Tube& tube, const Vec2<double>& a) const noexcept;
  /// The least f of that plan over now and a grid of times [m]: up to 0.1 m more than its reserve.
  double least(const Tube& tube, const Vec2<double>& a) const noexcept;
  Touch touch(const Tube& tube, const Vec2<double>& a, double t) const noexcept;

  double E(double t) const noexcept;
  double F(double t) const noexcept;
  double E_longest() const noexcept { return E_[times - 1]; }  ///< at the end of all plans [s]
  EscapeShape shape(double t) const noexcept;
  /// At the time less dt.
  EscapeShape left(const Touch& touch) const noexcept;

 private:
  static constexpr std::size_t times = 24;
  static constexpr double longest = 8.0;  // [s]
  using Curve = std::array<double, times>;
  using Shape = EscapeShape;
  struct Point;

  Point at(const Tube& tube, const Vec2<double>& a, double t) const noexcept;
  /// The best of all corners, where one of them is known.
  Escape best_corner(const Tube& tube, Escape best) const noexcept;
  /// Ascent in the disc from a plan and from straight away.
  Escape climbed(const Tube& tube, Escape plan, const Vec2<double>& away) const noexcept;

  /// f + rho0 of horizontal positions x and y.
  Curve curve(const Tube& tube, const Curve& x, const Curve& y) const noexcept;
  Curve along(const Tube& tube, const Vec2<double>& a) const noexcept;
  static std::size_t lowest(const Curve& f) noexcept;
  /// Where f is least around point i of the grid.
  double least_of(const Curve& f, std::size_t i) const noexcept;
  /// The least around point i of the grid.
  Touch nearest(const Tube& tube, const Vec2<double>& a, const Curve& f, std::size_t i) const noexcept;
  Escape refined(const Tube& tube, const Vec2<double>& a, const Curve& f) const noexcept;

  double c_ = 0.0, per_c_ = 0.0, dt_ = 0.0, e_back_ = 1.0;
  Curve t_{}, E_{}, F_{};
};

}  // namespace sightline
