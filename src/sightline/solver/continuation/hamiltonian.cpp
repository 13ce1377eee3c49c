#include <algorithm>
#include <stdexcept>

#include "sightline/solvers.hpp"

namespace sightline {

Hamiltonian::Hamiltonian(const Ocp& ocp)
    : ocp_(ocp),
      formulas_(ocp.formulas()),
      N_(ocp.horizon().N),
      nx_(ocp.nx()),
      nu_(ocp.nu()),
      x_(nx_, N_),
      u_(nu_, N_),
      lambda_(nx_, N_),
      x_ref_(nx_, N_ + 1),
      u_ref_(nu_, N_),
      Q_(nx_, N_),
      R_(nu_, N_),
      t_(1, N_),
      g_(nx_ + nu_, N_),
      u_min_(at(N_, nu_)),
      u_max_(at(N_, nu_)),
      added_(at(nu_, 1)),
      stage_x_(at(1, nx_)),
      stage_u_(at(1, nu_)),
      stage_rate_(at(1, nx_)),
      H_z_(at(1, nx_ + nu_)) {
  const Team& team = ocp.team();
  if (!team.swarms().empty()) {
    throw std::invalid_argument("this solver knows no keep_apart, expected newton_riccati");
  }
  for (int i = 0; i < team.bodies(); ++i) {
    x_at_.push_back(team.state_offset(BodyId{i}));
    u_at_.push_back(team.input_offset(BodyId{i}));
  }
  const auto fill = [](double* row, int n, double value) { std::fill_n(row, n, value); };
  for (const BodyId body : ocp.agent_bodies()) {
    const Agent& agent = team.agent(body);
    heading_limits_.emplace_back(agent.model, agent.Q, agent.Q_f);
    const int x0 = team.state_offset(body), u0 = team.input_offset(body);
    for (int i = 0; i < agent.model.nx(); ++i) fill(Q_[x0 + i], Q_.stride(), agent.Q[at(i, 1)]);
    for (int i = 0; i < agent.model.nu(); ++i) {
      fill(R_[u0 + i], R_.stride(), agent.R[at(i, 1)]);
      fill(u_ref_[u0 + i], u_ref_.stride(), agent.u_ref[at(i, 1)]);
    }
  }
  bind();
  lay_out_tangents();
}

void Hamiltonian::bind() {
  const Team& team = ocp_.team();
  // The inputs of a formula are consecutive rows of a few blocks.
  const auto take = [](Evaluation& run, int& next, const Rows& rows, int from, int n) {
    for (int i = 0; i < n; ++i) run.input(next++, rows[from + i]);
  };
  const auto bind_outputs = [](Evaluation& run, Rows& rows, int n) {
    for (int i = 0; i < n; ++i) run.output(i, rows[i]);
  };
  for (std::size_t a = 0; a < formulas_.agents.size(); ++a) {
    const AgentFormula& formula = formulas_.agents[a];
    const BodyId body = ocp_.agent_bodies()[a];
    const int x0 = team.state_offset(body), u0 = team.input_offset(body);
    const int nx = team.model(body).nx(), nu = team.model(body).nu();
    const auto inputs = [&](Evaluation& run) {
      int next = 0;
      take(run, next, x_, x0, nx);
      take(run, next, u_, u0, nu);
      take(run, next, x_ref_, x0, nx);
      take(run, next, u_ref_, u0, nu);
      take(run, next, Q_, x0, nx);
      take(run, next, R_, u0, nu);
      take(run, next, t_, 0, 1);
      return next;
    };
    Evaluation& first = agent_first_run_.emplace_back(*formula.first, N_);
    inputs(first);
    bind_outputs(first, agent_first_.emplace_back(formula.first->outputs(), N_), formula.first->outputs());
    for (int i = 0; i < nx; ++i) first.output(i, g_[x0 + i]);
    for (int i = 0; i < nu; ++i) first.output(nx + i, g_[nx_ + u0 + i]);

    Evaluation& second = agent_second_run_.emplace_back(*formula.second, N_);
    int next = inputs(second);
    take(second, next, lambda_, x0, nx);
    bind_outputs(second, agent_second_.emplace_back(formula.second->outputs(), N_),
                 formula.second->outputs());
  }
  for (const PairFormula& pair : formulas_.pairs) {
    const auto inputs = [&](Evaluation& run) {
      int next = 0;
      for (const BodyId body : {pair.a, pair.b}) {
        take(run, next, x_, team.state_offset(body), team.model(body).nx());
        take(run, next, u_, team.input_offset(body), team.model(body).nu());
      }
      take(run, next, t_, 0, 1);
      if (pair.third.index < 0) return;
      take(run, next, x_, team.state_offset(pair.third), team.model(pair.third).nx());
      take(run, next, u_, team.input_offset(pair.third), team.model(pair.third).nu());
    };
    Evaluation& first = pair_first_run_.emplace_back(*pair.first, N_);
    inputs(first);
    bind_outputs(first, pair_first_.emplace_back(pair.first->outputs(), N_), pair.first->outputs());
    Evaluation& second = pair_second_run_.emplace_back(*pair.second, N_);
    inputs(second);
    bind_outputs(second, pair_second_.emplace_back(pair.second->outputs(), N_), pair.second->outputs());
  }
}

void Hamiltonian::set_time(double t, double h) noexcept {
  h_ = h;
  const Team& team = ocp_.team();
  for (const BodyId body : ocp_.agent_bodies()) {
    const Agent& agent = team.agent(body);
    agent.x_ref.along(t, h, N_ + 1, agent.model, x_ref_[team.state_offset(body)], 1, x_ref_.stride());
  }
  for (int i = 0; i < N_; ++i) {
    const double tau = t + i * h;
    t_[0][i] = tau;
    for (const BodyId body : ocp_.agent_bodies()) {
      const Agent& agent = team.agent(body);
      const int u0 = team.input_offset(body);
      const std::size_t n = at(agent.model.nu(), 1);
      agent.limits.at(tau, {&u_min_[at(i, nu_) + at(u0, 1)], n}, {&u_max_[at(i, nu_) + at(u0, 1)], n});
    }
    for (int j = 0; j < nu_; ++j)
      u_min_[at(i, nu_) + at(j, 1)] -= added_[at(j, 1)], u_max_[at(i, nu_) + at(j, 1)] -= added_[at(j, 1)];
  }
}

void Hamiltonian::set_time(double t, double h, const double* x) noexcept {
  set_time(t, h);
  for (std::size_t a = 0; a < heading_limits_.size(); ++a) {
    const int x0 = ocp_.team().state_offset(ocp_.agent_bodies()[a]);
    heading_limits_[a](x + x0, 1, x_ref_[x0], N_ + 1, 1, x_ref_.stride());
  }
}

void Hamiltonian::set_u_ref(std::span<const double> u_ref) noexcept {
  for (int j = 0; j < nu_; ++j) std::fill_n(u_ref_[j], u_ref_.stride(), u_ref[at(j, 1)]);
}

void Hamiltonian::flow(const double* x, const double* u, double* rate) const noexcept {
  for (std::size_t b = 0; b < x_at_.size(); ++b) {
    ocp_.team().model(BodyId{static_cast<int>(b)}).f(x + x_at_[b], u + u_at_[b], rate + x_at_[b]);
  }
}

void Hamiltonian::roll_out(const double* x, const double* u, int stride, const double* Z, double scale,
                           double* X) noexcept {
  std::copy_n(x, nx_, X);
  for (int i = 0; i < N_; ++i) {
    const double* const x_i = X + at(i, nx_);
    double* const next = X + at(i + 1, nx_);
    flow(x_i, u + at(i, stride), stage_rate_.data());
    for (int j = 0; j < nx_; ++j) next[j] = x_i[j] + h_ * stage_rate_[at(j, 1)];
    if (Z == nullptr) continue;
    const double* const z = Z + at(i + 1, nx_);
    for (int j = 0; j < nx_; ++j) next[j] += scale * z[j];
  }
}

void Hamiltonian::linearise(const double* X, const double* u, int stride) noexcept {
  for (int j = 0; j < nx_; ++j) {
    for (int i = 0; i < N_; ++i) x_[j][i] = X[at(i, nx_) + at(j, 1)];
  }
  for (int j = 0; j < nu_; ++j) {
    for (int i = 0; i < N_; ++i) u_[j][i] = u[at(i, stride) + at(j, 1)];
  }
  for (const Evaluation& run : agent_first_run_) run.run();
  const Team& team = ocp_.team();
  for (std::size_t p = 0; p < formulas_.pairs.size(); ++p) {
    pair_first_run_[p].run();
    const PairFormula& pair = formulas_.pairs[p];
    const int za = team.model(pair.a).nx() + team.model(pair.a).nu();
    for (const Entry& e : pair.gradient) {
      const BodyId body = e.row < za ? pair.a : pair.b;
      const int z = e.row < za ? e.row : e.row - za, nx = team.model(body).nx();
      double* const sum =
          z < nx ? g_[team.state_offset(body) + z] : g_[nx_ + team.input_offset(body) + z - nx];
      const double* const add = pair_first_[p][e.output];
      for (int i = 0; i < N_; ++i) sum[i] += add[i];
    }
  }
}

void Hamiltonian::gradient(int i, const double* lambda_next, double* H_z) const noexcept {
  for (int j = 0; j < nx_ + nu_; ++j) H_z[j] = g_[j][i];
  for (std::size_t a = 0; a < formulas_.agents.size(); ++a) {
    const AgentTangent& agent = tangents_[a];
    for (const Entry& e : formulas_.agents[a].jacobian) {
      const int z = e.column < agent.nx ? agent.x_at + e.column : nx_ + agent.u_at + e.column - agent.nx;
      H_z[z] += agent_first_[a][e.output][i] * lambda_next[agent.x_at + e.row];
    }
  }
}

void Hamiltonian::terminal_gradient(const double* x, double* phi_x) const noexcept {
  std::fill_n(phi_x, nx_, 0.0);
  for (const AgentTangent& agent : tangents_) {
    const auto& Q_f = ocp_.team().agents()[static_cast<std::size_t>(&agent - tangents_.data())].Q_f;
    for (int j = 0; j < agent.nx; ++j) {
      const int z = agent.x_at + j;
      phi_x[z] = 2.0 * Q_f[at(j, 1)] * (x[z] - x_ref_[z][N_]);
    }
  }
}

void Hamiltonian::costates(const double* X, const double* Z, double scale, double* Lambda, double* F,
                           int stride) noexcept {
  terminal_gradient(X + at(N_, nx_), Lambda + at(N_, nx_));
  if (Z != nullptr) {
    for (int j = 0; j < nx_; ++j) Lambda[at(N_, nx_) + at(j, 1)] += scale * Z[at(N_, nx_) + at(j, 1)];
  }
  for (int i = N_ - 1; i >= 0; --i) {
    const double* const next = Lambda + at(i + 1, nx_);
    gradient(i, next, H_z_.data());
    std::copy_n(&H_z_[at(1, nx_)], nu_, F + at(i, stride));
    if (i == 0) break;
    double* const lambda = Lambda + at(i, nx_);
    for (int j = 0; j < nx_; ++j) lambda[j] = next[j] + h_ * H_z_[at(j, 1)];
    if (Z == nullptr) continue;
    for (int j = 0; j < nx_; ++j) lambda[j] += scale * Z[at(i, nx_) + at(j, 1)];
  }
}

void Hamiltonian::StageOperator::add(int source, int row, const double* values, bool scaled) {
  const auto found = std::find(sources.begin(), sources.end(), source);
  const int slot = static_cast<int>(found - sources.begin());
  if (found == sources.end()) sources.push_back(source);
  const bool first = std::none_of(contributions.begin(), contributions.end(),
                                  [&](const Contribution& c) { return c.slot == slot && c.row == row; });
  contributions.push_back({values, slot, row, first, scaled});
}

void Hamiltonian::StageOperator::assemble(int stages, double h) noexcept {
  for (const Contribution& c : contributions) {
    const double scale = c.scaled ? h : 1.0;
    double* place = columns[0] + c.slot * rows + c.row;
    for (int i = 0; i < stages; ++i, place += columns.stride()) {
      *place = (c.first ? 0.0 : *place) + scale * c.values[i];
    }
  }
}

void Hamiltonian::StageOperator::apply(int stage, const double* source, double* dest) const noexcept {
  const double* const column = columns[stage];
  for (int r = 0; r < rows; r += native_width) {
    NativeLane even = NativeLane::load(dest + r), odd(0.0);
    std::size_t c = 0;
    for (; c + 1 < sources.size(); c += 2) {
      const double* const pair = column + static_cast<int>(c) * rows + r;
      even = fma(NativeLane::load(pair), NativeLane(source[sources[c]]), even);
      odd = fma(NativeLane::load(pair + rows), NativeLane(source[sources[c + 1]]), odd);
    }
    if (c < sources.size()) {
      even = fma(NativeLane::load(column + static_cast<int>(c) * rows + r), NativeLane(source[sources[c]]),
                 even);
    }
    (even + odd).store(dest + r);
  }
}

void Hamiltonian::lay_out_tangents() {
  const Team& team = ocp_.team();
  int length = 0;
  for (const BodyId body : ocp_.agent_bodies()) {
    AgentTangent agent{};
    agent.nx = team.model(body).nx();
    agent.nu = team.model(body).nu();
    agent.x_at = team.state_offset(body);
    agent.u_at = team.input_offset(body);
    agent.dx_at = length;
    agent.du_at = agent.dx_at + padded(agent.nx);
    agent.dlambda_at = agent.du_at + padded(agent.nu);
    length = agent.dlambda_at + padded(agent.nx);
    tangents_.push_back(std::move(agent));
  }
  tangent_ = Rows(N_ + 1, length);
  d_input_ = Rows(1, nu_);

  const auto tangent_of = [&](BodyId body) -> AgentTangent& {
    const auto& bodies = ocp_.agent_bodies();
    return tangents_[static_cast<std::size_t>(std::find(bodies.begin(), bodies.end(), body) -
                                              bodies.begin())];
  };
  const auto source = [](const AgentTangent& agent, int z) {
    return z < agent.nx ? agent.dx_at + z : agent.du_at + z - agent.nx;
  };
  // A Hessian nonzero belongs to the costate or input equation of the agent that owns its row.
  const auto add_curvature = [&](AgentTangent& owner, int z, int from, const double* values) {
    if (z < owner.nx) {
      owner.backward.add(from, z, values, true);
    } else {
      owner.input.add(from, z - owner.nx, values, false);
    }
  };
  for (std::size_t a = 0; a < tangents_.size(); ++a) {
    AgentTangent& agent = tangents_[a];
    const AgentFormula& formula = formulas_.agents[a];
    for (const Entry& e : formula.jacobian) {
      const double* const values = agent_first_[a][e.output];
      agent.forward.add(source(agent, e.column), e.row, values, true);
      add_curvature(agent, e.column, agent.dlambda_at + e.row, values);
    }
    for (const Entry& e : formula.hessian) {
      add_curvature(agent, e.row, source(agent, e.column), agent_second_[a][e.output]);
    }
  }
  for (std::size_t p = 0; p < formulas_.pairs.size(); ++p) {
    const PairFormula& pair = formulas_.pairs[p];
    const int za = team.model(pair.a).nx() + team.model(pair.a).nu();
    for (const Entry& e : pair.hessian) {
      AgentTangent& owner = tangent_of(e.row < za ? pair.a : pair.b);
      const AgentTangent& other = tangent_of(e.column < za ? pair.a : pair.b);
      add_curvature(owner, e.row < za ? e.row : e.row - za,
                    source(other, e.column < za ? e.column : e.column - za), pair_second_[p][e.output]);
    }
  }
  for (AgentTangent& agent : tangents_) {
    for (StageOperator* op : {&agent.forward, &agent.backward, &agent.input}) {
      op->rows = padded(op == &agent.input ? agent.nu : agent.nx);
      op->columns = Rows(N_, static_cast<int>(op->sources.size()) * op->rows);
    }
  }
}

void Hamiltonian::second_order(const double* Lambda) noexcept {
  for (int j = 0; j < nx_; ++j) {
    for (int i = 0; i < N_; ++i) lambda_[j][i] = Lambda[at(i + 1, nx_) + at(j, 1)];
  }
  for (const Evaluation& run : agent_second_run_) run.run();
  for (const Evaluation& run : pair_second_run_) run.run();
  for (AgentTangent& agent : tangents_) {
    agent.forward.assemble(N_, h_);
    agent.backward.assemble(N_, h_);
    agent.input.assemble(N_, 1.0);
  }
}

void Hamiltonian::tangent(const double* du, double* dF, int stride) noexcept {
  for (const AgentTangent& agent : tangents_) std::fill_n(tangent_[0] + agent.dx_at, padded(agent.nx), 0.0);
  for (int i = 0; i < N_; ++i) {
    double* const s = tangent_[i];
    for (const AgentTangent& agent : tangents_) {
      std::copy_n(du + at(i, stride) + at(agent.u_at, 1), agent.nu, s + agent.du_at);
    }
    double* const next = tangent_[i + 1];
    for (const AgentTangent& agent : tangents_) {
      std::copy_n(s + agent.dx_at, padded(agent.nx), next + agent.dx_at);
      agent.forward.apply(i, s, next + agent.dx_at);
    }
  }
  // dlambda_N = phi_xx dx_N; the row of stage i holds dlambda_{i+1}.
  for (std::size_t a = 0; a < tangents_.size(); ++a) {
    const AgentTangent& agent = tangents_[a];
    const auto& Q_f = ocp_.team().agents()[a].Q_f;
    for (int j = 0; j < agent.nx; ++j) {
      tangent_[N_ - 1][agent.dlambda_at + j] = 2.0 * Q_f[at(j, 1)] * tangent_[N_][agent.dx_at + j];
    }
  }
  for (int i = N_ - 1; i >= 0; --i) {
    const double* const s = tangent_[i];
    for (const AgentTangent& agent : tangents_) {
      std::fill_n(d_input_[0], padded(agent.nu), 0.0);
      agent.input.apply(i, s, d_input_[0]);
      std::copy_n(d_input_[0], agent.nu, dF + at(i, stride) + at(agent.u_at, 1));
      if (i == 0) continue;
      double* const before = tangent_[i - 1] + agent.dlambda_at;
      std::copy_n(s + agent.dlambda_at, padded(agent.nx), before);
      agent.backward.apply(i, s, before);
    }
  }
}

}  // namespace sightline
