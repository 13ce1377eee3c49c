/// The interface between a loop and its world, commands and their bounds, disturbances, motions and injected faults.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "sightline/base.hpp"
#include "sightline/estimator.hpp"
#include "sightline/events.hpp"
#include "sightline/model.hpp"
#include "sightline/potential.hpp"
#include "sightline/team.hpp"

namespace sightline {

// Commands: the last stage before World::apply(), and the only place that bounds the inputs.
//
//   limits   u_min(t) <= u <= u_max(t), in force at t: always
//   rates    |u - u'| <= rate_max dt, u' applied one period before: as far as the limits allow
//
// Limits take precedence over rates: when a limit tightens beyond an input, the input follows the
// limit at once. The first stage of a plan uses the same interval, clamp(u' -+ rate_max dt, u_min,
// u_max).

/// Inputs of all robots (nu), finite and within the limits in force. Only a CommandGate creates
/// Commands, so a World receives no others. Valid until the gate's next pass().
class Command {
 public:
  std::size_t size() const noexcept { return u_.size(); }
  const double* data() const noexcept { return u_.data(); }
  const double* begin() const noexcept { return u_.data(); }
  const double* end() const noexcept { return u_.data() + u_.size(); }
  double operator[](std::size_t i) const noexcept { return u_[i]; }

 private:
  friend class CommandGate;
  explicit Command(std::span<const double> u) noexcept : u_(u) {}

  std::span<const double> u_;
};

/// Creates the commands of one team. After construction nothing here allocates, locks, throws or
/// prints.
class CommandGate {
 public:
  /// Each robot starts with its own limits. Until the first pass() its applied input is u*, clamped
  /// to those limits.
  /// @param period  between two commands [s]
  CommandGate(const Team& team, double period);
  CommandGate(const CommandGate&) = delete;
  CommandGate& operator=(const CommandGate&) = delete;

  /// Sets the limits in force from now on, one per robot in team order. They must outlive the next
  /// call.
  void set_limits(std::span<const InputLimits> limits) noexcept;

  // Called once in each period, in this order.

  /// Evaluates the limits in force at t [s].
  void open(double t) noexcept;
  /// Projects the inputs u (nu) onto the limits and rates.
  /// @param added  offset added to u afterwards (nu); limits and rates hold for the sum. Empty: no
  /// offset
  void keep_limits_and_rates(std::span<double> u, std::span<const double> added) const noexcept;
  /// Returns the command u + added. If an input of a robot is not finite, the robot keeps its
  /// previous inputs. Inputs beyond a limit are clamped.
  Command pass(std::span<const double> u, std::span<const double> added) noexcept;

  /// Robots whose inputs the last pass() replaced.
  std::span<const BodyId> replaced() const noexcept { return replaced_; }
  /// The command of the last pass().
  Command applied() const noexcept { return Command(applied_); }
  /// Writes a robot's u*, clamped to its limits at t [s], into the inputs u of all robots (nu).
  void rest(BodyId robot, double t, std::span<double> u) noexcept;

 private:
  struct Robot {
    BodyId body;
    std::size_t u, nu;  // offset and length
    const InputLimits* limits;
  };
  const Agent& agent(const Robot& robot) const noexcept { return team_.agent(robot.body); }

