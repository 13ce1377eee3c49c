#include <algorithm>
#include <cassert>
#include <map>

#include "sightline/base.hpp"
#include "sightline/formula.hpp"
#include "sightline/kernels.hpp"
#include "sightline/potential/tracking.hpp"
#include "sightline/solver/kernels/riccati.hpp"

namespace sightline {
namespace {

/// Builds one block program.
class Tracer {
 public:
  Graph graph;

  std::vector<Symbol> inputs(std::string_view name, int n) {
    program_.inputs.push_back({name, n});
    auto symbols = variables(graph, inputs_, n);
    inputs_ += n;
    return symbols;
  }
  void block(std::string_view name) { program_.outputs.push_back({name, 0}); }
  void output(const Symbol& s) {
    ++program_.outputs.back().size;
    outputs_.push_back(s.in(graph));
  }
  void output(std::span<const Symbol> symbols) {
    for (const Symbol& s : symbols) output(s);
  }
  BlockProgram finish() {
    program_.program = Program(graph, outputs_, inputs_);
    return std::move(program_);
  }

 private:
  BlockProgram program_;
  int inputs_ = 0;
  std::vector<Term> outputs_;
};

/// A runtime number: its value does not change the operations.
Symbol parameter(Graph& graph, double value) { return Symbol(graph, graph.parameter(value)); }

/// Recorded F = x + h f and s of a model. Nonzero numbers of the model and h are parameters.
struct Flow {
  std::vector<Symbol> F, s;
  Sight<Symbol> sight;
};

Flow record(Graph& graph, const Model& model, const Symbol& h, Seen seen, std::span<const Symbol> x,
            std::span<const Symbol> u) {
  Flow flow{std::vector<Symbol>(x.size()), std::vector<Symbol>(at(sight_size)), {}};
  const std::size_t own = at(model.nx());
  graph.keep_parameters(Zeros::folded);
  model.f(x.first(own), u, std::span(flow.F).first(own));
  flow.sight = model.sight(x.first(own), u);
  graph.keep_values();
  for (std::size_t i = 0; i < own; ++i) flow.F[i] = x[i] + h * flow.F[i];
  for (std::size_t i = own; i < x.size(); ++i) flow.F[i] = u[i - own];  // previous inputs of the next stage
  write_sight(flow.sight, flow.s);
  flow.s.resize(at(seen_size(seen)));
  return flow;
}

Symbol sum_of(std::span<const RelaxedBarrier> barriers, const Model& model, std::span<const Symbol> x,
              std::span<const Symbol> u) {
  Symbol sum = 0.0;
  for (const RelaxedBarrier& barrier : barriers) sum += barrier(model.sight(x, u), x, u);
  return sum;
}

/// Derivatives of F and s by x and u; each distinct non-constant entry is stored once, in `stored`.
struct Linearisation {
  Matrix<Symbol> A, B, J_x, J_u;
  std::vector<Term> stored;
};

/// Scales the steps of inputs, du = unit dv. An input that moves one state only, by a constant, is
/// measured in that state, so that its column of B is a unit vector; other inputs keep unit 1.
/// @return the units
std::vector<Symbol> measure(Graph& graph, Linearisation& l, const StageSizes& n) {
  std::vector<Symbol> units(at(n.nu), Symbol(1.0));
  for (int a = 0; a < n.nu; ++a) {
    bool constants = true;
    std::vector<int> moved;
    for (int i = 0; i < n.nx; ++i) {
      const Term entry = l.B(i, a).in(graph);
      constants &= graph.is_constant(entry);
      if (!graph.is_zero(entry)) moved.push_back(i);
    }
    for (int i = 0; i < n.ns; ++i) constants &= graph.is_constant(l.J_u(i, a).in(graph));
    if (!constants || moved.size() != 1) continue;
    Symbol& entry = l.B(moved[0], a);
    units[at(a)] = 1.0 / entry;
    entry = 1.0;
    for (int i = 0; i < n.ns; ++i) l.J_u(i, a) *= units[at(a)];
  }
  return units;
}

std::vector<Term> terms(Graph& graph, std::span<const Symbol> symbols) {
  std::vector<Term> t;
  for (const Symbol& s : symbols) t.push_back(s.in(graph));
  return t;
}

Symbol symbol(Graph& graph, Term t) {
  const bool known = graph.is_constant(t) && !graph.is_parameter(t);
  return known ? Symbol(graph.constant_value(t)) : Symbol(graph, t);
}

Linearisation linearise(Graph& graph, const Flow& flow, std::span<const Symbol> x,
                        std::span<const Symbol> u) {
  const int nx = static_cast<int>(x.size()), nu = static_cast<int>(u.size());
  const int ns = static_cast<int>(flow.s.size());
  Linearisation l{{nx, nx}, {nx, nu}, {ns, nx}, {ns, nu}, {}};
  std::vector<Term> z = terms(graph, x), z_u = terms(graph, u);
  z.insert(z.end(), z_u.begin(), z_u.end());
  for (int i = 0; i < nx + ns; ++i) {
    const Symbol& row = i < nx ? flow.F[at(i)] : flow.s[at(i - nx)];
    const std::vector<Term> slopes = gradient(graph, row.in(graph), z);
    for (int j = 0; j < nx + nu; ++j) {
      const Term t = slopes[at(j)];
      if (!graph.is_constant(t) &&
          std::none_of(l.stored.begin(), l.stored.end(), [&](Term s) { return s.node == t.node; })) {
        l.stored.push_back({t.node, false});
      }
      Symbol& entry = i < nx ? (j < nx ? l.A(i, j) : l.B(i, j - nx))
                             : (j < nx ? l.J_x(i - nx, j) : l.J_u(i - nx, j - nx));
      entry = symbol(graph, t);
    }
  }
  return l;
}

/// @param before  number of trailing states that hold the inputs of the previous stage
BlockProgram step_of(const Model& model, double h, Seen seen, int before) {
  Tracer t;
  const auto x = t.inputs("x", model.nx() + before), u = t.inputs("u", model.nu());
  const Flow flow = record(t.graph, model, parameter(t.graph, h), seen, x, u);
  t.block("F");
  t.output(flow.F);
  t.block("s");
  t.output(flow.s);
  return t.finish();
}

class StageTracer {
 public:
  StageTracer(const Model& model, double h, Seen seen, std::span<const RelaxedBarrier> barriers,
              std::span<const double> scales, const RateCost& rates)
      : model_(model), h_(h), seen_(seen), barriers_(barriers), scales_(scales), rates_(rates) {
    const int before = static_cast<int>(rates.R.size());
    sizes_ = {
        .nx = model.nx() + before, .nu = model.nu(), .ns = seen_size(seen), .stored = 0, .before = before};
    const auto x = plain_.inputs("x", sizes_.nx), u = plain_.inputs("u", sizes_.nu);
    const Symbol length = parameter(plain_.graph, h);
    linear_ = linearise(plain_.graph, record(plain_.graph, model, length, seen, x, u), x, u);
    sizes_.stored = static_cast<int>(linear_.stored.size());
    units_ = measure(plain_.graph, linear_, sizes_);
  }

