/// A filter that keeps a state in the set S of a ViewCertificate.
///
/// It replaces a command by the nearest one, input by input, after which the state is in S at the
/// next sample, whatever the target does within its bounds. Each input has an interval: across from
/// |v_s| <= V_s, along from r1 and r2, turn from Theta, climb from lo and hi. A reserve may decay by
/// a part rate dt of itself in a period; where the intervals of two reserves then contradict each
/// other, only S itself counts. The next state is that of the model's own step. If a sensor looks
/// aside, two inputs together push along and across.
///
/// Units are SI. Constant after construction: one filter may serve many loops and threads.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "sightline/barrier.hpp"
#include "sightline/base.hpp"
#include "sightline/model.hpp"
#include "sightline/safety/view_certificate.hpp"

namespace sightline {

/// The target as known to the robot.
struct ViewTarget {
  Vec3<double> p{};  ///< position in G [m]
  Vec2<double> v{};  ///< horizontal velocity in G [m/s]; used if the certificate has it measured
};

/// The point that the filter follows where measurements have errors: an estimate that moves towards
/// each measurement, no faster than ViewBounds::known() states. Then it stays within the radius of
/// the target.
class SlowEstimate {
 public:
  SlowEstimate(const ViewBounds& bounds, double dt) noexcept;
  /// The estimate after a measurement [m]; the first one is taken as it is.
  const Vec3<double>& follow(const Vec3<double>& measured) noexcept;

 private:
  double step_, climb_;  // greatest motion in a period; infinite without errors [m]
  bool has_begun_ = false;
  Vec3<double> p_{};
};

/// The observer's state that the filter uses where predictions of it contradict each other by the wind:
/// it moves by the model, and is corrected by no more than the wind of a period. Then it stays within
/// ViewPrediction::lag of the predicted position.
class SlowState {
 public:
  SlowState(const Model& model, const ViewTask& task);
  /// Takes a state (nx) as it is.
  void begin(std::span<const double> x) noexcept;
  /// Moves by the command u (nu) for a period, and towards the state x (nx). Until a first state is
  /// `predicted`, from an earlier measurement, it takes x as it is.
  void follow(std::span<const double> u, std::span<const double> x, bool predicted) noexcept;

  std::span<const double> state() const noexcept { return x_; }
  /// Distance to the predicted position at the last follow() [m], and to the predicted velocity [m/s].
  double lag() const noexcept { return lag_; }
  double velocity_lag() const noexcept { return velocity_lag_; }

 private:
  Model model_;
  double dt_, most_v_, most_p_;                   // greatest corrections of a period [m/s], [m]
  std::vector<std::size_t> position_, velocity_;  // horizontal ones among the states
  bool is_late_ = false;
  double lag_ = 0.0, velocity_lag_ = 0.0;
  std::vector<double> x_;
};

/// Reserves of S in the order of ViewReserve, all >= 0 in S. Bearings are multiplied by r, so all but
/// the last are in m; the last is in m/s.
using ViewReserves = std::array<double, 7>;

struct ViewFilterResult {
  bool active = false;                    ///< the command was changed
  bool certified = false;                 ///< the state is in S, and is in S at the next sample
  double reserve = -infinity;             ///< least of the reserves, of the present state
  ViewReserve least = ViewReserve::near;  ///< which one that is
};

class ViewFilter {
 public:
  /// @param certificate  one that exists, for this model
  /// @throws std::invalid_argument for a certificate that does not exist, for a model of more than
  ///         `most_states` states or `most_inputs` inputs, and for a period beyond `longest_period`
  ViewFilter(const Model& model, const ViewCertificate& certificate);

  static constexpr int most_states = 32, most_inputs = 4;
  static constexpr double longest_period = 0.05;  ///< [s]

  const ViewCertificate& certificate() const noexcept { return certificate_; }

  /// Reserves of S at a state (nx).
  ViewReserves reserves(std::span<const double> x, const ViewTarget& target) const noexcept;

  /// Replaces u by the nearest command that keeps the state in S. From a state outside S it takes
  /// the command that comes nearest to S. Allocates nothing.
  /// @param x  state of the robot (nx)
  /// @param u_min, u_max  present limits (nu)
  /// @param u  the command (nu); afterwards always finite and within the limits
  ViewFilterResult filter(std::span<const double> x, const ViewTarget& target, std::span<const double> u_min,
                          std::span<const double> u_max, std::span<double> u) const noexcept;

  /// The same result for a command that stays as it is.
  ViewFilterResult judge(std::span<const double> x, const ViewTarget& target,
                         std::span<const double> u) const noexcept;

 private:
  struct Place;
  struct Interval;
  struct Period;
  /// What is not known of the motion in a period.
  struct Unknown {
    double moves = 0.0, speeds = 0.0;  // of the target, beyond its known motion [m], [m/s]
    double climbs = 0.0;               // of the target, and error of the robot's climb [m]
    double turns = 0.0;                // error of the robot's heading [rad]
    double bearing(double r) const noexcept;
  };

  Period period(std::span<const double> x, const ViewTarget& target,
                std::span<const double> u) const noexcept;
  Place place(std::span<const double> x, std::span<const double> u, const ViewTarget& target) const noexcept;
  const Place& next(Period& now, std::span<const double> u) const noexcept;
  ViewReserves reserves(const Place& at, const Unknown& unknown) const noexcept;
  double least_gap(const std::vector<double>& heights, double r, double beside, double sign) const noexcept;
  double largest_push(double gap, double v, double u0, double r_per_u, double need) const noexcept;
  void turn(Period& now, std::span<double> u) const noexcept;
  Vec2<double> pushes(std::span<const double> u) const noexcept;
  Interval push_across(const Place& then, double value) const noexcept;
  Interval push_along(const Period& now, const Place& then, double value) const noexcept;
  void push(Period& now, std::span<double> u) const noexcept;
  void climb(Period& now, std::span<double> u) const noexcept;
  ViewFilterResult judge(Period& now, std::span<const double> u) const noexcept;

  Model model_;
  ViewCertificate certificate_;
  double keep_;  // part of a reserve that remains after a period
  Unknown unknown_;
  double E_, F_;     // velocity and displacement per acceleration, along [s], [s^2]
  double E_across_;  // [s]
};

}  // namespace sightline