  Team team_;
  double period_;  // [s]
  std::vector<Robot> robots_;
  std::vector<double> u_min_, u_max_, applied_;  // of all robots (nu)
  std::vector<BodyId> replaced_;
};

// One rigid body: position and attitude in G, and its motion under forces and torques.

inline Vec3<double> cross(const Vec3<double>& a, const Vec3<double>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Attitude: rotates coordinates from the body frame B to G. |q| = 1.
struct Quaternion {
  double w = 1.0, x = 0.0, y = 0.0, z = 0.0;

  bool operator==(const Quaternion&) const = default;
};
/// Placeholder for an unknown attitude.
inline constexpr Quaternion no_attitude = {0.0, 0.0, 0.0, 0.0};

/// Attitude as a matrix, by its columns: the axes of B in G.
struct Rotation {
  Vec3<double> x{1, 0, 0}, y{0, 1, 0}, z{0, 0, 1};

  Vec3<double> to_G(const Vec3<double>& a_B) const { return a_B.x * x + a_B.y * y + a_B.z * z; }
  Vec3<double> to_B(const Vec3<double>& a_G) const { return {dot(x, a_G), dot(y, a_G), dot(z, a_G)}; }
};

inline Rotation rotation(const Quaternion& q) {
  const double xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z;
  const double xy = q.x * q.y, xz = q.x * q.z, yz = q.y * q.z, wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
  return {{1 - 2 * (yy + zz), 2 * (xy + wz), 2 * (xz - wy)},
          {2 * (xy - wz), 1 - 2 * (xx + zz), 2 * (yz + wx)},
          {2 * (xz + wy), 2 * (yz - wx), 1 - 2 * (xx + yy)}};
}

/// The rotation whose columns are those of a matrix.
inline Rotation rotation_from(const Mat<3, 3>& R) {
  const auto column = [&](int j) { return Vec3<double>{R(0, j), R(1, j), R(2, j)}; };
  return {column(0), column(1), column(2)};
}

/// Composition: R_GB and R_BC to R_GC.
inline Rotation compose(const Rotation& R_GB, const Rotation& R_BC) {
  return {R_GB.to_G(R_BC.x), R_GB.to_G(R_BC.y), R_GB.to_G(R_BC.z)};
}
/// R_AB, the attitude of B relative to A, from the attitudes of both in G.
inline Rotation between(const Rotation& R_GA, const Rotation& R_GB) {
  return {R_GA.to_B(R_GB.x), R_GA.to_B(R_GB.y), R_GA.to_B(R_GB.z)};
}
/// Rotation by |w| [rad] about w.
inline Rotation turn_by(const Vec3<double>& w) {
  const double angle = norm(w);
  const SinCos<double> half = sincos(0.5 * angle);
  const double s = angle > 0 ? half.sin / angle : 0.5;
  return rotation({half.cos, s * w.x, s * w.y, s * w.z});
}
/// Quaternion of a rotation; of the two equivalent ones, the one with w >= 0.
inline Quaternion quaternion(const Rotation& R) {
  const double xx = R.x.x, yy = R.y.y, zz = R.z.z;
  Quaternion q;
  if (xx + yy + zz >= 0) {
    q = {1 + xx + yy + zz, R.y.z - R.z.y, R.z.x - R.x.z, R.x.y - R.y.x};
  } else if (xx >= yy && xx >= zz) {
    q = {R.y.z - R.z.y, 1 + xx - yy - zz, R.x.y + R.y.x, R.x.z + R.z.x};
  } else if (yy >= zz) {
    q = {R.z.x - R.x.z, R.x.y + R.y.x, 1 + yy - xx - zz, R.y.z + R.z.y};
  } else {
    q = {R.x.y - R.y.x, R.x.z + R.z.x, R.y.z + R.z.y, 1 + zz - xx - yy};
  }
  const double scale = (q.w < 0 ? -1 : 1) / sqrt(square(q.w) + square(q.x) + square(q.y) + square(q.z));
  return {scale * q.w, scale * q.x, scale * q.y, scale * q.z};
}

/// Horizontal unit direction of the body's x axis; (1, 0) if x is exactly vertical.
inline Vec2<double> heading(const Rotation& R) {
  const double level = norm(R.x.x, R.x.y);
  if (!(level > 0)) return {1, 0};
  return {R.x.x / level, R.x.y / level};
}
/// Tangent of the tilt of the body's z axis, forward and to the left of the heading: the `lean` of
/// a Sight. Bounded for every attitude.
inline Vec2<double> lean(const Rotation& R) {
  constexpr double least_up = 0.1;
  const Vec2<double> d = heading(R);
  const double up = R.z.z > least_up ? R.z.z : least_up;
  return rotate<double>({d.x, -d.y}, {R.z.x / up, R.z.y / up});
}
/// Rate of the heading [rad/s] at the angular velocity w, in B. From R' = R [w], whose first column
/// is w_z y - w_y z.
inline double heading_rate(const Rotation& R, const Vec3<double>& w) {
  const double level = square(R.x.x) + square(R.x.y);
  if (!(level > 0)) return 0.0;
  const Vec3<double> rate = w.z * R.y - w.y * R.z;
  return (R.x.x * rate.y - R.x.y * rate.x) / level;
}
/// Attitude with this heading d and tilt tangents `lean`: yaw, pitch atan(lean.x), roll.
inline Quaternion leaning(const Vec2<double>& d, const Vec2<double>& lean) {
  const double yaw = 0.5 * atan2(d.y, d.x), pitch = 0.5 * atan2(lean.x, 1.0),
               roll = -0.5 * atan2(lean.y, sqrt(1.0 + square(lean.x)));
  const double cz = cos(yaw), sz = sin(yaw), cy = cos(pitch), sy = sin(pitch), cx = cos(roll), sx = sin(roll);
  return {cx * cy * cz + sx * sy * sz, sx * cy * cz - cx * sy * sz, cx * sy * cz + sx * cy * sz,
          cx * cy * sz - sx * sy * cz};
}
/// Attitude without tilt, with this heading.
inline Quaternion upright(const Vec2<double>& d) {
  const double half = 0.5 * atan2(d.y, d.x);
  return {cos(half), 0, 0, sin(half)};
}

/// Newton-Euler equations,
///
///   m v' = F_G,   I w' + w x I w = M_B,   p' = v,   q' = q (0, w) / 2,
///
/// integrated by the semi-implicit Euler step: first the velocities at the old state, then position
/// and attitude with the new velocities. The attitude step is an exact rotation. MuJoCo's
/// integrator "Euler" uses the same order, so both give equal flights. First order: energy and
/// angular momentum of a freely rotating body drift in proportion to the step.
struct RigidBody {
  double mass = 1.0;                 ///< [kg], > 0
  Vec3<double> inertia = {1, 1, 1};  ///< about the axes of B, which are principal [kg m^2], > 0
  Vec3<double> p{}, v{};             ///< of the centre of mass, in G [m], [m/s]
  Quaternion q{};                    ///< B to G
  Vec3<double> w{};                  ///< angular velocity, in B [rad/s]

  /// Advances by h [s].
  /// @param force   on the centre of mass, including weight, in G [N]
  /// @param torque  about the centre of mass, in B [N m]
  void step(const Vec3<double>& force, const Vec3<double>& torque, double h) noexcept {
    v = v + (h / mass) * force;
    const Vec3<double> spin = {inertia.x * w.x, inertia.y * w.y, inertia.z * w.z};
    const Vec3<double> moment = torque - cross(w, spin);
    w = w + h * Vec3<double>{moment.x / inertia.x, moment.y / inertia.y, moment.z / inertia.z};
    p = p + h * v;
    turn(h);
  }

  Vec3<double> momentum() const { return mass * v; }  ///< in G [kg m/s]
  Vec3<double> angular_momentum() const {             ///< about the centre of mass, in G [N m s]
    return rotation(q).to_G({inertia.x * w.x, inertia.y * w.y, inertia.z * w.z});
  }
  /// Kinetic energy of translation and rotation [J].
  double energy() const {
    return 0.5 *
           (mass * dot(v, v) + inertia.x * square(w.x) + inertia.y * square(w.y) + inertia.z * square(w.z));
  }

 private:
  void turn(double h) noexcept {
    const double rate = norm(w);
    const SinCos<double> half = sincos(0.5 * h * rate);
    const double s = rate > 0 ? half.sin / rate : 0.5 * h;
    const Quaternion d = {half.cos, s * w.x, s * w.y, s * w.z};
    const Quaternion n = {
        q.w * d.w - q.x * d.x - q.y * d.y - q.z * d.z, q.w * d.x + q.x * d.w + q.y * d.z - q.z * d.y,
        q.w * d.y - q.x * d.z + q.y * d.w + q.z * d.x, q.w * d.z + q.x * d.y - q.y * d.x + q.z * d.w};
    const double size = 1 / sqrt(n.w * n.w + n.x * n.x + n.y * n.y + n.z * n.z);
    q = {size * n.w, size * n.x, size * n.y, size * n.z};
  }
};

// Detection of a body by a camera.

/// Pose of a detected body in the observer's camera frame S (x along the optical axis, y left, z
/// up), with covariance.
///
/// With the errors dp and dtheta of that covariance, the body's origin is at p + dp in S. Its axes
/// are turned by exp(dtheta) after q, with dtheta in S. The key [agent.NAME.sensor] defines S, of
/// detections by the robot's further cameras too; a mounting error enters p and q, but not the
/// covariance.
struct Detection {
  BodyId observer{}, target{};
  double stamp = 0.0;          ///< time of validity: the middle of the exposure [s]
  double arrival = 0.0;        ///< time at which the observer receives it, not before the stamp [s]
  Vec3<double> p{};            ///< target's origin in S [m]
  Quaternion q = no_attitude;  ///< target's axes in S; no_attitude if only the position is known
  std::array<double, 21>
      covariance{};  ///< of (dp, dtheta), upper triangle row by row [m^2], [m rad], [rad^2]
  int tags = 0;      ///< number of tags used

  bool is_oriented() const noexcept { return q != no_attitude; }
  void forget_attitude() noexcept {
    q = no_attitude;
    for (std::size_t i = 0; i < 6; ++i)
      for (std::size_t j = std::max<std::size_t>(i, 3); j < 6; ++j) covariance[place(i, j)] = 0.0;
  }
  /// Index of row i and column j, both 0 to 5, in the packed covariance.
  static constexpr std::size_t place(std::size_t i, std::size_t j) noexcept {
    const std::size_t row = i < j ? i : j, column = i < j ? j : i;
    return row * (11 - row) / 2 + column;
  }
  /// The full symmetric covariance matrix.
  Mat<6, 6> covariance_matrix() const noexcept {
    Mat<6, 6> all;
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j) all(i, j) = covariance[place(at(i), at(j))];
    return all;
  }
  void set_covariance(const Mat<6, 6>& all) noexcept {
    for (int i = 0; i < 6; ++i)
      for (int j = i; j < 6; ++j) covariance[place(at(i), at(j))] = all(i, j);
  }
};

// Interface between a control loop and the world that it controls: simulated, recorded or real.

/// Motion of a robot, as its autopilot reports it.
struct RobotMotion {
  BodyId robot{};
  MotionSample motion{};
};

/// A pose that a body broadcasts by radio.
struct BodyBroadcast {
  BodyId body{};
  BroadcastPose pose{};
};

/// Measurements at the beginning of a period. Valid until the next measure(); `truth`, until the
/// next apply().
struct Measured {
  std::span<const double> measured;         ///< states of all bodies, in the order of the team (nx)
  std::span<const double> stamps;           ///< time of each body's measured state [s]; minus infinity: none
  std::span<const double> truth;            ///< true states (nx); empty if unknown
  std::span<const Detection> detections{};  ///< arrived since the last measure(), in the order of arrival
  /// Attitudes of all bodies, no_attitude for a body without; empty: unknown. True ones, or those of
  /// the newest measurements if the truth is unknown.
  std::span<const Quaternion> attitudes{};
  std::span<const RobotMotion> motions{};       ///< since the last measure(), of each robot in order
  std::span<const BodyBroadcast> broadcasts{};  ///< arrived since the last measure()
};

/// Maximum number of each kind in one period.
struct MeasuredMost {
  std::size_t detections = 0, motions = 0, broadcasts = 0;
};

/// Whether a robot that an event adds can be steered.
enum class Joining : std::uint8_t {
  at_once,  ///< it appears at its start
  ready,    ///< it has taken off and holds
  waits,    ///< it takes off
  refused,  ///< it cannot join in this flight
};

/// The world that a Loop controls. After construction nothing here allocates, locks, throws or
/// prints; one thread.
///
/// Period k of the loop, at t = k period: set_presence() if it changes, measure(t), apply(t, ...).
/// The loop's Clock determines how time passes. apply() reports missed periods before the next
/// measure().
class World {
 public:
  virtual ~World() = default;

