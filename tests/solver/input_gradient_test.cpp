// Derivatives of the applied input against central differences of the converged solution.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "cli/allocations.hpp"
#include "sightline/solvers.hpp"
#include "tests/support/campaign.hpp"
#include "tests/support/chain_team.hpp"
#include "tests/support/changed_team.hpp"
#include "tests/support/random_team.hpp"
#include "tests/support/swap_team.hpp"

namespace sightline {
namespace {

using Values = std::vector<double>;

constexpr Horizon horizon{.T = 0.6, .N = 12, .dt = 0.01};
constexpr double now = 0.3;

NewtonRiccatiOptions converging() {
  return {.max_newton_steps = 100,
          .tolerance = 1e-12,
          .max_krylov = 40,
          .krylov_stop = 1e-11,
          .start_steps = 100};
}

struct Plan {
  std::vector<Values> stages;
};

Plan plan_of(const NewtonRiccati& solver) {
  Plan plan;
  for (int k = 0; k < solver.ocp().horizon().N; ++k) {
    plan.stages.emplace_back(static_cast<std::size_t>(solver.ocp().nu()));
    solver.plan(k, plan.stages.back());
  }
  return plan;
}

/// Which inputs of a plan are on a limit.
std::vector<bool> on_limits(const NewtonRiccati& solver, const Plan& plan) {
  const Team& team = solver.ocp().team();
  Values low(static_cast<std::size_t>(team.nu())), high = low;
  for (const BodyId body : solver.ocp().agent_bodies()) {
    const auto first = static_cast<std::size_t>(team.input_offset(body)), nu = team.agent(body).R.size();
    team.agent(body).limits.at(now, std::span(low).subspan(first, nu), std::span(high).subspan(first, nu));
  }
  std::vector<bool> on;
  for (const Values& u : plan.stages)
    for (std::size_t i = 0; i < u.size(); ++i) on.push_back(u[i] == low[i] || u[i] == high[i]);
  return on;
}

/// g' u of the converged solution near a plan; NaN without a solution of the same active set.
double converged(NewtonRiccati& solver, const Plan& from, const Values& states, const Values& g) {
  for (std::size_t k = 0; k < from.stages.size(); ++k) solver.set_plan(static_cast<int>(k), from.stages[k]);
  const Solution solution = solver.solve(now, states);
  if (solution.status != Status::converged || on_limits(solver, plan_of(solver)) != on_limits(solver, from))
    return std::nan("");
  double sum = 0.0;
  for (std::size_t i = 0; i < g.size(); ++i) sum += g[i] * solution.u[i];
  return sum;
}

/// Central difference of fourth order; NaN unless that of twice the step agrees to 5e-6: its error
/// is 16 times as large.
double slope(const std::function<double(double)>& f, double step) {
  const auto central = [&](double by) { return (f(by) - f(-by)) / (2.0 * by); };
  const double one = central(step), two = central(2.0 * step), four = central(4.0 * step);
  const double fine = (4.0 * one - two) / 3.0, coarse = (4.0 * two - four) / 3.0;
  return std::fabs(fine - coarse) < 5e-6 * std::max(1e-3, std::fabs(fine)) ? fine : std::nan("");
}

/// Compares derivatives, relative to the largest of them, at least 1e-3.
class Comparison {
 public:
  void add(double exact, double difference) {
    if (std::isnan(difference)) return;  // the changed problem has another active set or optimum
    largest_ = std::max(largest_, std::fabs(difference));
    off_ = std::max(off_, std::fabs(exact - difference));
    ++count_;
  }
  double error() const { return off_ / largest_; }
  int count() const { return count_; }

 private:
  double largest_ = 1e-3, off_ = 0.0;
  int count_ = 0;
};

/// A team with a converged plan that has a derivative.
struct Converged {
  Team team;
  Values states, g;
  std::unique_ptr<NewtonRiccati> solver;
  std::unique_ptr<InputGradient> gradient;
  Plan plan;

