/// The robots, their costs and couplings; and the optimal control problem of a team over a horizon.
#pragma once

#include <array>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "sightline/base.hpp"
#include "sightline/formula.hpp"
#include "sightline/model.hpp"
#include "sightline/potential.hpp"

namespace sightline {

// The robots, their own costs and their couplings. Composed at run time, the input of `Ocp`.

/// Any body with a position: a robot, a target, an obstacle.
struct BodyId {
  int index = -1;
  bool operator==(const BodyId&) const = default;
};

/// Index of a body in arrays over all bodies of a team.
constexpr std::size_t at(BodyId body) { return at(body.index); }

/// A robot that is controlled.
struct AgentId : BodyId {};

/// The two ends of a coupling; the first is the observer if the potential has one.
struct Between {
  BodyId first, second;
};

/// u_min <= u <= u_max over time [s].
class InputLimits {
 public:
  InputLimits(std::vector<double> u_min, std::vector<double> u_max);
  /// Limits that change at given times and hold until the next; the first also hold before.
  InputLimits(std::vector<double> times, std::vector<std::vector<double>> u_min,
              std::vector<std::vector<double>> u_max);

  /// Limits at t, each of length nu; writes no element beyond nu and allocates nothing.
  void at(double t, std::span<double> u_min, std::span<double> u_max) const noexcept;

  const std::vector<double>& times() const { return times_; }
  const std::vector<std::vector<double>>& u_min() const { return u_min_; }
  const std::vector<std::vector<double>>& u_max() const { return u_max_; }

 private:
  std::vector<double> times_;
  std::vector<std::vector<double>> u_min_, u_max_;  // [time][input]
};

/// A robot and its own cost (x* - x)' Q (x* - x) + (u* - u)' R (u* - u), at the end (x* - x)' Q_f
/// (x* - x).
struct Agent {
  std::string name;  ///< empty: uav0, uav1, ... in the order of adding
  Model model;
  std::vector<double> Q;    ///< nx, >= 0
  std::vector<double> R;    ///< nu, > 0
  std::vector<double> Q_f;  ///< nx, >= 0; empty: 0
  Reference x_ref{};
  std::vector<double> u_ref{};  ///< nu; empty: 0
  InputLimits limits;
  std::vector<double> rate_max{};  ///< greatest |du/dt| (nu), > 0 [1/s]; empty: no limit
  std::vector<double> R_rate{};    ///< of the cost du/dt' diag(R_rate) du/dt (nu), >= 0 [s^2]; empty: 0
};

/// Scale of each input of an agent (nu): half of the input's widest range. A solver divides steps,
/// residuals and distances to limits by it before it compares them with a threshold. A half range
/// beyond 1000 / sqrt(R) counts as unlimited; then the scale is 1 / sqrt(R), at which the input
/// costs 1. So the unit of an input has no effect.
std::vector<double> input_scales(const Agent& agent);

/// A body that is not controlled; its prediction has constant velocity.
struct Obstacle {
  std::string name;
  bool has_heading = false;  ///< its state is that of a PosedBody; else of a Body, with heading along x of G
};

/// A potential between two bodies, with its weight; acts on the agents in `felt_by`.
struct Coupling {
  Weighted term;
  Between between;
  std::vector<AgentId> felt_by;
  std::string name{};  ///< by which events refer to it
  Ramp ramp{};
  BodyId third{};  ///< a body past which the potential looks; the coupling does not act on it. Index -1: none