  /// All bodies that can ever be present; outlives the world's users.
  virtual const Team& team() const noexcept = 0;
  /// States in which the bodies start, and to which one that joins in flight is set (nx).
  virtual std::span<const double> start() const noexcept = 0;
  virtual MeasuredMost measured_max() const noexcept { return {}; }
  /// Sets which bodies are present from now on, one entry per body; before the first call, all are.
  virtual void set_presence(std::span<const Presence> presence) noexcept = 0;
  /// Whether robots that are absent from the team stay in the world, where they are measured.
  virtual bool absent_robots_stay() const noexcept { return false; }
  /// Requests that a robot which is absent or lands takes off. Called each period while an event
  /// that adds the robot waits; the answer is constant within a period.
  virtual Joining prepare(BodyId /*robot*/) noexcept { return Joining::at_once; }
  /// Ends that request, since the event is ignored: a robot that has taken off for it lands.
  virtual void call_off(BodyId /*robot*/) noexcept {}
  /// Applies changes that events make around the team, from now on. A world that is not simulated
  /// ignores them.
  virtual void surround(const Surroundings& /*around*/) noexcept {}
  /// Measurements at t [s], which must increase.
  virtual Measured measure(double t) noexcept = 0;
  /// Applies the inputs u (nu) from t [s] on, for `periods` periods of `period` [s]. For missed
  /// periods, u are the inputs that stayed in force.
  /// @param estimated  states from which u was computed (nx)
  /// @return false if the world cannot continue, which ends the loop
  virtual bool apply(double t, std::span<const double> estimated, const Command& u, double period,
                     std::int64_t periods) noexcept = 0;
  /// True states after the last apply() (nx), without any sensor; empty if unknown. Does not affect
  /// later measure() calls.
  virtual std::span<const double> truth() const noexcept { return {}; }
  /// Reason why apply() returned false, one sentence; empty if a state is no longer finite.
  /// Allocates: call only after the flight.
  virtual std::string ended() const { return {}; }
};

// Faults of measurements and controllers that a scenario injects.

enum class FaultKind : std::uint8_t {
  dropout,  ///< no measurement arrives; the last one stays, with its stamp
  delay,    ///< the measurement arrives later
  freeze,   ///< the same values repeat, with a fresh stamp
  nan,      ///< one number is NaN
  jump,     ///< the position has an added offset
};
std::string_view to_string(FaultKind kind);

/// A fault in the measurements of a body, for arrival times from <= t < until.
struct Fault {
  FaultKind kind = FaultKind::dropout;
  BodyId body{};  ///< index -1: every body
  double from = 0.0;
  double until = std::numeric_limits<double>::infinity();
  double probability = 1.0;  ///< for each measurement, in [0, 1]; dropout, nan, jump
  double delay = 0.1;        ///< of FaultKind::delay, added to the sensor's own [s], in [0, 10]
  Vec3<double> offset{};     ///< of FaultKind::jump [m]
  int number = -1;           ///< of FaultKind::nan: index in the body's state; -1: drawn each time

