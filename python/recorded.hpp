/// Potentials and references whose formulas were recorded from a Python function; evaluation calls
/// no Python.
///
/// A potential of two bodies is a formula over, in this order,
///
///   seen      the target in the sensor frame S of the observer, x along the axis [m], 3
///   observer  p, d, v and tilt (`lean`) in G, sight_size
///   target    likewise
///   t         the time [s]
///
/// A potential of one robot is a formula over that robot's state and t; a reference is one over t.
/// Roots, and with them abs, maximum and minimum, are smoothed over `corner`, so they have
/// derivatives everywhere.
#pragma once

#include <array>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "sightline/formula.hpp"
#include "sightline/potential.hpp"

namespace sightline::python {

inline constexpr double corner = 1e-6;  // in the unit of the root
inline constexpr int seen_size = 3;

/// The value of a formula of at most formula_steps_max steps; does not allocate.
inline double value_of(const Expression& formula, std::span<const double> variables) noexcept {
  std::array<double, formula_steps_max> scratch;
  return formula(variables, corner, std::span<double>(scratch));
}

/// A potential between two bodies.
class RecordedPair {
 public:
  static constexpr int variables_n = seen_size + 2 * sight_size + 1;

  /// @param limit  > 0 where the limit is violated; none: the potential has no limit
  RecordedPair(std::string name, Expression l, std::optional<Expression> limit, const SensorMount& mount)
      : name_(std::move(name)), l_(std::move(l)), limit_(std::move(limit)), mount_(mount) {}

  double operator()(const Sight<double>& observer, const Sight<double>& target, double t) const {
    return value_of(l_, variables(observer, target, t));
  }
  Symbol operator()(const Sight<Symbol>& observer, const Sight<Symbol>& target, const Symbol& t) const {
    const std::array<Symbol, variables_n> z = variables(observer, target, t);
    return l_(std::span<const Symbol>(z), corner);
  }
  double violation(const Sight<double>& observer, const Sight<double>& target, double t) const noexcept {
    return limit_ ? value_of(*limit_, variables(observer, target, t))
                  : -std::numeric_limits<double>::infinity();
  }

  const std::string& name() const { return name_; }
  /// Whether the formula depends on the target in the sensor frame.
  bool is_view() const { return sees(l_) || (limit_ && sees(*limit_)); }
  const SensorMount& mount() const { return mount_; }
  RecordedPair seen_from(const SensorMount& mount) const { return {name_, l_, limit_, mount}; }
  void check() const { check_mount(name_, mount_); }

 private:
  static bool sees(const Expression& formula) {
    return formula.uses(0) || formula.uses(1) || formula.uses(2);
  }
  template <class S>
  std::array<S, variables_n> variables(const Sight<S>& observer, const Sight<S>& target, const S& t) const {
    std::array<S, variables_n> z;
    const Vec3<S> seen = mount_(observer, target.p);
    z[0] = seen.x, z[1] = seen.y, z[2] = seen.z;
    write_sight(observer, z.data() + seen_size);
    write_sight(target, z.data() + seen_size + sight_size);
    z.back() = t;
    return z;
  }

  std::string name_;
  Expression l_;
  std::optional<Expression> limit_;
  SensorMount mount_;
};

/// A potential of one robot alone.
class RecordedSingle {
 public:
  static constexpr int variables_n = sight_size + 1;

  RecordedSingle(std::string name, Expression l, std::optional<Expression> limit)
      : name_(std::move(name)), l_(std::move(l)), limit_(std::move(limit)) {}

  double operator()(const Sight<double>& robot, double t) const { return value_of(l_, variables(robot, t)); }
  Symbol operator()(const Sight<Symbol>& robot, const Symbol& t) const {
    const std::array<Symbol, variables_n> z = variables(robot, t);
    return l_(std::span<const Symbol>(z), corner);
  }
  double violation(const Sight<double>& robot, double t) const noexcept {
    return limit_ ? value_of(*limit_, variables(robot, t)) : -std::numeric_limits<double>::infinity();
  }
  const std::string& name() const { return name_; }

 private:
  template <class S>
  static std::array<S, variables_n> variables(const Sight<S>& robot, const S& t) {
    std::array<S, variables_n> z;
    write_sight(robot, z.data());
    z.back() = t;
    return z;
  }

  std::string name_;
  Expression l_;
  std::optional<Expression> limit_;
};

/// A reference state over time.
struct RecordedReference {
  std::vector<Expression> states;  ///< of t, at most Reference::max_states

  /// A state with its own storage.
  struct State {
    std::array<double, Reference::max_states> x;
    std::size_t n;
    operator std::span<const double>() const { return {x.data(), n}; }
  };
  State operator()(double t) const {
    State state{{}, states.size()};
    for (std::size_t i = 0; i < states.size(); ++i) state.x[i] = value_of(states[i], {&t, 1});
    return state;
  }
};

}  // namespace sightline::python
