/// Joint filter of a team of planar robots that measure each other and landmarks.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/estimate/planar_sighting.hpp"
#include "sightline/estimator.hpp"

namespace sightline {

/// Motion of a planar robot as its odometry reports it, from t until the next sample.
struct WheelOdometry {
  double t = 0.0;         ///< [s]
  double v = 0.0;         ///< forward velocity [m/s]
  double yaw_rate = 0.0;  ///< [rad/s]
};

/// Pose of a planar robot in G.
struct PlanarPose {
  double x = 0.0, y = 0.0;  ///< [m]
  double psi = 0.0;         ///< heading [rad]
};

/// A pose in the frame of another one; its heading is not wrapped.
inline PlanarPose relative_to(const PlanarPose& frame, const PlanarPose& of) noexcept {
  const SinCos<double> e = sincos(frame.psi);
  const double dx = of.x - frame.x, dy = of.y - frame.y;
  return {e.cos * dx + e.sin * dy, e.cos * dy - e.sin * dx, of.psi - frame.psi};
}

/// Refused sightings of a robot that its filter keeps.
inline constexpr int refused_sightings_max = 16;

/// Standard deviations of odometry and sightings. docs/real_data.md has the equations.
///
/// A sensor's error is white noise plus, for each pair of sensor and body, a Gauss-Markov process:
/// E e(t) e(t + s) = sigma^2 exp(-|s| / tau).
struct TeamNoise {
  static constexpr std::string_view name = "localize";

  double distance_noise = 0.045;
  double skid_noise = 0.03;
  double curve_noise = 0.033;
  double turn_noise = 0.09;
  double position_walk = 0.0;
  double heading_walk = 0.0;
  double odometry_gap = 1.1;
  double speed_scale = 0.05;
  double turn_scale = 0.1;
  double turn_loss = 0.1;
  double yaw_rate_bias = 0.005;
  double yaw_rate_walk = 0.0;
  double clock_offset = 0.2;
  double wheel_turn = 0.05;
  double sensor_turn = 0.05;
  double range_depth = 1.0;
  double axis_turn = 0.03;
  double range_scale = 0.03;
  double range_offset = 0.05;
  double bearing_scale = 0.03;
  double range_noise = 0.0;
  double range_share = 0.006;
  double range_error = 0.009;
  double range_error_time = 5.0;
  double antenna_error = 0.0;
  double bearing_noise = 0.005;
  double bearing_error = 0.006;
  double bearing_error_time = 5.0;
  int restart_sightings = 8;