  /// @throws std::invalid_argument naming the field, its value and its range
  void check() const;
  bool strikes(BodyId at, double t) const noexcept;
};

inline constexpr double longest_fault_delay = 10.0;  // [s]

// Seeded disturbances of a flight: wind, gusts, wakes, command delay and lag, measurement noise
// and drift.
//
// Each source has its own random stream, from seed, kind and body. Enabling one disturbance leaves
// the numbers of the others unchanged. The same seed and binary give the same numbers.

/// Wakes of hovering robots, section 7.2: each wake oscillates slowly and pushes the other robots,
/// more at short distance.
struct Airflow {
  double amplitude = 0.0, distance = 1.5, frequency = 0.5;

  static constexpr double strongest = 4.0;
  static constexpr double wander = 0.3;  ///< of the phase [rad/sqrt(s)]: coherent over about ten seconds

  static constexpr auto parameters() {
    using A = Airflow;
    return Parameters{parameter("amplitude", &A::amplitude, "m/s^2", from_zero, "acceleration at `distance`"),
                      parameter("distance", &A::distance, "m", above_zero,
                                "at distance / q the push is q^2 times stronger, at most 4 times"),
                      parameter("frequency", &A::frequency, "Hz", from_zero, "of the oscillation")};
  }
};

/// Standard deviations of the white noise of a measurement.
struct Noise {
  double position = 0.0, heading = 0.0, velocity = 0.0;