  bool has_third() const { return third.index >= 0; }
};

/// The first body of a coupling as its potential sees it, with the position of the third, if there
/// is one.
/// @param sight  returns the Sight of a body by its BodyId
template <class SightOf>
auto first_sight(const SightOf& sight, BodyId first, BodyId third) {
  auto seen = sight(first);
  if (third.index >= 0) seen.third = sight(third).p;
  return seen;
}

/// Whether one formula can hold both: equal bodies, third body, felt_by and ramp.
bool alike(const Coupling& a, const Coupling& b);

/// A potential of one robot alone, with its weight.
struct Constraint {
  Weighted term;
  AgentId agent;
  std::string name{};  ///< by which events refer to it
  Ramp ramp{};
};

/// A limit c(x, u) <= 0 of one robot, kept by a barrier in its stage cost.
struct BarrierTerm {
  RelaxedBarrier barrier;
  AgentId agent;
};

/// One potential between all nearby pairs of some robots.
///
/// The potential acts on both robots of every pair whose distance is below `radius`. It depends
/// only on the difference of their poses, l(p_a - p_b, d_a - d_b). At the radius and beyond it is
/// negligible, so that a pair that appears or disappears causes no jump.
struct Swarm {
  Weighted term;
  std::vector<AgentId> agents;  ///< at least two, each once; a pair's a is the earlier of the list
  double radius = 2.5;          ///< [m], > 0
  int capacity = 256;           ///< greatest number of simultaneous pairs, >= 1; beyond it the nearest count

  /// Limit of the weighted value [-] and of its slope [1/m] at the radius.
  static constexpr double negligible = 1e-3;

  /// Checks everything except that the agents are robots of a team.
  /// @throws std::invalid_argument with the value that is out of range
  void check() const;

  /// l of the weighted potential over all pairs within the radius, for the Sights of the robots.
  double cost(std::span<const Sight<double>> robots, double t) const;
};

/// A bound of each of n inputs; if omitted, it is the model's own.
template <std::size_t n>
class InputBound {
 public:
  InputBound() = default;
  InputBound(const std::array<double, n>& values) : values_(values.begin(), values.end()) {}
  template <std::convertible_to<double>... Value>
  requires(sizeof...(Value) == n) InputBound(Value... values) : values_{static_cast<double>(values)...} {}

  void fill(double value) { values_.assign(n, value); }
  std::vector<double> or_else(std::span<const double> of_model) const {
    return values_.empty() ? std::vector<double>(of_model.begin(), of_model.end()) : values_;
  }

 private:
  std::vector<double> values_;
};

/// Options of an agent of a known model, for use in programs.
template <class M>
struct AgentOptions {
  std::array<double, M::nx> Q{};
  std::array<double, M::nu> R = filled(1.0);
  std::array<double, M::nx> Q_f{};
  Reference x_ref{};
  std::array<double, M::nu> u_ref{};
  InputBound<M::nu> u_min{};
  InputBound<M::nu> u_max{};
  std::string name{};
  std::vector<double> rate_max{};
  std::vector<double> R_rate{};

  static constexpr std::array<double, M::nu> filled(double value) {
    std::array<double, M::nu> a{};
    a.fill(value);
    return a;
  }
};

/// A list of agents on which a coupling acts; it does not enter the optimality conditions of other
/// agents, (8)-(10).
std::vector<AgentId> felt_by(std::initializer_list<AgentId> agents);
std::vector<AgentId> felt_by(AgentId agent);

/// Agents, obstacles, couplings and constraints. Every call checks its arguments and throws
/// std::invalid_argument with a sentence that names the faulty one.
class Team {
 public:
  template <RobotModel M>
  AgentId add(const M& model, const std::type_identity_t<AgentOptions<M>>& o = {}) {
    const auto list = [](const auto& a) { return std::vector<double>(a.begin(), a.end()); };
    const Model erased(model);
    return add(Agent{.name = o.name,
                     .model = erased,
                     .Q = list(o.Q),
                     .R = list(o.R),
                     .Q_f = list(o.Q_f),
                     .x_ref = o.x_ref,
                     .u_ref = list(o.u_ref),
                     .limits = InputLimits(o.u_min.or_else(erased.u_min()), o.u_max.or_else(erased.u_max())),
                     .rate_max = o.rate_max,
                     .R_rate = o.R_rate});
  }
  AgentId add(Agent agent);
  BodyId add(Obstacle obstacle);
  /// Replaces x_ref of a robot.
  /// @throws std::invalid_argument for another number of states than the robot has
  void set_reference(AgentId agent, Reference x_ref);