  StagePrograms trace() {
    return {sizes_,
            step_of(model_, h_, seen_, sizes_.before),
            back(true),
            back(false),
            precondition_back(),
            precondition_forward()};
  }

 private:
  BlockProgram back(bool carries_on) {
    const int nx = sizes_.nx, nu = sizes_.nu, ns = sizes_.ns;
    Tracer t;
    Graph& graph = t.graph;
    const auto x = t.inputs("x", nx), u = t.inputs("u", nu), x_ref = t.inputs("x_ref", nx);
    const auto held = t.inputs("held", nu), weights = t.inputs("weights", sizes_.weights());
    const auto coupling = t.inputs("coupling", sizes_.coupling()), carry = t.inputs("carry", sizes_.carry());
    const auto part = [](const std::vector<Symbol>& block, int from, int n) {
      return std::span<const Symbol>(block).subspan(at(from), at(n));
    };
    const auto Q = part(weights, 0, nx), R = part(weights, nx, nu), u_ref = part(weights, nx + nu, nu);
    const Symbol rho = weights[at(nx + 2 * nu)];
    const auto lambda = part(carry, 1, nx), P_upper = part(carry, 1 + 2 * nx, nx * (nx + 1) / 2);
    const std::vector<Symbol> e(carry.begin() + 1 + nx, carry.begin() + 1 + 2 * nx);

    // Phi and its derivatives: those of the cost, and of the flow in A, B, J.
    const Symbol h = parameter(graph, h_);
    const Flow flow = record(graph, model_, h, seen_, x, u);
    Linearisation l = linearise(graph, flow, x, u);
    Symbol cost = 0.5 * tracking_cost<Symbol>(x, x_ref, Q, u, u_ref, R) +
                  h * cost_of_limits(graph, flow.sight, part(x, 0, nx - sizes_.before), u);
    for (int a = 0; a < sizes_.before; ++a) {
      const Symbol change = u[at(a)] - x[at(nx - nu + a)];
      cost += parameter(graph, rates_.R[at(a)] / (carries_on ? h_ : rates_.first)) * (change * change);
    }
    Symbol along = 0.0;
    for (int i = 0; i < nx; ++i) along += lambda[at(i)] * flow.F[at(i)];
    for (int i = 0; i < ns; ++i) along += coupling[at(i)] * flow.s[at(i)];
    std::vector<Symbol> z = x;
    z.insert(z.end(), u.begin(), u.end());
    const Derivatives of_cost = derive(graph, cost.in(graph), terms(graph, z));
    const Derivatives of_flow = derive(graph, along.in(graph), terms(graph, z));
    const auto second = [&](int i, int j) {
      const int entry = upper_index(std::min(i, j), std::max(i, j), nx + nu);
      return symbol(graph, of_cost.second[at(entry)]) + symbol(graph, of_flow.second[at(entry)]);
    };

    graph.draw_constants(false);
    std::vector<Symbol> first;
    for (int i = 0; i < nx + nu; ++i) {
      Symbol slope = symbol(graph, of_cost.first[at(i)]);
      for (int q = 0; q < ns; ++q) slope += coupling[at(q)] * (i < nx ? l.J_x(q, i) : l.J_u(q, i - nx));
      for (int q = 0; q < nx; ++q) slope += lambda[at(q)] * (i < nx ? l.A(q, i) : l.B(q, i - nx));
      first.push_back(slope);
    }
    const std::vector<Symbol> units = measure(graph, l, sizes_);
    RiccatiStage<Symbol> stage{.nx = nx, .nu = nu};
    stage.A = l.A;
    stage.B = l.B;
    for (int i = 0; i < nx; ++i)
      for (int j = 0; j < nx; ++j) stage.Q(i, j) = second(i, j);
    std::vector<Symbol> floor;
    for (int a = 0; a < nu; ++a) {
      const Symbol& unit = units[at(a)];
      const double scale = scales_.empty() ? 1.0 : scales_[at(a)];
      const Symbol per_scale_2 = parameter(graph, 1.0 / (scale * scale));
      for (int j = 0; j < nx; ++j) stage.G(a, j) = unit * second(nx + a, j);
      for (int b = 0; b < nu; ++b) stage.R(a, b) = unit * units[at(b)] * second(nx + a, nx + b);
      stage.R(a, a) = unit * unit * (second(nx + a, nx + a) + rho * per_scale_2) + held[at(a)];
      stage.r[at(a)] = unit * first[at(nx + a)];
      floor.push_back(unit * unit * (pivot_floor * h) * per_scale_2);
    }
    add_couplings(stage, l, part(coupling, ns, ns * (ns + 1) / 2));
    Matrix<Symbol> P(nx, nx);
    for (int i = 0; i < nx; ++i)
      for (int j = 0; j < nx; ++j) P(i, j) = P_upper[at(upper_index(std::min(i, j), std::max(i, j), nx))];
    Symbol pivot_shift = carry[0];
    stage.eliminate(P, e, floor, pivot_shift);

    t.block("H_u");
    for (int a = 0; a < nu; ++a) t.output(first[at(nx + a)]);
    t.block("gain");
    t.output(stage.inverse_D);
    for (int a = 0; a < nu; ++a)
      for (int b = 0; b < a; ++b) t.output(stage.L(a, b));
    for (int j = 0; j < nx; ++j)
      for (int a = 0; a < nu; ++a) t.output(stage.K(a, j));
    for (const Term s : l.stored) t.output(Symbol(graph, s));
    t.block("k");
    t.output(stage.k);
    t.block("carry_out");
    t.output(pivot_shift);
    if (carries_on) {
      for (int i = 0; i < nx; ++i) t.output(first[at(i)]);
      for (int i = 0; i < nx; ++i) t.output(stage.costate_increment(i, e));
      for (int i = 0; i < nx; ++i)
        for (int j = i; j < nx; ++j) t.output(stage.cost_to_go(i, j));
    }
    return t.finish();
  }

