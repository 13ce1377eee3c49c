#include "sightline/solver/stage.hpp"

#include <algorithm>
#include <cassert>

#include "sightline/formula/derive.hpp"
#include "sightline/potential/tracking.hpp"

namespace sightline {
namespace {

std::size_t at(int i) { return static_cast<std::size_t>(i); }

template <class S>
class Matrix {
 public:
  Matrix(int rows, int columns) : columns_(columns), entries_(at(rows * columns), S(0.0)) {}
  S& operator()(int i, int j) { return entries_[at(i * columns_ + j)]; }
  const S& operator()(int i, int j) const { return entries_[at(i * columns_ + j)]; }

 private:
  int columns_;
  std::vector<S> entries_;
};

/// Linear-quadratic stage, and what its elimination gives.
template <class S>
struct RiccatiStage {
  int nx, nu;
  Matrix<S> A{nx, nx}, B{nx, nu};                     // y_next = A y + B du
  Matrix<S> Q{nx, nx}, G{nu, nx}, R{nu, nu};          // Phi_xx, Phi_ux, Phi_uu
  std::vector<S> r = std::vector<S>(at(nu), S(0.0));  // Phi_u
  Matrix<S> L{nu, nu}, K{nu, nx}, Y{nu, nx}, Z{nu, nx};
  std::vector<S> inverse_D = r, k = r, y = r, z = r;
  Matrix<S> PA{nx, nx};

  /// Eliminates du for the cost-to-go P and the costate increment e of the next stage:
  /// R + B'PB = L D L', K = L^-T D^-1 L^-1 (G + B'PA), k likewise; pivots are at least `floor`. An input with
  /// an infinite R does not move: the inverse of its pivot is zero, and with it all of its row.
  void eliminate(const Matrix<S>& P, const std::vector<S>& e, const std::vector<double>& floor, S& doubt) {
    Matrix<S> PB(nx, nu);
    for (int i = 0; i < nx; ++i) {
      for (int j = 0; j < nx; ++j)
        for (int q = 0; q < nx; ++q) PA(i, j) += P(i, q) * A(q, j);
    }
    for (int i = 0; i < nx; ++i) {
      for (int b = 0; b < nu; ++b)
        for (int q = 0; q < nx; ++q) PB(i, b) += P(i, q) * B(q, b);
    }
    for (int a = 0; a < nu; ++a) {
      for (int b = 0; b <= a; ++b)
        for (int q = 0; q < nx; ++q) R(a, b) += B(q, a) * PB(q, b);
      for (int j = 0; j < nx; ++j)
        for (int q = 0; q < nx; ++q) G(a, j) += B(q, a) * PA(q, j);
      for (int q = 0; q < nx; ++q) r[at(a)] += B(q, a) * e[at(q)];
    }
    for (int a = 0; a < nu; ++a) {
      doubt = maximum(floor[at(a)] - R(a, a), doubt);
      inverse_D[at(a)] = 1.0 / maximum(R(a, a), S(floor[at(a)]));
      for (int b = a + 1; b < nu; ++b) L(b, a) = R(b, a) * inverse_D[at(a)];
      for (int b = a + 1; b < nu; ++b)
        for (int c = a + 1; c <= b; ++c) R(b, c) -= L(b, a) * R(c, a);
    }
    for (int j = 0; j < nx; ++j) {
      for (int a = 0; a < nu; ++a) {
        Y(a, j) = G(a, j);
        for (int b = 0; b < a; ++b) Y(a, j) -= L(a, b) * Y(b, j);
        Z(a, j) = Y(a, j) * inverse_D[at(a)];
      }
    }
    for (int a = 0; a < nu; ++a) {
      y[at(a)] = r[at(a)];
      for (int b = 0; b < a; ++b) y[at(a)] -= L(a, b) * y[at(b)];
      z[at(a)] = y[at(a)] * inverse_D[at(a)];
    }
    for (int a = nu - 1; a >= 0; --a) {
      for (int j = 0; j < nx; ++j) {
        K(a, j) = Z(a, j);
        for (int b = a + 1; b < nu; ++b) K(a, j) -= L(b, a) * K(b, j);
      }
      k[at(a)] = z[at(a)];
      for (int b = a + 1; b < nu; ++b) k[at(a)] -= L(b, a) * k[at(b)];
    }
  }

