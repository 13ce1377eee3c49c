#include "sightline/analysis/flow.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "sightline/analysis/field.hpp"
#include "sightline/formula.hpp"
#include "sightline/model/state_roles.hpp"
#include "sightline/scenario/reach.hpp"

namespace sightline {
namespace {

constexpr int axes = 4;  // x, y, z, psi of a body
constexpr int variables_of_pair = 2 * axes;

/// Gradient by both bodies, then the upper triangle of the Hessian.
Program derivatives_of(const Potential& potential) {
  Graph graph;
  const std::vector<Symbol> in = variables(graph, 0, variables_of_pair);
  const Vec3<Symbol> still = {0.0, 0.0, 0.0};
  const auto sight = [&](std::size_t k) {
    return Sight<Symbol>{{{in[k], in[k + 1], in[k + 2]}, {cos(in[k + 3]), sin(in[k + 3])}}, still};
  };
  std::vector<Term> of;
  for (int i = 0; i < variables_of_pair; ++i) of.push_back(graph.input(i));
  const sightline::Term l = potential(sight(0), sight(axes), Symbol(0.0)).in(graph);
  Derivatives d = derive(graph, l, of);
  d.first.insert(d.first.end(), d.second.begin(), d.second.end());
  return Program(graph, d.first, variables_of_pair);
}

/// Gradient and stiffness of a body's cost along each of its axes.
struct Pull {
  std::array<double, axes> slope{}, stiffness{};
};

}  // namespace

void Flow::add(const Weighted& term, std::size_t a, std::size_t b, bool felt_by_a, bool felt_by_b) {
  Program value = formula_of(term.potential);
  const auto known =
      std::find_if(formulas_.begin(), formulas_.end(), [&](const Known& k) { return k.value == value; });
  const auto formula = static_cast<std::size_t>(known - formulas_.begin());
  if (known == formulas_.end()) formulas_.push_back({std::move(value), derivatives_of(term.potential)});
  terms_.push_back({formula, a, b, term.weight, felt_by_a, felt_by_b});
}

FlowEnd Flow::settle(int steps) const {
  constexpr double damping = 5.0, longest = 0.1, widest = 0.2;  // damping [1/m^2], longest step
                                                                // [m], widest turn [rad]
  constexpr double far = 0.3,
                   steady = 0.2;  // drift over a sixth of the steps [m]; its relative change
  const int sixth = std::max(1, steps / 6);
  std::vector<Drifting> now = bodies_;
  const auto centre = [&] {
    Vec3<double> sum{};
    double movable = 0.0;
    for (const Drifting& body : now) {
      if (!(body.free[0] || body.free[1] || body.free[2])) continue;
      sum = sum + body.p;
      movable += 1;
    }
    return (1 / std::max(1.0, movable)) * sum;
  };
  std::vector<Evaluation> evaluations;
  Rows in(variables_of_pair, 1), out(variables_of_pair + variables_of_pair * (variables_of_pair + 1) / 2, 1);
  for (const Known& known : formulas_) {
    Evaluation& e = evaluations.emplace_back(known.derivatives, 1);
    for (int i = 0; i < variables_of_pair; ++i) e.input(i, in[i]);
    for (int i = 0; i < known.derivatives.outputs(); ++i) e.output(i, out[i]);
  }

  std::array<Vec3<double>, 3> marks{};  // the centre two sixths before the end, one sixth before
                                        // it, and at the end
  for (int n = 0; n < 6 * sixth; ++n) {
    if (n == 4 * sixth) marks[0] = centre();
    if (n == 5 * sixth) marks[1] = centre();
    std::vector<Pull> pulls(now.size());
    for (const Term& term : terms_) {
      const auto put = [&](int first, const Drifting& body) {
        in[first][0] = body.p.x, in[first + 1][0] = body.p.y, in[first + 2][0] = body.p.z;
        in[first + 3][0] = body.psi;
      };
      put(0, now[term.a]);
      put(axes, now[term.b]);
      evaluations[term.formula].run();
      const auto feel = [&](Pull& pull, int first) {
        for (int i = 0; i < axes; ++i) {
          const auto at = static_cast<std::size_t>(i);
          pull.slope[at] += term.weight * out[first + i][0];
          for (int j = 0; j < axes; ++j) {
            const int entry = upper_index(first + std::min(i, j), first + std::max(i, j), variables_of_pair);
            pull.stiffness[at] += term.weight * std::fabs(out[variables_of_pair + entry][0]);
          }
        }
      };
      if (term.felt_by_a) feel(pulls[term.a], 0);
      if (term.felt_by_b) feel(pulls[term.b], axes);
    }
    for (const Hold& hold : holds_) {
      const Drifting& body = now[hold.body];
      Pull& pull = pulls[hold.body];
      const Vec3<double> off = body.p - hold.place;
      const std::array<double, 3> error = {off.x, off.y, off.z}, q = {hold.q.x, hold.q.y, hold.q.z};
      for (std::size_t i = 0; i < 3; ++i) pull.slope[i] += 2 * q[i] * error[i], pull.stiffness[i] += 2 * q[i];
      pull.slope[3] += hold.q_psi * std::sin(body.psi - hold.heading);
      pull.stiffness[3] += hold.q_psi;
    }
    for (std::size_t i = 0; i < now.size(); ++i) {
      std::array<double, axes> step{};
      for (std::size_t k = 0; k < axes; ++k) {
        const double wanted = -pulls[i].slope[k] / (damping + pulls[i].stiffness[k]);
        if (now[i].free[k] && std::isfinite(wanted)) step[k] = wanted;
      }
      const double length = norm(Vec3<double>{step[0], step[1], step[2]});
      const double share = length > longest ? longest / length : 1.0;
      now[i].p = now[i].p + share * Vec3<double>{step[0], step[1], step[2]};
      now[i].psi += std::clamp(step[3], -widest, widest);
    }
  }
  marks[2] = centre();
  const Vec3<double> before = marks[1] - marks[0], last = marks[2] - marks[1];
  FlowEnd settled{std::move(now)};
  if (norm(last) > far && norm(last - before) < steady * norm(last)) settled.drift = last;
  return settled;
}

Flow flow_of(const Team& team, std::span<const double> x0, std::span<const AgentId> moving) {
  std::vector<Drifting> bodies;
  std::vector<Hold> holds;
  const std::vector<double> none(static_cast<std::size_t>(team.nu()) + 1, 0.0);
  for (int i = 0; i < team.bodies(); ++i) {
    const BodyId body{i};
    const Model& model = team.model(body);
    const Sight<double> s = model.sight(x0.data() + team.state_offset(body), none.data());
    Drifting& drifting = bodies.emplace_back(Drifting{s.p, std::atan2(s.d.y, s.d.x), {}});
    if (std::find(moving.begin(), moving.end(), body) == moving.end()) continue;
    const auto reach = reach_of(model);
    drifting.free = {reach[0], reach[1], reach[2], reach[3] || reach[4]};
    const Agent& agent = team.agent(body);
    const StateRoles roles = roles_of(model);
    const auto weight = [&](int state) {
      return state >= 0 ? agent.Q[static_cast<std::size_t>(state)] : 0.0;
    };
    std::vector<double> x(agent.Q.size());
    agent.x_ref(0.0, model, x);
    const Sight<double> reference = model.sight(x.data(), none.data());
    const Hold hold = {bodies.size() - 1,
                       reference.p,
                       {weight(roles.position[0]), weight(roles.position[1]), weight(roles.position[2])},
                       std::atan2(reference.d.y, reference.d.x),
                       weight(roles.direction[0]) + weight(roles.direction[1]) + 2 * weight(roles.angle)};
    if (hold.q.x > 0) drifting.p.x = hold.place.x;
    if (hold.q.y > 0) drifting.p.y = hold.place.y;
    if (hold.q.z > 0) drifting.p.z = hold.place.z;
    holds.push_back(hold);
  }
  Flow flow(std::move(bodies));
  for (const Hold& hold : holds) flow.add(hold);
  for (const Coupling& c : with_thirds_at(team, x0)) {
    const auto feels = [&](BodyId body) {
      return std::find(c.felt_by.begin(), c.felt_by.end(), body) != c.felt_by.end();
    };
    flow.add({c.term.weight * c.ramp.to, c.term.potential}, at(c.between.first), at(c.between.second),
             feels(c.between.first), feels(c.between.second));
  }
  for (const Constraint& c : team.constraints()) {
    flow.add({c.term.weight * c.ramp.to, c.term.potential}, at(c.agent), at(c.agent), true, false);
  }
  return flow;
}

}  // namespace sightline