  /// Sum of the barriers, each with its own parameters.
  Symbol cost_of_limits(Graph& graph, const Sight<Symbol>& sight, std::span<const Symbol> x,
                        std::span<const Symbol> u) const {
    Symbol sum = 0.0;
    for (const RelaxedBarrier& barrier : barriers_) {
      graph.keep_parameters(Zeros::folded);
      const Symbol cost = barrier(sight, x, u);
      graph.keep_values();
      sum += cost;
    }
    return sum;
  }

  /// Adds J' H J, with H the Hessian of the potentials by s.
  void add_couplings(RiccatiStage<Symbol>& stage, const Linearisation& l, std::span<const Symbol> H) const {
    const int nx = sizes_.nx, nu = sizes_.nu, ns = sizes_.ns;
    const auto J = [&](int i, int z) { return z < nx ? l.J_x(i, z) : l.J_u(i, z - nx); };
    // Entries between v and the tilt are zero for Seen::leaning.
    const auto is_zero = [&](int i, int q) {
      return seen_ == Seen::leaning && std::max(i, q) >= seen_size(Seen::pose_and_motion) &&
             std::min(i, q) >= seen_size(Seen::pose) && std::min(i, q) < seen_size(Seen::pose_and_motion);
    };
    Matrix<Symbol> HJ(ns, nx + nu);
    for (int i = 0; i < ns; ++i) {
      for (int z = 0; z < nx + nu; ++z) {
        for (int q = 0; q < ns; ++q)
          if (!is_zero(i, q)) HJ(i, z) += H[at(upper_index(std::min(i, q), std::max(i, q), ns))] * J(q, z);
      }
    }
    const auto add = [&](Symbol& entry, int row, int column) {
      for (int q = 0; q < ns; ++q) entry += J(q, row) * HJ(q, column);
    };
    for (int i = 0; i < nx; ++i) {
      for (int j = i; j < nx; ++j) {
        add(stage.Q(i, j), i, j);
        stage.Q(j, i) = stage.Q(i, j);
      }
    }
    for (int a = 0; a < nu; ++a) {
      for (int j = 0; j < nx; ++j) add(stage.G(a, j), nx + a, j);
      for (int b = 0; b < nu; ++b) add(stage.R(a, b), nx + a, nx + b);
    }
  }

