/// User-defined potential, from limits as text: inequalities, unit step, slope, sigmoid (section
/// 5).
///
///   const Region sonar = Region(all_of({"bearing < half_angle", "0.3 m < range < 6 m"}),
///                               {{"half_angle", "20 deg"}}).slope(Softplus{}).sigmoid(5.0);
///
/// A formula may use (docs/potentials.md defines the language and the mathematics)
///
///   x, y, z                    the target in the sensor frame S, x on the axis, y left, z up [m]
///   range, bearing             its distance from the sensor [m] and its angle from the axis [rad]
///   azimuth, elevation         its angles in S, to the left and up [rad]
///   r_x, r_y, r_z, distance    from observer to target in G, and its length [m]
///   observer.p_x .. p_z        position in G [m]
///   observer.d_x, .d_y         heading in G
///   observer.v_x .. v_z        velocity in G [m/s]
///   observer.lean_f, .lean_s   tangents of the tilt, forward and to the left
///   target.p_x .. .lean_s      the same of the target
///   t                          the time [s]
///   third.p_x .. p_z           a third body of the coupling, such as an occluding one, in G [m]
#pragma once

#include <array>
#include <initializer_list>
#include <memory>
#include <set>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "sightline/formula/parse.hpp"
#include "sightline/potential/potential.hpp"

namespace sightline {

/// A comparison as text, or a nested combination of them.
struct Limits {
  enum class Kind { limit, all_of, any_of, opposite };

  Kind kind = Kind::limit;
  std::string text;           ///< of a limit: "range < 4 m"
  std::string grows_with{};   ///< of a limit: formula that scales its quadratic slope; empty: that of the
                              ///< slope
  std::vector<Limits> parts;  ///< of the other kinds; `opposite` has one

  Limits(std::string limit, std::string grows = {}) : text(std::move(limit)), grows_with(std::move(grows)) {}
  Limits(const char* limit) : Limits(std::string(limit)) {}
  Limits(Kind of, std::vector<Limits> these) : kind(of), parts(std::move(these)) {}
};

/// Conjunction, disjunction and negation of limits: `not all_of({"x > 0 m", "range < 4 m"})`.
Limits all_of(std::vector<Limits> parts);
Limits any_of(std::vector<Limits> parts);
Limits operator!(Limits limits);

/// A named number or formula; a number may have a range.
struct Parameter {
  std::string name, text;
  std::string low{}, high{};  ///< formulas of the bounds; empty: none

  Parameter(std::string called, std::string formula, std::string least = {}, std::string most = {})
      : name(std::move(called)), text(std::move(formula)), low(std::move(least)), high(std::move(most)) {}
  Parameter(std::string called, double value);
};

/// Value 1 outside a limit; the gradient is zero except at the limit, (30), (33).
struct NoSlope {};
/// Slope of the paper: kappa_H + kappa_G grows_with outside a limit, (34).
struct Quadratic {
  double kappa_G = 0.01;               ///< >= 0 [1 / unit of `grows_with`]
  std::string grows_with = "range^2";  ///< formula; a limit may have its own
  double kappa_H = 1.0;                ///< height of the step, > 0
};
/// kappa_H + kappa_G c outside a limit c <= 0. The smooth form is the integral of the sigmoid,
/// whose gradient never vanishes.
struct Softplus {
  double kappa_G = 1.0;  ///< > 0 [1 / unit of the limit]
  double kappa_H = 1.0;  ///< height of the step, >= 0
};
using Slope = std::variant<NoSlope, Quadratic, Softplus>;

/// Maximum nesting of all_of, any_of and not, and maximum number of limits.
inline constexpr int region_depth_max = 16;
inline constexpr std::size_t region_limits_max = 64;
/// Maximum number of operations of all limits together.
inline constexpr std::size_t region_steps_max = 2000;

class Region {
 public:
  /// @throws FormulaError if a text is not a formula; std::invalid_argument for a parameter out of
  /// range or too many limits
  Region(const Limits& inside, const std::vector<Parameter>& parameters = {});