  bool has_gradient() {
    solver = std::make_unique<NewtonRiccati>(team, horizon, converging());
    gradient = std::make_unique<InputGradient>(*solver);
    if (solver->solve(now, states).status != Status::converged) return false;
    plan = plan_of(*solver);
    return gradient->differentiate(g);
  }
};

Converged random_problem(Random& random) {
  const int agents = 1 + static_cast<int>(random() % 4);
  const Feeling feeling = random() % 2 == 0 ? Feeling::everyone : Feeling::anyone;
  const RandomRobots fleet = random() % 2 == 0 ? RandomRobots::multirotors : RandomRobots::any_size;
  Converged c;
  c.team = random_team(random, agents, feeling, fleet);
  c.states = random_states(random, c.team, 1.0);
  for (int b = 0; b < c.team.bodies(); ++b) {
    const auto at_x = static_cast<std::size_t>(c.team.state_offset(BodyId{b}));
    EXPECT_TRUE(c.team.model(BodyId{b}).normalise(&c.states[at_x]));
  }
  c.g = random_numbers(random, c.team.nu(), 1.0);
  return c;
}

void compare_states(const Converged& c, Comparison& comparison) {
  NewtonRiccati other(c.team, horizon, converging());
  for (std::size_t i = 0; i < c.states.size(); ++i) {
    const auto at_change = [&](double by) {
      Values x = c.states;
      x[i] += by;
      return converged(other, c.plan, x, c.g);
    };
    comparison.add(c.gradient->states()[i], slope(at_change, 5e-5));
  }
}

void compare_parameter(const Converged& c, std::size_t i, Comparison& comparison) {
  const InputGradient::Parameter& parameter = c.gradient->parameters()[i];
  // A shift of a free heading, or of one that the heading-error limit turns, has no derivative.
  const bool may_turn = parameter.name.find("x_ref") != std::string::npos;
  const auto at_change = [&](double by) {
    NewtonRiccati its(changed_team(c.team, parameter.name, by), horizon, converging());
    const double value = converged(its, c.plan, c.states, c.g);
    return may_turn && !InputGradient(its).differentiate(c.g) ? std::nan("") : value;
  };
  const double step = 2e-3 * (parameter.value != 0 ? std::fabs(parameter.value) : 0.1);
  comparison.add(c.gradient->by_parameters()[i], slope(at_change, step));
}

TEST(InputGradient, IsTheCentralDifferenceOfTheOptimumOfRandomTeams) {
  const int wanted_teams = runs(200, 5);
  Random random(7);
  int teams = 0;
  Comparison count;
  for (int trial = 0; teams < wanted_teams; ++trial) {
    ASSERT_LT(trial, 2 * wanted_teams) << "most random teams have a derivative";
    Converged c = random_problem(random);
    if (!c.has_gradient()) continue;
    ++teams;
    Comparison states, parameters;
    compare_states(c, states);
    for (int sample = 0; sample < 3; ++sample)
      compare_parameter(c, random() % c.gradient->parameters().size(), parameters);
    EXPECT_LT(states.error(), 1e-6) << "team " << trial;
    EXPECT_LT(parameters.error(), 1e-6) << "team " << trial;
    for (int i = 0; i < states.count() + parameters.count(); ++i) count.add(0.0, 0.0);
  }
  EXPECT_GT(count.count(), 15 * teams);
}

/// Compares the derivatives by some of the states.
void expect_slopes_of_states(const Converged& c, int count, Random& random) {
  NewtonRiccati other(c.team, horizon, converging());
  Comparison comparison;
  for (int sample = 0; sample < count; ++sample) {
    const std::size_t i = random() % c.states.size();
    const auto at_change = [&](double by) {
      Values x = c.states;
      x[i] += by;
      return converged(other, c.plan, x, c.g);
    };
    comparison.add(c.gradient->states()[i], slope(at_change, 1e-4));
  }
  EXPECT_LT(comparison.error(), 1e-6);
  EXPECT_GT(comparison.count(), count / 2);
}

TEST(InputGradient, HoldsForChainsInLanesOfSeveralRobots) {
  Random random(2);
  for (const auto variant : {paper::Variant::joint, paper::Variant::masked}) {
    for (const int robots : {2, 5, 20}) {
      Converged c;
      c.team = chain(robots, variant);
      c.states = chain_start(robots);
      c.g = random_numbers(random, c.team.nu(), 1.0);
      ASSERT_TRUE(c.has_gradient());
      expect_slopes_of_states(c, 20, random);
    }
  }
}

TEST(InputGradient, HoldsForTheStatesOfASwarm) {
  Random random(3);
  const Swap swap(6, 3.0);
  Converged c;
  c.team = swap.team;
  c.states = swap.x0;
  c.g = random_numbers(random, c.team.nu(), 1.0);
  ASSERT_TRUE(c.has_gradient());
  expect_slopes_of_states(c, 20, random);
}

TEST(InputGradient, KnowsThePreviousInputIfItsRateHasACost) {
  Team team;
  AgentOptions<Multirotor> options{.x_ref = Constant{.p = {0.3, -0.2, 1.1}}};
  options.Q = {1, 1, 1, 0, 0, 0.1, 0.1};
  options.R_rate = {0.02, 0.01, 0.03, 0.02};
  options.name = "uav";
  team.add(Multirotor{}, options);
  const Values states = {0, 0, 1, 1, 0, 0.1, -0.1}, g = {1, -2, 0.5, 0.7}, offset(4, 0.0);
  Values previous = {0.1, -0.1, 0.2, 0.0};
  NewtonRiccati solver(team, horizon, converging());
  InputGradient gradient(solver);
  const auto value = [&](NewtonRiccati& its) {
    its.set_applied({.previous = previous, .offset = offset});
    const Solution s = its.solve(now, states);
    EXPECT_EQ(s.status, Status::converged);
    double sum = 0.0;
    for (std::size_t i = 0; i < g.size(); ++i) sum += g[i] * s.u[i];
    return sum;
  };
  value(solver);
  ASSERT_TRUE(gradient.differentiate(g));
  const Values by_previous(gradient.previous().begin(), gradient.previous().end());
  for (std::size_t i = 0; i < previous.size(); ++i) {
    NewtonRiccati other(team, horizon, converging());
    const double here = previous[i];
    const auto at_change = [&](double by) {
      previous[i] = here + by;
      return value(other);
    };
    const double difference = slope(at_change, 1e-3);
    previous[i] = here;
    EXPECT_NEAR(by_previous[i], difference, 1e-6 * std::fabs(difference));
    EXPECT_GT(std::fabs(difference), 1e-4);
  }
  for (std::size_t p = 0; p < gradient.parameters().size(); ++p) {
    const auto& parameter = gradient.parameters()[p];
    if (parameter.name.find("R_rate") == std::string::npos) continue;
    const auto at_change = [&](double by) {
      NewtonRiccati its(changed_team(team, parameter.name, by), horizon, converging());
      return value(its);
    };
    const double difference = slope(at_change, 1e-4);
    EXPECT_NEAR(gradient.by_parameters()[p], difference, 1e-6 * std::fabs(difference)) << parameter.name;
    EXPECT_GT(std::fabs(difference), 1e-4);
  }
}

TEST(InputGradient, AnInputOnItsLimitDoesNotMove) {
  Team team;
  AgentOptions<PointMass> options{.x_ref = Constant{.p = {5.0, 0.0, 1.0}}};
  options.Q = {3, 3, 3, 0, 0, 0};
  team.add(PointMass{}, options);
  NewtonRiccati solver(team, horizon, converging());
  InputGradient gradient(solver);
  const Values states = {0, 0, 1, 0, 0, 0};
  const Solution solution = solver.solve(now, states);
  ASSERT_EQ(solution.u[0], team.agents()[0].limits.u_max()[0][0]);
  ASSERT_TRUE(gradient.differentiate(Values{1, 0, 0}));
  for (const double slope : gradient.states()) EXPECT_EQ(slope, 0.0);
  for (const double slope : gradient.by_parameters()) EXPECT_EQ(slope, 0.0);
  ASSERT_TRUE(gradient.differentiate(Values{0, 1, 0}));
  EXPECT_LT(gradient.states()[1], -1e-3);
}

TEST(InputGradient, IsZeroWithoutAFactorisationAndTakesNoMemory) {
  const Team team = chain(3, paper::Variant::joint);
  NewtonRiccati solver(team, horizon);
  InputGradient gradient(solver);
  const Values g(static_cast<std::size_t>(team.nu()), 1.0);
  const auto is_zero = [](std::span<const double> values) {
    return std::all_of(values.begin(), values.end(), [](double v) { return v == 0.0; });
  };
  EXPECT_FALSE(gradient.differentiate(g));
  const Values states = chain_start(3);
  for (int k = 0; k < 4; ++k) solver.solve(0.01 * k, states);
  const std::int64_t before = cli::allocations();
  EXPECT_TRUE(gradient.differentiate(g));
  EXPECT_EQ(cli::allocations(), before);
  EXPECT_FALSE(is_zero(gradient.states()) || is_zero(gradient.by_parameters()));
  EXPECT_FALSE(gradient.differentiate(Values{1.0}));
  EXPECT_TRUE(is_zero(gradient.states()) && is_zero(gradient.by_parameters()));
  EXPECT_TRUE(gradient.differentiate(g));
  solver.kkt(0.0, states);
  EXPECT_FALSE(gradient.differentiate(g));
  solver.solve(0.0, Values(states.size(), std::nan("")));
  EXPECT_FALSE(gradient.differentiate(g));
}

}  // namespace
}  // namespace sightline