  /// The gain block as inputs of a sweep.
  struct Gain {
    std::vector<Symbol> inverse_D, units;
    Matrix<Symbol> L, K, A, B, J_x, J_u;
  };
  Gain gain(Tracer& t) const {
    const int nx = sizes_.nx, nu = sizes_.nu, ns = sizes_.ns;
    const auto block = t.inputs("gain", sizes_.gain());
    auto next = block.begin();
    Gain g{{}, {}, {nu, nu}, {nu, nx}, {nx, nx}, {nx, nu}, {ns, nx}, {ns, nu}};
    for (int a = 0; a < nu; ++a) g.inverse_D.push_back(*next++);
    for (int a = 0; a < nu; ++a)
      for (int b = 0; b < a; ++b) g.L(a, b) = *next++;
    for (int j = 0; j < nx; ++j)
      for (int a = 0; a < nu; ++a) g.K(a, j) = *next++;
    const std::vector<Symbol> stored(next, block.end());
    std::map<int, Symbol> parameters;
    const auto there = [&](const Symbol& entry) { return reread(t.graph, entry, stored, parameters); };
    const auto fill = [&](Matrix<Symbol>& to, const Matrix<Symbol>& from, int rows, int columns) {
      for (int i = 0; i < rows; ++i)
        for (int j = 0; j < columns; ++j) to(i, j) = there(from(i, j));
    };
    fill(g.A, linear_.A, nx, nx);
    fill(g.B, linear_.B, nx, nu);
    fill(g.J_x, linear_.J_x, ns, nx);
    fill(g.J_u, linear_.J_u, ns, nu);
    for (const Symbol& unit : units_) g.units.push_back(there(unit));
    return g;
  }
  /// Maps an entry of the linearisation to another graph, through the stored entries and known
  /// parameters.
  Symbol reread(Graph& graph, const Symbol& entry, const std::vector<Symbol>& stored,
                std::map<int, Symbol>& parameters) const {
    Graph& plain = const_cast<Graph&>(plain_.graph);
    const Term t = entry.in(plain);
    if (plain.is_parameter(t)) {
      if (!parameters.contains(t.node)) parameters[t.node] = parameter(graph, plain.node(t).value);
      return t.negative ? -parameters[t.node] : parameters[t.node];
    }
    if (plain.is_constant(t)) return plain.constant_value(t);
    const auto found =
        std::find_if(linear_.stored.begin(), linear_.stored.end(), [&](Term s) { return s.node == t.node; });
    assert(found != linear_.stored.end() && "every entry that changes is stored");
    const Term there = stored[at(static_cast<int>(found - linear_.stored.begin()))].in(graph);
    return Symbol(graph, t.negative ? -there : there);
  }

