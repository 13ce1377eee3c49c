// Computes the spectra of P^-1 C (docs/equations.md, 11) on problems of a flight. They govern the
// convergence of passes over the robots of a team. It also counts the iterations of each method for
// the team's step:  build/release/bin/bench_spectra [CASE ...]
//
// A problem is recorded between two updates of the closed loop: the state of the second, and the
// plan of the first. P^-1 C is assembled as a dense matrix by the functions of the solver itself.
// Its basis is the range of each robot's inputs in its observed quantities; Eigen computes the
// spectra. It takes 2 min on one core. Beyond 1500 unknowns, about 20 robots, eigenvalues are not
// computed.
#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "bench/cases.hpp"
#include "sightline/base.hpp"
#include "sightline/formula.hpp"
#include "sightline/solver/newton/groups.hpp"
#include "sightline/solver/newton/influence.hpp"
#include "sightline/solvers.hpp"
#include "tests/support/closed_loop.hpp"

namespace {

using namespace sightline;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// The initial problem of one update of a closed loop.
struct Recorded {
  double t = 0.0;
  std::vector<double> x, plan;  // plan: [stage][input]
  int passes = 0;               // iterations of the update, over its linearisations
};

std::vector<Recorded> recorded(const BenchCase& what, std::span<const int> updates) {
  NewtonRiccati solver(what.team, bench_horizon);
  const std::size_t nu = at(what.team.nu());
  std::vector<Recorded> problems;
  std::vector<double> plan(at(bench_horizon.N) * nu);
  int k = 0;
  fly(solver, what.x0, updates.back() + 1,
      [&](double t, const std::vector<double>& x, const Solution& solution) {
        if (std::find(updates.begin(), updates.end(), k++) != updates.end())
          problems.push_back({t, x, plan, solution.iterations});
        for (int stage = 0; stage < bench_horizon.N; ++stage)
          solver.plan(stage, std::span(plan).subspan(at(stage) * nu, nu));
      });
  return problems;
}

/// A recorded problem, linearised as in an update. Blocks are robots in the order of the influence
/// graph.
struct Problem {
  MatrixXd M;              ///< P^-1 C
  MatrixXd M_bare;         ///< the same without the potentials' own curvature in P, so that C has it
  VectorXd alone;          ///< steps of all robots without couplings; the team's step is y + M y = alone
  std::vector<int> ends;   ///< end of each robot's block
  std::vector<int> turns;  ///< of each robot: turn of its group in the substitution

  int first(std::size_t robot) const { return robot == 0 ? 0 : ends[robot - 1]; }
  int size(std::size_t robot) const { return ends[robot] - first(robot); }
};

class Linearisation {
 public:
  Linearisation(const BenchCase& what, const Recorded& recorded)
      : ocp_(what.team, bench_horizon),
        potentials_(trace_potentials(ocp_)),
        graph_(influence_graph(potentials_, agents())),
        groups_(ocp_, potentials_, what.kernels, graph_.order),
        couplings_(make_couplings(potentials_, layout(), ocp_.team().bodies(), what.kernels)),
        u_(5, layout().u_length),
        s_(4, layout().s_length),
        c_(2, layout().c_length) {
    const double h = bench_horizon.h();
    for (int k = 0; k < bench_horizon.N; ++k) couplings_->set_time(k, recorded.t + k * h);
    couplings_->set_weights(recorded.t);
    for (int a = 0; a < agents(); ++a) take(a, recorded);
    groups_.roll_out(u_[0], s_[0]);
    couplings_->evaluate(s_[0], c_[0]);
    groups_.solve(u_[0], u_[1], c_[0], u_[2], u_[3], s_[1]);
    hold(recorded.t);
  }

