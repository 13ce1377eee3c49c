/// Type-erased robot model, so that teams can be composed at run time.
#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "sightline/base/integrate.hpp"
#include "sightline/base/or_nan.hpp"
#include "sightline/base/parameter.hpp"
#include "sightline/base/tangent.hpp"
#include "sightline/formula/trace.hpp"
#include "sightline/model/frames.hpp"

namespace sightline {

/// Requirements on a robot's struct; see robots.hpp. Optional: `u_max()` and `u_min()`, the limits
/// of its inputs, by default 1 and -u_max. `parameters()` describes its parameters
/// (base/parameter.hpp), and `check()` rejects inconsistent ones. With `--threads` several threads
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
/// x' = f(x, u). The tilt is that of the commanded thrust, forward and to the left (frames.hpp),
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

template <RobotModel M>
struct Model::Block final : Model::Interface {
  M model;

  explicit Block(const M& m) : model(m) {
    this->nx = M::nx;
    this->nu = M::nu;
    this->name = M::name;
    if constexpr (requires { M::states; }) this->states = M::states;
    if constexpr (requires { M::inputs; }) this->inputs = M::inputs;
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

}  // namespace sightline
