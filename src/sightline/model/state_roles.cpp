#include "sightline/model/state_roles.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include "sightline/formula.hpp"
#include "sightline/model.hpp"

namespace sightline {
namespace {

/// Jacobian: at(i, k) is d y_i / d x_k of y = (sight in the order of `write_sight`, yaw rate).
struct Slopes {
  std::vector<double> of;
  std::size_t nx;
  double at(std::size_t i, std::size_t k) const { return of[i * nx + k]; }
};

/// Symbolic formulas of a robot, over its states, then its inputs.
class RobotFormulas {
 public:
  explicit RobotFormulas(const Model& model) : states_(model.nx()) {
    const auto nx = static_cast<std::size_t>(model.nx());
    const std::vector<Symbol> z = variables(graph_, 0, model.nx() + model.nu());
    for (const Symbol& variable : z) variables_.push_back(variable.in(graph_));
    const std::span<const Symbol> all = z;
    std::vector<Symbol> rate(nx);
    model.f(all.first(nx), all.subspan(nx), rate);
    for (const Symbol& one : rate) rates_.push_back(one.in(graph_));
    std::array<Symbol, sight_size> sight;
    write_sight(model.sight(all.first(nx), all.subspan(nx)), sight);
    for (std::size_t i = 0; i < sight_size; ++i) sight_[i] = sight[i].in(graph_);
  }

  Term rate(int state) const { return rates_[static_cast<std::size_t>(state)]; }
  Term climb() const { return sight_[7]; }

  /// d_x d_y' - d_y d_x'.
  Term yaw_rate() {
    const auto rate_of = [&](Term of) {
      const std::vector<Term> slope = slopes(of);
      Term sum = graph_.constant(0.0);
      for (std::size_t k = 0; k < rates_.size(); ++k)
        sum = graph_.add(sum, graph_.multiply(slope[k], rates_[k]));
      return sum;
    };
    const Term d_x = sight_[3], d_y = sight_[4];
    return graph_.subtract(graph_.multiply(d_x, rate_of(d_y)), graph_.multiply(d_y, rate_of(d_x)));
  }

  /// Indices of the variables that a term depends on: states, then inputs.
  std::vector<int> dependences(Term of) {
    std::vector<int> all;
    const std::vector<Term> slope = gradient(graph_, of, variables_);
    for (std::size_t k = 0; k < slope.size(); ++k) {
      if (!graph_.is_zero(slope[k])) all.push_back(static_cast<int>(k));
    }
    return all;
  }
  bool is_state(int variable) const { return variable < states_; }

  /// The Jacobian as a program of states and inputs.
  Program jacobian() {
    std::vector<Term> all;
    const auto append = [&](const std::vector<Term>& row) { all.insert(all.end(), row.begin(), row.end()); };
    for (const Term one : sight_) append(slopes(one));
    append(slopes(yaw_rate()));
    return Program(graph_, all, static_cast<int>(variables_.size()));
  }

 private:
  std::vector<Term> slopes(Term of) {
    return gradient(graph_, of, std::span(variables_).first(rates_.size()));
  }

