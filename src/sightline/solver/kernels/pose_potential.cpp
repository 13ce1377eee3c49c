#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>

#include "sightline/base.hpp"
#include "sightline/formula.hpp"
#include "sightline/kernels.hpp"

namespace sightline {
namespace {

/// Records the weighted sum over the given variables; all other variables are zero.
Term record(Graph& graph, std::span<const Weighted* const> terms, double h, std::span<const int> variables,
            Numbers numbers) {
  std::vector<Symbol> z(at(PosePotential::variable_count), Symbol(graph, graph.constant(0.0)));
  int input = 0;
  for (const int v : variables) z[at(v)] = Symbol(graph, graph.input(input++));
  const auto part = [&](int from) { return std::span<const Symbol>(z).subspan(at(from), at(sight_size)); };
  Sight<Symbol> a = sight_from<Symbol>(part(0));
  a.uncertainty = z[at(PosePotential::uncertainty_variable)];
  const Symbol* const third = &z[at(PosePotential::third_variable)];
  a.third = {third[0], third[1], third[2]};
  const Sight<Symbol> b = sight_from<Symbol>(part(sight_size));
  Term l = graph.constant(0.0);
  for (const Weighted* term : terms) {
    if (numbers == Numbers::parameters) graph.keep_parameters();
    l = graph.add(l,
                  (h * term->weight * term->potential(a, b, z[at(PosePotential::time_variable)])).in(graph));
  }
  return l;
}

/// Sorts by name: a canonical order, so that one program serves all teams.
std::vector<const Weighted*> sorted(std::span<const Weighted* const> terms) {
  std::vector<const Weighted*> list(terms.begin(), terms.end());
  std::stable_sort(list.begin(), list.end(), [](const Weighted* a, const Weighted* b) {
    return a->potential.name() > b->potential.name();
  });
  return list;
}

std::vector<Term> recorded_inputs(Graph& graph, int n) {
  std::vector<Term> z;
  for (int i = 0; i < n; ++i) z.push_back(graph.input(i));
  return z;
}

std::vector<int> range(int n) {
  std::vector<int> list(at(n));
  std::iota(list.begin(), list.end(), 0);
  return list;
}

/// Inputs that the output depends on.
std::vector<int> occurring(const Graph& graph, Term out, int n) {
  std::vector<bool> live(at(graph.size()), false);
  live[at(out.node)] = true;
  std::vector<int> list;
  std::vector<bool> occurs(at(n), false);
  for (std::size_t v = live.size(); v-- > 0;) {
    if (!live[v]) continue;
    const Node& node = graph.nodes()[v];
    if (node.op == Op::input) {
      occurs[static_cast<std::size_t>(node.value)] = true;
    } else if (node.op != Op::constant) {
      live[at(node.a.node)] = true;
      if (node.b.node >= 0) live[at(node.b.node)] = true;
    }
  }
  for (int i = 0; i < n; ++i) {
    if (occurs[at(i)]) list.push_back(i);
  }
  return list;
}

/// Whether l has the form l(p_a - p_b, d_a): the gradient by p_b is symbolically the negative of
/// that by p_a.
bool is_relative(Graph& graph, Term l, const std::vector<int>& variables) {
  const bool pose_of_a_and_position_of_b = std::all_of(variables.begin(), variables.end(), [](int v) {
    return v < 5 || (v >= sight_size && v < sight_size + 3);
  });
  if (!pose_of_a_and_position_of_b) return false;
  const std::vector<Term> first = gradient(graph, l, recorded_inputs(graph, 2 * sight_size));
  for (int i = 0; i < 3; ++i) {
    const Term a = first[at(i)], b = first[at(sight_size + i)];
    if (!(graph.is_zero(a) && graph.is_zero(b)) && a != -b) return false;
  }
  return true;
}

}  // namespace

Seen PosePotential::sees(bool of_b) const {
  const int from = of_b ? sight_size : 0;
  const auto beyond = [&](Seen seen) {
    return std::any_of(variables.begin(), variables.end(),
                       [&](int v) { return v >= from + seen_size(seen) && v < from + sight_size; });
  };
  if (!beyond(Seen::pose_and_motion)) return beyond(Seen::pose) ? Seen::pose_and_motion : Seen::pose;
  const bool multiplied = std::any_of(own.begin(), own.end(), [&](const Second& h) {
    return h.row >= from + seen_size(Seen::pose) && h.row < from + seen_size(Seen::pose_and_motion) &&
           h.column >= from + seen_size(Seen::pose_and_motion) && h.column < from + sight_size;
  });
  return multiplied ? Seen::all : Seen::leaning;
}

PosePotential trace_potential(std::span<const Weighted* const> given, double h, const Ends& ends,
                              Numbers numbers) {
  const std::vector<const Weighted*> terms = sorted(given);
  PosePotential p;
  p.names.emplace_back();
  for (const Weighted* term : terms) {
    if (!p.names[0].empty()) p.names[0] += " + ";
    p.names[0] += term->potential.name();
  }
  {
    Graph graph;
    const Term l = record(graph, terms, h, range(PosePotential::variable_count), numbers);
    p.variables = occurring(graph, l, PosePotential::variable_count);
    p.relative = ends.a_is_agent && ends.b_is_agent && is_relative(graph, l, p.variables);
  }
  if (p.relative) p.variables = range(PosePotential::relative_size);
  Graph graph;
  const int n = static_cast<int>(p.variables.size());
  const Term l = record(graph, terms, h, p.variables, numbers);
  p.value = Program(graph, std::vector{l}, n);
  const Derivatives d = derive(graph, l, recorded_inputs(graph, n));
  std::vector<Term> outputs;
  if (p.relative) {
    outputs = d.first;
    outputs.insert(outputs.end(), d.second.begin(), d.second.end());
    p.derivatives = Program(graph, outputs, n);
    return p;
  }

  const auto output = [&](Term t) {
    const auto found = std::find_if(outputs.begin(), outputs.end(), [&](Term o) { return o.node == t.node; });
    if (found != outputs.end()) return static_cast<int>(found - outputs.begin());
    outputs.push_back({t.node, false});
    return static_cast<int>(outputs.size()) - 1;
  };
  const auto of_b = [](int v) { return v >= sight_size; };
  const auto feels = [&](int v) {
    return of_b(v) ? ends.b_feels && ends.b_is_agent : ends.a_feels && ends.a_is_agent;
  };
  for (int i = 0; i < n; ++i) {
    const int v = p.variables[at(i)];
    const Term t = d.first[at(i)];
    if (v >= PosePotential::time_variable || graph.is_zero(t)) continue;
    if (feels(v)) p.gradient.push_back({v, output(t), t.negative});
    for (int j = i; j < n; ++j) {
      const int w = p.variables[at(j)];
      const Term s = d.second[at(upper_index(i, j, n))];
      if (w >= PosePotential::time_variable || graph.is_zero(s)) continue;
      if (of_b(v) == of_b(w)) {
        if (feels(v)) p.own.push_back({v, w, output(s), s.negative});
      } else if (ends.a_is_agent && ends.b_is_agent) {
        p.cross.push_back({v, w, output(s), s.negative});
      }
    }
  }
  p.derivatives = Program(graph, outputs, n);
  return p;
}

namespace {

using Terms = std::vector<const Weighted*>;

/// Takes the compiled program with the most terms, if any, and removes its terms.
std::optional<PosePotential> take_compiled(Terms& terms, double h, const Ends& ends,
                                           const IsCompiled& is_compiled) {
  constexpr std::size_t few = 6;  // with more terms only all or single ones are tried
  const std::size_t n = terms.size();
  for (std::size_t size = n; size > 0; --size) {
    if (n > few && size > 1 && size < n) continue;
    std::vector<bool> chosen(n, false);
    std::fill_n(chosen.begin(), size, true);
    do {
      Terms some, rest;
      for (std::size_t i = 0; i < n; ++i) (chosen[i] ? some : rest).push_back(terms[i]);
      PosePotential p = trace_potential(some, h, ends, Numbers::parameters);
      if (!is_compiled(p.derivatives)) continue;
      terms = rest;
      return p;
    } while (std::prev_permutation(chosen.begin(), chosen.end()));
  }
  return std::nullopt;
}

/// Traces the terms of one pair or one robot: one potential if relative, else several.
std::vector<PosePotential> trace_terms(const Terms& terms, double h, const Ends& ends,
                                       const IsCompiled& is_compiled) {
  Terms left = terms;
  std::vector<PosePotential> parts;
  while (is_compiled && !left.empty()) {
    std::optional<PosePotential> compiled = take_compiled(left, h, ends, is_compiled);
    if (!compiled) break;
    parts.push_back(std::move(*compiled));
  }
  if (!left.empty()) parts.push_back(trace_potential(left, h, ends));
  if (parts.size() == 1 || !std::all_of(parts.begin(), parts.end(), [](const auto& p) { return p.relative; }))
    return parts;
  PosePotential whole = std::move(parts[0]);
  for (std::size_t i = 1; i < parts.size(); ++i) {
    whole.others.push_back(std::move(parts[i].derivatives));
    whole.names.push_back(std::move(parts[i].names[0]));
  }
  whole.value = trace_potential(terms, h, ends).value;
  return {std::move(whole)};
}

}  // namespace

namespace {

/// The constants of an output, in the order of its formula.
std::vector<Term> constants_of(const Graph& graph, Term out) {
  std::vector<Term> list;
  for (const int v : graph.in_order(std::array{out})) {
    if (graph.is_constant({v, false})) list.push_back({v, false});
  }
  return list;
}

/// Derivative of h times the sum of the terms along a step, D = l_s' ds; the step's entries are the
/// inputs after the variables.
Term along_step(Graph& graph, std::span<const Weighted* const> terms, double h, const PotentialSlopes& p) {
  const int n = static_cast<int>(p.variables.size());
  const Term l = record(graph, terms, h, p.variables, Numbers::parameters);
  graph.keep_values();
  const std::vector<Term> slopes = gradient(graph, l, recorded_inputs(graph, n));
  Term D = graph.constant(0.0);
  int step = n;
  for (int i = 0; i < n; ++i) {
    if (std::find(p.along.begin(), p.along.end(), p.variables[at(i)]) != p.along.end())
      D = graph.add(D, graph.multiply(slopes[at(i)], graph.input(step++)));
  }
  return D;
}

/// A term with another weight (i = 0) or another number of its potential.
Weighted changed(const Weighted& term, std::size_t i, double value) {
  if (i == 0) return {value, term.potential};
  return {term.weight, term.potential.with_number(i - 1, value)};
}

/// Finite difference of fourth order: the sum of factor f(x + by step) / step.
struct Shift {
  double by, factor;
};
constexpr std::array<Shift, 4> shifts = {
    {{1.0, 2.0 / 3.0}, {-1.0, -2.0 / 3.0}, {2.0, -1.0 / 12.0}, {-2.0, 1.0 / 12.0}}};

}  // namespace

// The numbers of a potential enter its formula as constants, which are functions of the weight and
// the parameters. Their derivatives are differences, taken here once; those of D by the constants
// are exact. If a parameter happens to equal another number, its formula has another shape nearby:
// then D itself is the difference.
PotentialSlopes trace_slopes(std::span<const Weighted* const> given, double h, const Ends& ends,
                             bool third_is_agent) {
  constexpr double relative_step = 1e-3;
  PotentialSlopes p;
  const std::vector<const Weighted*> terms = sorted(given);
  for (const Weighted* term : terms)
    p.order.push_back(static_cast<std::size_t>(std::find(given.begin(), given.end(), term) - given.begin()));
  {
    Graph graph;
    const Term l = record(graph, terms, h, range(PosePotential::variable_count), Numbers::parameters);
    p.variables = occurring(graph, l, PosePotential::variable_count);
    p.relative = ends.a_is_agent && ends.b_is_agent && is_relative(graph, l, p.variables);
  }
  if (p.relative) p.variables = range(PosePotential::relative_size);
  for (const int v : p.variables) {
    const bool of_b = v >= sight_size, of_third = v >= PosePotential::third_variable;
    const bool is_sight = v < PosePotential::time_variable;
    const bool is_agent = of_third ? third_is_agent : of_b ? ends.b_is_agent : ends.a_is_agent;
    const bool moves_r = p.relative && v < 3 && ends.b_feels;
    if (is_sight && is_agent && (moves_r || (of_b ? ends.b_feels : ends.a_feels))) p.along.push_back(v);
    if ((is_sight || of_third) && !is_agent) p.uncontrolled.push_back(v);
  }
  const int n = static_cast<int>(p.variables.size());
  const int inputs = n + static_cast<int>(p.along.size());
  Graph graph;
  const Term D = along_step(graph, terms, h, p);
  const Program program(graph, std::vector{D}, inputs);
  const std::vector<Term> constants = constants_of(graph, D);
  const std::vector<Term> by_constants = gradient(graph, D, constants);
  std::vector<Term> outputs;
  const auto output = [&](std::size_t of_term, std::size_t i, double value) {
    const double step = relative_step * (value != 0.0 ? std::fabs(value) : 1.0);
    std::vector<const Weighted*> list(terms.begin(), terms.end());
    std::vector<double> slopes(constants.size(), 0.0);
    bool same_shape = true;
    Term difference = graph.constant(0.0);
    for (const Shift& shift : shifts) {
      const Weighted nearby = changed(*terms[of_term], i, value + shift.by * step);
      list[of_term] = &nearby;
      Graph its;
      const Term D_nearby = along_step(its, list, h, p);
      const std::vector<Term> its_constants = constants_of(its, D_nearby);
      same_shape &= its_constants.size() == constants.size() &&
                    structure(Program(its, std::vector{D_nearby}, inputs)) == structure(program);
      for (std::size_t c = 0; same_shape && c < constants.size(); ++c)
        slopes[c] += shift.factor / step * its.constant_value(its_constants[c]);
    }
    if (!same_shape) {
      for (const Shift& shift : shifts) {
        const Weighted nearby = changed(*terms[of_term], i, value + shift.by * step);
        list[of_term] = &nearby;
        const Term D_nearby = along_step(graph, list, h, p);
        difference = graph.add(difference, graph.multiply(graph.constant(shift.factor / step), D_nearby));
      }
      return difference;
    }
    for (std::size_t c = 0; c < constants.size(); ++c) {
      if (slopes[c] != 0.0)
        difference = graph.add(difference, graph.multiply(graph.parameter(slopes[c]), by_constants[c]));
    }
    return difference;
  };
  for (std::size_t t = 0; t < terms.size(); ++t) {
    outputs.push_back(output(t, 0, terms[t]->weight));
    std::size_t i = 0;
    for (const auto& [key, value] : terms[t]->potential.numbers()) outputs.push_back(output(t, ++i, value));
  }
  const std::vector<Term> by_inputs = gradient(graph, D, recorded_inputs(graph, n));
  for (int i = 0; i < n; ++i) {
    if (std::find(p.uncontrolled.begin(), p.uncontrolled.end(), p.variables[at(i)]) != p.uncontrolled.end())
      outputs.push_back(by_inputs[at(i)]);
  }
  p.program = Program(graph, outputs, inputs);
  return p;
}

std::vector<BodyPotential> trace_potentials(const Ocp& ocp, const IsCompiled& is_compiled) {
  const Team& team = ocp.team();
  const double h = ocp.horizon().h();
  std::vector<int> agent_of(at(team.bodies()), -1);
  for (std::size_t i = 0; i < ocp.agent_bodies().size(); ++i) {
    agent_of[at(ocp.agent_bodies()[i].index)] = static_cast<int>(i);
  }
  std::vector<BodyPotential> list;
  std::vector<bool> taken(team.couplings().size(), false);
  for (std::size_t i = 0; i < taken.size(); ++i) {
    if (taken[i]) continue;
    const Coupling& first = team.couplings()[i];
    std::vector<const Weighted*> terms;
    for (std::size_t j = i; j < taken.size(); ++j) {
      const Coupling& c = team.couplings()[j];
      if (taken[j] || !alike(c, first)) continue;
      terms.push_back(&c.term);
      taken[j] = true;
    }
    const auto feels = [&](BodyId body) {
      return std::find(first.felt_by.begin(), first.felt_by.end(), body) != first.felt_by.end();
    };
    const BodyId a = first.between.first, b = first.between.second;
    const Ends ends{team.is_agent(a), team.is_agent(b), feels(a), feels(b)};
    const int third = first.has_third() ? agent_of[at(first.third.index)] : -1;
    for (PosePotential& p : trace_terms(terms, h, ends, is_compiled))
      list.push_back({agent_of[at(a.index)], agent_of[at(b.index)], a.index, b.index, third,
                      first.third.index, ends, std::move(p), first.ramp});
  }
  std::vector<bool> constrained(team.constraints().size(), false);
  for (std::size_t i = 0; i < constrained.size(); ++i) {
    if (constrained[i]) continue;
    const Constraint& first = team.constraints()[i];
    std::vector<const Weighted*> terms;
    for (std::size_t j = i; j < constrained.size(); ++j) {
      const Constraint& c = team.constraints()[j];
      if (constrained[j] || c.agent != first.agent || c.ramp != first.ramp) continue;
      terms.push_back(&c.term);
      constrained[j] = true;
    }
    const Ends ends{true, false, true, false};
    const int body = first.agent.index;
    for (PosePotential& p : trace_terms(terms, h, ends, is_compiled))
      list.push_back({agent_of[at(body)], -1, body, -1, -1, -1, ends, std::move(p), first.ramp});
  }
  return list;
}

SwarmPotential trace_swarm(const Weighted& term, double h, Numbers numbers) {
  constexpr int n = PosePotential::relative_size;
  Graph graph;
  const std::vector<int> variables = range(n);
  const Term l = record(graph, std::array{&term}, h, variables, numbers);
  const std::vector<int> seen = occurring(graph, l, n);
  SwarmPotential p;
  p.name = term.potential.name();
  p.sees_headings = std::any_of(seen.begin(), seen.end(), [](int v) { return v >= 3; });
  p.value = Program(graph, std::vector{l}, n);
  const Derivatives d = derive(graph, l, recorded_inputs(graph, n));
  std::vector<Term> outputs = d.first;
  outputs.insert(outputs.end(), d.second.begin(), d.second.end());
  p.derivatives = Program(graph, outputs, n);
  return p;
}

std::vector<SwarmPotential> trace_swarms(const Ocp& ocp, const IsCompiled& is_compiled) {
  std::vector<SwarmPotential> list;
  const std::vector<BodyId>& bodies = ocp.agent_bodies();
  for (const Swarm& swarm : ocp.team().swarms()) {
    const double h = ocp.horizon().h();
    SwarmPotential p = trace_swarm(swarm.term, h, Numbers::parameters);
    if (!is_compiled || !is_compiled(p.derivatives)) p = trace_swarm(swarm.term, h, Numbers::known);
    for (const AgentId agent : swarm.agents)
      p.agents.push_back(static_cast<int>(std::find(bodies.begin(), bodies.end(), agent) - bodies.begin()));
    p.radius = swarm.radius;
    p.capacity = swarm.capacity;
    list.push_back(std::move(p));
  }
  return list;
}

}  // namespace sightline
