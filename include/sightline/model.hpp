/// Robot models: frames and poses, the type-erased Model, models as text, and the roles of states and inputs.
#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/base.hpp"
#include "sightline/formula.hpp"

namespace sightline {

// Frames, poses and sensor mounts: G global, V vehicle, B body, S sensor; (17)-(22), (40)-(48).

inline constexpr double gravity = 9.81;  ///< g [m/s^2]

/// Position and heading of a robot in G; roll and pitch are neglected (hover-controlled robots).
template <class S>
struct Pose {
  Vec3<S> p;  ///< position [m]
  Vec2<S> d;  ///< heading (cos psi, sin psi), (18), (19); |d| = 1
};

/// Arguments of a potential for one robot: pose and velocity in G, tilt, uncertainty of its view,
/// and the third body of the coupling.
///
/// The tilt xi is the tangent of the thrust's angle to the vertical: horizontal over vertical
/// specific thrust, by its components in V. The thrust points along (xi_f, xi_s, 1). An upright
/// robot has (0, 0).
template <class S>
struct Sight : Pose<S> {
  Vec3<S> v;        ///< velocity [m/s]
  Vec2<S> lean{};   ///< tilt xi = (xi_f, xi_s), forward and to the left [-]
  S uncertainty{};  ///< lateral standard deviation of the observed body's relative position [m]; 0: exact
  Vec3<S> third{};  ///< in the first body of a coupling: position in G of the third one [m]
};

/// Numbers of a Sight that follow from state and input, in the order p, d, v, lean.
inline constexpr int sight_size = 10;

template <class S, class Row>
Sight<S> sight_from(const Row& r) {
  return {{{r[0], r[1], r[2]}, {r[3], r[4]}}, {r[5], r[6], r[7]}, {r[8], r[9]}};
}

template <class S, class Row>
void write_sight(const Sight<S>& s, Row&& r) {
  r[0] = s.p.x, r[1] = s.p.y, r[2] = s.p.z;
  r[3] = s.d.x, r[4] = s.d.y;
  r[5] = s.v.x, r[6] = s.v.y, r[7] = s.v.z;
  r[8] = s.lean.x, r[9] = s.lean.y;
}

/// Rotates v_V from V to G: R(d) v, (22). The transpose rotates from G to V, (43).
template <class S>
Vec2<S> rotate(const Vec2<S>& d, const Vec2<S>& v_V) {
  return {d.x * v_V.x - d.y * v_V.y, d.y * v_V.x + d.x * v_V.y};
}

/// Ranges of the angles [rad] and of the lever arm [m] of a sensor; pi/2 and pi rounded up to four
/// digits.
inline constexpr Bounds mount_pitches = {-1.5708, 1.5708, "in [-pi/2, pi/2]"};
inline constexpr Bounds mount_turns = {-3.1416, 3.1416, "in [-pi, pi]"};
inline constexpr Bounds mount_offsets = {-5.0, 5.0, "-5 to 5"};

/// Frame to which a sensor is fixed.
enum class MountFrame {
  level,  ///< V, as in the paper: a gimbal holds the sensor level
  body,   ///< B, which tilts with the thrust
};
inline constexpr std::array<std::string_view, 2> mount_frames = {"level", "body"};

/// Place of a sensor on its robot [m]: x ahead, y to the left, z up. A number alone is along x.
struct LeverArm : Vec3<double> {
  constexpr LeverArm(double ahead = 0.0, double left = 0.0, double up = 0.0)
      : Vec3<double>{ahead, left, up} {}
  friend constexpr bool operator==(const LeverArm& a, const LeverArm& b) {
    return a.x == b.x && a.y == b.y && a.z == b.z;
  }
  constexpr bool is_along_x() const { return y == 0.0 && z == 0.0; }
};

/// Mount of a sensor on the robot, (45): the place of its frame S, and the rotation from S to the
/// frame F of the mount, V or B,
///
///   R_FS = R_z(yaw) R_y(pitch) R_x(roll),
///
/// so the sensor axis in F is (cos yaw cos pitch, sin yaw cos pitch, -sin pitch): yaw > 0 looks to
/// the left, pitch > 0 down. Roll > 0 turns the picture about the axis, its left side up.
/// All users transform by these functions: points of G by operator(), points of S by point_in_F(),
/// directions of S by attitude().
///
/// B is V pitched and rolled: z along the thrust, x in the vertical plane of the heading. Its axes
/// in V, before normalisation, are, with xi the tilt (docs/equations.md, 1),
///
///   x_B ~ (1, 0, -xi_f),   y_B ~ (-xi_f xi_s, 1 + xi_f^2, -xi_s),   z_B ~ (xi_f, xi_s, 1)
struct SensorMount {
  double pitch = 0.5;                    ///< beta
  LeverArm offset = 0.17;                ///< d_s
  MountFrame frame = MountFrame::level;  ///< F
  double sigmas = 0.0;                   ///< of Sight::uncertainty
  double yaw = 0.0, roll = 0.0;

