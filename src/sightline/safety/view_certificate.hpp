/// The certificate of a view: a set of states that a filter can never be forced to leave, and whose
/// every state has the target in the sensor's region.
///
/// Coordinates are relative to the target, in the frame V of the robot's heading, turned by the
/// direction of the sensor: r horizontal distance, theta bearing of the target (left > 0), h height of
/// the robot above the target, v_f, v_s velocity. (w_r, w_t) is the target's velocity along and across
/// the line of sight:
///
///   r'     = w_r - (v_f cos theta + v_s sin theta)                        |(w_r, w_t)| <= W
///   theta' = (w_t - v_s cos theta + v_f sin theta) / r - omega            |omega| <= Omega
///   h'     = v_z - w_z                                                    |w_z| <= W_z
///   v_f'   = -c v_f + a_f,   v_s' = -c_s v_s + a_s                        |a_f| <= b, |a_s| <= b_s
///
/// Braking distance at full thrust against a target that approaches at W_e:
///
///   n(v) = integral of y / (b - c W_e + c y) over y from 0 to v + W_e, or 0 for v <= -W_e
///   W_e  = (W + V_s sin T) / cos T,   T = Theta + 1.5 Omega dt
///
/// The set:
///
///   S = { r - r1 >= n(v_f), r2 - r >= n(-v_f), |theta| <= Theta, |v_s| <= V_s, lo(r) <= h <= hi(r) }
///
/// If the target's velocity is measured, v is relative to it and W_e = V_s tan T. The theorem, its
/// conditions (C1) to (C6) and the proof are in docs/certified_view.md. Units are SI.
#pragma once

#include <array>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

#include "sightline/barrier.hpp"
#include "sightline/base.hpp"
#include "sightline/model.hpp"
#include "sightline/potential.hpp"

namespace sightline {

/// How the commands move a robot: each command moves one coordinate of the heading frame. The view is
/// kept in that frame turned by `ahead`, where two commands may move one coordinate together.
struct ViewMotion {
  /// A command and its effect; gain * u is an acceleration, a climb or a yaw rate.
  struct Axis {
    int input = -1;     ///< index, or -1: no such motion
    double gain = 0.0;  ///< per unit of the input
    double most = 0.0;  ///< greatest |gain u| in both directions; [m/s^2], [m/s] or [rad/s]
    double drag = 0.0;  ///< of its velocity [1/s]; along and across
    double lag = 0.0;   ///< of its rate behind the command [s]; of climb and turn
  };
  Axis along{}, across{}, climb{}, turn{};
  bool is_level = false;        ///< whether its velocity keeps its direction in G while it turns
  int rate_state = -1;          ///< index of the yaw rate in the state, if it lags
  Vec2<double> lean{};          ///< greatest |xi_f|, |xi_s| that commands produce [-]
  Vec2<double> ahead = {1, 0};  ///< direction of the sensor in V, unit vector

  bool is_turned() const { return ahead.x != 0 && ahead.y != 0; }  ///< by no multiple of a right angle
  /// Greatest accelerations along and across `ahead` that commands produce in every combination
  /// [m/s^2]: the sides of a rectangle within the turned one of the commands.
  /// @param part  of the greatest one across, in (0, 1); not used unless is_turned()
  Vec2<double> pushes(double part) const;
  Vec2<double> most_push() const;  ///< greatest along and across, each by itself [m/s^2]
  Vec2<double> drags() const;      ///< along and across `ahead` [1/s]
  double drag_between() const;     ///< acceleration along per velocity across, and vice versa [1/s]
};

/// @param u_min, u_max  limits of the inputs (nu), finite
/// @param ahead  direction in V in which a target is to be, unit vector
/// @throws std::invalid_argument for a robot that moves otherwise: with a sentence that names it
ViewMotion view_motion(const Model& model, std::span<const double> u_min, std::span<const double> u_max,
                       const Vec2<double>& ahead = {1, 0});

/// The direction in V of the axes of all sensors together; ahead for axes that are upright.
Vec2<double> view_direction(std::span<const Potential> limits);

/// Whether the target, `ahead` and `left` of a robot `above` it [m], is where it must be; seen along
/// ViewMotion::ahead.
using ViewRegion = std::function<bool(double ahead, double left, double above)>;

/// The region in which all potentials hold: sensor and distances, for every tilt up to that of the
/// motion for a sensor that is fixed to the body.
/// @throws std::invalid_argument for a potential that depends on more than the relative position
ViewRegion view_region(std::vector<Potential> limits, const ViewMotion& motion);

/// Heights at which the target is in the region at all bearings up to a limit, tabulated once.
class ViewSection {
 public:
  struct Heights {
    double low, high;  ///< [m]; low > high: none
    bool is_empty() const { return !(low < high); }
  };
  static constexpr int distances = 121, bearings = 36;
  static constexpr double bearing_step = 0.0125;  ///< [rad]

