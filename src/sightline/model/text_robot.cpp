#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <set>
#include <stdexcept>
#include <utility>

#include "sightline/base.hpp"
#include "sightline/model.hpp"

namespace sightline {
namespace {

constexpr double corner = 1e-6;

/// Index of a state, by its name.
std::size_t place_of(const TextRobot& robot, std::string_view what, const std::string& name) {
  const auto found = std::find(robot.states.begin(), robot.states.end(), name);
  if (found == robot.states.end()) throw_invalid("{} = \"{}\", expected the name of a state", what, name);
  return static_cast<std::size_t>(found - robot.states.begin());
}

/// Strings, and views of them with the same lifetime.
struct Names {
  explicit Names(const std::vector<std::string>& names) : texts(names), views(texts.begin(), texts.end()) {}
  std::vector<std::string> texts;
  std::vector<std::string_view> views;
};

struct Parsed final : Model::Interface {
  Parsed(const TextRobot& robot, std::vector<Expression> rates)
      : title_(robot.name), state_names_(robot.states), input_names_(robot.inputs), rates_(std::move(rates)) {
    nx = static_cast<int>(robot.states.size());
    nu = static_cast<int>(robot.inputs.size());
    name = title_;
    states = state_names_.views;
    inputs = input_names_.views;
    u_max = robot.u_max.empty() ? std::vector<double>(robot.inputs.size(), 1.0) : robot.u_max;
    u_min = robot.u_min.empty() ? std::vector<double>(robot.inputs.size(), -1.0) : robot.u_min;
    turns = !robot.heading.empty();
    for (std::size_t i = 0; i < 3; ++i) position_[i] = place_of(robot, "position", robot.position[i]);
    for (const std::string& h : robot.heading) heading_.push_back(place_of(robot, "heading", h));
    std::set<std::size_t> taken(position_.begin(), position_.end());
    taken.insert(heading_.begin(), heading_.end());
    if (taken.size() != 3 + heading_.size())
      throw_invalid("a state is twice in position and heading, expected each once");
    assert(std::all_of(rates_.begin(), rates_.end(),
                       [](const Expression& rate) { return rate.steps().size() <= formula_steps_max; }) &&
           "a formula is not longer");
  }

  void f(const double* x, const double* u, double* rate) const noexcept override {
    std::array<double, text_states_max + text_inputs_max> z;
    std::copy_n(x, nx, z.begin());
    std::copy_n(u, nu, z.begin() + nx);
    std::array<double, formula_steps_max> scratch;
    for (std::size_t i = 0; i < rates_.size(); ++i)
      rate[i] = rates_[i](std::span<const double>(z), corner, std::span<double>(scratch));
  }
  Sight<double> sight(const double* x, const double* u) const noexcept override {
    std::array<double, text_states_max> rate;
    f(x, u, rate.data());
    return sight_of(x, rate.data());
  }
  void step(double* x, const double* u, double dt) const noexcept override {
    std::array<double, RungeKuttaScratch::rows_needed * text_states_max> rows;
    const std::size_t n = rates_.size();
    const auto rate = [&](std::span<const double> z, std::span<double> r) { f(z.data(), u, r.data()); };
    rk4_step(rate, std::span<double>(x, n), dt,
             {std::span<double>(rows).first(RungeKuttaScratch::rows_needed * n)});
  }
  void at_rest(std::span<const Pose<double>> poses, double* x, std::ptrdiff_t stage,
               std::ptrdiff_t entry) const noexcept override {
    for (const Pose<double>& pose : poses) {
      const auto number = [&](std::size_t i) -> double& { return x[static_cast<std::ptrdiff_t>(i) * entry]; };
      for (std::size_t i = 0; i < rates_.size(); ++i) number(i) = 0.0;
      const std::array<double, 3> p = {pose.p.x, pose.p.y, pose.p.z};
      for (std::size_t i = 0; i < 3; ++i) number(position_[i]) = p[i];
      if (heading_.size() == 1) number(heading_[0]) = std::atan2(pose.d.y, pose.d.x);
      if (heading_.size() == 2) number(heading_[0]) = pose.d.x, number(heading_[1]) = pose.d.y;
      x += stage;
    }
  }
  void push(const double*, const Vec3<double>&, double*) const noexcept override {}
  bool normalise(double* x) const noexcept override {
    if (!all_finite({x, rates_.size()})) return false;
    if (heading_.size() == 1) x[heading_[0]] = wrap_angle(x[heading_[0]]);
    if (heading_.size() < 2) return true;
    std::array<double, 2> d = {x[heading_[0]], x[heading_[1]]};
    if (!normalise_heading(d.data())) return false;
    x[heading_[0]] = d[0], x[heading_[1]] = d[1];
    return true;
  }
  void f(std::span<const Symbol> x, std::span<const Symbol> u, std::span<Symbol> rate) const override {
    std::vector<Symbol> z(x.begin(), x.end());
    z.insert(z.end(), u.begin(), u.end());
    for (std::size_t i = 0; i < rates_.size(); ++i) rate[i] = rates_[i](std::span<const Symbol>(z), corner);
  }
  Sight<Symbol> sight(std::span<const Symbol> x, std::span<const Symbol> u) const override {
    std::vector<Symbol> rate(rates_.size());
    f(x, u, rate);
    return sight_of(x.data(), rate.data());
  }