  Problem problem() {
    Problem result;
    const std::vector<int>& order = graph_.order;
    for (const int a : order) result.turns.push_back(layout().groups[at(layout().place(a).group)].turn);

    std::copy_n(c_[0], layout().c_length, c_[1]);
    for (int a = 0; a < agents(); ++a)
      own_curvature(a, [&](std::ptrdiff_t entry, int, int) { c_[1][entry] = 0.0; });
    groups_.solve(u_[0], u_[1], c_[1], u_[2], u_[3], s_[1]);
    const std::vector<MatrixXd> bare = inverses();
    groups_.solve(u_[0], u_[1], c_[0], u_[2], u_[3], s_[1]);
    const std::vector<MatrixXd> P_inverse = inverses();

    std::vector<MatrixXd> basis;  // per robot: range of its inputs in its observed quantities
    int n = 0;
    for (const int a : order) {
      const Eigen::ColPivHouseholderQR<MatrixXd> qr(bare[at(a)]);
      basis.emplace_back(qr.householderQ() * MatrixXd::Identity(bare[at(a)].rows(), qr.rank()));
      result.ends.push_back(n += static_cast<int>(qr.rank()));
    }
    result.M = result.M_bare = MatrixXd::Zero(n, n);
    result.alone.resize(n);
    for (std::size_t j = 0; j < order.size(); ++j) {
      const MatrixXd D = curvature(order[j]);
      for (int q = 0; q < result.size(j); ++q) {
        std::fill_n(s_[2], layout().s_length, 0.0);
        write(order[j], basis[j].col(q));
        couplings_->product(s_[2], s_[3]);
        for (std::size_t i = 0; i < order.size(); ++i) {
          VectorXd r = read(order[i], s_[3]);
          const auto rows = [&](MatrixXd& m) {
            return m.col(result.first(j) + q).segment(result.first(i), result.size(i));
          };
          rows(result.M) = basis[i].transpose() * (P_inverse[at(order[i])] * r);
          if (i == j) r += D * basis[j].col(q);
          rows(result.M_bare) = basis[i].transpose() * (bare[at(order[i])] * r);
        }
      }
      result.alone.segment(result.first(j), result.size(j)) = basis[j].transpose() * read(order[j], s_[1]);
    }
    return result;
  }

 private:
  int agents() const { return static_cast<int>(ocp_.agent_bodies().size()); }
  const Layout& layout() const { return groups_.layout(); }
  int ns(int a) const { return layout().part(a).ns; }
  int length(int a) const { return (layout().stages - 1) * ns(a); }  // stage 0 is fixed

  /// Takes the state, reference and plan of a robot.
  void take(int a, const Recorded& recorded) {
    const Agent& agent = ocp_.team().agents()[at(a)];
    const BodyId body = ocp_.agent_bodies()[at(a)];
    Group& group = groups_.group_of(a);
    const int lane = layout().place(a).lane, nx = group.sizes().nx, nu = layout().part(a).nu;
    for (int i = 0; i < nx; ++i) group.x(0, i, lane) = recorded.x[at(ocp_.team().state_offset(body) + i)];
    agent.x_ref.along(recorded.t, bench_horizon.h(), bench_horizon.N + 1, agent.model,
                      &group.x_ref(0, 0, lane), static_cast<std::ptrdiff_t>(nx) * layout().width,
                      layout().width);
    const Layout::View u = layout().u(a);
    for (int k = 0; k < bench_horizon.N; ++k) {
      for (int i = 0; i < nu; ++i)
        u_[0][u(k, i)] = recorded.plan[at(k * ocp_.nu() + ocp_.team().input_offset(body) + i)];
    }
  }

  /// Fixes inputs that are on a limit with the gradient pointing beyond it.
  void hold(double t) {
    for (int a = 0; a < agents(); ++a) {
      const Agent& agent = ocp_.team().agents()[at(a)];
      const std::size_t nu = agent.R.size();
      std::vector<double> low(nu), high(nu);
      agent.limits.at(t, low, high);
      const Layout::View u = layout().u(a);
      for (int k = 0; k < bench_horizon.N; ++k) {
        for (std::size_t i = 0; i < nu; ++i) {
          const std::ptrdiff_t place = u(k, static_cast<int>(i));
          const double value = u_[0][place], slope = u_[2][place];
          const bool held = (value <= low[i] && slope > 0.0) || (value >= high[i] && slope < 0.0);
          u_[1][place] = held ? infinity : 0.0;
        }
      }
    }
  }