  Graph graph_;
  int states_;
  std::vector<Term> variables_, rates_;
  std::array<Term, sight_size> sight_;
};

}  // namespace

StateRoles roles_of(const Model& model) {
  constexpr int samples = 5;
  constexpr std::size_t heading = 3, velocity = 5, tilt = 8, yaw_rate = sight_size;  // rows of the Jacobian
  const auto nx = static_cast<std::size_t>(model.nx());
  const Program slopes = RobotFormulas(model).jacobian();
  std::mt19937_64 random(1);
  const auto draw = [&] { return std::uniform_real_distribution<double>(0.1, 1.0)(random); };
  std::vector<Slopes> seen;
  std::vector<Vec2<double>> headings;
  for (int n = 0; n < samples; ++n) {
    std::vector<double> z(nx + static_cast<std::size_t>(model.nu()));
    std::generate(z.begin(), z.end(), draw);
    if (!model.normalise(z.data())) continue;
    seen.push_back({evaluate(slopes, z), nx});
    headings.push_back(model.sight(z.data(), z.data() + nx).d);
  }
  const auto always = [&](auto&& holds) {
    bool all = !seen.empty();
    for (std::size_t n = 0; n < seen.size(); ++n) all = all && holds(seen[n], headings[n]);
    return all;
  };
  const auto is = [](double a, double b) { return std::fabs(a - b) < 1e-9; };

  StateRoles roles;
  for (std::size_t k = 0; k < nx; ++k) {
    const int state = static_cast<int>(k);
    const auto is_unit = [&](std::size_t first, std::size_t count, std::size_t axis) {
      return always([&](const Slopes& s, const Vec2<double>&) {
        bool unit = true;
        for (std::size_t i = 0; i < count; ++i) unit = unit && is(s.at(first + i, k), i == axis ? 1.0 : 0.0);
        return unit;
      });
    };
    bool placed = false;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (is_unit(0, 3, axis)) roles.position[axis] = state, placed = true;
    }
    for (std::size_t axis = 0; axis < 2; ++axis) {
      if (is_unit(heading, 2, axis)) roles.direction[axis] = state, placed = true;
    }
    const bool turns = always([&](const Slopes& s, const Vec2<double>& d) {
      return is(s.at(heading, k), -d.y) && is(s.at(heading + 1, k), d.x);
    });
    if (turns) roles.angle = state, placed = true;
    const bool speeds = always([&](const Slopes& s, const Vec2<double>&) {
      return is(norm(Vec3<double>{s.at(velocity, k), s.at(velocity + 1, k), s.at(velocity + 2, k)}), 1.0);
    });
    if (placed) continue;
    if (speeds) {
      roles.velocities.push_back(state);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        if (is_unit(velocity, 3, axis)) roles.velocity_G[axis] = state, placed = true;
      }
      const auto along = [&](auto&& direction) {
        return always([&](const Slopes& s, const Vec2<double>& d) {
          const Vec2<double> e = direction(d);
          return is(s.at(velocity, k), e.x) && is(s.at(velocity + 1, k), e.y);
        });
      };
      if (!placed && along([](const Vec2<double>& d) { return d; })) roles.velocity_V[0] = state;
      if (!placed && along([](const Vec2<double>& d) { return Vec2<double>{-d.y, d.x}; }))
        roles.velocity_V[1] = state;
      continue;
    }
    if (always([&](const Slopes& s, const Vec2<double>&) { return is(s.at(yaw_rate, k), 1.0); }))
      roles.rate = state, placed = true;
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const bool tilts = always([&](const Slopes& s, const Vec2<double>&) {
        return s.at(tilt + axis, k) > 0 && is(s.at(tilt + 1 - axis, k), 0.0);
      });
      if (tilts) roles.tilt[axis] = state, placed = true;
    }
    if (!placed) roles.others.push_back(state);
  }
  if (roles.direction[0] < 0 || roles.direction[1] < 0) roles.direction = {-1, -1};
  return roles;
}

bool has_height(const Model& model) {
  RobotFormulas formulas(model);
  if (!formulas.dependences(formulas.climb()).empty()) return true;
  std::vector<double> x(static_cast<std::size_t>(model.nx())), u(static_cast<std::size_t>(model.nu()));
  model.at_rest({{0, 0, 1}, {1, 0}}, x.data());
  return model.sight(x.data(), u.data()).v.z != 0;
}

int yaw_input(const Model& model) {
  RobotFormulas formulas(model);
  std::vector<Term> level = {formulas.yaw_rate()};
  std::set<int> states, inputs;
  while (!level.empty()) {
    std::vector<Term> next;
    for (const Term term : level) {
      for (const int variable : formulas.dependences(term)) {
        if (!formulas.is_state(variable)) {
          inputs.insert(variable - model.nx());
        } else if (states.insert(variable).second) {
          next.push_back(formulas.rate(variable));
        }
      }
    }
    if (!inputs.empty()) return inputs.size() == 1 ? *inputs.begin() : -1;
    level = std::move(next);
  }
  return -1;
}

bool takes_push(const Model& model) {
  std::vector<double> x(static_cast<std::size_t>(model.nx())), rate(x.size());
  model.at_rest({{0, 0, 1}, {0.8, 0.6}}, x.data());
  model.push(x.data(), {1.0, 2.0, 3.0}, rate.data());
  return std::any_of(rate.begin(), rate.end(), [](double one) { return one != 0; });
}

}  // namespace sightline