  static constexpr auto parameters() {
    using M = SensorMount;
    return Parameters{parameter("frame", &M::frame, mount_frames, "of angles and offset: V or B"),
                      parameter("yaw", &M::yaw, "rad", mount_turns, "> 0 looks to the left"),
                      parameter("pitch", &M::pitch, "rad", mount_pitches, "> 0 looks down"),
                      parameter("roll", &M::roll, "rad", mount_turns, "about the axis, > 0: left side up"),
                      KeyText{"offset", "-5 to 5 m",
                              "lever arm in the frame: [ahead, left, up], or a number ahead", "0.17"},
                      parameter("sigmas", &M::sigmas, "", {0.0, 6.0, "0 to 6"},
                                "standard deviations of the observed position by which views shrink; 0 of a "
                                "further sensor")};
  }
  bool operator==(const SensorMount&) const = default;

  /// R_FS: its columns are the axes of S in F.
  Mat<3, 3> attitude() const noexcept {
    if (yaw == 0.0 && roll == 0.0) return turn_y(pitch);
    return turn_z(yaw) * turn_y(pitch) * turn_x(roll);
  }
  /// Position in F, relative to the robot, of a point of S.
  Vec3<double> point_in_F(const Vec3<double>& p_S) const noexcept { return offset + attitude() * p_S; }
  /// Distance from the sensor to the point of its axis that is this far from the robot [m]; the
  /// nearest one if all are farther.
  double depth_at(double distance) const noexcept {
    const double along = (transposed(attitude()) * offset).x;
    return std::max(
        0.0, sqrt(std::max(0.0, square(distance) - dot<double>(offset, offset) + square(along))) - along);
  }

  /// Transforms a point of G into the sensor frame S of an upright robot: p_S = T_SG p_G, (46),
  /// (48).
  template <class S>
  Vec3<S> operator()(const Pose<S>& robot, const Vec3<S>& point) const {
    const double c = cos(pitch), s = sin(pitch);
    const Vec3<S> r = robot.p - point;
    const S eta = offset.x + robot.d.x * r.x + robot.d.y * r.y;
    if (!is_in_plane()) return from_sensor(eta, S(robot.d.y * r.x - robot.d.x * r.y), r.z);
    return {r.z * s - eta * c, robot.d.y * r.x - robot.d.x * r.y, -(r.z * c) - eta * s};
  }

  /// The same for a tilted robot: p_S = T_SB T_BV T_VG p_G if the sensor is fixed to the body. At
  /// zero tilt both give the same bits.
  template <class S>
  Vec3<S> operator()(const Sight<S>& robot, const Vec3<S>& point) const {
    if (frame == MountFrame::level)
      return farthest(robot.uncertainty, (*this)(static_cast<const Pose<S>&>(robot), point));
    const double c = cos(pitch), s = sin(pitch);
    const Vec2<S>& xi = robot.lean;
    const Vec3<S> r = robot.p - point;
    // From the point to the robot, in V; ahead with the lever arm, y to the right.
    const S arm = offset.x + robot.d.x * r.x + robot.d.y * r.y, ahead = robot.d.x * r.x + robot.d.y * r.y;
    const S right = robot.d.y * r.x - robot.d.x * r.y;
    const S of_x = 1.0 + square(xi.x), of_z = of_x + square(xi.y);
    const S per_x = 1.0 / sqrt(of_x), per_z = 1.0 / sqrt(of_z);
    // In B; the tilt does not rotate the lever arm itself.
    const S eta = offset.x * (1.0 - per_x) + per_x * (arm - xi.x * r.z);
    const S y = (of_x * right + xi.y * (xi.x * ahead + r.z)) * (per_x * per_z);
    const S z = (r.z + xi.x * ahead - xi.y * right) * per_z;
    if (!is_in_plane()) return farthest(robot.uncertainty, from_sensor(eta, y, z));
    return farthest(robot.uncertainty, Vec3<S>{z * s - eta * c, y, -(z * c) - eta * s});
  }

