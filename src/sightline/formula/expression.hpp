/// A formula read from text: a list of operations over named quantities, for any scalar.
///
/// On `Symbol` it appends itself to a graph, as a formula written in C++ does; from there on the
/// two are treated alike.
#pragma once

#include <algorithm>
#include <cassert>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include "sightline/formula/trace.hpp"
#include "sightline/formula/unit.hpp"

namespace sightline {

class Expression {
 public:
  enum class Kind {
    variable,
    constant,
    add,
    subtract,
    multiply,
    divide,
    negate,
    root,  ///< sqrt(a + width^2): all functions with a corner use it
    sine,
    cosine,
    angle,  ///< atan2(a, b)
    exponential,
    logarithm,
    logistic,  ///< 1 / (1 + e^-a)
    softplus,  ///< ln(1 + e^a)
  };
  /// Operands a and b are earlier steps; for a variable, a is its index.
  struct Step {
    Kind kind{};
    int a = -1, b = -1;
    double value = 0.0;

    friend bool operator<(const Step& s, const Step& t) {
      return std::tie(s.kind, s.a, s.b, s.value) < std::tie(t.kind, t.a, t.b, t.value);
    }
  };

  /// The constant zero.
  Expression() : steps_{{Kind::constant}} {}
  /// @param smoothed  names of the functions with a corner in the formula
  Expression(std::vector<Step> steps, std::optional<Unit> unit, std::set<std::string> smoothed)
      : steps_(std::move(steps)), unit_(unit), smoothed_(std::move(smoothed)) {}

  static Expression variable(int index, Unit unit) { return {{{Kind::variable, index}}, unit, {}}; }
  static Expression constant(double value, std::optional<Unit> unit) {
    return {{{Kind::constant, -1, -1, value}}, unit, {}};
  }

  /// The value at the variables. Roots are smoothed over `width` (in their unit), and exact at
  /// width 0.
  template <class S>
  S operator()(std::span<const S> variables, double width) const {
    std::vector<S> v;
    v.reserve(steps_.size());
    for (const Step& step : steps_) v.push_back(apply<S>(step, variables, v, width));
    return v.back();
  }
  /// The same without allocation: `scratch` holds one value per step.
  template <class S>
  S operator()(std::span<const S> variables, double width, std::span<S> scratch) const {
    assert(scratch.size() >= steps_.size() && "scratch holds a value for each step");
    for (std::size_t i = 0; i < steps_.size(); ++i)
      scratch[i] = apply<S>(steps_[i], variables, scratch, width);
    return scratch[steps_.size() - 1];
  }

  /// Steps ordered so that operands come first; the last step is the result.
  std::span<const Step> steps() const { return steps_; }
  /// The unit; none if a number without a unit leaves it open.
  std::optional<Unit> unit() const { return unit_; }
  const std::set<std::string>& smoothed() const { return smoothed_; }
  bool is_constant() const { return steps_.back().kind == Kind::constant; }
  bool uses(int variable) const {
    return std::any_of(steps_.begin(), steps_.end(),
                       [&](const Step& s) { return s.kind == Kind::variable && s.a == variable; });
  }

 private:
  template <class S>
  static S apply(const Step& step, std::span<const S> variables, std::span<const S> v, double width) {
    const auto a = [&]() -> const S& { return v[static_cast<std::size_t>(step.a)]; };
    const auto b = [&]() -> const S& { return v[static_cast<std::size_t>(step.b)]; };
    switch (step.kind) {
      case Kind::variable:
        return variables[static_cast<std::size_t>(step.a)];
      case Kind::constant:
        return step.value;
      case Kind::add:
        return a() + b();
      case Kind::subtract:
        return a() - b();
      case Kind::multiply:
        return a() * b();
      case Kind::divide:
        return a() / b();
      case Kind::negate:
        return -a();
      case Kind::root:
        return sqrt(a() + width * width);
      case Kind::sine:
        return sin(a());
      case Kind::cosine:
        return cos(a());
      case Kind::angle:
        return atan2(a(), b());
      case Kind::exponential:
        return exp(a());
      case Kind::logarithm:
        return log(a());
      case Kind::logistic:
        return logistic(a());
      case Kind::softplus:
        return softplus(a());
    }
    return step.value;
  }

  std::vector<Step> steps_;
  std::optional<Unit> unit_;
  std::set<std::string> smoothed_;
};

/// Builds an Expression: each distinct step once, constants folded, finite or not.
class ExpressionBuilder {
 public:
  using Kind = Expression::Kind;

  int variable(int index) { return unique({Kind::variable, index}); }
  int constant(double value) { return unique({Kind::constant, -1, -1, value}); }
  /// One of add, subtract, multiply, divide and angle.
  int binary(Kind kind, int a, int b);
  /// One of negate, root, sine, cosine, exponential, logarithm, logistic and softplus.
  int unary(Kind kind, int a);
  /// base^n; for a root, each factor root^2 becomes the root's argument.
  int power(int base, int n);
  int absolute(int a) { return unary(Kind::root, power(a, 2)); }
  /// The larger or the smaller of a and b: half of a + b plus or minus |a - b|.
  int larger(int a, int b) { return half_of_sum(Kind::add, a, b); }
  int smaller(int a, int b) { return half_of_sum(Kind::subtract, a, b); }
  /// Appends all steps of another expression and returns the result's step.
  int copy(const Expression& expression);

  std::optional<double> value(int step) const;
  std::size_t size() const { return steps_.size(); }
  /// An expression with only the steps that `result` needs.
  Expression finish(int result, std::optional<Unit> unit, std::set<std::string> smoothed) const;

 private:
  const Expression::Step& at(int step) const { return steps_[static_cast<std::size_t>(step)]; }
  int unique(const Expression::Step& step);
  int half_of_sum(Kind kind, int a, int b);

  std::vector<Expression::Step> steps_;
  std::map<Expression::Step, int> index_;
};

}  // namespace sightline