  /// Entry (i, j) of the cost-to-go of this stage.
  S cost_to_go(int i, int j) const {
    S s = Q(i, j);
    for (int q = 0; q < nx; ++q) s += A(q, i) * PA(q, j);
    for (int a = 0; a < nu; ++a) s -= Y(a, i) * Z(a, j);
    return s;
  }
  S costate_increment(int j, const std::vector<S>& e) const {
    S s = 0.0;
    for (int q = 0; q < nx; ++q) s += A(q, j) * e[at(q)];
    for (int a = 0; a < nu; ++a) s -= Z(a, j) * y[at(a)];
    return s;
  }
};

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

/// F = x + h f and s of a model, recorded.
struct Flow {
  std::vector<Symbol> F, s;
};

Flow record(const Model& model, double h, Seen seen, std::span<const Symbol> x, std::span<const Symbol> u) {
  Flow flow{std::vector<Symbol>(x.size()), std::vector<Symbol>(at(sight_size))};
  model.f(x, u, flow.F);
  for (std::size_t i = 0; i < x.size(); ++i) flow.F[i] = x[i] + h * flow.F[i];
  write_sight(model.sight(x, u), flow.s);
  flow.s.resize(at(seen_size(seen)));
  return flow;
}

Symbol sum_of(std::span<const RelaxedBarrier> barriers, const Model& model, std::span<const Symbol> x,
              std::span<const Symbol> u) {
  Symbol sum = 0.0;
  for (const RelaxedBarrier& barrier : barriers) sum += barrier(model.sight(x, u), x, u);
  return sum;
}

/// The derivatives of F and s by x and u, each distinct entry that changes in one place of `stored`.
struct Linearisation {
  Matrix<Symbol> A, B, J_x, J_u;
  std::vector<Term> stored;
};

/// What each step of an input is measured in, du = unit dv: where an input moves one state alone, by a
/// constant, in what it moves, so that its column of B is a column of the identity; elsewhere in itself.
std::vector<double> units(Graph& graph, const Linearisation& l, const StageSizes& n) {
  std::vector<double> list(at(n.nu), 1.0);
  for (int a = 0; a < n.nu; ++a) {
    bool constants = true;
    std::vector<double> moved;
    for (int i = 0; i < n.nx; ++i) {
      const Term entry = l.B(i, a).in(graph);
      constants &= graph.is_constant(entry);
      if (!graph.is_zero(entry)) moved.push_back(graph.constant_value(entry));
    }
    for (int i = 0; i < n.ns; ++i) constants &= graph.is_constant(l.J_u(i, a).in(graph));
    if (constants && moved.size() == 1) list[at(a)] = 1.0 / moved[0];
  }
  return list;
}

void scale_columns(Matrix<Symbol>& m, int rows, std::span<const double> factors) {
  for (int i = 0; i < rows; ++i) {
    for (std::size_t a = 0; a < factors.size(); ++a) m(i, static_cast<int>(a)) *= factors[a];
  }
}

std::vector<Term> terms(Graph& graph, std::span<const Symbol> symbols) {
  std::vector<Term> t;
  for (const Symbol& s : symbols) t.push_back(s.in(graph));
  return t;
}

Symbol symbol(Graph& graph, Term t) {
  return graph.is_constant(t) ? Symbol(graph.constant_value(t)) : Symbol(graph, t);
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

class StageTracer {
 public:
  StageTracer(const Model& model, double h, Seen seen, std::span<const RelaxedBarrier> barriers)
      : model_(model), h_(h), seen_(seen), barriers_(barriers) {
    sizes_ = {.nx = model.nx(), .nu = model.nu(), .ns = seen_size(seen), .stored = 0};
    const auto x = plain_.inputs("x", sizes_.nx), u = plain_.inputs("u", sizes_.nu);
    linear_ = linearise(plain_.graph, record(model, h, seen, x, u), x, u);
    sizes_.stored = static_cast<int>(linear_.stored.size());
    units_ = units(plain_.graph, linear_, sizes_);
  }

  StagePrograms trace() {
    return {sizes_,      trace_step(model_, h_, seen_), back(true),
            back(false), precondition_back(),           precondition_forward()};
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

    // Phi and its derivatives: those of the cost, and along the flow A, B, J once more.
    const Flow flow = record(model_, h_, seen_, x, u);
    Linearisation l = linearise(graph, flow, x, u);
    const Symbol cost =
        0.5 * tracking_cost<Symbol>(x, x_ref, Q, u, u_ref, R) + h_ * sum_of(barriers_, model_, x, u);
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
    scale_columns(l.B, nx, units_);
    scale_columns(l.J_u, ns, units_);
    RiccatiStage<Symbol> stage{.nx = nx, .nu = nu};
    stage.A = l.A;
    stage.B = l.B;
    for (int i = 0; i < nx; ++i)
      for (int j = 0; j < nx; ++j) stage.Q(i, j) = second(i, j);
    std::vector<double> floor;
    for (int a = 0; a < nu; ++a) {
      const double unit = units_[at(a)];
      for (int j = 0; j < nx; ++j) stage.G(a, j) = unit * second(nx + a, j);
      for (int b = 0; b < nu; ++b) stage.R(a, b) = unit * units_[at(b)] * second(nx + a, nx + b);
      stage.R(a, a) = unit * unit * (second(nx + a, nx + a) + rho) + held[at(a)];
      stage.r[at(a)] = unit * first[at(nx + a)];
      floor.push_back(unit * unit * pivot_floor * h_);
    }
    add_couplings(stage, l, part(coupling, ns, ns * (ns + 1) / 2));
    Matrix<Symbol> P(nx, nx);
    for (int i = 0; i < nx; ++i)
      for (int j = 0; j < nx; ++j) P(i, j) = P_upper[at(upper_index(std::min(i, j), std::max(i, j), nx))];
    Symbol doubt = carry[0];
    stage.eliminate(P, e, floor, doubt);

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
    t.output(doubt);
    if (carries_on) {
      for (int i = 0; i < nx; ++i) t.output(first[at(i)]);
      for (int i = 0; i < nx; ++i) t.output(stage.costate_increment(i, e));
      for (int i = 0; i < nx; ++i)
        for (int j = i; j < nx; ++j) t.output(stage.cost_to_go(i, j));
    }
    return t.finish();
  }

  /// Adds J' H J, H the Hessian of the potentials with respect to s.
  void add_couplings(RiccatiStage<Symbol>& stage, const Linearisation& l, std::span<const Symbol> H) const {
    const int nx = sizes_.nx, nu = sizes_.nu, ns = sizes_.ns;
    const auto J = [&](int i, int z) { return z < nx ? l.J_x(i, z) : l.J_u(i, z - nx); };
    Matrix<Symbol> HJ(ns, nx + nu);
    for (int i = 0; i < ns; ++i) {
      for (int z = 0; z < nx + nu; ++z) {
        for (int q = 0; q < ns; ++q)
          HJ(i, z) += H[at(upper_index(std::min(i, q), std::max(i, q), ns))] * J(q, z);
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

  /// The gain block as a sweep reads it.
  struct Gain {
    std::vector<Symbol> inverse_D;
    Matrix<Symbol> L, K, A, B, J_x, J_u;
  };
  Gain gain(Tracer& t) const {
    const int nx = sizes_.nx, nu = sizes_.nu, ns = sizes_.ns;
    const auto block = t.inputs("gain", sizes_.gain());
    auto next = block.begin();
    Gain g{{}, {nu, nu}, {nu, nx}, {nx, nx}, {nx, nu}, {ns, nx}, {ns, nu}};
    for (int a = 0; a < nu; ++a) g.inverse_D.push_back(*next++);
    for (int a = 0; a < nu; ++a)
      for (int b = 0; b < a; ++b) g.L(a, b) = *next++;
    for (int j = 0; j < nx; ++j)
      for (int a = 0; a < nu; ++a) g.K(a, j) = *next++;
    const std::vector<Symbol> stored(next, block.end());
    const auto fill = [&](Matrix<Symbol>& to, Matrix<Symbol> from, int rows, int columns) {
      for (int i = 0; i < rows; ++i)
        for (int j = 0; j < columns; ++j) to(i, j) = reread(t.graph, from(i, j), stored);
    };
    fill(g.A, linear_.A, nx, nx);
    fill(g.B, linear_.B, nx, nu);
    fill(g.J_x, linear_.J_x, ns, nx);
    fill(g.J_u, linear_.J_u, ns, nu);
    scale_columns(g.B, nx, units_);
    scale_columns(g.J_u, ns, units_);
    return g;
  }
  /// An entry of the linearisation in another graph, out of the stored ones.
  Symbol reread(Graph& graph, const Symbol& entry, const std::vector<Symbol>& stored) const {
    Graph& plain = const_cast<Graph&>(plain_.graph);
    const Term t = entry.in(plain);
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
      std::array<Symbol, 3> s = {k[at(a)], 0.0, 0.0};  // three sums side by side
      for (int j = 0; j < nx; ++j) s[at(j % 3)] += g.K(a, j) * y[at(j)];
      dv.push_back(-((s[0] + s[1]) + s[2]));
      t.output(units_[at(a)] * dv.back());
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
  StageSizes sizes_;
  Tracer plain_;
  Linearisation linear_{{0, 0}, {0, 0}, {0, 0}, {0, 0}, {}};
  std::vector<double> units_;
};

}  // namespace

BlockProgram trace_step(const Model& model, double h, Seen seen) {
  Tracer t;
  const auto x = t.inputs("x", model.nx()), u = t.inputs("u", model.nu());
  const Flow flow = record(model, h, seen, x, u);
  t.block("F");
  t.output(flow.F);
  t.block("s");
  t.output(flow.s);
  return t.finish();
}

Program trace_barriers(const Model& model, std::span<const RelaxedBarrier> barriers) {
  Tracer t;
  const auto x = t.inputs("x", model.nx()), u = t.inputs("u", model.nu());
  t.block("barrier");
  t.output(sum_of(barriers, model, x, u));
  return t.finish().program;
}

StagePrograms trace_stage(const Model& model, double h, Seen seen, std::span<const RelaxedBarrier> barriers) {
  return StageTracer(model, h, seen, barriers).trace();
}

std::uint64_t structure(const StagePrograms& programs) {
  std::uint64_t hash = 0;
  for (const BlockProgram* p : programs.all()) hash = hash * 1099511628211ull ^ structure(p->program);
  return hash;
}

}  // namespace sightline