  /// The same region with another slope; default NoSlope.
  Region slope(Slope slope) const;
  /// The same region with this sharpness [1 / unit of the limits]; default 1.
  Region sigmoid(double kappa_A) const;
  /// The same region with this sensor mount on the observer.
  Region seen_from(const SensorMount& mount) const;
  /// The same region with another smoothing width, in the unit of the smoothed function; default
  /// 1e-3. It smooths roots, and with them abs, min, max and norm.
  Region smoothed_over(double width) const;
  Region named(std::string name) const;

  /// l [-], which the solver uses: with the sigmoid as the step.
  double operator()(const Sight<double>& observer, const Sight<double>& target, double t) const;
  Symbol operator()(const Sight<Symbol>& observer, const Sight<Symbol>& target, const Symbol& t) const;

  /// 0 inside the region and 1 outside, (29), from the unsmoothed inequalities.
  double unit_step(const Sight<double>& observer, const Sight<double>& target, double t) const;
  /// The unit step with its slope, (34).
  double sloped(const Sight<double>& observer, const Sight<double>& target, double t) const;
  /// > 0 outside: the largest c of all_of, the smallest of any_of, each in its own unit. Never
  /// throws or allocates.
  double violation(const Sight<double>& observer, const Sight<double>& target, double t) const noexcept;

  const std::string& name() const { return name_; }
  static constexpr std::string_view limit_unit = "in the unit of its formula";
  double kappa_A() const { return kappa_A_; }
  const SensorMount& mount() const { return mount_; }
  double width() const { return width_; }
  /// Whether a limit depends on the target in the sensor frame: x, y, z or a quantity derived from
  /// them.
  bool is_view() const;
  /// Whether a formula depends on the position of a third body.
  bool sees_third() const;
  /// Each of the limits that all have to hold, as a region of its own; a copy of itself if there is
  /// one.
  std::vector<Region> conjuncts() const;
  /// Names of the functions whose corners are smoothed.
  std::set<std::string> smoothed() const;
  /// @throws std::invalid_argument naming the field, its value and its range
  void check() const;

  /// The names that a formula with these parameters may use.
  /// @throws as the constructor
  static Vocabulary vocabulary(const std::vector<Parameter>& parameters);

 private:
  struct Leaf {
    Expression c;
    Expression grows;
    bool grows_by_itself;
  };
  /// all_of or any_of of parts, or a leaf.
  struct Part {
    Limits::Kind kind;
    std::size_t leaf = 0;
    std::vector<Part> parts{};
  };
  struct Parsed {
    Vocabulary names;
    std::vector<Leaf> leaves;
    Part root;
    std::size_t steps = 0;
  };
  template <class S>
  struct Beyond;

  static Part read(Parsed& parsed, const Limits& limits, bool opposite, int depth);
  template <class Step, class S>
  Beyond<S> evaluate(const Part& part, const Step& eps, std::span<const S> variables) const;
  template <class Step, class S>
  S over(const Step& eps, const Sight<S>& observer, const Sight<S>& target, const S& t) const;
  /// @param scratch  one value per step of a leaf
  double excess(const Part& part, std::span<const double> variables,
                std::span<double> scratch) const noexcept;
  template <class S>
  using Variables = std::array<S, 6 + 2 * sight_size + 1 + 3>;  // x, y, z, r, both sights, t, the third body
  template <class S>
  Variables<S> variables(const Sight<S>& observer, const Sight<S>& target, const S& t) const;

  std::shared_ptr<const Parsed> parsed_;
  Slope slope_{};
  Expression grows_{};  // of the slope
  double kappa_A_ = 1.0, width_ = 1e-3;
  SensorMount mount_{};
  std::string name_ = "region";
};

}  // namespace sightline