  static constexpr auto parameters() {
    return Parameters{parameter("position", &Noise::position, "m", from_zero, "of each axis"),
                      parameter("heading", &Noise::heading, "rad", from_zero, "of the heading"),
                      parameter("velocity", &Noise::velocity, "m/s", from_zero, "of each axis")};
  }
};

/// Errors of the robots' own odometry, besides the white noise. A measurement has the error
///
///   position, heading   b(t)                     b(t) = b_0 + random walk
///   velocity v          b(t) + scale v           for each velocity state
///
/// b_0 and scale are drawn once per flight, with the standard deviations `..._bias` and
/// `velocity_scale`. A walk of density K has the standard deviation K sqrt(t) after t. The errors
/// are independent: the position is not the integral of the measured velocity.
struct Odometry {
  static constexpr std::string_view name = "odometry";

  double position_bias = 0.0;
  double position_walk = 0.0;
  double heading_bias = 0.0;
  double heading_walk = 0.0;
  double velocity_bias = 0.0;
  double velocity_walk = 0.0;
  double velocity_scale = 0.0;

  static constexpr auto parameters() {
    using O = Odometry;
    return Parameters{
        parameter("position_bias", &O::position_bias, "m", from_zero, "offset of each axis at the start"),
        parameter("position_walk", &O::position_walk, "m/sqrt(s)", from_zero,
                  "density of the random walk of that offset"),
        parameter("heading_bias", &O::heading_bias, "rad", from_zero, "offset of the heading at the start"),
        parameter("heading_walk", &O::heading_walk, "rad/sqrt(s)", from_zero,
                  "density of the random walk of that offset"),
        parameter("velocity_bias", &O::velocity_bias, "m/s", from_zero, "bias of each velocity at the start"),
        parameter("velocity_walk", &O::velocity_walk, "m/s/sqrt(s)", from_zero,
                  "density of the random walk of that bias"),
        parameter("velocity_scale", &O::velocity_scale, "", from_zero,
                  "error of the scale of all velocities of a robot")};
  }

  bool operator==(const Odometry&) const = default;
};

/// All disturbances of a simulated flight. The default is none.
struct Disturbances {
  Vec3<double> wind{};      ///< steady acceleration in G [m/s^2]
  double gust_sigma = 0.0;  ///< of each horizontal and vertical axis [m/s^2], >= 0
  double gust_time = 1.0;   ///< correlation time of the gusts [s], > 0
  Airflow airflow{};        ///< between each pair of robots
  double input_delay = 0.0, yaw_lag = 0.0, input_gain = 1.0, slip = 0.0;
  Noise noise{};        ///< of the measurement
  Odometry odometry{};  ///< of robots
  double measurement_delay = 0.0;