  /// Couples two bodies; acts on all robots of `between`, or on the listed ones.
  void couple(const Weighted& term, Between between);
  void couple(const Weighted& term, Between between, std::vector<AgentId> felt_by);
  void couple(Coupling coupling);
  /// A potential between all pairs of these robots whose distance is below `radius` [m], acting on
  /// both; beyond `capacity` pairs, the nearest count.
  void keep_apart(const Weighted& term, std::vector<AgentId> agents, double radius, int capacity);
  /// A potential of one robot alone.
  void constrain(const Weighted& term, AgentId agent);
  void constrain(Constraint constraint);
  /// A limit of one robot's state and input.
  void constrain(const RelaxedBarrier& barrier, AgentId agent);

  /// Bodies in the order of adding; `body` is an agent or an obstacle. Here and below, an id that
  /// is not of the team throws std::out_of_range.
  int bodies() const { return static_cast<int>(bodies_.size()); }
  bool is_agent(BodyId body) const { return bodies_[index(body)].agent >= 0; }
  const Agent& agent(BodyId body) const;
  /// Index of a robot in agents().
  /// @throws std::out_of_range for a body that is no robot
  std::size_t agent_index(BodyId robot) const;
  std::string_view name(BodyId body) const { return bodies_[index(body)].name; }
  /// The body of that name, or index -1.
  BodyId find(std::string_view name) const;
  const Model& model(BodyId body) const { return bodies_[index(body)].model; }

  const std::vector<Agent>& agents() const { return agents_; }
  const std::vector<Coupling>& couplings() const { return couplings_; }
  const std::vector<Swarm>& swarms() const { return swarms_; }
  const std::vector<Constraint>& constraints() const { return constraints_; }
  const std::vector<BarrierTerm>& barriers() const { return barriers_; }
  /// Barriers of one robot, in the order of adding.
  std::vector<RelaxedBarrier> barriers(BodyId body) const;

  /// Offset of a body's state in the stacked state x of all bodies, in the order of adding.
  int state_offset(BodyId body) const { return bodies_[index(body)].state_offset; }
  /// Offset of an agent's input in the stacked input u.
  int input_offset(BodyId body) const { return bodies_[index(body)].input_offset; }
  int nx() const { return nx_; }
  int nu() const { return nu_; }

 private:
  struct Entry {
    std::string name;
    Model model;
    int agent;  // index in agents_, or -1
    int state_offset, input_offset;
  };
  std::size_t index(BodyId body) const {
    if (body.index < 0 || body.index >= bodies()) refuse_body(body);
    return at(body);
  }
  [[noreturn]] void refuse_body(BodyId body) const;
  BodyId enter(std::string name, const Model& model, int agent);
  void check_body(BodyId body) const;
  void check_weight(const Weighted& term) const;
  void check_new_name(std::string_view name) const;
  void check_third(const Coupling& coupling) const;

  std::vector<Entry> bodies_;
  std::vector<Agent> agents_;
  std::vector<Coupling> couplings_;
  std::vector<Swarm> swarms_;
  std::vector<Constraint> constraints_;
  std::vector<BarrierTerm> barriers_;
  int nx_ = 0, nu_ = 0;
};

/// u* of all robots, in the order of the team (nu): the inputs in force before the first command.
std::vector<double> resting_inputs(const Team& team);

// The optimal control problem of a team over a horizon, the input of every solver. Constant and
// shareable.
//
//   min over u   phi(x(t_f), t_f) + int l(x, u, tau) dtau                        (1)
//   subject to   x' = f(x, u),  x(t_0) = x_k,  u_min <= u <= u_max               (2)
//   with         l = sum_i l_i(x_i, u_i) + sum_c k_c l_c(x_i, x_j)               (8)
//
// Discrete: h = T/N, x_{i+1} = x_i + h f(x_i, u_i). For the solvers by continuation, the first
// request traces the formulas of each agent and each coupled pair, once for all copies. Agents and
// pairs of one kind share a program.

struct Horizon {
  double T = 1.0;
  int N = 20;
  double dt = 0.01;