  /// Whether the sensor sits on the x axis of F and looks along its xz plane, as in the paper: (48)
  /// then has fewer operations.
  bool is_in_plane() const noexcept { return yaw == 0.0 && roll == 0.0 && offset.is_along_x(); }

  /// p_S = R_FS^T (p_F - d_s) of a point.
  /// @param eta          from the point to the sensor, along x of F [m]
  /// @param left, below  from the robot to the point along y of F, from the point to the robot along z [m]
  template <class S>
  Vec3<S> from_sensor(const S& eta, const S& left, const S& below) const {
    const Mat<3, 3> R = attitude();
    const S x = -eta, y = left - offset.y, z = -below - offset.z;
    const auto along = [&](int axis) { return R(0, axis) * x + R(1, axis) * y + R(2, axis) * z; };
    return {along(0), along(1), along(2)};
  }

  /// Of the points displaced laterally by `sigmas` standard deviations from p_S, the one farthest
  /// off the axis. If it is in view, all are. Within about that radius rho of the axis the
  /// direction is undefined, so the displacement is smaller: (y, z) is scaled by 1 + rho / sqrt(y^2
  /// + z^2 + rho^2), docs/equations.md, 1.
  template <class S>
  Vec3<S> farthest(const S& uncertainty, const Vec3<S>& p_S) const {
    if (sigmas == 0.0) return p_S;
    constexpr double axis = 1e-12;  // keeps the root positive for rho = 0 on the axis [m^2]
    const S rho = sigmas * uncertainty;
    const S grown = 1.0 + rho / sqrt(square(p_S.y) + square(p_S.z) + square(rho) + axis);
    return {p_S.x, grown * p_S.y, grown * p_S.z};
  }
};

/// Angle between the sensor axis and a point of S [rad], in [0, pi], (71); 0 at the sensor itself.
double off_axis(const Vec3<double>& p_S);

/// Angle between the sensor axis and a point of G [rad]. The overload for a Pose assumes an upright
/// robot; the one for a Sight includes its tilt.
inline double view_angle(const SensorMount& mount, const Pose<double>& robot, const Vec3<double>& point) {
  return off_axis(mount(robot, point));
}
template <std::same_as<Sight<double>> Seen>
double view_angle(const SensorMount& mount, const Seen& robot, const Vec3<double>& point) {
  return off_axis(mount(robot, point));
}

// Type-erased robot model, so that teams can be composed at run time.

/// Requirements on a robot's struct; see robots.hpp. Optional: `u_max()` and `u_min()`, the limits
/// of its inputs, by default 1 and -u_max. `parameters()` describes its parameters
/// (base.hpp), and `check()` rejects inconsistent ones. With `--threads` several threads
/// call its functions concurrently.
template <class M>
concept RobotModel = requires(const M& m, const std::array<double, M::nx>& x,
                              const std::array<double, M::nu>& u) {
  { m.f(x, u) } -> std::same_as<std::array<double, M::nx>>;
  { m.pose(x) } -> std::same_as<Pose<double>>;
  { m.at_rest(Pose<double>{}) } -> std::same_as<std::array<double, M::nx>>;
  { M::name } -> std::convertible_to<std::string_view>;
};

/// Sight of a robot at state x under input u. The pose is pose(x); the velocity is its rate under
/// x' = f(x, u). The tilt is that of the commanded thrust, forward and to the left (see Pose),
/// from an optional `Vec2<S> lean(x, u)`. Without it the robot is upright.
template <class S, class M>
Sight<S> sight(const M& model, const std::array<S, M::nx>& x, const std::array<S, M::nu>& u) {
  const std::array<S, M::nx> rate = model.f(x, u);
  std::array<Tangent<S>, M::nx> moving;
  for (std::size_t i = 0; i < M::nx; ++i) moving[i] = {x[i], rate[i]};
  const Pose<Tangent<S>> pose = model.pose(moving);
  Sight<S> seen = {{{pose.p.x.value, pose.p.y.value, pose.p.z.value}, {pose.d.x.value, pose.d.y.value}},
                   {pose.p.x.rate, pose.p.y.rate, pose.p.z.rate}};
  if constexpr (requires { model.lean(x, u); }) seen.lean = model.lean(x, u);
  return seen;
}

/// A robot model of any type; immutable and shared. Arrays have the lengths nx and nu. If a
/// function of the struct throws, its results are NaN.
class Model {
 public:
  /// @throws std::invalid_argument for a parameter out of its range, and from the robot's own
  /// check()
  template <RobotModel M>
  Model(const M& model) : block_(std::make_shared<const Block<M>>(model)) {
    if constexpr (Described<M>) check_parameters(model);
    if constexpr (requires { model.check(); }) model.check();
  }

