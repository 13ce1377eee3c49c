#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <mutex>
#include <stdexcept>

#include "sightline/formula.hpp"
#include "sightline/potential/tracking.hpp"
#include "sightline/team.hpp"

namespace sightline {
namespace {

std::vector<Term> terms(Graph& graph, std::span<const Symbol> symbols) {
  std::vector<Term> t;
  for (const Symbol& s : symbols) t.push_back(s.in(graph));
  return t;
}

/// Appends the nonzeros of a symmetric Hessian to the outputs, each once, and lists them in both
/// triangles.
/// @param keep  whether row i, column j is needed
template <class Keep>
void list_hessian(const Graph& graph, const std::vector<Term>& upper, int n, Keep&& keep,
                  std::vector<Term>& outputs, std::vector<Entry>& entries) {
  for (int i = 0; i < n; ++i) {
    for (int j = i; j < n; ++j) {
      const Term t = upper[static_cast<std::size_t>(upper_index(i, j, n))];
      if (graph.is_zero(t) || !(keep(i, j) || keep(j, i))) continue;
      const int output = static_cast<int>(outputs.size());
      outputs.push_back(t);
      if (keep(i, j)) entries.push_back({i, j, output});
      if (i != j && keep(j, i)) entries.push_back({j, i, output});
    }
  }
}

/// One tracing of all formulas of a team.
class Tracing {
 public:
  explicit Tracing(const Team& team) : team_(team) {}
  Formulas formulas(std::span<const BodyId> agents);

 private:
  std::shared_ptr<const Program> shared(Program program);
  AgentFormula trace_agent(const Agent& agent, BodyId body);
  PairFormula trace_pair(std::span<const Coupling* const> couplings);