  double h() const { return T / N; }
  static constexpr auto parameters() {
    return Parameters{parameter("stages", &Horizon::N, "", {1, 1000, "1 to 1000"}, "number N of stages"),
                      parameter("duration", &Horizon::T, "s",
                                {std::numeric_limits<double>::min(), 1e6, "> 0 s, at most 1e6"}, "length T"),
                      parameter("period", &Horizon::dt, "s", {1e-4, 1e3, "1e-4 to 1000"}, "of control")};
  }
};

/// A structural nonzero of a matrix that changes along the horizon: its place, and the output that holds it.
struct Entry {
  int row, column, output;
};

/// One agent's stage, z = (x, u):
///
///   inputs    x (nx), u (nu), x* (nx), u* (nu), Q (nx), R (nu), t, lambda (nx, `second` alone)
///   first     l_z (nx + nu), then the nonzeros of f_z
///   second    the nonzeros of the Hessian of l + lambda' f with respect to z
///
/// where l holds the tracking cost, the agent's constraints and its barriers.
struct AgentFormula {
  std::shared_ptr<const Program> first, second;
  std::vector<Entry> jacobian;  ///< of f: row in x, column in z, output of `first`
  std::vector<Entry> hessian;   ///< row and column in z, both triangles, output of `second`
};

/// The couplings between one pair of bodies that are alike, at their full weights, z = (x_a, u_a,
/// x_b, u_b):
///
///   inputs    z, t, then x and u of the third body, if there is one
///   first     l_z for each variable in `gradient`
///   second    the nonzeros of the Hessian with respect to the agents' part of z
///
/// Rows of agents outside `felt_by` are missing, so the mask acts on H_u and H_x alike, (9), (10).
struct PairFormula {
  BodyId a, b, third;
  std::shared_ptr<const Program> first, second;
  std::vector<Entry> gradient;  ///< row in z; column unused (0), output of `first`
  std::vector<Entry> hessian;   ///< row and column in z, output of `second`
};

/// All formulas of a problem.
struct Formulas {
  std::vector<AgentFormula> agents;  ///< in the order of team().agents()
  std::vector<PairFormula> pairs;
};

class Ocp {
 public:
  /// @throws std::invalid_argument for a horizon out of range or a team without agents
  Ocp(Team team, const Horizon& horizon);

  const Team& team() const { return team_; }
  const Horizon& horizon() const { return horizon_; }
  int nx() const { return team_.nx(); }
  int nu() const { return team_.nu(); }

  /// The first call on any copy traces them, which takes milliseconds and allocates: a solver
  /// requests them in its constructor. Thread-safe; concurrent callers wait. The formulas live as
  /// long as a copy.
  /// @throws what a formula throws while it is traced; the next call tries again
  const Formulas& formulas() const;
  /// Whether they are traced.
  bool is_traced() const noexcept;

  /// Body of each agent, in the order of team().agents().
  const std::vector<BodyId>& agent_bodies() const { return agent_bodies_; }

 private:
  struct Traced;  // shared by all copies

  Team team_;
  Horizon horizon_;
  std::vector<BodyId> agent_bodies_;
  std::shared_ptr<Traced> traced_;
};

/// l(x, u, t) of the whole team with the weights at t, regardless of the mask, at the stacked
/// states and inputs.
/// @throws std::invalid_argument unless x has nx and u has nu numbers
double stage_cost(const Team& team, double t, std::span<const double> x, std::span<const double> u);

}  // namespace sightline