  static constexpr auto parameters() {
    using D = Disturbances;
    constexpr Bounds delay = {0.0, 1.0, "0 to 1"};
    return Parameters{
        KeyText{"wind", "[x, y, z] or { size, direction }", "steady acceleration [m/s^2]", "none"},
        KeyText{"gust", "{ sigma, time }", "of each axis [m/s^2], >= 0; correlation time [s], > 0", "0, 1"},
        parameter("input_delay", &D::input_delay, "s", delay, "from command to effect"),
        parameter("yaw_lag", &D::yaw_lag, "s",
                  {1e-3, std::numeric_limits<double>::max(), "0 or >= 0.001", true},
                  "time constant of the input u_psi"),
        parameter("input_gain", &D::input_gain, "", above_zero, "true effect of an input over the model's"),
        parameter("slip", &D::slip, "", {0.0, 0.9, "0 to 0.9"},
                  "of wheels: lost fraction of a rover's translation and turn"),
        parameter("delay", &D::measurement_delay, "s", delay, "from state to measurement")};
  }
  /// Whether measurements differ from the true states.
  bool spoil_measurements() const;
  /// @throws std::invalid_argument naming the field, its value and its range
  void check() const;
};

/// Purpose of a random stream.
enum class StreamId : std::uint64_t {
  gust,
  wake,
  position_noise,
  heading_noise,
  velocity_noise,
  motion,
  run,
  draw,
  fault,
  position_drift,
  heading_drift,
  velocity_drift,
  gyro_noise,
  gyro_bias,
  accelerometer_noise,
  accelerometer_bias,
  mounting,
  latency,
  sighting,
  picture
};

/// Random numbers of one seed, purpose and body: SplitMix64, with Box-Muller for normal numbers.
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, StreamId purpose, int body);

  double uniform() noexcept;  ///< in (0, 1]
  double normal() noexcept;   ///< mean 0, standard deviation 1
  Vec3<double> normals() noexcept;
  std::uint64_t bits() noexcept;

 private:
  std::uint64_t state_;
  double spare_ = 0.0;
  bool has_spare_ = false;
};

/// n independent Gauss-Markov processes of variance 1 (MarkovStep), stationary from the first value on.
template <int n>
class GaussMarkov {
 public:
  explicit GaussMarkov(double correlation_time) : time_(correlation_time) {}

  /// Their values at t [s], which does not decrease.
  /// @param w  standard normal numbers; without a correlation time they are the values
  const Column<n>& at(double t, const Column<n>& w) noexcept {
    const MarkovStep step(t - last_, last_ > -infinity ? time_ : 0.0);
    for (int i = 0; i < n; ++i) x_(i, 0) = step.keep * x_(i, 0) + step.fresh * w(i, 0);
    last_ = t;
    return x_;
  }

 private:
  double time_, last_ = -infinity;
  Column<n> x_{};
};

/// Coloured noise: one Ornstein-Uhlenbeck process for each robot and axis, in its exact
/// discretisation
///
///   a(t + s) = a(t) e^{-s/tau} + sigma sqrt(1 - e^{-2s/tau}) n,   a(0) = sigma n,   n normal,
///
/// so that for any step the variance is sigma^2 and the correlation e^{-s/tau}.
class Gusts {
 public:
  Gusts(double sigma, double time, int robots, std::uint64_t seed);

  const Vec3<double>& acceleration(int robot) const noexcept { return a_[static_cast<std::size_t>(robot)]; }
  void advance(double s) noexcept;

 private:
  double sigma_, time_;
  std::vector<RandomStream> streams_;
  std::vector<Vec3<double>> a_;
};

/// Accelerations from the robots' wakes. Each other robot j, at distance D, accelerates robot i by
///
///   amplitude min((distance / D)^2, strongest) sin(phase_j) e
///
/// with e horizontal and normal to the line from j to i. Two robots aligned along x oscillate in y,
/// as in the paper's flight. The phase of each robot advances at `frequency`, from a seeded start
/// and with a slow seeded random walk.
class Wakes {
 public:
  Wakes(const Airflow& airflow, int robots, std::uint64_t seed);

  /// Adds the accelerations [m/s^2] of the robots at these positions [m].
  void push(std::span<const Vec3<double>> p, std::span<Vec3<double>> acceleration) const noexcept;
  void advance(double s) noexcept;

 private:
  Airflow airflow_;
  std::vector<RandomStream> streams_;
  std::vector<double> phase_, swing_;  // [rad], sin(phase)
};