  /// Interface of a robot of any kind; Block implements it for a struct.
  struct Interface {
    int nx = 0, nu = 0;
    std::string_view name;
    bool turns = false, rolls = false;
    std::span<const std::string_view> states, inputs;
    std::vector<double> u_min, u_max;

    virtual ~Interface() = default;
    virtual std::vector<ParameterText> parameters() const { return {}; }
    virtual void f(const double* x, const double* u, double* rate) const noexcept = 0;
    virtual Sight<double> sight(const double* x, const double* u) const noexcept = 0;
    virtual void step(double* x, const double* u, double dt) const noexcept = 0;
    virtual void at_rest(std::span<const Pose<double>> poses, double* x, std::ptrdiff_t stage,
                         std::ptrdiff_t entry) const noexcept = 0;
    virtual void push(const double* x, const Vec3<double>& a, double* rate) const noexcept = 0;
    virtual bool normalise(double* x) const noexcept = 0;
    virtual void f(std::span<const Symbol> x, std::span<const Symbol> u, std::span<Symbol> rate) const = 0;
    virtual Sight<Symbol> sight(std::span<const Symbol> x, std::span<const Symbol> u) const = 0;
  };
  /// A robot whose numbers of states and inputs are known only at run time, such as a TextRobot.
  explicit Model(std::shared_ptr<const Interface> block) : block_(std::move(block)) {}

  int nx() const { return block_->nx; }
  int nu() const { return block_->nu; }
  std::string_view name() const { return block_->name; }
  /// Names of the states, nx, and of the inputs, nu; x_0, x_1, ... and u_0, u_1, ... where the robot has none.
  std::span<const std::string_view> states() const { return block_->states; }
  std::span<const std::string_view> inputs() const { return block_->inputs; }
  /// Default limits of the inputs; the team may override them.
  std::span<const double> u_min() const { return block_->u_min; }
  std::span<const double> u_max() const { return block_->u_max; }
  /// Descriptions of its parameters; empty if the robot does not describe them.
  std::vector<ParameterText> parameters() const { return block_->parameters(); }
  /// Whether its state includes a heading; else the heading is along x of G.
  bool turns() const { return block_->turns; }
  /// Whether it drives on wheels, which may slip.
  bool rolls() const { return block_->rolls; }

  /// rate = x' = f(x, u).
  void f(const double* x, const double* u, double* rate) const noexcept { block_->f(x, u, rate); }
  Sight<double> sight(const double* x, const double* u) const noexcept { return block_->sight(x, u); }
  /// Advances x by one Runge-Kutta step of dt [s] with u held.
  void step(double* x, const double* u, double dt) const noexcept { block_->step(x, u, dt); }
  /// Writes the state at rest in a pose; a heading of (0, 0) means any heading.
  void at_rest(const Pose<double>& pose, double* x) const noexcept { at_rest({&pose, 1}, x, 0, 1); }
  /// The same for many poses; entry i of the k-th state at x[k stage + i entry].
  void at_rest(std::span<const Pose<double>> poses, double* x, std::ptrdiff_t stage,
               std::ptrdiff_t entry) const noexcept {
    block_->at_rest(poses, x, stage, entry);
  }
  /// Adds the rate of the state under an acceleration in G [m/s^2] to `rate`; adds nothing for a
  /// model without `push`.
  void push(const double* x, const Vec3<double>& acceleration, double* rate) const noexcept {
    block_->push(x, acceleration, rate);
  }
  /// Projects a measured state onto its manifold (|d| = 1, psi within (-pi, pi]).
  /// @return false if that is impossible: a number is not finite, or the heading is (0, 0)
  [[nodiscard]] bool normalise(double* x) const noexcept { return block_->normalise(x); }

