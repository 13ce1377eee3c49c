// Derivatives of the applied input: the adjoint of the Newton step, docs/equations.md, 15.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "sightline/base.hpp"
#include "sightline/model/state_roles.hpp"
#include "sightline/solver/newton/points.hpp"
#include "sightline/solver/newton/workspace.hpp"
#include "sightline/solvers.hpp"

namespace sightline {
namespace {

constexpr double adjoint_tolerance = 3e-7;  // of the team's adjoint step, relative
constexpr int most_iterations = 60;

/// Potentials of one formula between some pairs of bodies, evaluated pair by pair over packs of
/// stages.
struct SlopesOfPairs {
  /// Potentials between two bodies, or of one robot.
  struct Pair {
    BodyPotential between;           // its program is not used
    std::vector<std::size_t> first;  // of each potential: place of its weight among the parameters
    std::vector<int> numbers;        // of each potential: outputs
  };

  SlopesOfPairs(PotentialSlopes of_potentials, int packs, KernelChoice choice)
      : slopes(std::make_unique<PotentialSlopes>(std::move(of_potentials))),
        formula(slopes->program, choice),
        in(1, packs * slopes->program.inputs() * native_width),
        out(1, packs * slopes->program.outputs() * native_width) {}

  std::unique_ptr<PotentialSlopes> slopes;  // the formula refers to its program
  PackFormula<native_width> formula;
  Rows in, out;  // [pack][input][lane], [pack][output][lane]
  std::vector<Pair> pairs{};
};

}  // namespace

struct InputGradient::Work {
  explicit Work(newton::Workspace& workspace);

  bool differentiate(std::span<const double> g) noexcept;

  newton::Workspace& w;
  const Layout& layout;
  int packs;  // of stages
  Gmres gmres;
  Rows u_vectors, s_vectors;
  Rows y, p, slopes;               // of each group
  Rows s_of_agents, ds_of_agents;  // (10 agents x N)
  Rows ones, times;                // of the stages: 1 and k h; 0 beyond the horizon
  std::vector<int> turns;          // groups, those that are felt last come first
  std::vector<SlopesOfPairs> formulas;
  std::vector<Parameter> parameters;
  std::vector<std::size_t> first_of_agent;  // place of its Q
  std::vector<int> headings;                // [body]: first state of the heading vector; -1: none
  std::vector<double> by_states, by_previous, by_parameters;
  double error = 0.0;