  static constexpr auto parameters() {
    using N = TeamNoise;
    constexpr Bounds count = {1, refused_sightings_max, "1 to 16"};
    return Parameters{
        parameter("distance_noise", &N::distance_noise, "m/sqrt(m)", from_zero, "of the distance driven"),
        parameter("skid_noise", &N::skid_noise, "m/sqrt(m)", from_zero,
                  "of the position across the drive, per distance driven"),
        parameter("curve_noise", &N::curve_noise, "rad/sqrt(m)", from_zero,
                  "of the heading per distance driven"),
        parameter("turn_noise", &N::turn_noise, "rad/sqrt(rad)", from_zero,
                  "of the heading per angle turned"),
        parameter("position_walk", &N::position_walk, "m/sqrt(s)", from_zero,
                  "random walk of the position, each axis"),
        parameter("heading_walk", &N::heading_walk, "rad/sqrt(s)", from_zero, "random walk of the heading"),
        parameter("odometry_gap", &N::odometry_gap, "s", above_zero,
                  "age of odometry, if above 8 mean intervals, beyond which the motion is unknown"),
        parameter("speed_scale", &N::speed_scale, "", from_zero, "constant scale error of the velocity"),
        parameter("turn_scale", &N::turn_scale, "", from_zero, "constant scale error of the yaw rate"),
        parameter("turn_loss", &N::turn_loss, "m/rad", from_zero,
                  "constant loss of velocity per yaw rate, as by slipping wheels"),
        parameter("yaw_rate_bias", &N::yaw_rate_bias, "rad/s", from_zero,
                  "bias of the yaw rate at the start"),
        parameter("yaw_rate_walk", &N::yaw_rate_walk, "rad/s/sqrt(s)", from_zero,
                  "density of the random walk of that bias"),
        parameter("clock_offset", &N::clock_offset, "s", from_zero,
                  "constant delay of the motion after its odometry; 0: there is none"),
        parameter("wheel_turn", &N::wheel_turn, "rad", from_zero,
                  "constant angle from the heading to where the wheels drive"),
        parameter("sensor_turn", &N::sensor_turn, "rad", from_zero,
                  "constant mounting error of the sensor; 0: there is none"),
        parameter("range_depth", &N::range_depth, "", from_zero,
                  "constant share of the depth along the sensor's axis in a range; 0: ranges are distances"),
        parameter("axis_turn", &N::axis_turn, "rad", from_zero,
                  "constant angle from bearing 0 to the axis of depths"),
        parameter("range_scale", &N::range_scale, "", from_zero, "constant scale error of a sensor's ranges"),
        parameter("range_offset", &N::range_offset, "m", from_zero, "constant error of a sensor's ranges"),
        parameter("bearing_scale", &N::bearing_scale, "", from_zero,
                  "constant scale error of a sensor's bearings"),
        parameter("range_noise", &N::range_noise, "m", from_zero, "white noise of a range"),
        parameter("range_share", &N::range_share, "", from_zero, "white noise per range"),
        parameter("range_error", &N::range_error, "", from_zero, "lasting error of a pair, per range"),
        parameter("range_error_time", &N::range_error_time, "s", above_zero,
                  "correlation time of that error"),
        parameter(
            "antenna_error", &N::antenna_error, "m", from_zero,
            "constant error of an antenna's ranges, where sightings name antennas; half of its variance "
            "is towards each other body alone"),
        parameter("bearing_noise", &N::bearing_noise, "rad", above_zero, "white noise of a bearing"),
        parameter("bearing_error", &N::bearing_error, "rad", from_zero, "lasting error of a pair"),
        parameter("bearing_error_time", &N::bearing_error_time, "s", above_zero,
                  "correlation time of that error"),
        parameter("restart_sightings", &N::restart_sightings, "", count,
                  "refused sightings of a robot in a row that restart it where one pose explains them")};
  }

  bool operator==(const TeamNoise&) const = default;
  /// @throws std::invalid_argument naming a number out of its range, or a range without noise
  void check() const;
};

/// Component of a sighting that was measured.
enum class Sighted { range_and_bearing, range, bearing };

/// A sighting: range and bearing of one body in the sensor frame of a robot.
struct TeamSighting {
  static constexpr int unidentified = -1, no_antenna = -1;

  double stamp = 0.0;          ///< [s]
  int observer = 0;            ///< a robot
  int subject = unidentified;  ///< robots from 0, then landmarks
  Sighted of = Sighted::range_and_bearing;
  double range = 0.0, bearing = 0.0;  ///< [m], [rad]
  Vec3<double> sensor{}, point{};     ///< places on the observer and on the subject [m]
  /// Antennas of a range on the observer and on the subject, a robot, from 0; their errors add.
  int antenna = no_antenna, other_antenna = no_antenna;
};

/// Result of a sighting.
struct TeamFit {
  FitVerdict verdict = FitVerdict::waiting;
  int subject = TeamSighting::unidentified;  ///< the associated body
  bool slipped = false;                      ///< the heading became uncertain to explain the bearing
  int dimension = 0;                         ///< of the innovation; 0: there is none
  double squared = 0.0;                      ///< y^T S^-1 y
  double log_det = 0.0;                      ///< ln det S, ranges in m, bearings in rad
  std::array<double, 2> y{};                 ///< innovation: range [m], bearing [rad], in this order
  /// L^-1 y with S = L L^T; standard normal and white in time if the filter is consistent
  std::array<double, 2> white{};
};

/// Pose with its covariance (x, y, psi).
struct PoseGuess {
  PlanarPose pose{};
  Mat<3, 3> P{};
};

/// States of one robot in TeamFilter, in this order.
enum class RobotState {
  x,
  y,
  psi,
  speed_scale,
  turn_scale,
  turn_loss,
  yaw_rate_bias,
  clock_offset,
  wheel_turn,
  sensor_turn,
  range_scale,
  range_depth,
  axis_turn,
  range_offset,
  bearing_scale
};
inline constexpr int robot_states = 15;
/// Names of its constants in the same order, the last states; TeamNoise has their deviations by them.
inline constexpr std::array<std::string_view, 12> robot_constants = {
    "speed_scale", "turn_scale",  "turn_loss",   "yaw_rate_bias", "clock_offset", "wheel_turn",
    "sensor_turn", "range_scale", "range_depth", "axis_turn",     "range_offset", "bearing_scale"};
inline constexpr int first_constant = robot_states - static_cast<int>(robot_constants.size());
static_assert(first_constant == static_cast<int>(RobotState::speed_scale));

/// Extended Kalman filter of all robots at once, so no information is counted twice. Its state is
///
///   for each robot   p, psi      pose in G
///                    s_v, s_r    scale errors of the odometry                              constant
///                    c           loss of velocity in a turn                                constant
///                    b           bias of the yaw rate                                   random walk
///                    delta       clock offset: the motion at t is the odometry's at t - delta
///                    alpha       angle from the heading to where the wheels drive          constant
///                    mu          mounting error of its sensor                              constant
///                    s_d, gamma, eps, o   scale, depth, its axis, offset of its ranges     constant
///                    s_b         scale of its bearings                                     constant
///   for each antenna             error of its ranges, common and to each other body     constant
///   for each pair    rho, eta    lasting errors of range and bearing (RangeBearing)    Gauss-Markov
///
/// and its motion, with v_m, r_m of the odometry,
///
///   v = (1 + s_v) v_m - c |r_m| sign(v_m),   but not beyond 0;   r = (1 + s_r) r_m + b,
///   p' = R(psi + alpha) (v, 0).
///
/// A pair of observer and subject has states from its first sighting until 5 correlation times after
/// its last one, so their number is bounded. Sightings and motion come in order of time. After
/// construction nothing allocates or throws.
class TeamFilter {
 public:
  static constexpr int frame_max = 8;  ///< sightings that are associated together