 private:
  template <class S>
  Sight<S> sight_of(const S* x, const S* rate) const {
    const std::size_t i = position_[0], j = position_[1], k = position_[2];
    Vec2<S> d = {S(1.0), S(0.0)};
    if (heading_.size() == 1) d = {cos(x[heading_[0]]), sin(x[heading_[0]])};
    if (heading_.size() == 2) d = {x[heading_[0]], x[heading_[1]]};
    return {{{x[i], x[j], x[k]}, d}, {rate[i], rate[j], rate[k]}};
  }

  std::string title_;
  Names state_names_, input_names_;
  std::array<std::size_t, 3> position_{};
  std::vector<std::size_t> heading_;
  std::vector<Expression> rates_;
};

}  // namespace

Vocabulary TextRobot::vocabulary() const {
  Vocabulary names;
  int next = 0;
  const auto enter = [&](std::string_view what, const std::string& word) {
    if (!is_free_name(word) || names.contains(word)) {
      throw_invalid("{} \"{}\", expected a name of its own: letters, digits and _, no function or unit", what,
                    word);
    }
    names.insert_or_assign(word, Expression({{Expression::Kind::variable, next++}}, std::nullopt, {}));
  };
  for (const std::string& state : states) enter("a state", state);
  for (const std::string& input : inputs) enter("an input", input);
  std::set<std::string_view> taken;
  for (const Definition& p : parameters) {
    if (!is_free_name(p.name) || names.contains(p.name) || !taken.insert(p.name).second) {
      throw FormulaError(
          p.text, 0,
          fmt::format("a parameter called \"{}\", expected a name of its own: letters, digits and _, "
                      "no function, unit, state or input",
                      p.name),
          p.name);
    }
  }
  define(names, parameters);
  return names;
}

Model TextRobot::model() const {
  if (f.size() != states.size())
    throw_invalid("{} rates for {} states, expected one of each", f.size(), states.size());
  const Vocabulary names = vocabulary();
  std::vector<Expression> rates;
  for (const std::string& rate : f) rates.push_back(parse_formula(rate, names));
  return model(std::move(rates));
}

Model TextRobot::model(std::vector<Expression> rates) const {
  const auto size_is_within = [](std::string_view what, std::size_t n, std::size_t most) {
    if (n == 0 || n > most) throw_invalid("{} {}, expected 1 to {}", n, what, most);
  };
  size_is_within("states", states.size(), text_states_max);
  size_is_within("inputs", inputs.size(), text_inputs_max);
  if (rates.size() != states.size())
    throw_invalid("{} rates for {} states, expected one of each", rates.size(), states.size());
  (void)vocabulary();
  for (const Expression& rate : rates) {
    if (rate.steps().size() > formula_steps_max)
      throw_invalid("a rate of {} operations, expected at most {}", rate.steps().size(), formula_steps_max);
  }
  if (heading.size() > 2)
    throw_invalid("a heading of {} states, expected the angle, the two of the direction, or none",
                  heading.size());
  for (const auto* bound : {&u_min, &u_max}) {
    if (!bound->empty() && bound->size() != inputs.size())
      throw_invalid("limits of {} inputs for {}, expected one of each", bound->size(), inputs.size());
  }
  return Model(std::make_shared<const Parsed>(*this, std::move(rates)));
}

}  // namespace sightline