  BlockProgram precondition_back() const {
    const int nx = sizes_.nx, nu = sizes_.nu, ns = sizes_.ns;
    Tracer t;
    t.graph.draw_constants(false);
    const auto p = t.inputs("p", nx), r = t.inputs("r", ns);
    const Gain g = gain(t);
    std::vector<Symbol> w(at(nu), Symbol(0.0));
    for (int a = 0; a < nu; ++a) {
      for (int q = 0; q < nx; ++q) w[at(a)] += g.B(q, a) * p[at(q)];
      for (int q = 0; q < ns; ++q) w[at(a)] -= g.J_u(q, a) * r[at(q)];
    }
    t.block("p_out");
    for (int j = 0; j < nx; ++j) {
      Symbol s = 0.0;
      for (int q = 0; q < ns; ++q) s -= g.J_x(q, j) * r[at(q)];
      for (int q = 0; q < nx; ++q) s += g.A(q, j) * p[at(q)];
      for (int a = 0; a < nu; ++a) s -= g.K(a, j) * w[at(a)];
      t.output(s);
    }
    std::vector<Symbol> k = w;
    for (int a = 0; a < nu; ++a)
      for (int b = 0; b < a; ++b) k[at(a)] -= g.L(a, b) * k[at(b)];
    for (int a = nu - 1; a >= 0; --a) {
      k[at(a)] *= g.inverse_D[at(a)];
      for (int b = a + 1; b < nu; ++b) k[at(a)] -= g.L(b, a) * k[at(b)];
    }
    t.block("k");
    t.output(k);
    return t.finish();
  }

  BlockProgram precondition_forward() const {
    const int nx = sizes_.nx, nu = sizes_.nu, ns = sizes_.ns;
    Tracer t;
    t.graph.draw_constants(false);
    const auto y = t.inputs("y", nx);
    const Gain g = gain(t);
    const auto k = t.inputs("k", nu);
    std::vector<Symbol> dv;
    t.block("du");
    for (int a = 0; a < nu; ++a) {
      std::array<Symbol, 3> s = {k[at(a)], 0.0, 0.0};  // three parallel sums
      for (int j = 0; j < nx; ++j) s[at(j % 3)] += g.K(a, j) * y[at(j)];
      dv.push_back(-((s[0] + s[1]) + s[2]));
      t.output(g.units[at(a)] * dv.back());
    }
    const auto product = [&](const Matrix<Symbol>& M_x, const Matrix<Symbol>& M_u, int rows) {
      for (int i = 0; i < rows; ++i) {
        Symbol s = 0.0;
        for (int q = 0; q < nx; ++q) s += M_x(i, q) * y[at(q)];
        for (int a = 0; a < nu; ++a) s += M_u(i, a) * dv[at(a)];
        t.output(s);
      }
    };
    t.block("y_out");
    product(g.A, g.B, nx);
    t.block("ds");
    product(g.J_x, g.J_u, ns);
    return t.finish();
  }

  const Model& model_;
  double h_;
  Seen seen_;
  std::span<const RelaxedBarrier> barriers_;
  std::span<const double> scales_;
  RateCost rates_;
  StageSizes sizes_;
  Tracer plain_;
  Linearisation linear_{{0, 0}, {0, 0}, {0, 0}, {0, 0}, {}};
  std::vector<Symbol> units_;
};

}  // namespace

BlockProgram trace_step(const Model& model, double h, Seen seen) { return step_of(model, h, seen, 0); }

Program trace_barriers(const Model& model, std::span<const RelaxedBarrier> barriers) {
  Tracer t;
  const auto x = t.inputs("x", model.nx()), u = t.inputs("u", model.nu());
  t.block("barrier");
  t.output(sum_of(barriers, model, x, u));
  return t.finish().program;
}

StagePrograms trace_stage(const Model& model, double h, Seen seen, std::span<const RelaxedBarrier> barriers,
                          std::span<const double> scales, const RateCost& rates) {
  return StageTracer(model, h, seen, barriers, scales, rates).trace();
}

ProgramSize size_of(const StagePrograms& programs) {
  ProgramSize sum;
  for (const BlockProgram* p : programs.all()) {
    const ProgramSize size = size_of(p->program);
    sum.inputs += size.inputs;
    sum.outputs += size.outputs;
    sum.constants += size.constants;
    sum.instructions += size.instructions;
  }
  return sum;
}

std::uint64_t structure(const StagePrograms& programs) {
  std::uint64_t hash = 0;
  for (const BlockProgram* p : programs.all()) hash = hash * 1099511628211ull ^ structure(p->program);
  return hash;
}

}  // namespace sightline