  struct Landmark {
    double x = 0.0, y = 0.0, z = 0.0;  ///< in G [m]
  };

  /// @param heights  of the robots [m]; as many as there are robots
  /// @param t0       time of the first pose [s]
  /// @param antennas  of each robot
  /// @throws std::invalid_argument from TeamNoise::check(), or without robots
  TeamFilter(std::vector<double> heights, std::vector<Landmark> landmarks, const TeamNoise& noise, double t0,
             int antennas = 0);

  int robots() const noexcept { return robots_; }
  int bodies() const noexcept { return robots_ + static_cast<int>(landmarks_.size()); }
  double time() const noexcept { return now_; }
  int states() const noexcept { return n_; }

  /// Sets the pose of a robot, independent of all else. A robot without one is at the origin, within
  /// 1 km and 2 rad.
  void start(int robot, const PoseGuess& guess) noexcept;
  /// Adds an odometry sample; ignored unless finite and after the previous one.
  void take(int robot, const WheelOdometry& sample) noexcept;
  /// Propagates to t [s]; does nothing for a past t.
  void advance(double t) noexcept;
  /// Applies an identified sighting at the present time. A sighting beyond the gate is refused.
  TeamFit take(const TeamSighting& z) noexcept;
  /// Associates sightings of one robot at one time with bodies, all together, and applies them
  /// (joint compatibility). Sightings that more than one body explains, and those after the first
  /// `frame_max`, are left out.
  void take_unidentified(std::span<const TeamSighting> frame, std::span<TeamFit> fits) noexcept;
  /// Applies the pose of a robot that is known otherwise, at the present time.
  TeamFit take_pose(int robot, const PoseGuess& known) noexcept;

  /// Pose of a robot from identified sightings of one time, by it or of it, without its prior: the
  /// other robots are where the filter has them. Empty unless one pose explains them far better than
  /// any other.
  std::optional<PoseGuess> locate(int robot, std::span<const TeamSighting> frame) noexcept;

  PoseGuess pose(int robot) const noexcept;
  double state(int robot, RobotState k) const noexcept { return x_[at(index(robot, k))]; }
  /// Standard deviation of that state.
  double sigma(int robot, RobotState k) const noexcept;