  /// Symbolic f and sight, for derivatives.
  void f(std::span<const Symbol> x, std::span<const Symbol> u, std::span<Symbol> rate) const {
    block_->f(x, u, rate);
  }
  Sight<Symbol> sight(std::span<const Symbol> x, std::span<const Symbol> u) const {
    return block_->sight(x, u);
  }

 private:
  template <RobotModel M>
  struct Block;

  std::shared_ptr<const Interface> block_;
};

/// Scales d to |d| = 1.
/// @return false if d is (nearly) (0, 0) or not finite
[[nodiscard]] bool normalise_heading(double* d) noexcept;
/// psi wrapped to (-pi, pi], (15).
double wrap_angle(double psi) noexcept;
[[nodiscard]] bool all_finite(std::span<const double> values) noexcept;

/// Characters of "u_0", "u_1", ... (letter u), four each.
template <char letter, std::size_t n>
requires(n <= 100) inline constexpr std::array<char, 4 * n> numbered_text = [] {
  std::array<char, 4 * n> text{};
  for (std::size_t i = 0; i < n; ++i) {
    text[4 * i] = letter;
    text[4 * i + 1] = '_';
    text[4 * i + 2] = static_cast<char>('0' + (i < 10 ? i : i / 10));
    if (i >= 10) text[4 * i + 3] = static_cast<char>('0' + i % 10);
  }
  return text;
}();
/// Names of the states or inputs of a robot that does not name them.
template <char letter, std::size_t n>
inline constexpr std::array<std::string_view, n> numbered_names = [] {
  std::array<std::string_view, n> names;
  for (std::size_t i = 0; i < n; ++i) names[i] = {&numbered_text<letter, n>[4 * i], i < 10 ? 3U : 4U};
  return names;
}();

template <RobotModel M>
struct Model::Block final : Model::Interface {
  M model;

  explicit Block(const M& m) : model(m) {
    this->nx = M::nx;
    this->nu = M::nu;
    this->name = M::name;
    if constexpr (requires { M::states; }) {
      static_assert(std::size(M::states) == M::nx, "a name for each state");
      this->states = M::states;
    } else {
      this->states = numbered_names<'x', M::nx>;
    }
    if constexpr (requires { M::inputs; }) {
      static_assert(std::size(M::inputs) == M::nu, "a name for each input");
      this->inputs = M::inputs;
    } else {
      this->inputs = numbered_names<'u', M::nu>;
    }
    this->rolls = requires { M::rolls; };
    this->turns = requires { M::heading_at; }
    || requires { M::angle_at; };
    this->u_max.assign(inputs_n, 1.0);
    if constexpr (requires { m.u_max(); }) copy_limits(m.u_max(), this->u_max);
    for (const double most : this->u_max) this->u_min.push_back(-most);
    if constexpr (requires { m.u_min(); }) copy_limits(m.u_min(), this->u_min);
  }

  template <std::size_t n>
  static void copy_limits(const std::array<double, n>& from, std::vector<double>& to) {
    to.assign(from.begin(), from.end());
  }
  template <std::size_t n, class S>
  static std::array<S, n> take(const S* values) {
    std::array<S, n> a;
    for (std::size_t i = 0; i < n; ++i) a[i] = values[i];
    return a;
  }
  static constexpr std::size_t states_n = M::nx, inputs_n = M::nu;

