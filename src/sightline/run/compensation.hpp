/// What a robot's planning model leaves out, made up for between the state estimate and the controllers: commands that
/// act late, and an acceleration that nobody commanded.
///
///   x' = f(x, u(t - delay)) + push(x, w)
///
/// A command given at t comes into force at t + delay. So the controllers are given the state of that time, carried on
/// under the commands in flight, and plan from there. The disturbance w, an acceleration of G, is what the commands do not
/// explain of the measured motion: between two measurements s apart
///
///   w <- w + (1 - e^{-s / time}) (v - v') / s,
///
/// v' being the velocity that the model reaches from the measurement before, under w. States that are neither pose nor
/// velocity, such as a lagging tilt, follow from the commands alone there: an error of a gain then enters w, and leaves no
/// offset. The constant command u_w that cancels w,
///
///   B u_w = -w,   B = d v' / d u once the lags are over, least squares, inputs in parts of their range,
///
/// is added to what the controllers ask for. They plan without w and for the rest of the command, from a state without what
/// u_w holds of the lags: as if w were both in their prediction and, as u_w, in u*. What u_w makes a robot lean, its plan
/// leans besides.
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

/// What a robot's u* follows from.
enum class FeedForwardFrom {
  none,       ///< it is the team's
  reference,  ///< it is the input by which the robot's model follows its reference: feed_forward.hpp
};
inline constexpr std::array<std::string_view, 2> feed_forwards = {"none", "reference"};

/// Of one robot.
struct RobotCompensation {
  BodyId robot;
  double command_delay = 0.0;     ///< from command to effect, and what stands for lags [s], in [0, 1]
  double disturbance_time = 0.0;  ///< of the estimate of w [s], in [0.05, 60]; 0: none
  FeedForwardFrom feed_forward = FeedForwardFrom::none;  ///< what its u* follows from
};

class Compensation {
 public:
  static constexpr double longest_delay = 1.0;                     ///< [s]
  static constexpr double least_time = 0.05, longest_time = 60.0;  ///< of an estimate [s]
  /// Most that u_w takes of what an input can do either way.
  static constexpr double most_part = 0.8;

  /// @param period  shortest time between two commands [s]; sizes the memory of inputs
  /// @throws std::invalid_argument for a body that is no robot of the team, one that is named twice, and numbers out of
  /// their range
  Compensation(const Team& team, const std::vector<RobotCompensation>& robots, double period);

  // Once in each period, in this order. Nothing throws, allocates, locks or prints.

  /// A measurement of a robot. Where it is not valid, or not newer than the last, nothing happens.
  void look(BodyId robot, const ValidStates& measured) noexcept;
  /// The states (nx) that commands of t meet: those of robots after their delay, free of what u_w holds; those of bodies
  /// that are no robots after the longest of them. Valid until the next call.
  /// @param estimate  the states at t
  std::span<const double> ahead(double t, const ValidStates& estimate) noexcept;
  /// u_w of all robots (nu), to be added to what is asked of them.
  std::span<const double> added() const noexcept { return added_; }
  /// What u_w holds of the states of all bodies (nx), which those of ahead() are free of.
  std::span<const double> held() const noexcept { return held_; }
  /// What u_w makes each body lean (Sight::lean), beside what the controllers ask for.
  std::span<const Vec2<double>> lean() const noexcept { return lean_; }
  /// Writes a robot's u* (nu) at time t [s] and state x (nx of the robot), where it follows from its reference; else nothing.
  void write_reference_inputs(BodyId robot, const Reference& x_ref, double t, const double* x,
                              std::span<double> u_ref) noexcept;
  /// The inputs u of all robots (nu) are given at t.
  void record(double t, std::span<const double> u) noexcept { history_.record(t, u); }
  /// The robot comes to be there: nothing is known of it.
  void forget(BodyId robot) noexcept;

  /// Longest delay of a robot [s].
  double lead() const noexcept { return lead_; }
  /// The estimated disturbance of a robot [m/s^2], in G; 0 without an estimate.
  Vec3<double> disturbance(BodyId robot) const noexcept;

 private:
  /// A body, compensated or carried on.
  struct Member {
    std::size_t body, x, u, nx, nu;  // place in the team, offsets and lengths
    Model model;
    double delay, time;
    std::vector<double> counter;      // u_w over reach, of 1 m/s^2 along x, y, z of V, or else of G: 3 x nu
    std::vector<double> held;         // what a unit of an input holds of each state in the end: nu x nx
    std::vector<Vec2<double>> leans;  // what a unit of each input makes it lean then
    std::optional<FeedForward> feed_forward;
    std::vector<char> shown;    // whether each state is a pose or a velocity; the others follow from commands
    std::vector<double> reach;  // what each input can do either way
    std::vector<double> last;   // measured before, with own inner states
    double stamp;               // of last; minus infinity: none
    Vec3<double> w{};
  };

  static void find_counter(Member& member, const Agent& agent);
  void find_steady(const Member& member, std::span<const double> x) noexcept;

  std::vector<Member> members_;
  std::vector<int> member_of_;  // of each body; -1: none
  InputHistory history_;
  double lead_;
  std::vector<double> x_, scratch_, added_, held_;
  std::vector<Vec2<double>> lean_;
};

}  // namespace sightline