 private:
  /// A linearised measurement of m <= 3 components: y = H dx + noise, over the used columns.
  struct Row {
    static constexpr int width = RangeBearing::estimated + 4;  // two for each antenna
    int m = 0, used = 0;
    std::array<int, width> columns{};
    Mat<3, width> H{};
    Column<3> y{};
    Mat<3, 3> R{};
  };
  struct Pair {
    int observer, subject;
    double seen;  // [s]
  };
  enum class Slip { none, shown, admitted };
  /// Deviations of a pose that is wrong by more than it claims [m], [rad].
  static constexpr double wrong_position = 0.5, wrong_heading = 0.3;
  /// A refused sighting with the dead reckoning of its observer and its subject at that time.
  struct Refused {
    TeamSighting z{};
    PlanarPose observer{}, subject{};
  };
  struct Robot {
    std::array<WheelOdometry, 256> ring{};
    std::size_t first = 0, count = 0;
    double v = 0.0, yaw_rate = 0.0;  // corrected odometry at the present time
    PlanarPose path{};               // dead reckoning alone
    std::array<Refused, refused_sightings_max> refused{};
    int refusals = 0;             // in a row
    int contradictions = 0;       // refused sightings without identity, less twice the accepted ones
    double accepted = -infinity;  // last time
    double slip = 0.0, slip_variance = 0.0, slip_seen = -infinity;  // of the last bearing that shows one
    const WheelOdometry& operator[](std::size_t i) const noexcept { return ring[(first + i) % ring.size()]; }
  };
  /// A body that a sighting may show, and G = H P of its measurement, row by row.
  struct Candidate {
    int subject;
    Row row;
    const double* G;
  };
  /// Sums of locate() over the measurements of one pair and one component. Their covariance is
  /// diag(w) + sigma^2 s s^T: white noise, and a lasting error that all of them share.
  struct LastingError {
    double q = 0.0, v = 0.0;  // s^T w^-1 s, s^T w^-1 y
    Column<3> u{};            // H^T w^-1 s
  };
  static constexpr int candidates_max = 6;
  struct Association;

  /// Gate of a sum of squares with that many degrees of freedom: the 99.9 % quantile of chi^2, by
  /// Laurent and Massart from above.
  static double sum_gate(int freedom) noexcept { return freedom + 2 * sqrt(6.9 * freedom) + 13.8; }
  static std::size_t at(int i) noexcept { return static_cast<std::size_t>(i); }
  static int index(int robot, RobotState k) noexcept { return robot * robot_states + static_cast<int>(k); }
  /// State of an antenna's error towards another body; its common error where `body` is the robot.
  int antenna_index(int robot, int antenna, int body) const noexcept {
    return robots_ * robot_states + (robot * antennas_ + antenna) * bodies() + body;
  }
  double& P(int i, int j) noexcept { return P_[at(i) * at(capacity_) + at(j)]; }
  double P(int i, int j) const noexcept { return P_[at(i) * at(capacity_) + at(j)]; }

  void step(double dt) noexcept;
  void move(int robot, double dt) noexcept;
  void fade(double dt) noexcept;
  double gap() const noexcept;
  int pair_of(const TeamSighting& z) const noexcept;
  int pair_for(const TeamSighting& z) noexcept;
  void drop_pair(int pair) noexcept;
  bool is_usable(const TeamSighting& z) const noexcept;
  Row row_of(const TeamSighting& z, int pair) noexcept;
  void times_P(const Row& row, double* G) const noexcept;
  double squared_distance(const Row& row) const noexcept;
  TeamFit apply(const Row& row) noexcept;
  Slip slip_of(const Row& row, int robot) noexcept;
  void refuse(const TeamSighting& z) noexcept;
  void agree(int robot) noexcept;
  void restart(int robot, PoseGuess found) noexcept;
  std::optional<PoseGuess> fit_near(int robot, std::span<const TeamSighting> frame, const PoseGuess& prior,
                                    const PlanarPose& from) noexcept;
  TeamSighting moved(const Refused& one) const noexcept;
  double depth_share(int robot, double bearing) const noexcept;
  bool is_lost(int robot) const noexcept;
  bool find(int robot) noexcept;
  void widen(int robot) noexcept;

  TeamNoise noise_;
  std::vector<Landmark> landmarks_;
  std::vector<double> heights_;
  int robots_, antennas_, first_pair_, capacity_, n_;  // first_pair_: index of the state of the first pair
  std::vector<double> x_, P_, decay_;
  std::vector<double> G_, candidate_G_;  // rows of H P: 3, and 2 for each candidate of a frame
  std::vector<Robot> odometry_;
  double driven_ = 0.0, turned_ = 0.0, covered_ = 0.0;  // integrals of v^2, r^2 and 1 over all odometry
  double intervals_ = 0.0;                              // of odometry, in covered_
  std::vector<Pair> pairs_;
  std::vector<LastingError> lasting_;  // range and bearing: of each body as subject, and as observer
  SightingModel model_;
  double now_;
};

}  // namespace sightline