  void write(int a, const VectorXd& from) {
    const Layout::View s = layout().s(a);
    for (int k = 1; k < layout().stages; ++k)
      for (int i = 0; i < ns(a); ++i) s_[2][s(k, i)] = from[(k - 1) * ns(a) + i];
  }
  VectorXd read(int a, const double* rows) const {
    const Layout::View s = layout().s(a);
    VectorXd to(length(a));
    for (int k = 1; k < layout().stages; ++k)
      for (int i = 0; i < ns(a); ++i) to[(k - 1) * ns(a) + i] = rows[s(k, i)];
    return to;
  }
  /// The last P^-1 of each robot, in its observed quantities.
  std::vector<MatrixXd> inverses() {
    std::vector<MatrixXd> of_robots;
    int longest = 0;
    for (int a = 0; a < agents(); ++a) {
      of_robots.emplace_back(length(a), length(a));
      longest = std::max(longest, length(a));
    }
    for (int column = 0; column < longest; ++column) {
      std::fill_n(s_[2], layout().s_length, 0.0);
      for (int a = 0; a < agents(); ++a)
        if (column < length(a)) write(a, VectorXd::Unit(length(a), column));
      groups_.precondition(s_[2], u_[4], s_[3]);
      for (int a = 0; a < agents(); ++a)
        if (column < length(a)) of_robots[at(a)].col(column) = read(a, s_[3]);
    }
    return of_robots;
  }
  /// Calls f(place in c, row, column) for the upper triangle of the potentials' Hessian of one
  /// robot, in its observed quantities.
  template <class F>
  void own_curvature(int a, F&& f) const {
    const Layout::View c = layout().c(a);
    for (int k = 1; k < layout().stages; ++k)
      for (int i = 0; i < ns(a); ++i)
        for (int j = i; j < ns(a); ++j)
          f(c(k, ns(a) + upper_index(i, j, ns(a))), (k - 1) * ns(a) + i, (k - 1) * ns(a) + j);
  }
  MatrixXd curvature(int a) const {
    MatrixXd D = MatrixXd::Zero(length(a), length(a));
    own_curvature(a, [&](std::ptrdiff_t entry, int i, int j) { D(i, j) = D(j, i) = c_[0][entry]; });
    return D;
  }