  std::vector<ParameterText> parameters() const override { return parameter_texts(model); }
  void f(const double* x, const double* u, double* rate) const noexcept override {
    write_or_nan(rate, states_n, [&] {
      const auto r = model.f(take<states_n>(x), take<inputs_n>(u));
      for (std::size_t i = 0; i < states_n; ++i) rate[i] = r[i];
    });
  }
  Sight<double> sight(const double* x, const double* u) const noexcept override {
    try {
      return sightline::sight(model, take<states_n>(x), take<inputs_n>(u));
    } catch (...) {
      constexpr double nan = std::numeric_limits<double>::quiet_NaN();
      return {{{nan, nan, nan}, {nan, nan}}, {nan, nan, nan}, {nan, nan}};
    }
  }
  void step(double* x, const double* u, double dt) const noexcept override {
    const auto held = take<inputs_n>(u);
    write_or_nan(x, states_n, [&] {
      const auto rate = [&](const std::array<double, states_n>& z) { return model.f(z, held); };
      const std::array<double, states_n> after = rk4_step(rate, take<states_n>(x), dt);
      std::copy(after.begin(), after.end(), x);
    });
  }
  void at_rest(std::span<const Pose<double>> poses, double* x, std::ptrdiff_t stage,
               std::ptrdiff_t entry) const noexcept override {
    for (const Pose<double>& pose : poses) {
      std::array<double, states_n> r;
      write_or_nan(r.data(), states_n, [&] { r = model.at_rest(pose); });
      for (std::size_t i = 0; i < states_n; ++i) x[static_cast<std::ptrdiff_t>(i) * entry] = r[i];
      x += stage;
    }
  }
  void push([[maybe_unused]] const double* x, [[maybe_unused]] const Vec3<double>& a,
            [[maybe_unused]] double* rate) const noexcept override {
    if constexpr (requires { model.push(take<states_n>(x), a); }) {
      write_or_nan(rate, states_n, [&] {
        const auto r = model.push(take<states_n>(x), a);
        for (std::size_t i = 0; i < states_n; ++i) rate[i] += r[i];
      });
    }
  }
  bool normalise(double* x) const noexcept override {
    if (!all_finite({x, states_n})) return false;
    if constexpr (requires { M::heading_at; }) return normalise_heading(x + M::heading_at);
    if constexpr (requires { M::angle_at; }) x[M::angle_at] = wrap_angle(x[M::angle_at]);
    return true;
  }
  void f(std::span<const Symbol> x, std::span<const Symbol> u, std::span<Symbol> rate) const override {
    const auto r = model.f(take<states_n>(x.data()), take<inputs_n>(u.data()));
    for (std::size_t i = 0; i < states_n; ++i) rate[i] = r[i];
  }
  Sight<Symbol> sight(std::span<const Symbol> x, std::span<const Symbol> u) const override {
    return sightline::sight(model, take<states_n>(x.data()), take<inputs_n>(u.data()));
  }
};

// Robot models. Each is one struct: x' = f(x, u), pose(x), and the state at rest in a given pose.
//
// A user-defined robot is a struct of the same form. Everything else (velocity in G, derivatives)
// follows from it.

namespace detail {

/// Common parameters of (24) and (15).
template <class M>
constexpr auto multirotor_parameters() {
  return Parameters{parameter("b_z", &M::b_z, "m/s", any_finite, "climb per command"),
                    parameter("b_psi", &M::b_psi, "rad/s", any_finite, "yaw rate per command"),
                    parameter("a_f", &M::a_f, "1/s", any_finite, "forward drag"),
                    parameter("b_f", &M::b_f, "m/s^2", any_finite, "forward acceleration per command"),
                    parameter("a_s", &M::a_s, "1/s", any_finite, "sideward drag"),
                    parameter("b_s", &M::b_s, "m/s^2", any_finite, "sideward acceleration per command")};
}

}  // namespace detail

/// Hover-controlled multirotor with the heading as a direction vector, (24). The defaults are the
/// AR.Drone 2.0, (16).
///
///   x = [p_x, p_y, p_z, d_x, d_y, v_f, v_s]  position [m], heading, velocity forward and to the
///                                            left in V [m/s]
///   u = [u_f, u_s, u_z, u_psi]               normalised commands, within [-1, 1]
struct Multirotor {
  static constexpr int nx = 7, nu = 4;
  static constexpr std::string_view name = "multirotor";
  static constexpr std::array<std::string_view, nx> states = {"p_x", "p_y", "p_z", "d_x",
                                                              "d_y", "v_f", "v_s"};
  static constexpr std::array<std::string_view, nu> inputs = {"u_f", "u_s", "u_z", "u_psi"};

  double b_z = 1.0;
  double b_psi = 1.6;
  double a_f = -0.5092;
  double b_f = 1.458;
  double a_s = -0.5092;
  double b_s = 1.458;

  static constexpr auto parameters() { return detail::multirotor_parameters<Multirotor>(); }

