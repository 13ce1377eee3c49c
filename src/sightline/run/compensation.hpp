/// Compensation of command delays and constant disturbances that the planning model omits.
///
/// It acts between the state estimate and the controllers, for the motion
///
///   x' = f(x, u(t - delay)) + push(x, w)
///
/// A command given at t takes effect at t + delay. The controllers therefore plan from the state at
/// t + delay, predicted under the commands in flight. The disturbance w, an acceleration in G, is
/// the part of the measured motion that the commands do not explain. Between two measurements that
/// are s apart
///
///   w <- w + (1 - e^{-s / time}) (v - v') / s,
///
/// where v' is the velocity that the model reaches from the previous measurement, under w. States
/// that are neither pose nor velocity, such as a lagging tilt, follow from the commands alone. A
/// gain error then enters w and leaves no offset. The constant command u_w cancels w:
///
///   B u_w = -w,   B = d v' / d u after the lags have settled,
///
/// in the least-squares sense, with inputs as fractions of their range. It is added to the
/// controllers' inputs. The controllers plan without w and for the remaining command, from a state
/// without the part of the lags that u_w maintains. The effect is that of w in their prediction and
/// of u_w in u*. The tilt due to u_w adds to the tilt of the plan.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "sightline/ocp/team.hpp"
#include "sightline/run/feed_forward.hpp"
#include "sightline/run/valid_states.hpp"
#include "sightline/safety/input_history.hpp"

namespace sightline {

/// Source of a robot's u*.
enum class FeedForwardFrom {
  none,       ///< u* of the team
  reference,  ///< the input with which the robot's model follows its reference: feed_forward.hpp
};
inline constexpr std::array<std::string_view, 2> feed_forwards = {"none", "reference"};

/// Compensation settings of one robot.
struct RobotCompensation {
  BodyId robot;
  double command_delay = 0.0;     ///< from a command to its effect, with an allowance for lags [s], in [0, 1]
  double disturbance_time = 0.0;  ///< time constant of the estimate of w [s], in [0.05, 60]; 0: no estimate
  FeedForwardFrom feed_forward = FeedForwardFrom::none;  ///< source of u*
};

class Compensation {
 public:
  static constexpr double longest_delay = 1.0;                     ///< of a command [s]
  static constexpr double least_time = 0.05, longest_time = 60.0;  ///< time constants of the estimate [s]
  /// Greatest fraction of an input's half range that u_w uses.
  static constexpr double most_part = 0.8;

  /// @param period  shortest time between two commands [s]; sizes the input history
  /// @throws std::invalid_argument for a body that is no robot of the team, for a robot that is
  ///         named twice, and for numbers out of their range
  Compensation(const Team& team, const std::vector<RobotCompensation>& robots, double period);

  // The loop calls these functions once each period, in this order. None throws, allocates, locks or
  // prints.

  /// Takes a measurement of a robot. Ignores one that is invalid or not newer than the last.
  void look(BodyId robot, const ValidStates& measured) noexcept;
  /// The states (nx) at which the commands of t take effect. For a robot: after its own delay,
  /// without the part that u_w maintains. For other bodies: after the longest delay. Valid until
  /// the next call.
  /// @param estimate  states at t (nx)
  std::span<const double> ahead(double t, const ValidStates& estimate) noexcept;
  /// u_w of all robots (nu), to be added to the controllers' inputs.
  std::span<const double> added() const noexcept { return added_; }
  /// The part of the states of all bodies (nx) that u_w maintains; ahead() subtracts it.
  std::span<const double> held() const noexcept { return held_; }
  /// Tilt of each body (Sight::lean) due to u_w, in addition to that of the controllers' inputs.
  std::span<const Vec2<double>> lean() const noexcept { return lean_; }
  /// Writes a robot's u* (nu) at time t [s] and state x (nx of the robot), if it follows from the
  /// reference; else leaves u_ref unchanged.
  void write_reference_inputs(BodyId robot, const Reference& x_ref, double t, const double* x,
                              std::span<double> u_ref) noexcept;
  /// Records the inputs u of all robots (nu) that are given at t [s].
  void record(double t, std::span<const double> u) noexcept { history_.record(t, u); }
  /// Discards all knowledge of a robot that joins the team.
  void forget(BodyId robot) noexcept;

  /// Longest command delay of all robots [s].
  double lead() const noexcept { return lead_; }
  /// The estimated disturbance of a robot [m/s^2], in G; 0 without an estimate.
  Vec3<double> disturbance(BodyId robot) const noexcept;

 private:
  /// A body whose state is compensated, or only predicted.
  struct Member {
    std::size_t body, x, u, nx, nu;  // index in the team, offsets and lengths
    Model model;
    double delay, time;
    std::vector<double> counter;      // u_w over reach, for 1 m/s^2 along x, y, z of V, or of G: 3 x nu
    std::vector<double> held;         // steady-state change of each state per unit of an input: nu x nx
    std::vector<Vec2<double>> leans;  // steady-state tilt per unit of each input
    std::optional<FeedForward> feed_forward;
    std::vector<char> shown;    // whether each state is part of pose or velocity; others follow commands
    std::vector<double> reach;  // half the range of each input
    std::vector<double> last;   // previous measurement, with predicted inner states
    double stamp;               // time of `last` [s]; minus infinity: none
    Vec3<double> w{};
  };

  static void find_counter(Member& member, const Agent& agent);
  void find_steady(const Member& member, std::span<const double> x) noexcept;

  std::vector<Member> members_;
  std::vector<int> member_of_;  // index into members_ for each body; -1: none
  InputHistory history_;
  double lead_;
  std::vector<double> x_, scratch_, added_, held_;
  std::vector<Vec2<double>> lean_;
};

}  // namespace sightline