  Ocp ocp_;
  std::vector<BodyPotential> potentials_;
  InfluenceGraph graph_;
  Groups groups_;
  std::unique_ptr<Couplings> couplings_;
  Rows u_, s_, c_;
};

Eigen::VectorXcd spectrum(const MatrixXd& M) { return Eigen::EigenSolver<MatrixXd>(M, false).eigenvalues(); }

/// The spectral radius.
double radius(const MatrixXd& M) { return M.isZero(0.0) ? 0.0 : spectrum(M).cwiseAbs().maxCoeff(); }

/// M restricted to the blocks of robots i and j with among(i, j).
template <class Among>
MatrixXd part(const Problem& problem, const MatrixXd& M, Among&& among) {
  MatrixXd kept = MatrixXd::Zero(M.rows(), M.cols());
  for (std::size_t i = 0; i < problem.ends.size(); ++i) {
    for (std::size_t j = 0; j < problem.ends.size(); ++j) {
      if (!among(static_cast<int>(i), static_cast<int>(j))) continue;
      const auto of = [&](auto& m) {
        return m.block(problem.first(i), problem.first(j), problem.size(i), problem.size(j));
      };
      of(kept) = of(M);
    }
  }
  return kept;
}

MatrixXd one_and(const MatrixXd& M) { return MatrixXd::Identity(M.rows(), M.cols()) + M; }

/// Error propagation of one pass over the robots; robot i is solved together with each robot j with
/// with(i, j).
template <class With>
MatrixXd pass(const Problem& problem, With&& with) {
  const MatrixXd now = part(problem, problem.M, with);
  return -one_and(now).partialPivLu().solve(problem.M - now);
}

/// Passes from the uncoupled steps until the error is at most `near` of the team step's length;
/// `most` if it never is.
int passes(const MatrixXd& G, const VectorXd& alone, const VectorXd& y, double near) {
  constexpr int most = 99;
  VectorXd error = alone - y;
  int n = 0;
  for (; n < most && error.norm() > near * y.norm(); ++n) error = G * error;
  return n;
}

/// Iterations of GMRES on A y = b to a residual of at most `near` of the length of b.
int gmres(const MatrixXd& A, const VectorXd& y, double near) {
  Gmres solver(static_cast<int>(A.rows()), 99);
  Rows rows(2, solver.length());
  const auto of = [&](auto* numbers) { return Eigen::Map<VectorXd>(numbers, A.rows()); };
  of(rows[0]) = A * y;
  const double length = of(rows[0]).norm();
  const auto product = [&](const double* v, double* out) {
    of(out) = A * Eigen::Map<const VectorXd>(v, A.rows());
  };
  return solver.solve(product, rows[0], rows[1], near * length).iterations;
}

/// Upper bound on the iterations of conjugate gradients for any right side, by Chebyshev
/// polynomials. It is "-" if the least eigenvalue is not positive: the iterations may then stop
/// early.
std::string enough(double least, double largest, double near) {
  if (!(least > 0.0)) return "-";
  const double root = std::sqrt(largest / least), rate = (root - 1.0) / (root + 1.0);
  return fmt::format("{:.0f}", std::ceil(std::log(near / 2.0) / std::log(rate)));
}

/// Columns of the eigenvalues 1 + lambda of 1 + M.
std::string modes(const MatrixXd& M, std::size_t robots, double near) {
  const Eigen::VectorXcd values = spectrum(M);
  const Eigen::ArrayXd sizes = values.cwiseAbs().array();
  VectorXd real = values.real();
  std::sort(real.begin(), real.end());
  const double least = 1.0 + real[0], largest = 1.0 + real[real.size() - 1];
  return fmt::format("{:.2f} | {:.2f} to {:.2f} | {:.1f} | {:.2f} | {}", sizes.maxCoeff(), least, largest,
                     static_cast<double>((sizes > 0.5).count()) / static_cast<double>(robots),
                     1.0 + real[std::min<Eigen::Index>(8, real.size() - 1)], enough(least, largest, near));
}

void look_at(const BenchCase& what, const Recorded& recorded) {
  constexpr double near = 1e-3, nearer = 5e-6;
  constexpr int most = 1500;  // unknowns; beyond, eigenvalues are not computed
  const Problem problem = Linearisation(what, recorded).problem();
  const MatrixXd &M = problem.M, all = one_and(M);
  const VectorXd y = all.partialPivLu().solve(problem.alone);
  const auto ordered = [&](int size) {
    return pass(problem, [size](int i, int j) { return j / size <= i / size; });
  };
  const auto in_blocks = [&](int size) {
    return one_and(part(problem, M, [size](int i, int j) { return j / size == i / size; }));
  };
  const MatrixXd turns =
      pass(problem, [&](int i, int j) { return problem.turns[at(j)] < problem.turns[at(i)]; });
  const MatrixXd one = ordered(1);
  // If one ordered pass leaves no error, all eigenvalues are zero; rounding would hide that.
  const bool is_cascade = one.isZero(0.0), is_small = M.rows() <= most;
  const std::string lambdas = is_cascade ? "0.00 | 1.00 to 1.00 | 0.0 | 1.00 | -"
                              : is_small ? modes(M, problem.ends.size(), near)
                                         : "- | - | - | - | -";
  const std::string left =
      is_small ? fmt::format("{:.2f} | {:.2f} | {:.2f}", radius(one), radius(ordered(2)), radius(ordered(3)))
               : "- | - | -";
  const auto both = [&](const MatrixXd& G) {
    return fmt::format("{} / {}", passes(G, problem.alone, y, near), passes(G, problem.alone, y, nearer));
  };
  fmt::print("| {} | {:.2f} | {} | {} | {} | {} | {} | {} | {} | {} | {} | {} |\n", what.name, recorded.t,
             M.rows(), lambdas, gmres(one_and(problem.M_bare), y, near), gmres(all, y, near),
             gmres(in_blocks(2).partialPivLu().solve(all), y, near),
             gmres(in_blocks(3).partialPivLu().solve(all), y, near), left, both(one), both(turns),
             recorded.passes);
  std::fflush(stdout);
}

constexpr std::string_view head =
    R"(lambda: eigenvalues of P^-1 C; strong: those beyond 0.5, of each robot; 9th: the ninth least 1 + lambda.
CG: iterations to 1e-3 that the least and the largest promise. GMRES: iterations to 1e-3; bare: where P is without
the potentials' own curvature; of 2, of 3: where P solves for so many robots together.
A pass visits robots, or so many together, in order, and leaves the share of an error that its largest eigenvalue says.
In order, in turns: passes to 1e-3 and to 5e-6, robot by robot and as substitution visits them.
solver: iterations or passes of the update.

| case | t s | unknowns | max lambda | 1 + lambda | strong | 9th | CG | GMRES bare | GMRES | of 2 | of 3 | pass | of 2 | of 3 | in order | in turns | solver |
|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|
)";

}  // namespace

int main(int argc, char** argv) try {
  std::vector<std::string> names(argv + 1, argv + argc);
  if (names.empty()) names = {"chain_16", "cascade_16", "strong_chain_16", "mutual_chain_16"};
  constexpr std::array updates = {1, 50, 150, 600};
  fmt::print("{}", head);
  for (const std::string& name : names) {
    const BenchCase what = bench_case(name);
    for (const Recorded& problem : recorded(what, updates)) look_at(what, problem);
  }
} catch (const std::exception& error) {
  fmt::print(stderr, "{}\n", error.what());
  return 2;
}
