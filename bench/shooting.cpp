#include "bench/shooting.hpp"

#include <algorithm>
#include <cmath>

#include "sightline/base.hpp"

namespace sightline {

MultipleShooting::MultipleShooting(Ocp ocp)
    : ocp_(std::move(ocp)),
      x_(ocp_.nx(), N() + 1),
      u_(ocp_.nu(), N()),
      reference_(ocp_.nx(), N() + 1),
      lambda_(ocp_.nx(), N()),
      time_(1, N()),
      weights_(2 * (ocp_.nx() + ocp_.nu()), N()),
      agents_(ocp_.formulas().agents.size()),
      pairs_(ocp_.formulas().pairs.size()),
      variables_(at(ocp_.team().bodies()), -1),
      rows_(variables_) {
  for (const Agent& agent : ocp_.team().agents())
    heading_limits_.emplace_back(agent.model, agent.Q, agent.Q_f);
  bind();
}

/// Every formula reads the trajectories in place; its results are stored with it.
void MultipleShooting::bind() {
  int weight = 0;
  const auto constants = [&](Evaluation& e, Evaluation& f, int& input, const std::vector<double>& values,
                             int n) {
    for (int i = 0; i < n; ++i, ++input, ++weight) {
      std::fill_n(weights_[weight], weights_.stride(), values.empty() ? 0.0 : values[at(i)]);
      e.input(input, weights_[weight]);
      f.input(input, weights_[weight]);
    }
  };
  const auto outputs = [&](Bound& rows, const Program& first, const Program& second) {
    rows.first_out = Rows(first.outputs(), N());
    rows.second_out = Rows(second.outputs(), N());
    for (int i = 0; i < first.outputs(); ++i) rows.first.output(i, rows.first_out[i]);
    for (int i = 0; i < second.outputs(); ++i) rows.second.output(i, rows.second_out[i]);
  };
  for (std::size_t a = 0; a < agents_.size(); ++a) {
    const BodyId body = ocp_.agent_bodies()[a];
    const Agent& agent = ocp_.team().agents()[a];
    const AgentFormula& formula = ocp_.formulas().agents[a];
    Bound& rows = agents_[a];
    rows.first = Evaluation(*formula.first, N());
    rows.second = Evaluation(*formula.second, N());
    const int nx = agent.model.nx(), nu = agent.model.nu();
    int input = 0;
    const auto both = [&](Rows& source, int from, int n) {
      for (int i = 0; i < n; ++i, ++input) {
        rows.first.input(input, source[from + i]);
        rows.second.input(input, source[from + i]);
      }
    };
    both(x_, x_at(body), nx);
    both(u_, u_at(body), nu);
    both(reference_, x_at(body), nx);
    constants(rows.first, rows.second, input, agent.u_ref, nu);
    constants(rows.first, rows.second, input, agent.Q, nx);
    constants(rows.first, rows.second, input, agent.R, nu);
    both(time_, 0, 1);
    for (int i = 0; i < nx; ++i) rows.second.input(input + i, lambda_[x_at(body) + i]);
    outputs(rows, *formula.first, *formula.second);
  }
  for (std::size_t p = 0; p < pairs_.size(); ++p) {
    const PairFormula& formula = ocp_.formulas().pairs[p];
    Bound& rows = pairs_[p];
    rows.first = Evaluation(*formula.first, N());
    rows.second = Evaluation(*formula.second, N());
    int input = 0;
    const auto both = [&](double* row) {
      rows.first.input(input, row);
      rows.second.input(input++, row);
    };
    for (const BodyId body : {formula.a, formula.b}) {
      for (int i = 0; i < ocp_.team().model(body).nx(); ++i) both(x_[x_at(body) + i]);
      for (int i = 0; i < ocp_.team().model(body).nu(); ++i) both(u_[u_at(body) + i]);
    }
    both(time_[0]);
    if (formula.third.index >= 0) {
      const Model& third = ocp_.team().model(formula.third);
      for (int i = 0; i < third.nx(); ++i) both(x_[x_at(formula.third) + i]);
      for (int i = 0; i < third.nu(); ++i) both(u_[u_at(formula.third) + i]);
    }
    outputs(rows, *formula.first, *formula.second);
  }
}

void MultipleShooting::set(double t, std::span<const double> x, std::span<const double> inputs) {
  t_ = t;
  for (int k = 0; k < N(); ++k) {
    time_[0][k] = time(k);
    for (int i = 0; i < ocp_.nu(); ++i) u_[i][k] = inputs[at(k) * at(ocp_.nu()) + at(i)];
  }
  for (int i = 0; i < ocp_.nx(); ++i) x_[i][0] = x[at(i)];
  for (int b = 0; b < ocp_.team().bodies(); ++b) roll_out(BodyId{b});
  for (std::size_t a = 0; a < agents_.size(); ++a) {
    const Agent& agent = ocp_.team().agents()[a];
    const int from = x_at(ocp_.agent_bodies()[a]);
    agent.x_ref.along(t, h(), N() + 1, agent.model, reference_[from], 1, reference_.stride());
    heading_limits_[a](x.data() + from, 1, reference_[from], N() + 1, 1, reference_.stride());
  }
}

/// x_k + h f(x_k, u_k).
std::vector<double> MultipleShooting::next(BodyId body, int k) const {
  const Model& model = ocp_.team().model(body);
  std::vector<double> x(at(model.nx())), u(at(model.nu())), rate(x);
  for (int i = 0; i < model.nx(); ++i) x[at(i)] = x_[x_at(body) + i][k];
  for (int i = 0; i < model.nu(); ++i) u[at(i)] = u_[u_at(body) + i][k];
  model.f(x.data(), u.data(), rate.data());
  for (std::size_t i = 0; i < x.size(); ++i) x[i] += h() * rate[i];
  return x;
}

void MultipleShooting::roll_out(BodyId body) {
  for (int k = 0; k < N(); ++k) {
    const std::vector<double> x = next(body, k);
    for (int i = 0; i < static_cast<int>(x.size()); ++i) x_[x_at(body) + i][k + 1] = x[at(i)];
  }
}

void MultipleShooting::choose(const std::vector<int>& agents) {
  free_ = agents;
  std::fill(variables_.begin(), variables_.end(), -1);
  per_stage_ = constraints_per_stage_ = 0;
  for (const int a : free_) {
    const BodyId body = ocp_.agent_bodies()[at(a)];
    const Model& model = ocp_.team().model(body);
    variables_[at(body.index)] = per_stage_;
    rows_[at(body.index)] = constraints_per_stage_;
    per_stage_ += model.nu() + model.nx();
    constraints_per_stage_ += model.nx();
  }
  jacobian_.clear();
  hessian_.clear();
  for (int k = 0; k < N(); ++k) {
    const auto second = [&](int row, int column, const double* value) {
      if (row >= column && column >= 0) hessian_.push_back({row, column, value});
    };
    for (const int a : free_) {
      const BodyId body = ocp_.agent_bodies()[at(a)];
      const AgentFormula& formula = ocp_.formulas().agents[at(a)];
      const int nx = ocp_.team().model(body).nx(), row = k * constraints_per_stage_ + rows_[at(body.index)];
      for (int i = 0; i < nx; ++i) {
        jacobian_.push_back({row + i, variable(body, i, k + 1), nullptr, -1.0});
        if (k > 0) jacobian_.push_back({row + i, variable(body, i, k), nullptr, 1.0});
      }
      for (const Entry& e : formula.jacobian) {
        const int column = variable(body, e.column, k);
        if (column >= 0) jacobian_.push_back({row + e.row, column, agents_[at(a)].first_out[e.output] + k});
      }
      for (const Entry& e : formula.hessian)
        second(variable(body, e.row, k), variable(body, e.column, k),
               agents_[at(a)].second_out[e.output] + k);
    }
    for (std::size_t p = 0; p < pairs_.size(); ++p) {
      const PairFormula& formula = ocp_.formulas().pairs[p];
      const Model& first = ocp_.team().model(formula.a);
      const int za = first.nx() + first.nu();
      const auto z = [&](int i) {
        return i < za ? variable(formula.a, i, k) : variable(formula.b, i - za, k);
      };
      for (const Entry& e : formula.hessian)
        second(z(e.row), z(e.column), pairs_[p].second_out[e.output] + k);
    }
  }
  for (const int a : free_) {
    const BodyId body = ocp_.agent_bodies()[at(a)];
    for (int i = 0; i < static_cast<int>(ocp_.team().agent(body).Q_f.size()); ++i) {
      const int last = variable(body, i, N());
      hessian_.push_back({last, last, nullptr, 2.0 * ocp_.team().agent(body).Q_f[at(i)]});
    }
  }
}

/// Index among the unknowns of entry i of z = (x, u) of a body at stage k; -1 if it is no unknown.
int MultipleShooting::variable(BodyId body, int i, int k) const {
  const int from = variables_[at(body.index)];
  if (from < 0) return -1;
  const Model& model = ocp_.team().model(body);
  if (i >= model.nx()) return k * per_stage_ + from + i - model.nx();
  return k == 0 ? -1 : (k - 1) * per_stage_ + from + model.nu() + i;
}

void MultipleShooting::move_to(const double* w) {
  for (const int a : free_) {
    const BodyId body = ocp_.agent_bodies()[at(a)];
    const Model& model = ocp_.team().model(body);
    for (int k = 0; k < N(); ++k) {
      for (int i = 0; i < model.nu(); ++i) u_[u_at(body) + i][k] = w[variable(body, model.nx() + i, k)];
      for (int i = 0; i < model.nx(); ++i) x_[x_at(body) + i][k + 1] = w[variable(body, i, k + 1)];
    }
  }
}

std::vector<double> MultipleShooting::point() const {
  std::vector<double> w(at(N() * per_stage_));
  for (const int a : free_) {
    const BodyId body = ocp_.agent_bodies()[at(a)];
    const Model& model = ocp_.team().model(body);
    for (int k = 0; k < N(); ++k) {
      for (int i = 0; i < model.nu(); ++i) w[at(variable(body, model.nx() + i, k))] = u_[u_at(body) + i][k];
      for (int i = 0; i < model.nx(); ++i) w[at(variable(body, i, k + 1))] = x_[x_at(body) + i][k + 1];
    }
  }
  return w;
}

void MultipleShooting::bounds(std::vector<double>& low, std::vector<double>& high) const {
  constexpr double none = 2e19;  // IPOPT's value for no bound
  low.assign(at(N() * per_stage_), -none);
  high.assign(low.size(), none);
  for (const int a : free_) {
    const BodyId body = ocp_.agent_bodies()[at(a)];
    const Agent& agent = ocp_.team().agent(body);
    for (int k = 0; k < N(); ++k) {
      const std::size_t first = at(variable(body, agent.model.nx(), k)), n = at(agent.model.nu());
      agent.limits.at(time(k), {&low[first], n}, {&high[first], n});
    }
  }
}

/// The stage cost of the free agents at stage k.
double MultipleShooting::stage(int k) const {
  const Team& team = ocp_.team();
  const auto column = [&](const Rows& rows, int from, int n) {
    std::vector<double> values(at(n));
    for (int i = 0; i < n; ++i) values[at(i)] = rows[from + i][k];
    return values;
  };
  const auto sight = [&](BodyId body) {
    const Model& model = team.model(body);
    return model.sight(column(x_, x_at(body), model.nx()).data(), column(u_, u_at(body), model.nu()).data());
  };
  const auto is_free = [&](BodyId body) { return variables_[at(body.index)] >= 0; };
  double l = 0.0;
  for (const int a : free_) {
    const BodyId body = ocp_.agent_bodies()[at(a)];
    const Agent& agent = team.agent(body);
    for (int i = 0; i < agent.model.nx(); ++i)
      l += agent.Q[at(i)] * std::pow(reference_[x_at(body) + i][k] - x_[x_at(body) + i][k], 2);
    for (int i = 0; i < agent.model.nu(); ++i) {
      const double u_ref = agent.u_ref.empty() ? 0.0 : agent.u_ref[at(i)];
      l += agent.R[at(i)] * std::pow(u_ref - u_[u_at(body) + i][k], 2);
    }
  }
  for (const Constraint& c : team.constraints()) {
    if (is_free(c.agent)) l += c.term.weight * c.term.potential(sight(c.agent), sight(c.agent), time(k));
  }
  for (const BarrierTerm& b : team.barriers()) {
    if (!is_free(b.agent)) continue;
    const Model& model = team.model(b.agent);
    const std::vector<double> x = column(x_, x_at(b.agent), model.nx()),
                              u = column(u_, u_at(b.agent), model.nu());
    l += b.barrier(sight(b.agent), std::span<const double>(x), std::span<const double>(u));
  }
  for (const Coupling& c : team.couplings()) {
    if (!std::any_of(c.felt_by.begin(), c.felt_by.end(), is_free)) continue;
    l += c.term.weight *
         c.term.potential(first_sight(sight, c.between.first, c.third), sight(c.between.second), time(k));
  }
  return l;
}

double MultipleShooting::cost() const {
  double J = 0.0;
  for (int k = 0; k < N(); ++k) J += h() * stage(k);
  for (const int a : free_) {
    const BodyId body = ocp_.agent_bodies()[at(a)];
    const std::vector<double>& Q_f = ocp_.team().agent(body).Q_f;
    for (int i = 0; i < static_cast<int>(Q_f.size()); ++i)
      J += Q_f[at(i)] * std::pow(reference_[x_at(body) + i][N()] - x_[x_at(body) + i][N()], 2);
  }
  return J;
}

void MultipleShooting::gradient(double* dJ) {
  std::fill_n(dJ, N() * per_stage_, 0.0);
  const auto add = [&](int variable, double value) {
    if (variable >= 0) dJ[variable] += value;
  };
  for (const int a : free_) {
    const BodyId body = ocp_.agent_bodies()[at(a)];
    const Agent& agent = ocp_.team().agent(body);
    Bound& rows = agents_[at(a)];
    rows.first.run();
    for (int k = 0; k < N(); ++k) {
      for (int i = 0; i < agent.model.nx() + agent.model.nu(); ++i)
        add(variable(body, i, k), h() * rows.first_out[i][k]);
    }
    for (int i = 0; i < static_cast<int>(agent.Q_f.size()); ++i) {
      add(variable(body, i, N()),
          2.0 * agent.Q_f[at(i)] * (x_[x_at(body) + i][N()] - reference_[x_at(body) + i][N()]));
    }
  }
  for (std::size_t p = 0; p < pairs_.size(); ++p) {
    const PairFormula& formula = ocp_.formulas().pairs[p];
    pairs_[p].first.run();
    const Model& first = ocp_.team().model(formula.a);
    const int za = first.nx() + first.nu();
    for (int k = 0; k < N(); ++k) {
      for (const Entry& e : formula.gradient)
        add(e.row < za ? variable(formula.a, e.row, k) : variable(formula.b, e.row - za, k),
            h() * pairs_[p].first_out[e.output][k]);
    }
  }
}

void MultipleShooting::defects(double* d) const {
  for (const int a : free_) {
    const BodyId body = ocp_.agent_bodies()[at(a)];
    for (int k = 0; k < N(); ++k) {
      const std::vector<double> x = next(body, k);
      double* const to = d + k * constraints_per_stage_ + rows_[at(body.index)];
      for (int i = 0; i < static_cast<int>(x.size()); ++i) to[i] = x[at(i)] - x_[x_at(body) + i][k + 1];
    }
  }
}

void MultipleShooting::jacobian_values(double* values) {
  for (const int a : free_) agents_[at(a)].first.run();
  for (const Nonzero& e : jacobian_) *values++ = e.value == nullptr ? e.constant : h() * *e.value;
}

/// The formulas have sigma = 1, so lambda / sigma replaces lambda.
void MultipleShooting::hessian_values(double sigma, const double* lambda, double* values) {
  const double scale = std::max(sigma, 1e-10);  // IPOPT requests 0 while it searches a feasible point
  for (const int a : free_) {
    const BodyId body = ocp_.agent_bodies()[at(a)];
    for (int k = 0; k < N(); ++k) {
      const double* const from = lambda + k * constraints_per_stage_ + rows_[at(body.index)];
      for (int i = 0; i < ocp_.team().model(body).nx(); ++i) lambda_[x_at(body) + i][k] = from[i] / scale;
    }
    agents_[at(a)].second.run();
  }
  for (Bound& rows : pairs_) rows.second.run();
  for (const Nonzero& e : hessian_) *values++ = scale * (e.value == nullptr ? e.constant : h() * *e.value);
}

std::vector<double> MultipleShooting::inputs() const {
  std::vector<double> u;
  for (int k = 0; k < N(); ++k) {
    for (int i = 0; i < ocp_.nu(); ++i) u.push_back(u_[i][k]);
  }
  return u;
}

}  // namespace sightline