  const Team& team_;
  std::vector<std::shared_ptr<const Program>> programs_;
};

Formulas Tracing::formulas(std::span<const BodyId> agents) {
  Formulas formulas;
  for (const BodyId body : agents) formulas.agents.push_back(trace_agent(team_.agent(body), body));

  // Couplings that are alike() become one formula and share common terms.
  std::vector<bool> taken(team_.couplings().size(), false);
  for (std::size_t i = 0; i < taken.size(); ++i) {
    if (taken[i]) continue;
    const Coupling& first = team_.couplings()[i];
    std::vector<const Coupling*> same;
    for (std::size_t j = i; j < taken.size(); ++j) {
      const Coupling& c = team_.couplings()[j];
      if (taken[j] || !alike(c, first)) continue;
      same.push_back(&c);
      taken[j] = true;
    }
    formulas.pairs.push_back(trace_pair(same));
  }
  return formulas;
}

std::shared_ptr<const Program> Tracing::shared(Program program) {
  for (const auto& known : programs_) {
    if (*known == program) return known;
  }
  programs_.push_back(std::make_shared<const Program>(std::move(program)));
  return programs_.back();
}

AgentFormula Tracing::trace_agent(const Agent& agent, BodyId body) {
  const int nx = agent.model.nx(), nu = agent.model.nu(), nz = nx + nu;
  Graph graph;
  int next = 0;
  const auto inputs = [&](int n) {
    auto symbols = variables(graph, next, n);
    next += n;
    return symbols;
  };
  const auto x = inputs(nx), u = inputs(nu), x_ref = inputs(nx), u_ref = inputs(nu), Q = inputs(nx),
             R = inputs(nu);
  const Symbol t = inputs(1)[0];
  const int first_inputs = next;
  const auto lambda = inputs(nx);

  Symbol l = tracking_cost<Symbol>(x, x_ref, Q, u, u_ref, R);
  for (const Constraint& c : team_.constraints()) {
    if (c.agent != body) continue;
    const Sight<Symbol> robot = agent.model.sight(std::span<const Symbol>(x), std::span<const Symbol>(u));
    l += c.term.weight * c.term.potential(robot, robot, t);
  }
  for (const RelaxedBarrier& barrier : team_.barriers(body)) {
    const std::span<const Symbol> at_x(x), at_u(u);
    l += barrier(agent.model.sight(at_x, at_u), at_x, at_u);
  }
  std::vector<Symbol> rate(x.size());
  agent.model.f(std::span<const Symbol>(x), std::span<const Symbol>(u), rate);
  Symbol hamiltonian = l;
  for (std::size_t i = 0; i < rate.size(); ++i) hamiltonian += lambda[i] * rate[i];

  std::vector<Symbol> z_symbols = x;
  z_symbols.insert(z_symbols.end(), u.begin(), u.end());
  const std::vector<Term> z = terms(graph, z_symbols);

  AgentFormula formula;
  std::vector<Term> first = gradient(graph, l.in(graph), z);
  for (int i = 0; i < nx; ++i) {
    const std::vector<Term> row = gradient(graph, rate[static_cast<std::size_t>(i)].in(graph), z);
    for (int j = 0; j < nz; ++j) {
      if (graph.is_zero(row[static_cast<std::size_t>(j)])) continue;
      formula.jacobian.push_back({i, j, static_cast<int>(first.size())});
      first.push_back(row[static_cast<std::size_t>(j)]);
    }
  }
  std::vector<Term> second;
  const Derivatives d = derive(graph, hamiltonian.in(graph), z);
  list_hessian(
      graph, d.second, nz, [](int, int) { return true; }, second, formula.hessian);
  formula.first = shared(Program(graph, first, first_inputs));
  formula.second = shared(Program(graph, second, next));
  return formula;
}

PairFormula Tracing::trace_pair(std::span<const Coupling* const> couplings) {
  const Between between = couplings[0]->between;
  const Model &a = team_.model(between.first), &b = team_.model(between.second);
  const int za = a.nx() + a.nu(), zb = b.nx() + b.nu();
  Graph graph;
  const auto z_symbols = variables(graph, 0, za + zb);
  const Symbol t(graph, graph.input(za + zb));
  int inputs = za + zb + 1;
  const auto part = [&](int from, int n) {
    return std::span<const Symbol>(z_symbols).subspan(static_cast<std::size_t>(from),
                                                      static_cast<std::size_t>(n));
  };
  Sight<Symbol> sight_a = a.sight(part(0, a.nx()), part(a.nx(), a.nu()));
  const Sight<Symbol> sight_b = b.sight(part(za, b.nx()), part(za + b.nx(), b.nu()));
  const BodyId third = couplings[0]->third;
  if (couplings[0]->has_third()) {
    const Model& c = team_.model(third);
    const auto x = variables(graph, inputs, c.nx()), u = variables(graph, inputs + c.nx(), c.nu());
    sight_a.third = c.sight(std::span<const Symbol>(x), std::span<const Symbol>(u)).p;
    inputs += c.nx() + c.nu();
  }
  Symbol l = 0.0;
  for (const Coupling* c : couplings) l += c->term.weight * c->term.potential(sight_a, sight_b, t);

  const auto& felt_by = couplings[0]->felt_by;
  const auto owner = [&](int i) { return i < za ? between.first : between.second; };
  const auto felt = [&](int i) {
    return std::find(felt_by.begin(), felt_by.end(), owner(i)) != felt_by.end();
  };

  PairFormula formula{.a = between.first,
                      .b = between.second,
                      .third = third,
                      .first = {},
                      .second = {},
                      .gradient = {},
                      .hessian = {}};
  const std::vector<Term> z = terms(graph, z_symbols);
  const Derivatives d = derive(graph, l.in(graph), z);
  std::vector<Term> first, second;
  for (int i = 0; i < za + zb; ++i) {
    const Term t_i = d.first[static_cast<std::size_t>(i)];
    if (!felt(i) || graph.is_zero(t_i)) continue;
    formula.gradient.push_back({i, 0, static_cast<int>(first.size())});
    first.push_back(t_i);
  }
  list_hessian(
      graph, d.second, za + zb, [&](int i, int j) { return felt(i) && team_.is_agent(owner(j)); }, second,
      formula.hessian);
  formula.first = shared(Program(graph, first, inputs));
  formula.second = shared(Program(graph, second, inputs));
  return formula;
}

}  // namespace

struct Ocp::Traced {
  std::once_flag once;
  std::atomic<bool> done{false};
  Formulas formulas;
};

Ocp::Ocp(Team team, const Horizon& horizon)
    : team_(std::move(team)), horizon_(horizon), traced_(std::make_shared<Traced>()) {
  check_parameters(horizon, "horizon");
  if (team_.agents().empty())
    throw std::invalid_argument("the team has no agent, expected at least one robot");

  for (int i = 0; i < team_.bodies(); ++i) {
    if (team_.is_agent(BodyId{i})) agent_bodies_.push_back(BodyId{i});
  }
}

const Formulas& Ocp::formulas() const {
  std::call_once(traced_->once, [&] {
    traced_->formulas = Tracing(team_).formulas(agent_bodies_);
    traced_->done.store(true, std::memory_order_release);
  });
  return traced_->formulas;
}

bool Ocp::is_traced() const noexcept { return traced_->done.load(std::memory_order_acquire); }

double stage_cost(const Team& team, double t, std::span<const double> x, std::span<const double> u) {
  const std::size_t nx = static_cast<std::size_t>(team.nx()), nu = static_cast<std::size_t>(team.nu());
  if (x.size() != nx || u.size() != nu) {
    throw std::invalid_argument(
        fmt::format("{} states and {} inputs, expected the team's {} and {}", x.size(), u.size(), nx, nu));
  }
  double cost = 0.0;
  const auto state = [&](BodyId body) { return x.data() + team.state_offset(body); };
  const auto input = [&](BodyId body) { return u.data() + team.input_offset(body); };
  const auto sight = [&](BodyId body) { return team.model(body).sight(state(body), input(body)); };
  std::vector<double> x_ref;
  for (int i = 0; i < team.bodies(); ++i) {
    const BodyId body{i};
    if (!team.is_agent(body)) continue;
    const Agent& agent = team.agent(body);
    x_ref.resize(agent.Q.size());
    agent.x_ref(t, agent.model, x_ref);
    cost += tracking_cost<double>({state(body), agent.Q.size()}, x_ref, agent.Q,
                                  {input(body), agent.R.size()}, agent.u_ref, agent.R);
  }
  for (const Constraint& c : team.constraints()) {
    cost += c.ramp.at(t) * c.term.weight * c.term.potential(sight(c.agent), sight(c.agent), t);
  }
  for (const BarrierTerm& b : team.barriers()) {
    const Model& model = team.model(b.agent);
    cost += b.barrier(sight(b.agent),
                      std::span<const double>(state(b.agent), static_cast<std::size_t>(model.nx())),
                      std::span<const double>(input(b.agent), static_cast<std::size_t>(model.nu())));
  }
  for (const Coupling& c : team.couplings()) {
    cost += c.ramp.at(t) * c.term.weight *
            c.term.potential(first_sight(sight, c.between.first, c.third), sight(c.between.second), t);
  }
  std::vector<Sight<double>> seen;
  for (const Swarm& swarm : team.swarms()) {
    seen.clear();
    for (const AgentId agent : swarm.agents) seen.push_back(sight(agent));
    cost += swarm.cost(seen, t);
  }
  return cost;
}

}  // namespace sightline
