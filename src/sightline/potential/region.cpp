#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "sightline/base.hpp"
#include "sightline/potential.hpp"
#include "sightline/potentials.hpp"

namespace sightline {
namespace {

using Kind = Limits::Kind;

struct Variable {
  std::string_view name;
  Unit unit;
};
constexpr int sensor_variables = 3, time_at = 6 + 2 * sight_size, third_at = time_at + 1;
constexpr std::array own_variables = {
    Variable{"x", units::length},   Variable{"y", units::length},   Variable{"z", units::length},
    Variable{"r_x", units::length}, Variable{"r_y", units::length}, Variable{"r_z", units::length},
};
constexpr std::array<Variable, sight_size> sight_variables = {
    Variable{"p_x", units::length},   Variable{"p_y", units::length},   Variable{"p_z", units::length},
    Variable{"d_x", units::none},     Variable{"d_y", units::none},     Variable{"v_x", units::velocity},
    Variable{"v_y", units::velocity}, Variable{"v_z", units::velocity}, Variable{"lean_f", units::none},
    Variable{"lean_s", units::none},
};
constexpr std::array<std::pair<std::string_view, std::string_view>, 5> derived = {{
    {"range", "norm(x, y, z)"},
    {"bearing", "atan2(hypot(y, z), x)"},
    {"azimuth", "atan2(y, x)"},
    {"elevation", "atan2(z, hypot(x, y))"},
    {"distance", "norm(r_x, r_y, r_z)"},
}};

Vocabulary own_names() {
  Vocabulary names;
  int index = 0;
  const auto add = [&](std::string name, Unit unit) {
    names.emplace(std::move(name), Expression::variable(index++, unit));
  };
  for (const Variable& v : own_variables) add(std::string(v.name), v.unit);
  for (const char* who : {"observer", "target"}) {
    for (const Variable& v : sight_variables) add(fmt::format("{}.{}", who, v.name), v.unit);
  }
  add("t", units::time);
  for (const char* axis : {"x", "y", "z"}) add(fmt::format("third.p_{}", axis), units::length);
  std::vector<Definition> definitions;
  for (const auto& [name, text] : derived) definitions.push_back({std::string(name), std::string(text)});
  define(names, definitions);
  return names;
}

void check_range(const Parameter& p, const Vocabulary& names) {
  if (p.low.empty() && p.high.empty()) return;
  const Expression& value = names.find(p.name)->second;
  const auto number = [&](const std::string& text) {
    const Expression bound = parse_formula(text, names);
    if (!bound.is_constant())
      throw FormulaError(text, 0, "a bound of a range that varies, expected a number", p.name);
    if (value.unit() && bound.unit() && *value.unit() != *bound.unit()) {
      throw FormulaError(text, 0,
                         fmt::format("the bound is {}, expected {} as the value is", to_string(*bound.unit()),
                                     to_string(*value.unit())),
                         p.name);
    }
    return bound.steps().back().value;
  };
  if (!value.is_constant())
    throw FormulaError(p.text, 0, "a formula that varies has no range, expected a number", p.name);
  const double v = value.steps().back().value;
  if (!(v >= number(p.low) && v <= number(p.high))) {
    throw FormulaError(p.text, 0, fmt::format("it is {} in SI units, expected {} to {}", v, p.low, p.high),
                       p.name);
  }
}

/// Softplus slope: max(c, 0) over the unit step, and its smooth form, the integral of the sigmoid.
double ramp(const UnitStep&, double c) { return std::max(c, 0.0); }
template <class S>
S ramp(const SigmoidStep& eps, const S& c) {
  return (1.0 / eps.kappa_A) * softplus(S(eps.kappa_A * c));
}

}  // namespace

Limits all_of(std::vector<Limits> parts) { return {Kind::all_of, std::move(parts)}; }
Limits any_of(std::vector<Limits> parts) { return {Kind::any_of, std::move(parts)}; }
Limits operator!(Limits limits) { return {Kind::opposite, {std::move(limits)}}; }

Parameter::Parameter(std::string called, double value)
    : name(std::move(called)), text(fmt::format("{}", value)) {}

Vocabulary Region::vocabulary(const std::vector<Parameter>& parameters) {
  static const Vocabulary own = own_names();
  Vocabulary names = own;
  std::vector<Definition> definitions;
  std::set<std::string_view> taken;
  for (const Parameter& p : parameters) {
    if (!is_free_name(p.name) || own.contains(p.name) || !taken.insert(p.name).second) {
      throw FormulaError(p.text, 0,
                         fmt::format("a parameter called \"{}\", expected a name of its own: letters, digits "
                                     "and _, no function, unit or quantity",
                                     p.name),
                         p.name);
    }
    definitions.push_back({p.name, p.text});
  }
  define(names, definitions);
  for (const Parameter& p : parameters) check_range(p, names);
  return names;
}

Region::Part Region::read(Parsed& parsed, const Limits& limits, bool opposite, int depth) {
  if (depth > region_depth_max) {
    throw std::invalid_argument(
        fmt::format("all_of, any_of and not are nested deeper than {}, expected fewer", region_depth_max));
  }
  if (limits.kind == Kind::opposite) return read(parsed, limits.parts.at(0), !opposite, depth + 1);
  // De Morgan: the negation of all_of is any_of of the negations.
  const bool all = limits.kind == Kind::limit ? !opposite : (limits.kind == Kind::all_of) != opposite;
  Part part{all ? Kind::all_of : Kind::any_of};
  if (limits.kind != Kind::limit) {
    if (limits.parts.empty()) throw std::invalid_argument("an empty all_of or any_of, expected limits");
    for (const Limits& inner : limits.parts) {
      part.parts.push_back(read(parsed, inner, opposite, depth + 1));
    }
    return part;
  }
  for (const Expression& c : parse_limits(limits.text, parsed.names)) {
    if (parsed.leaves.size() == region_limits_max) {
      throw std::invalid_argument(fmt::format("more than {} limits, expected fewer", region_limits_max));
    }
    Leaf leaf{c, {}, !limits.grows_with.empty()};
    if (opposite) {
      ExpressionBuilder turned;
      leaf.c = turned.finish(turned.unary(Expression::Kind::negate, turned.copy(c)), c.unit(), c.smoothed());
    }
    if (leaf.grows_by_itself) leaf.grows = parse_formula(limits.grows_with, parsed.names);
    parsed.steps += leaf.c.steps().size() + leaf.grows.steps().size();
    if (parsed.steps > region_steps_max) {
      throw std::invalid_argument(
          fmt::format("limits of more than {} operations in all, expected fewer", region_steps_max));
    }
    part.parts.push_back({Kind::limit, parsed.leaves.size()});
    parsed.leaves.push_back(std::move(leaf));
  }
  return part;
}

Region::Region(const Limits& inside, const std::vector<Parameter>& parameters) {
  Parsed parsed{vocabulary(parameters), {}, {}, 0};
  parsed.root = read(parsed, inside, false, 0);
  parsed_ = std::make_shared<const Parsed>(std::move(parsed));
}

Region Region::slope(Slope slope) const {
  Region region = *this;
  if (const auto* quadratic = std::get_if<Quadratic>(&slope)) {
    region.grows_ = parse_formula(quadratic->grows_with, parsed_->names);
  }
  region.slope_ = std::move(slope);
  return region;
}

Region Region::sigmoid(double kappa_A) const {
  Region region = *this;
  region.kappa_A_ = kappa_A;
  return region;
}

Region Region::seen_from(const SensorMount& mount) const {
  Region region = *this;
  region.mount_ = mount;
  return region;
}

Region Region::smoothed_over(double width) const {
  Region region = *this;
  region.width_ = width;
  return region;
}

Region Region::named(std::string name) const {
  Region region = *this;
  region.name_ = std::move(name);
  return region;
}

void Region::check() const {
  require(kappa_A_ > 0, name_, "kappa_A", kappa_A_, "> 0");
  require(width_ > 0, name_, "smooth", width_, "> 0");
  check_mount(name_, mount_);
  if (const auto* quadratic = std::get_if<Quadratic>(&slope_)) {
    require(quadratic->kappa_G >= 0, name_, "slope.kappa_G", quadratic->kappa_G, ">= 0");
    require(quadratic->kappa_H > 0, name_, "slope.kappa_H", quadratic->kappa_H, "> 0");
  } else if (const auto* softplus = std::get_if<Softplus>(&slope_)) {
    require(softplus->kappa_G > 0, name_, "slope.kappa_G", softplus->kappa_G, "> 0");
    require(softplus->kappa_H >= 0, name_, "slope.kappa_H", softplus->kappa_H, ">= 0");
  }
}

template <class S>
Region::Variables<S> Region::variables(const Sight<S>& observer, const Sight<S>& target, const S& t) const {
  const Vec3<S> p_S = mount_(observer, target.p), r = target.p - observer.p;
  Variables<S> v = {p_S.x, p_S.y, p_S.z, r.x, r.y, r.z};
  write_sight(observer, v.begin() + 6);
  write_sight(target, v.begin() + 6 + sight_size);
  v[at(time_at)] = t;
  v[at(third_at)] = observer.third.x, v[at(third_at + 1)] = observer.third.y;
  v[at(third_at + 2)] = observer.third.z;
  return v;
}

/// Result of one part of the region: the step, the step with its slope, and the ramp of Softplus.
template <class S>
struct Region::Beyond {
  S step, sloped, ramp;
};

template <class Step, class S>
Region::Beyond<S> Region::evaluate(const Part& part, const Step& eps, std::span<const S> variables) const {
  const double width = std::is_same_v<Step, UnitStep> ? 0.0 : width_;
  if (part.kind == Kind::limit) {
    const Leaf& leaf = parsed_->leaves[part.leaf];
    const S c = leaf.c(variables, width), step = eps(c);
    if (const auto* q = std::get_if<Quadratic>(&slope_)) {
      const S of = (leaf.grows_by_itself ? leaf.grows : grows_)(variables, width);
      return {step, step * (q->kappa_H + q->kappa_G * of), 0.0};
    }
    if (std::holds_alternative<Softplus>(slope_)) return {step, step, ramp(eps, c)};
    return {step, step, 0.0};
  }
  Beyond<S> all = evaluate(part.parts.back(), eps, variables);
  if (part.kind == Kind::all_of) {
    // The first violated limit determines the value; later limits count only where it holds, (30).
    for (std::size_t i = part.parts.size() - 1; i-- > 0;) {
      const Beyond<S> one = evaluate(part.parts[i], eps, variables);
      const S holds = 1.0 - one.step;
      all = {one.step + all.step * holds, one.sloped + all.sloped * holds, one.ramp + all.ramp};
    }
    return all;
  }
  // any_of is violated only where all parts are. The slope is the mean of theirs, the ramp the
  // smallest.
  S mean = all.sloped;
  for (std::size_t i = part.parts.size() - 1; i-- > 0;) {
    const Beyond<S> one = evaluate(part.parts[i], eps, variables);
    mean = mean * one.step + one.sloped * all.step;
    const S apart = one.ramp - all.ramp;
    all.ramp = 0.5 * (one.ramp + all.ramp - sqrt(apart * apart + width * width));
    all.step = one.step * all.step;
  }
  all.sloped = (1.0 / static_cast<double>(part.parts.size())) * mean;
  return all;
}

template <class Step, class S>
S Region::over(const Step& eps, const Sight<S>& observer, const Sight<S>& target, const S& t) const {
  const Variables<S> v = variables(observer, target, t);
  const Beyond<S> beyond = evaluate<Step, S>(parsed_->root, eps, v);
  const auto* softplus = std::get_if<Softplus>(&slope_);
  if (softplus == nullptr) return beyond.sloped;
  const S slope = softplus->kappa_G * beyond.ramp;
  return softplus->kappa_H > 0 ? S(softplus->kappa_H * beyond.step + slope) : slope;
}

double Region::operator()(const Sight<double>& observer, const Sight<double>& target, double t) const {
  return over(SigmoidStep{kappa_A_}, observer, target, t);
}
Symbol Region::operator()(const Sight<Symbol>& observer, const Sight<Symbol>& target, const Symbol& t) const {
  return over(SigmoidStep{kappa_A_}, observer, target, t);
}
double Region::sloped(const Sight<double>& observer, const Sight<double>& target, double t) const {
  return over(UnitStep{}, observer, target, t);
}
double Region::unit_step(const Sight<double>& observer, const Sight<double>& target, double t) const {
  return violation(observer, target, t) > 0 ? 1.0 : 0.0;
}

double Region::violation(const Sight<double>& observer, const Sight<double>& target,
                         double t) const noexcept {
  std::array<double, region_steps_max> scratch;
  return excess(parsed_->root, variables(observer, target, t), scratch);
}

double Region::excess(const Part& part, std::span<const double> variables,
                      std::span<double> scratch) const noexcept {
  if (part.kind == Kind::limit) return parsed_->leaves[part.leaf].c(variables, 0.0, scratch);
  double c = excess(part.parts.front(), variables, scratch);
  for (std::size_t i = 1; i < part.parts.size(); ++i) {
    const double other = excess(part.parts[i], variables, scratch);
    c = part.kind == Kind::all_of ? std::max(c, other) : std::min(c, other);
  }
  return c;
}

bool Region::is_view() const {
  return std::any_of(parsed_->leaves.begin(), parsed_->leaves.end(), [](const Leaf& leaf) {
    return leaf.c.uses(0) || leaf.c.uses(1) || leaf.c.uses(sensor_variables - 1);
  });
}

bool Region::sees_third() const {
  const auto sees = [](const Expression& e) {
    return e.uses(third_at) || e.uses(third_at + 1) || e.uses(third_at + 2);
  };
  const bool grows = std::holds_alternative<Quadratic>(slope_);
  return (grows && sees(grows_)) ||
         std::any_of(parsed_->leaves.begin(), parsed_->leaves.end(), [&](const Leaf& leaf) {
           return sees(leaf.c) || (grows && leaf.grows_by_itself && sees(leaf.grows));
         });
}

std::vector<Region> Region::conjuncts() const {
  std::vector<Region> found;
  const auto collect = [&](const auto& self, const Part& part) -> void {
    if (part.kind == Kind::all_of) {
      for (const Part& inner : part.parts) self(self, inner);
      return;
    }
    Parsed own = *parsed_;
    own.root = part;
    found.emplace_back(*this).parsed_ = std::make_shared<const Parsed>(std::move(own));
  };
  collect(collect, parsed_->root);
  return found;
}

std::set<std::string> Region::smoothed() const {
  std::set<std::string> all;
  const auto add = [&](const Expression& e) {
    const bool corner = std::any_of(e.steps().begin(), e.steps().end(), [](const Expression::Step& step) {
      return step.kind == Expression::Kind::root;
    });
    if (corner) all.insert(e.smoothed().begin(), e.smoothed().end());
  };
  for (const Leaf& leaf : parsed_->leaves) {
    add(leaf.c);
    if (leaf.grows_by_itself) add(leaf.grows);
  }
  add(grows_);
  return all;
}

}  // namespace sightline