  /// @throws std::invalid_argument if the region is empty or has points beyond 30 m
  explicit ViewSection(const ViewRegion& region);

  double step() const { return step_; }                        ///< between distances [m]
  double reach() const { return distance(distances - 1); }     ///< beyond all of the region [m]
  double distance(int k) const { return first_ + k * step_; }  ///< r_k [m]
  static double bearing(int i) { return bearing_step * (i + 1); }
  /// Heights at r_k and all bearings up to `bearing`, with the target anywhere within `radius` [m].
  Heights heights(int k, double bearing, double radius) const;

 private:
  double first_ = 0.0, step_ = 0.0;
  std::vector<Heights> heights_;  // bearings x distances
};

/// n(v) and its inverse.
struct ViewBrake {
  double drag = 0.0;    ///< c [1/s]
  double thrust = 1.0;  ///< b - c W_e, the deceleration at v = -W_e, > 0 [m/s^2]
  double speed = 0.0;   ///< W_e [m/s]

  double distance(double v) const noexcept;        ///< n(v) [m]
  double slope(double v) const noexcept;           ///< n'(v) [s]
  double fastest(double distance) const noexcept;  ///< greatest v with n(v) <= distance [m/s]
};

/// Greatest errors of the motion by which an observer that is localized by vision keeps track of its
/// target; all 0 of one whose own state is measured.
struct ViewOdometry {
  double velocity = 0.0;  ///< of its estimated velocity [m/s]
  double turn = 0.0;      ///< of its estimated yaw rate [rad/s]
  double delay = 0.0;     ///< from a command to its effect, constant [s]

  bool is_used() const { return velocity > 0; }
  /// Distance of the filter's velocity to the true one [m/s].
  double velocity_error(const ViewBounds& bounds, double dt) const;
  /// The bounds of the target as it moves in the frame of this odometry.
  /// @param bounds  of the target itself; `error` is that of its position relative to the robot, `age`
  ///                the delay alone
  /// @param reach  greatest distance of the target in the region [m]
  ViewBounds seen(const ViewBounds& bounds, double reach, double dt) const;
};

/// The task of a certificate.
struct ViewTask {
  ViewMotion motion{};
  ViewBounds bounds{};  ///< of an observer that is localized by vision: those of ViewOdometry::seen()
  double dt = 0.01;     ///< period of the commands [s]
  ViewOdometry odometry{};
  /// Horizontal speed to which the robot itself may be requested to keep [m/s]: its set needs no more.
  double requested = infinity;
};

/// What `age` costs an observer whose own state is predicted, from a measurement of that age, by its
/// model and its commands. The wind of that time is missing in the prediction. All are 0 without.
struct ViewPrediction {
  double speed = 0.0;   ///< at which the point that the filter follows is corrected [m/s]
  double radius = 0.0;  ///< from that point to the robot, at most [m]
  double lag = 0.0;     ///< from that point to the predicted position, at most [m]
};
ViewPrediction view_prediction(const ViewBounds& bounds, double dt);

/// A condition of the theorem that can limit the certified speed.
enum class ViewLimit { none, range, yaw, height, thrust, request };
std::string_view to_string(ViewLimit limit) noexcept;

struct ViewCertificate {
  ViewTask task{};
  double theta = 0.0;                 ///< Theta [rad]
  double sideward = 0.0;              ///< V_s [m/s]
  Vec2<double> push{};                ///< b, b_s, in every combination [m/s^2]
  double near = 0.0;                  ///< r1 [m]
  double far = 0.0;                   ///< r2 [m]
  double turn = 0.0;                  ///< Omega, the yaw rate that the filter uses [rad/s]
  double climb = 0.0;                 ///< greatest vertical speed that the filter uses [m/s]
  ViewBrake brake{};                  ///< n
  std::vector<double> low{}, high{};  ///< lo and hi at equal distances from r1 to r2 [m]
  double volume = 0.0;                ///< of S in (r, theta, h, v_f, v_s); 0: there is no certificate

  bool exists() const { return volume > 0; }
  double step() const { return (far - near) / static_cast<double>(low.size() - 1); }
  /// lo(r) or hi(r), linear between the nodes and constant beyond them.
  double at(const std::vector<double>& heights, double r) const noexcept;
};

/// The largest certificate of a task, or one of volume 0.
ViewCertificate certify_view(const ViewTask& task, const ViewSection& section);

/// The largest W that can be certified [m/s], to 0.5 %, and the condition that limits it.
struct CertifiedSpeed {
  double speed = 0.0;  ///< 0: not even a target at rest
  ViewLimit limit = ViewLimit::none;
};
CertifiedSpeed certified_speed(ViewTask task, const ViewSection& section);

}  // namespace sightline