/// Error of the odometry of one robot, as Odometry defines it.
class OdometryErrors {
 public:
  /// @param velocities  number of velocity states of the robot
  OdometryErrors(const Odometry& odometry, std::size_t velocities, std::uint64_t seed, int body);

  void advance(double s) noexcept;

  const Vec3<double>& position() const noexcept { return position_; }  ///< [m]
  double heading() const noexcept { return heading_; }                 ///< [rad]
  /// Error of velocity state i [m/s], whose true value is v [m/s].
  double velocity(std::size_t i, double v) const noexcept { return velocity_[i] + scale_ * v; }

 private:
  Odometry odometry_;
  // Each stream draws its initial values first, even if they are unused.
  RandomStream of_position_, of_heading_, of_velocity_;
  Vec3<double> position_;
  double heading_, scale_;
  std::vector<double> velocity_;
};

/// Queue of delayed commands. Each command comes into force `delay` after give(), also between two
/// steps.
class InputDelay {
 public:
  /// @param period   the shortest time between two commands [s]; of faster ones only the latest is
  /// kept
  /// @param initial  the command in force until the first arrives (nu)
  InputDelay(double delay, double period, std::span<const double> initial);

  void give(double t, std::span<const double> u) noexcept;
  /// The command in force at t [s]; t must not decrease.
  std::span<const double> at(double t) noexcept;
  /// When the next command comes into force [s]; infinity if none is pending. Call after at().
  double next_arrival() const noexcept;

 private:
  std::size_t row(std::size_t ahead) const noexcept { return (held_ + ahead) % arrival_.size(); }

  double delay_;
  std::size_t nu_, held_ = 0, waiting_ = 0;
  std::vector<double> arrival_, rows_;
};

// Motions of targets and obstacles, which are not controlled, in the simulated world.
//
// Each motion sets the velocity that is held over the next step. A body without a motion keeps its
// velocity.

/// The key `agent` of a motion.
inline constexpr KeyText approached_robot = {"agent", "a robot", "to which it moves", "must be given"};

/// Straight lines from point to point at constant speed.
struct PathMotion {
  enum class End {
    rest,   ///< stays at the last point
    round,  ///< continues to the first point, and repeats
  };
  std::vector<Vec3<double>> points;
  double speed = 0.5;
  End end = End::rest;

  static constexpr std::string_view name = "path";
  static constexpr auto parameters() {
    using M = PathMotion;
    return Parameters{
        ListParameter<M, Vec3<double>>{"points", &M::points, "m", "two or more"},
        parameter("speed", &M::speed, "m/s", above_zero, "along the path"),
        parameter("end", &M::end, std::array<std::string_view, 2>{"rest", "round"}, "round: begins again")};
  }
  void check() const;
};

/// From position to position at given times, planned or recorded.
struct WaypointsMotion : Waypoints {
  static constexpr auto parameters() {
    return detail::timed_positions<Waypoints>() + detail::timed_velocities<Waypoints>();
  }
};

/// Horizontal circle: centre + radius (cos a, sin a, 0), a = phase + rate t.
struct CircleMotion {
  Vec3<double> centre{};
  double radius = 1.0, rate = 0.3, phase = 0.0;

  static constexpr std::string_view name = "circle";
  static constexpr auto parameters() {
    using M = CircleMotion;
    return Parameters{needed(parameter("centre", &M::centre, "m", any_finite, "of the circle")),
                      parameter("radius", &M::radius, "m", from_zero, "of the circle"),
                      parameter("rate", &M::rate, "rad/s", any_finite, "angular velocity"),
                      parameter("phase", &M::phase, "rad", any_finite, "angle at the start")};
  }
  void check() const { check_parameters(*this); }
};

/// Moves straight to the robot's current position; stops while it is closer than the standoff.
struct ChaseMotion {
  AgentId agent{};
  double speed = 0.5, standoff = 0.0;

  static constexpr std::string_view name = "chase";
  static constexpr auto parameters() {
    using M = ChaseMotion;
    return Parameters{approached_robot, parameter("speed", &M::speed, "m/s", above_zero, "of the body"),
                      parameter("standoff", &M::standoff, "m", from_zero, "distance to the robot")};
  }
  void check() const { check_parameters(*this); }
};

/// Rests until a time, then flies along one straight line that is not updated. The line passes
/// `miss` to the left of the point where the body would meet the robot at the robot's present
/// velocity. If the body is too slow to meet the robot, the line passes the robot's position
/// instead.
struct CrossMotion {
  AgentId agent{};
  double at = 0.0, speed = 1.0, miss = 0.0;

  static constexpr std::string_view name = "cross";
  static constexpr auto parameters() {
    using M = CrossMotion;
    return Parameters{approached_robot, parameter("at", &M::at, "s", from_zero, "start of the motion"),
                      parameter("speed", &M::speed, "m/s", above_zero, "of the body"),
                      parameter("miss", &M::miss, "m", any_finite, "to the left; negative: to the right")};
  }
  void check() const { check_parameters(*this); }
};