  template <class S>
  std::array<S, nx> f(const std::array<S, nx>& x, const std::array<S, nu>& u) const {
    const Vec2<S> d = {x[3], x[4]}, v_V = {x[5], x[6]};
    const Vec2<S> v_G = rotate(d, v_V);
    const S rate = b_psi * u[3];
    return {v_G.x,
            v_G.y,
            b_z * u[2],
            -(d.y * rate),
            d.x * rate,
            a_f * v_V.x + b_f * u[0],
            a_s * v_V.y - b_s * u[1]};
  }

  template <class S>
  Pose<S> pose(const std::array<S, nx>& x) const {
    return {{x[0], x[1], x[2]}, {x[3], x[4]}};
  }

  /// Tilt: that of the commanded acceleration. Aerodynamic drag is not part of the thrust.
  template <class S>
  Vec2<S> lean(const std::array<S, nx>&, const std::array<S, nu>& u) const {
    return {(b_f / gravity) * u[0], (-b_s / gravity) * u[1]};
  }

  std::array<double, nx> at_rest(const Pose<double>& pose) const {
    return {pose.p.x, pose.p.y, pose.p.z, pose.d.x, pose.d.y, 0.0, 0.0};
  }

  /// Rate of the state under an acceleration a in G [m/s^2]. It does not affect the vertical
  /// velocity, which is commanded.
  std::array<double, nx> push(const std::array<double, nx>& x, const Vec3<double>& a) const {
    const Vec2<double> a_V = rotate<double>({x[3], -x[4]}, {a.x, a.y});
    return {0, 0, 0, 0, 0, a_V.x, a_V.y};
  }

  /// Index of the heading (d_x, d_y) in the state.
  static constexpr int heading_at = 3;
};

/// The same multirotor with the yaw angle psi as a state, (14), (15). It demonstrates the problem
/// that (24) avoids: the angle jumps at pi, and a controller that tracks it there keeps rotating
/// (Fig. 4).
///
///   x = [p_x, p_y, p_z, psi, v_f, v_s]
struct AngleMultirotor {
  static constexpr int nx = 6, nu = 4;
  static constexpr std::string_view name = "angle_multirotor";
  static constexpr std::array<std::string_view, nx> states = {"p_x", "p_y", "p_z", "psi", "v_f", "v_s"};
  static constexpr std::array<std::string_view, nu> inputs = Multirotor::inputs;

  double b_z = 1.0, b_psi = 1.6, a_f = -0.5092, b_f = 1.458, a_s = -0.5092, b_s = 1.458;

  static constexpr auto parameters() { return detail::multirotor_parameters<AngleMultirotor>(); }

  template <class S>
  std::array<S, nx> f(const std::array<S, nx>& x, const std::array<S, nu>& u) const {
    const Vec2<S> v_V = {x[4], x[5]};
    const Vec2<S> v_G = rotate({cos(x[3]), sin(x[3])}, v_V);
    return {v_G.x, v_G.y, b_z * u[2], b_psi * u[3], a_f * v_V.x + b_f * u[0], a_s * v_V.y - b_s * u[1]};
  }

  template <class S>
  Pose<S> pose(const std::array<S, nx>& x) const {
    return {{x[0], x[1], x[2]}, {cos(x[3]), sin(x[3])}};
  }

  template <class S>
  Vec2<S> lean(const std::array<S, nx>&, const std::array<S, nu>& u) const {
    return {(b_f / gravity) * u[0], (-b_s / gravity) * u[1]};
  }

  std::array<double, nx> at_rest(const Pose<double>& pose) const {
    return {pose.p.x, pose.p.y, pose.p.z, std::atan2(pose.d.y, pose.d.x), 0.0, 0.0};
  }

  std::array<double, nx> push(const std::array<double, nx>& x, const Vec3<double>& a) const {
    const Vec2<double> a_V = rotate<double>({cos(x[3]), -sin(x[3])}, {a.x, a.y});
    return {0, 0, 0, 0, a_V.x, a_V.y};
  }

  /// Index of the angle psi in the state.
  static constexpr int angle_at = 3;
};

/// A body that is not controlled, a target or an obstacle; its velocity is constant.
///
///   x = [p_x, p_y, p_z, v_x, v_y, v_z]
struct Body {
  static constexpr int nx = 6, nu = 0;
  static constexpr std::string_view name = "body";
  static constexpr std::array<std::string_view, nx> states = {"p_x", "p_y", "p_z", "v_x", "v_y", "v_z"};
  static constexpr std::array<std::string_view, nu> inputs = {};