 private:
  void multiply(const double* z, double* rows) noexcept;
  double pass(const double* ds_own, double* ds) noexcept;
  void solve_adjoint(const double* ds_own, double* ds) noexcept;
  void conjugate_gradients(double* ds) noexcept;
  void take_own_slopes() noexcept;
  void take_potentials(const double* ds) noexcept;
  void add_body(int body, int component, double sum, double moment) noexcept;
  void project_headings() noexcept;
  void add_parameters(const std::string& name, std::span<const double> values);
  void add_potentials(std::span<const Weighted* const> terms, SlopesOfPairs::Pair pair);
  void collect(const double* s, Rows& of_agents) const noexcept;
  const double* row_of(const BodyPotential& between, int variable, const Rows& of_agents) const noexcept;
  void gather(SlopesOfPairs& formula, const SlopesOfPairs::Pair& pair) noexcept;
  void scatter(const SlopesOfPairs& formula, const SlopesOfPairs::Pair& pair) noexcept;
};

InputGradient::Work::Work(newton::Workspace& workspace)
    : w(workspace),
      layout(w.groups.layout()),
      packs((layout.stages + native_width - 1) / native_width),
      gmres(layout.s_length, w.influence.kind == Influence::cyclic ? most_iterations : 1),
      u_vectors(2, layout.u_length),
      s_vectors(7, std::max(layout.s_length, gmres.length())) {
  const Team& team = w.ocp.team();
  int most_x = 0, most_slopes = 0;
  for (std::size_t a = 0; a < team.agents().size(); ++a) {
    const Agent& agent = team.agents()[a];
    const Group& group = w.groups.group_of(static_cast<int>(a));
    most_x = std::max(most_x, group.sizes().nx);
    most_slopes = std::max(most_slopes, group.slopes());
    first_of_agent.push_back(parameters.size());
    const std::string name(team.name(w.ocp.agent_bodies()[a]));
    const std::vector<double> shift(agent.Q.size(), 0.0);
    add_parameters(name + ".x_ref", shift);
    add_parameters(name + ".u_ref", agent.u_ref);
    add_parameters(name + ".Q", agent.Q);
    add_parameters(name + ".R", agent.R);
    add_parameters(name + ".Q_f", agent.Q_f);
    if (group.sizes().before > 0) add_parameters(name + ".R_rate", agent.R_rate);
  }
  const int groups = static_cast<int>(layout.groups.size());
  const int sights = sight_size * static_cast<int>(layout.agents.size());
  s_of_agents = Rows(sights, layout.stages);
  ds_of_agents = Rows(sights, layout.stages);
  ones = Rows(1, layout.stages), times = Rows(1, layout.stages);
  for (int k = 0; k < layout.stages; ++k) ones[0][k] = 1.0, times[0][k] = k * w.ocp.horizon().h();
  y = Rows(groups, (layout.stages + 1) * most_x * layout.width);
  p = Rows(groups, most_x * layout.width);
  slopes = Rows(groups, most_slopes * layout.width);
  for (int g = 0; g < groups; ++g) turns.push_back(g);
  std::stable_sort(turns.begin(), turns.end(),
                   [&](int a, int b) { return layout.groups[at(a)].turn > layout.groups[at(b)].turn; });

  std::vector<int> agent_of(at(team.bodies()), -1);
  for (std::size_t i = 0; i < w.ocp.agent_bodies().size(); ++i)
    agent_of[at(w.ocp.agent_bodies()[i])] = static_cast<int>(i);
  const auto agent = [&](BodyId body) { return body.index < 0 ? -1 : agent_of[at(body)]; };
  std::vector<std::size_t> of_couplings, of_constraints;  // places of their weights
  const auto add_term = [&](const Weighted& term, const std::string& name) {
    parameters.push_back({name + ".weight", term.weight});
    for (const auto& [key, value] : term.potential.numbers()) parameters.push_back({name + "." + key, value});
    return parameters.size() - 1 - term.potential.numbers().size();
  };
  for (std::size_t i = 0; i < team.couplings().size(); ++i)
    of_couplings.push_back(add_term(team.couplings()[i].term, fmt::format("couple[{}]", i)));
  for (std::size_t i = 0; i < team.constraints().size(); ++i)
    of_constraints.push_back(add_term(team.constraints()[i].term, fmt::format("constrain[{}]", i)));

  /// Takes the terms that one formula can hold together.
  const auto add_alike = [&](const auto& list, const std::vector<std::size_t>& places, auto&& is_alike,
                             auto&& between) {
    std::vector<bool> taken(list.size(), false);
    for (std::size_t i = 0; i < list.size(); ++i) {
      if (taken[i]) continue;
      std::vector<const Weighted*> terms;
      SlopesOfPairs::Pair pair{between(list[i]), {}, {}};
      for (std::size_t j = i; j < list.size(); ++j) {
        if (taken[j] || !is_alike(list[i], list[j])) continue;
        taken[j] = true;
        terms.push_back(&list[j].term);
        pair.first.push_back(places[j]);
        pair.numbers.push_back(1 + static_cast<int>(list[j].term.potential.numbers().size()));
      }
      add_potentials(terms, std::move(pair));
    }
  };
  add_alike(team.couplings(), of_couplings, alike, [&](const Coupling& c) {
    const auto feels = [&](BodyId body) {
      return std::find(c.felt_by.begin(), c.felt_by.end(), body) != c.felt_by.end();
    };
    const BodyId a = c.between.first, b = c.between.second;
    return BodyPotential{.a = agent(a),
                         .b = agent(b),
                         .body_a = a.index,
                         .body_b = b.index,
                         .third = agent(c.third),
                         .third_body = c.third.index,
                         .ends = {team.is_agent(a), team.is_agent(b), feels(a), feels(b)},
                         .potential = {},
                         .ramp = c.ramp};
  });
  add_alike(
      team.constraints(), of_constraints,
      [](const Constraint& a, const Constraint& b) { return a.agent == b.agent && a.ramp == b.ramp; },
      [&](const Constraint& c) {
        return BodyPotential{.a = agent(c.agent),
                             .body_a = c.agent.index,
                             .ends = {true, false, true, false},
                             .potential = {},
                             .ramp = c.ramp};
      });
  for (int b = 0; b < team.bodies(); ++b) headings.push_back(roles_of(team.model(BodyId{b})).direction[0]);
  by_states.resize(at(team.nx()));
  by_previous.resize(at(team.nu()));
  by_parameters.resize(parameters.size());
}

void InputGradient::Work::add_parameters(const std::string& name, std::span<const double> values) {
  for (std::size_t i = 0; i < values.size(); ++i)
    parameters.push_back({fmt::format("{}[{}]", name, i), values[i]});
}

void InputGradient::Work::add_potentials(std::span<const Weighted* const> terms, SlopesOfPairs::Pair pair) {
  const BodyPotential& between = pair.between;
  PotentialSlopes its = trace_slopes(terms, w.ocp.horizon().h(), between.ends, between.third >= 0);
  const auto same = [&](const SlopesOfPairs& other) {
    return other.slopes->program == its.program && other.slopes->variables == its.variables &&
           other.slopes->along == its.along && other.slopes->uncontrolled == its.uncontrolled &&
           other.slopes->relative == its.relative && other.slopes->order == its.order;
  };
  auto found = std::find_if(formulas.begin(), formulas.end(), same);
  if (found == formulas.end())
    found = formulas.insert(found, SlopesOfPairs(std::move(its), packs, w.options.kernels));
  found->pairs.push_back(std::move(pair));
}

/// rows = C' z.
void InputGradient::Work::multiply(const double* z, double* rows) noexcept {
  w.groups.each(*w.pool, [&](int g, int) noexcept { w.couplings->transposed_product(g, z, rows); });
  w.couplings->add_swarms(z, rows);
}

/// One pass of ds = ds_own - P^-1 C' ds over the groups, against the order of influence; each group
/// uses the previous ones (block Gauss-Seidel). Without ds_own: of ds = -P^-1 C' ds.
/// @return the largest change, relative to the largest entry
double InputGradient::Work::pass(const double* ds_own, double* ds) noexcept {
  double *const rows = s_vectors[2], *const z = s_vectors[3];
  NativeLane moved = 0.0, length = 0.0;
  if (w.couplings->has_swarms()) multiply(ds, rows);
  for (const int g : turns) {
    const Layout::Span s = layout.s_of(g);
    if (!w.couplings->has_swarms()) w.couplings->transposed_product(g, ds, rows);
    w.groups.precondition(g, rows, u_vectors[1], z);
    for (std::ptrdiff_t i = s.first; i < s.end(); i += NativeLane::width) {
      const NativeLane own = ds_own != nullptr ? NativeLane::load(ds_own + i) : NativeLane(0.0);
      const NativeLane next = own - NativeLane::load(z + i);
      moved = maximum(absolute(next - NativeLane::load(ds + i)), moved);
      length = maximum(absolute(next), length);
      next.store(ds + i);
    }
  }
  return largest(moved) / std::max(largest(length), 1e-300);
}

/// Solves ds = ds_own - P^-1 C' ds: by conjugate gradients if P + C is symmetric; by passes in a
/// cascade, which they solve exactly; else by GMRES on passes.
void InputGradient::Work::solve_adjoint(const double* ds_own, double* ds) noexcept {
  std::copy_n(ds_own, layout.s_length, ds);
  switch (w.influence.kind) {
    case Influence::none:
      return;
    case Influence::mutual:
      return conjugate_gradients(ds);
    case Influence::cascade:
      for (int i = 0; i < std::min(w.influence.depth, most_iterations); ++i) {
        if (pass(ds_own, ds) <= adjoint_tolerance) break;
      }
      return;
    case Influence::cyclic:
      break;
  }
  double* const b = s_vectors[4];
  std::fill_n(b, layout.s_length, 0.0);
  pass(ds_own, b);
  std::copy_n(b, layout.s_length, ds);
  const auto product = [&](const double* v, double* image) {
    std::copy_n(v, layout.s_length, image);
    pass(nullptr, image);
    for (int i = 0; i < layout.s_length; i += NativeLane::width)
      (NativeLane::load(v + i) - NativeLane::load(image + i)).store(image + i);
  };
  gmres.solve(product, b, ds, 0.1 * adjoint_tolerance * std::sqrt(dot(b, b, gmres.length())));
}

/// As Krylov: w stands for P p, which is never multiplied.
void InputGradient::Work::conjugate_gradients(double* ds) noexcept {
  double *const r = s_vectors[2], *const z = s_vectors[3], *const p_s = s_vectors[4];
  double *const P_p = s_vectors[5], *const C_p = s_vectors[6];
  const int n = gmres.length();
  const auto each_pack = [&](int g, auto&& f) {
    const Layout::Span s = layout.s_of(g);
    for (std::ptrdiff_t i = s.first; i < s.end(); i += NativeLane::width) f(i);
  };
  const auto at_i = [](const double* v, std::ptrdiff_t i) { return NativeLane::load(v + i); };
  multiply(ds, r);
  double first = 0.0, rho = 0.0;
  NativeLane step = 0.0;
  for (int k = 0; k < most_iterations; ++k) {
    w.groups.each(*w.pool, [&](int g, int) noexcept {
      if (k > 0) {
        each_pack(g, [&](std::ptrdiff_t i) {
          fma(step, at_i(p_s, i), at_i(ds, i)).store(ds + i);
          fma(step, at_i(P_p, i) + at_i(C_p, i), at_i(r, i)).store(r + i);
        });
      }
      w.groups.precondition(g, r, u_vectors[1], z);
    });
    const double next = dot(r, z, n);
    if (k == 0) first = next;
    if (!(next > 1e-28)) return;                      // already solved, or not a number
    const double shrinks = k > 0 ? next / rho : 1.0;  // energy of the correction
    const NativeLane beta = k > 0 ? shrinks : 0.0;
    rho = next;
    w.groups.each(*w.pool, [&](int g, int) noexcept {
      each_pack(g, [&](std::ptrdiff_t i) {
        fma(beta, at_i(p_s, i), at_i(z, i)).store(p_s + i);
        fma(beta, at_i(P_p, i), at_i(r, i)).store(P_p + i);
      });
    });
    multiply(p_s, C_p);
    const double curvature = dot(p_s, P_p, n) + dot(p_s, C_p, n);
    if (!(curvature > 0.0)) return;
    step = -rho / curvature;
    // This step and the refinement shrink what is left as much as the last step did.
    if (rho * square(shrinks) < square(adjoint_tolerance) * first) break;
  }
  for (int i = 0; i < layout.s_length; i += NativeLane::width)
    fma(step, at_i(p_s, i), at_i(ds, i)).store(ds + i);
}

bool InputGradient::Work::differentiate(std::span<const double> g) noexcept {
  std::fill(by_states.begin(), by_states.end(), 0.0);
  std::fill(by_previous.begin(), by_previous.end(), 0.0);
  std::fill(by_parameters.begin(), by_parameters.end(), 0.0);
  const bool turned = std::find(w.turned.begin(), w.turned.end(), 1) != w.turned.end();
  if (!w.factorised || turned || g.size() != by_previous.size()) return false;
  const FlushSubnormals guard;
  const Team& team = w.ocp.team();
  double *const g_u = u_vectors[0], *const du = u_vectors[1];
  double *const ds_own = s_vectors[0], *const ds = s_vectors[1], *const r = s_vectors[2];
  std::fill_n(g_u, layout.u_length, 0.0);
  for (int a = 0; a < static_cast<int>(layout.agents.size()); ++a) {
    const Layout::View to = layout.u(a);
    const std::size_t from = at(team.input_offset(w.ocp.agent_bodies()[at(a)]));
    for (int i = 0; i < layout.part(a).nu; ++i) g_u[to(0, i)] = g[from + at(i)];
  }
  const auto solve_groups = [&](const double* right_side, double* steps) {
    w.groups.each(*w.pool, [&](int group, int) noexcept {
      w.groups.adjoint(group, g_u, right_side, du, steps, y[group], p[group]);
    });
  };
  solve_groups(nullptr, ds_own);
  solve_adjoint(ds_own, ds);
  multiply(ds, r);
  for (int i = 0; i < layout.s_length; ++i) r[i] = -r[i];
  double* const refined = ds_own;
  solve_groups(r, refined);
  double moved = 0.0, length = 0.0;
  bool finite = true;
  for (int i = 0; i < layout.s_length; ++i) {
    moved = std::max(moved, std::fabs(refined[i] - ds[i]));
    length = std::max(length, std::fabs(refined[i]));
    finite = finite && std::isfinite(refined[i]);
  }
  error = length > 0.0 ? moved / length : 0.0;
  take_own_slopes();
  take_potentials(refined);
  project_headings();
  if (finite && error < 1e-3) return true;
  for (auto* const of : {&by_states, &by_previous, &by_parameters}) std::fill(of->begin(), of->end(), 0.0);
  return false;
}

/// Derivatives by the states and by the robots' own weights and references.
void InputGradient::Work::take_own_slopes() noexcept {
  const Team& team = w.ocp.team();
  const double* const du = u_vectors[1];
  w.groups.each(*w.pool, [&](int g, int) noexcept { w.groups.own_slopes(g, w.u_next, du, y[g], slopes[g]); });
  for (int a = 0; a < static_cast<int>(layout.agents.size()); ++a) {
    const Layout::Place& place = layout.place(a);
    const StageSizes& n = w.groups.group_of(a).sizes();
    const int own = n.nx - n.before;
    const auto entry = [&](const Rows& rows, int i) {
      return -rows[place.group][i * layout.width + place.lane];
    };
    for (int i = 0; i < own; ++i) by_states[at(w.x_at[at(a)] + i)] = entry(p, i);
    const int input = team.input_offset(w.ocp.agent_bodies()[at(a)]);
    for (int i = 0; i < n.before; ++i) by_previous[at(input + i)] = entry(p, own + i);
    std::size_t to = first_of_agent[at(a)];
    int from = 0;
    const auto take = [&](int count, int skipped) {
      for (int i = 0; i < count; ++i) by_parameters[to++] = entry(slopes, from + i);
      from += count + skipped;
    };
    take(own, n.before);  // x*
    take(n.nu, 0);        // u*
    take(own, n.before);  // Q
    take(n.nu, 0);        // R
    take(own, n.before);  // Q_f
    take(n.before, 0);    // R_rate
  }
}

/// Derivatives by the numbers of the potentials and by the states of uncontrolled bodies.
void InputGradient::Work::take_potentials(const double* ds) noexcept {
  collect(w.s, s_of_agents);
  collect(ds, ds_of_agents);
  for (SlopesOfPairs& formula : formulas) {
    for (const SlopesOfPairs::Pair& pair : formula.pairs) {
      gather(formula, pair);
      formula.formula.run(formula.in[0], formula.out[0], packs);
      scatter(formula, pair);
    }
  }
}

/// Copies s to rows of single agents and entries, stage by stage.
void InputGradient::Work::collect(const double* s, Rows& of_agents) const noexcept {
  for (int g = 0; g < static_cast<int>(layout.groups.size()); ++g) {
    const Layout::Part& part = layout.groups[at(g)];
    const std::span<const int> members = w.groups.members(g);
    for (int k = 0; k < layout.stages; ++k) {
      for (int i = 0; i < part.ns; ++i) {
        const double* const from = s + part.s + (k * part.ns + i) * layout.width;
        for (std::size_t lane = 0; lane < members.size(); ++lane)
          of_agents[members[lane] * sight_size + i][k] = from[lane];
      }
    }
  }
}

/// Values of one variable, as in PosePotential, stage by stage.
const double* InputGradient::Work::row_of(const BodyPotential& between, int v,
                                          const Rows& of_agents) const noexcept {
  const StageParameters& parameters_set = w.couplings->parameters();
  if (v == PosePotential::time_variable) return parameters_set.time[0];
  if (v == PosePotential::uncertainty_variable) return parameters_set.uncertainty[between.body_a];
  const bool of_b = v >= sight_size, of_third = v >= PosePotential::third_variable;
  const int agent = of_third ? between.third : of_b ? between.b : between.a;
  const int body = of_third ? between.third_body : of_b ? between.body_b : between.body_a;
  const int component = of_third ? v - PosePotential::third_variable : of_b ? v - sight_size : v;
  return agent >= 0 ? of_agents[agent * sight_size + component]
                    : parameters_set.bodies[body * sight_size + component];
}

/// Writes the inputs of a pair at all stages.
void InputGradient::Work::gather(SlopesOfPairs& formula, const SlopesOfPairs::Pair& pair) noexcept {
  using L = NativeLane;
  const std::ptrdiff_t stride = formula.slopes->program.inputs() * L::width;
  const Ends& ends = pair.between.ends;
  double* to = formula.in[0];
  const auto add = [&](const std::vector<int>& variables, const Rows& of_agents, L of_a, L of_b) {
    for (const int v : variables) {
      const double* const a = row_of(pair.between, v, of_agents);
      const bool differs = formula.slopes->relative && v < 3;
      const double* const b = differs ? row_of(pair.between, sight_size + v, of_agents) : a;
      for (int k = 0; k < packs; ++k) {
        const L of_first = L::load(a + k * L::width);
        const L value = differs ? of_a * of_first - of_b * L::load(b + k * L::width) : of_first;
        value.store(to + k * stride);
      }
      to += L::width;
    }
  };
  add(formula.slopes->variables, s_of_agents, 1.0, 1.0);
  add(formula.slopes->along, ds_of_agents, ends.a_feels ? 1.0 : 0.0, ends.b_feels ? 1.0 : 0.0);
}

/// Sums the outputs of a pair over the stages.
void InputGradient::Work::scatter(const SlopesOfPairs& formula, const SlopesOfPairs::Pair& pair) noexcept {
  using L = NativeLane;
  const double part = pair.between.ramp.at(w.time);
  const int outputs = formula.slopes->program.outputs();
  int output = 0;
  const auto sum_with = [&](const Rows& factors) {
    L sum = 0.0;
    for (int k = 0; k < packs; ++k) {
      const L value = L::load(formula.out[0] + (k * outputs + output) * L::width);
      const L factor = L::load(factors[0] + k * L::width);
      sum += where_negative(-factor, factor * value, L(0.0));
    }
    double all = 0.0;
    for (int i = 0; i < L::width; ++i) all += sum[i];
    return part * all;
  };
  for (const std::size_t t : formula.slopes->order) {
    for (int i = 0; i < pair.numbers[t]; ++i, ++output)
      by_parameters[pair.first[t] + at(i)] = -sum_with(ones);
  }
  for (const int v : formula.slopes->uncontrolled) {
    const bool of_third = v >= PosePotential::third_variable, of_b = v >= sight_size;
    const BodyPotential& between = pair.between;
    const int body = of_third ? between.third_body : of_b ? between.body_b : between.body_a;
    const int component = of_third ? v - PosePotential::third_variable : of_b ? v - sight_size : v;
    add_body(body, component, sum_with(ones), sum_with(times));
    ++output;
  }
}

/// Adds the derivative by one component of a body's Sight along the horizon, p(k) = p + k h v: its
/// sum over the stages, and that of k h times it.
void InputGradient::Work::add_body(int body, int component, double sum, double moment) noexcept {
  const std::size_t x = at(w.ocp.team().state_offset(BodyId{body}));
  const Prediction& prediction = w.predictions[at(body)];
  if (prediction.holds(w.time, {w.x_now[x], w.x_now[x + 1], w.x_now[x + 2]})) return;
  const bool is_heading = component == 3 || component == 4;
  if (is_heading && headings[at(body)] < 0) return;
  const int entry = component < 3   ? component
                    : is_heading    ? headings[at(body)] + component - 3
                    : component < 8 ? component - 2
                                    : -1;
  if (entry < 0) return;
  by_states[x + at(entry)] -= sum;
  if (component < 3) by_states[x + at(3 + component)] -= moment;
}

/// Keeps the part of the derivatives that turns a heading: its length is normalised.
void InputGradient::Work::project_headings() noexcept {
  for (std::size_t b = 0; b < headings.size(); ++b) {
    if (headings[b] < 0) continue;
    const std::size_t d = at(w.ocp.team().state_offset(BodyId{static_cast<int>(b)}) + headings[b]);
    const double along = w.x_now[d] * by_states[d] + w.x_now[d + 1] * by_states[d + 1];
    by_states[d] -= along * w.x_now[d];
    by_states[d + 1] -= along * w.x_now[d + 1];
  }
}

InputGradient::InputGradient(NewtonRiccati& solver) : work_(std::make_unique<Work>(*solver.workspace_)) {}
InputGradient::InputGradient(InputGradient&& other) noexcept = default;
InputGradient& InputGradient::operator=(InputGradient&& other) noexcept = default;
InputGradient::~InputGradient() = default;

bool InputGradient::differentiate(std::span<const double> g) noexcept { return work_->differentiate(g); }
std::span<const double> InputGradient::states() const noexcept { return work_->by_states; }
std::span<const double> InputGradient::previous() const noexcept { return work_->by_previous; }
std::span<const double> InputGradient::by_parameters() const noexcept { return work_->by_parameters; }
const std::vector<InputGradient::Parameter>& InputGradient::parameters() const noexcept {
  return work_->parameters;
}
double InputGradient::error() const noexcept { return work_->error; }

}  // namespace sightline