/// An obstacle carried by hand, as in section 7.3. It rests at its start until a time, then jumps
/// to `from` and approaches the robot up to a standoff. It follows a robot that evades.
struct HandMotion {
  AgentId agent{};
  double at = 15.0;
  Vec3<double> from{};
  double speed = 0.2, standoff = 0.9;

  static constexpr std::string_view name = "hand";
  static constexpr auto parameters() {
    using M = HandMotion;
    return Parameters{approached_robot, parameter("at", &M::at, "s", from_zero, "time of the jump"),
                      needed(parameter("from", &M::from, "m", any_finite, "place after the jump")),
                      parameter("speed", &M::speed, "m/s", above_zero, "of the body"),
                      parameter("standoff", &M::standoff, "m", from_zero, "distance to the robot")};
  }
  void check() const { check_parameters(*this); }
};

/// Changes direction at intervals: straight to the robot with probability `aim`, else at random.
/// With probability 0.5 it moves at full speed, else at a uniformly drawn lower speed.
struct AdversaryMotion {
  enum class Within { plane, space };
  AgentId agent{};
  double speed = 1.5, every = 0.5, aim = 0.5;
  Within within = Within::plane;

  static constexpr std::string_view name = "adversary";
  static constexpr auto parameters() {
    using M = AdversaryMotion;
    return Parameters{
        approached_robot, parameter("speed", &M::speed, "m/s", above_zero, "greatest speed of the body"),
        parameter("every", &M::every, "s", {1e-3, std::numeric_limits<double>::max(), ">= 0.001"},
                  "between two turns"),
        parameter("aim", &M::aim, "", {0.0, 1.0, "in [0, 1]"}, "probability of a turn to the robot"),
        parameter("within", &M::within, std::array<std::string_view, 2>{"plane", "space"}, "of the motion")};
  }
  void check() const { check_parameters(*this); }
};

using Motion = std::variant<PathMotion, WaypointsMotion, CircleMotion, ChaseMotion, CrossMotion, HandMotion,
                            AdversaryMotion>;

/// A body and its motion.
struct BodyMotion {
  BodyId body{};
  Motion motion;
};

/// Start position of a motion that defines one: a path, waypoints or a circle.
std::optional<Vec3<double>> start_of(const Motion& motion);
/// Upper bound of the motion's speed [m/s].
double top_speed(const Motion& motion);

/// Moves the targets and obstacles of a team. Each has its own random stream.
class Motions {
 public:
  /// @throws std::invalid_argument if a parameter is out of its range, a body is a robot or has two
  /// motions, or a followed body is not a robot
  /// @param speed_max  as in PlantOptions
  Motions(const Team& team, std::vector<BodyMotion> motions, std::uint64_t seed,
          const std::vector<double>& speed_max = {});

  bool empty() const noexcept { return movers_.empty(); }

  /// Starts an event's move of a body, from its position in the stacked state x to a place where it
  /// then rests. A repeated call with the same move has no effect.
  void move(const Surroundings::Move& move, std::span<const double> x) noexcept;
  /// Ends the event's move of a body that starts again.
  void leave(BodyId body) noexcept;

  /// Sets the velocity of each body in the stacked state x for the step from t to t + dt [s]. Sets
  /// the position of a body that enters at t. Calls with equal t give equal results; t must not
  /// decrease. Allocates nothing.
  /// @param u  the inputs of the robots (nu), or empty
  void steer(double t, double dt, std::span<const double> u, std::span<double> x) noexcept;

 private:
  struct Place {
    Model model;
    std::size_t x, u;  // offsets
  };
  struct Mover {
    Motion motion;
    std::size_t x;   // offset of p, then v
    Place followed;  // the followed robot, if any
    RandomStream chance;
    std::vector<double> lengths;  // of the path up to each point [m]
    Vec3<double> v{};             // held for longer than a step
    double next = 0.0;            // time of its next change of direction [s]
    bool entered = false;
  };

  struct Steer;

  /// A body that an event moves, starting at `from`; one for each target and obstacle.
  struct Carried {
    std::size_t x = 0;                                           // offset of p, then v
    double speed_max = std::numeric_limits<double>::infinity();  // [m/s]
    Surroundings::Move move{};
    Vec3<double> from{};
    double begun = std::numeric_limits<double>::quiet_NaN();  // begin of the last move received [s]
    bool moves = false;
  };

  std::vector<Mover> movers_;
  std::vector<Carried> carried_;
};

}  // namespace sightline