  template <class S>
  std::array<S, nx> f(const std::array<S, nx>& x, const std::array<S, nu>&) const {
    return {x[3], x[4], x[5], S(0.0), S(0.0), S(0.0)};
  }

  template <class S>
  Pose<S> pose(const std::array<S, nx>& x) const {
    return {{x[0], x[1], x[2]}, {S(1.0), S(0.0)}};
  }

  std::array<double, nx> at_rest(const Pose<double>& pose) const {
    return {pose.p.x, pose.p.y, pose.p.z, 0, 0, 0};
  }
};

/// Model of an external robot in the couplings of others: a Body that keeps its heading.
///
///   x = [p_x, p_y, p_z, v_x, v_y, v_z, d_x, d_y]
struct PosedBody {
  static constexpr int nx = 8, nu = 0;
  static constexpr std::string_view name = "posed_body";
  static constexpr std::array<std::string_view, nx> states = {"p_x", "p_y", "p_z", "v_x",
                                                              "v_y", "v_z", "d_x", "d_y"};
  static constexpr std::array<std::string_view, nu> inputs = {};

  template <class S>
  std::array<S, nx> f(const std::array<S, nx>& x, const std::array<S, nu>&) const {
    return {x[3], x[4], x[5], S(0.0), S(0.0), S(0.0), S(0.0), S(0.0)};
  }

  template <class S>
  Pose<S> pose(const std::array<S, nx>& x) const {
    return {{x[0], x[1], x[2]}, {x[6], x[7]}};
  }

  std::array<double, nx> at_rest(const Pose<double>& pose) const {
    return {pose.p.x, pose.p.y, pose.p.z, 0, 0, 0, pose.d.x, pose.d.y};
  }

  /// Index of the heading d in the state.
  static constexpr int heading_at = 6;
};

/// Writes a robot's Sight as the state of a Body or, if x has room for a heading, of a PosedBody.
inline void write_body(const Sight<double>& seen, std::span<double> x) {
  x[0] = seen.p.x, x[1] = seen.p.y, x[2] = seen.p.z;
  x[3] = seen.v.x, x[4] = seen.v.y, x[5] = seen.v.z;
  if (x.size() == PosedBody::nx) x[6] = seen.d.x, x[7] = seen.d.y;
}

// A user-defined robot as text: x' = f(x, u) in the formula language, with names for states and
// inputs.

/// Maximum numbers of states and inputs of a text robot.
inline constexpr std::size_t text_states_max = 16, text_inputs_max = 8;

/// Definition of a robot by formulas. A car, as an example:
///
///   TextRobot{.states = {"p_x", "p_y", "p_z", "psi", "v"},
///             .inputs = {"a", "w"},
///             .f = {"v * cos(psi)", "v * sin(psi)", "0", "w", "a - drag * v"},
///             .position = {"p_x", "p_y", "p_z"},
///             .heading = {"psi"},
///             .parameters = {{"drag", "0.5"}}}
///
/// All numbers are in SI units; f may use the states, the inputs and the parameters. Corners (abs,
/// min, max, norm) are smoothed over 1e-6. The robot runs in the interpreter and gives the same
/// bits as a struct with the same formulas.
struct TextRobot {
  std::string name = "text";
  std::vector<std::string> states, inputs;  ///< unique names
  std::vector<std::string> f;               ///< the rate of each state
  std::array<std::string, 3> position;      ///< names of the states p_x, p_y and p_z in G [m]
  std::vector<std::string> heading{};  ///< name of the state psi [rad], or the two of d; empty: along x of G
  std::vector<Definition> parameters{};  ///< numbers, or formulas of other parameters
  std::vector<double> u_min{},
      u_max{};  ///< limits of the inputs, which the team may override; empty: -1 and 1

  /// The names that its formulas may use.
  /// @throws FormulaError for a parameter, std::invalid_argument for an invalid name of a state or
  /// an input
  Vocabulary vocabulary() const;
  /// @throws as vocabulary(); FormulaError for a rate; std::invalid_argument for inconsistent sizes
  /// or names
  Model model() const;
  /// The same from recorded rates, over states, then inputs; the rates in `f` are not used, and
  /// `parameters` are only checked.
  /// @throws as vocabulary(); std::invalid_argument for inconsistent sizes or names
  Model model(std::vector<Expression> rates) const;
};

}  // namespace sightline
