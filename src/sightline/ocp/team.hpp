/// The robots, their own costs, and their couplings. Composed at run time; `Ocp` is made from
/// it.
#pragma once

#include <array>
#include <functional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "sightline/base/index.hpp"
#include "sightline/model/model.hpp"
#include "sightline/model/robots.hpp"
#include "sightline/potential/potential.hpp"
#include "sightline/potential/ramp.hpp"
#include "sightline/potential/reference.hpp"
#include "sightline/potential/relaxed_barrier.hpp"

namespace sightline {

/// Anything that has a position: a robot, a target, an obstacle.
struct BodyId {
  int index = -1;
  bool operator==(const BodyId&) const = default;
};

/// The place of a body in arrays over all of a team.
constexpr std::size_t at(BodyId body) { return at(body.index); }

/// A robot that is controlled.
struct AgentId : BodyId {};

/// The two ends of a coupling; the first is the observer where the potential has one.
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

  /// Both of length nu, beyond which nothing is written; nothing is allocated.
  void at(double t, std::span<double> u_min, std::span<double> u_max) const noexcept;

  const std::vector<double>& times() const { return times_; }
  const std::vector<std::vector<double>>& u_min() const { return u_min_; }
  const std::vector<std::vector<double>>& u_max() const { return u_max_; }

 private:
  std::vector<double> times_;
  std::vector<std::vector<double>> u_min_, u_max_;  // [time][input]
};

/// A robot and its own cost (x* - x)' Q (x* - x) + (u* - u)' R (u* - u), at the end (x* - x)' Q_f (x* - x).
struct Agent {
  std::string name;  ///< empty: uav0, uav1, ... in the order of adding
  Model model;
  std::vector<double> Q;    ///< nx, >= 0
  std::vector<double> R;    ///< nu, > 0
  std::vector<double> Q_f;  ///< nx, >= 0; empty: 0
  Reference x_ref{};
  std::vector<double> u_ref{};  ///< nu; empty: 0
  InputLimits limits;
  std::vector<double> rate_max{};  ///< of the inputs either way, nu, > 0 [1/s]; empty: any
  std::vector<double> R_rate{};    ///< of du/dt' diag(R_rate) du/dt in its cost, nu, >= 0 [s^2]; empty: 0
};

/// What each input of an agent is measured in (nu) where a solver compares steps, residuals and distances to limits with
/// a threshold: half of its widest range. A range beyond 1000 / sqrt(R) is as good as none; there it is 1 / sqrt(R), at
/// which the input costs 1. So the unit in which an input is written changes nothing.
std::vector<double> input_scales(const Agent& agent);

/// A body that is not controlled; it is predicted with constant velocity.
struct Obstacle {
  std::string name;
  bool has_heading = false;  ///< its state is that of a PosedBody; else a Body's, which heads along x of G
};

/// A potential between two bodies, with its weight; felt by the agents listed.
struct Coupling {
  Weighted term;
  Between between;
  std::vector<AgentId> felt_by;
  std::string name{};  ///< for events to speak of it
  Ramp ramp{};
  BodyId third{};  ///< a body that the potential looks past; it feels nothing. Index -1: none

  bool has_third() const { return third.index >= 0; }
};

/// The first of a coupling's bodies as its potential sees it: with the place of the third, if there is one.
/// @param sight  of a body by its BodyId
template <class SightOf>
auto first_sight(const SightOf& sight, BodyId first, BodyId third) {
  auto seen = sight(first);
  if (third.index >= 0) seen.third = sight(third).p;
  return seen;
}

/// Whether one formula serves both: the same bodies, felt by the same agents, by the same part.
bool alike(const Coupling& a, const Coupling& b);

/// A potential of one robot alone, with its weight.
struct Constraint {
  Weighted term;
  AgentId agent;
  std::string name{};  ///< for events to speak of it
  Ramp ramp{};
};

/// A limit c(x, u) <= 0 of one robot, kept by a barrier in its stage cost.
struct BarrierTerm {
  RelaxedBarrier barrier;
  AgentId agent;
};

/// One potential between all of some robots that are near each other.
///
/// The potential lies between any two of these robots that are nearer than `radius`, and both feel it. It is a
/// function of the difference of their poses alone, l(p_a - p_b, d_a - d_b), and next to nothing at the radius
/// and beyond, so that a pair that appears or disappears causes no jump.
struct Swarm {
  Weighted term;
  std::vector<AgentId> agents;  ///< at least two, each once; a pair's a is the earlier of the list
  double radius = 2.5;          ///< [m], > 0
  int capacity = 256;           ///< pairs at one time, >= 1; of more, the nearest count

  /// Weighted value and slope [1/m] that the potential may have at the radius.
  static constexpr double negligible = 1e-3;

  /// Checks all but what the robots are.
  /// @throws std::invalid_argument naming what is out of its range
  void check() const;

  /// l of the weighted potential between all pairs that are nearer than the radius, of robots seen like this.
  double cost(std::span<const Sight<double>> robots, double t) const;
};

/// A bound of each of n inputs; left out, it is the model's own.
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

/// A list of agents that feel a coupling; the others' optimality conditions do not see it, (8)-(10).
std::vector<AgentId> felt_by(std::initializer_list<AgentId> agents);
std::vector<AgentId> felt_by(AgentId agent);

/// Agents, obstacles, couplings and constraints. Every call checks what it is given and throws
/// std::invalid_argument with a sentence that names it.
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

  /// Couples two bodies; felt by all robots of `between`, or by those listed.
  void couple(const Weighted& term, Between between);
  void couple(const Weighted& term, Between between, std::vector<AgentId> felt_by);
  void couple(Coupling coupling);
  /// A potential between all pairs of these robots that are nearer than `radius` [m], felt by both; of more than
  /// `capacity` pairs the nearest count.
  void keep_apart(const Weighted& term, std::vector<AgentId> agents, double radius, int capacity);
  /// A potential that one robot feels by itself.
  void constrain(const Weighted& term, AgentId agent);
  void constrain(Constraint constraint);
  /// A limit of one robot's state and input.
  void constrain(const RelaxedBarrier& barrier, AgentId agent);

  /// Bodies in the order of adding; `body` is an agent or an obstacle. Here and below an id that is none of the team
  /// throws std::out_of_range.
  int bodies() const { return static_cast<int>(bodies_.size()); }
  bool is_agent(BodyId body) const { return bodies_[index(body)].agent >= 0; }
  const Agent& agent(BodyId body) const;
  std::string_view name(BodyId body) const { return bodies_[index(body)].name; }
  /// The body of that name, or index -1.
  BodyId find(std::string_view name) const;
  const Model& model(BodyId body) const { return bodies_[index(body)].model; }

  const std::vector<Agent>& agents() const { return agents_; }
  const std::vector<Coupling>& couplings() const { return couplings_; }
  const std::vector<Swarm>& swarms() const { return swarms_; }
  const std::vector<Constraint>& constraints() const { return constraints_; }
  const std::vector<BarrierTerm>& barriers() const { return barriers_; }
  /// Those of one robot, in the order of adding.
  std::vector<RelaxedBarrier> barriers(BodyId body) const;

  /// Where a body's state stands in the stacked state x of all bodies, in the order of adding.
  int state_offset(BodyId body) const { return bodies_[index(body)].state_offset; }
  /// Where an agent's input stands in the stacked input u.
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

/// u* of all robots, in the order of the team (nu): what they are told before anybody tells them something.
std::vector<double> resting_inputs(const Team& team);

}  // namespace sightline
