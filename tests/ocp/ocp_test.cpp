#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <map>
#include <thread>

#include "sightline/formula.hpp"
#include "sightline/team.hpp"
#include "tests/support/error.hpp"
#include "tests/support/random_team.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

using testing::HasSubstr;

Team one_robot() {
  Team team;
  team.add(Multirotor{});
  return team;
}

std::span<const double> part(const std::vector<double>& v, int from, int n) {
  return std::span(v).subspan(static_cast<std::size_t>(from), static_cast<std::size_t>(n));
}

/// Inputs of an agent's formulas at a random point, as ocp.hpp lists them.
struct AgentPoint {
  std::vector<double> inputs;
  int nx, nu;

  AgentPoint(Random& random, const Team& team, BodyId body) {
    const Model& model = team.model(body);
    nx = model.nx(), nu = model.nu();
    const auto add = [&](std::span<const double> v) { inputs.insert(inputs.end(), v.begin(), v.end()); };
    add(part(random_states(random, team, 1.0), team.state_offset(body), nx));
    add(random_numbers(random, nu, 1.0));
    add(random_numbers(random, nx, 1.0));
    add(random_numbers(random, nu, 1.0));
    for (int i = 0; i < nx + nu; ++i) inputs.push_back(uniform(random, 0.1, 2.0));
    inputs.push_back(uniform(random, 0, 2));
    add(random_numbers(random, nx, 1.0));
  }
  std::size_t first_inputs() const { return inputs.size() - static_cast<std::size_t>(nx); }
};

/// Central differences of fourth order of a program's outputs along input i.
std::vector<double> slopes(const Program& program, std::vector<double> inputs, int i) {
  const double step = 4e-4, here = inputs[static_cast<std::size_t>(i)];
  const auto moved = [&](int steps) {
    inputs[static_cast<std::size_t>(i)] = here + steps * step;
    return evaluate(program, inputs);
  };
  const auto ahead = moved(1), behind = moved(-1), far_ahead = moved(2), far_behind = moved(-2);
  std::vector<double> slope(ahead.size());
  for (std::size_t k = 0; k < slope.size(); ++k) {
    slope[k] = (8 * (ahead[k] - behind[k]) - (far_ahead[k] - far_behind[k])) / (12 * step);
  }
  return slope;
}

/// The entries as a map from place to value; each place once.
std::map<std::pair<int, int>, double> placed(const std::vector<Entry>& entries,
                                             const std::vector<double>& outputs) {
  std::map<std::pair<int, int>, double> values;
  for (const Entry& e : entries) {
    EXPECT_TRUE(
        values.emplace(std::pair{e.row, e.column}, outputs[static_cast<std::size_t>(e.output)]).second)
        << "twice: " << e.row << ", " << e.column;
  }
  return values;
}

double value_at(const std::map<std::pair<int, int>, double>& values, int row, int column) {
  const auto found = values.find({row, column});
  return found == values.end() ? 0.0 : found->second;
}

TEST(Ocp, AHorizonOutOfRangeIsRefusedByItsKey) {
  const auto sentence = [](const Horizon& horizon) { return refusal_of([&] { Ocp(one_robot(), horizon); }); };
  for (const double T : {0.0, -1.0, not_a_number, infinite})
    EXPECT_THAT(sentence({.T = T}), HasSubstr("horizon.duration = "));
  for (const int N : {0, -1, 1001, 100000000}) {
    EXPECT_EQ(sentence({.N = N}), "horizon.stages = " + std::to_string(N) + ", expected 1 to 1000");
  }
  for (const double dt : {0.0, -1.0, 0.9e-4, not_a_number, infinite})
    EXPECT_THAT(sentence({.dt = dt}), HasSubstr("horizon.period"));
  for (const int N : {1, 1000}) EXPECT_EQ(sentence({.N = N, .dt = 1e-4}), "");
}

TEST(Ocp, ATeamWithoutAnAgentIsRefused) {
  Team team;
  EXPECT_THAT(refusal_of([&] { Ocp(team, {}); }), HasSubstr("expected at least one robot"));
  team.add(Obstacle{.name = "tree"});
  EXPECT_THAT(refusal_of([&] { Ocp(team, {}); }), HasSubstr("expected at least one robot"));
}

TEST(Ocp, AnAgentsJacobianIsTheSlopeOfItsModel) {
  Random random(2);
  for (int trial = 0; trial < 20; ++trial) {
    const Ocp ocp(random_team(random, 2, Feeling::anyone), {});
    for (std::size_t a = 0; a < ocp.formulas().agents.size(); ++a) {
      const AgentFormula& formula = ocp.formulas().agents[a];
      const BodyId body = ocp.agent_bodies()[a];
      AgentPoint point(random, ocp.team(), body);
      std::vector<double> z(point.inputs.begin(), point.inputs.begin() + point.nx + point.nu);
      const auto first = evaluate(*formula.first, std::span(point.inputs).first(point.first_inputs()));
      const auto jacobian = placed(formula.jacobian, first);
      for (int j = 0; j < point.nx + point.nu; ++j) {
        const double step = 1e-4, here = z[static_cast<std::size_t>(j)];
        std::vector<double> ahead(static_cast<std::size_t>(point.nx)), behind(ahead);
        z[static_cast<std::size_t>(j)] = here + step;
        ocp.team().model(body).f(z.data(), z.data() + point.nx, ahead.data());
        z[static_cast<std::size_t>(j)] = here - step;
        ocp.team().model(body).f(z.data(), z.data() + point.nx, behind.data());
        z[static_cast<std::size_t>(j)] = here;
        for (int i = 0; i < point.nx; ++i) {
          const auto k = static_cast<std::size_t>(i);
          EXPECT_LE(relative_error(value_at(jacobian, i, j), (ahead[k] - behind[k]) / (2 * step)), 1e-7);
        }
      }
    }
  }
}

TEST(Ocp, AnAgentsHessianIsTheSlopeOfItsGradientAndHasBothTriangles) {
  Random random(3);
  for (int trial = 0; trial < 20; ++trial) {
    const Ocp ocp(random_team(random, 2, Feeling::anyone), {});
    for (std::size_t a = 0; a < ocp.formulas().agents.size(); ++a) {
      const AgentFormula& formula = ocp.formulas().agents[a];
      const AgentPoint point(random, ocp.team(), ocp.agent_bodies()[a]);
      const auto first_inputs = std::vector<double>(point.inputs.begin(), point.inputs.end() - point.nx);
      const auto hessian = placed(formula.hessian, evaluate(*formula.second, point.inputs));
      const int nz = point.nx + point.nu;
      for (int j = 0; j < nz; ++j) {
        // H_z = l_z + f_z' lambda, moved along z_j.
        const auto moved = slopes(*formula.first, first_inputs, j);
        std::vector<double> H_z(moved.begin(), moved.begin() + nz);
        for (const Entry& e : formula.jacobian) {
          H_z[static_cast<std::size_t>(e.column)] +=
              moved[static_cast<std::size_t>(e.output)] *
              point.inputs[point.first_inputs() + static_cast<std::size_t>(e.row)];
        }
        for (int i = 0; i < nz; ++i) {
          EXPECT_LE(relative_error(value_at(hessian, i, j), H_z[static_cast<std::size_t>(i)]), 1e-8)
              << i << ", " << j;
          EXPECT_EQ(value_at(hessian, i, j), value_at(hessian, j, i));
        }
      }
    }
  }
}

TEST(Ocp, APairHasTheRowsOfWhoFeelsItAndTheColumnsOfAllAgents) {
  Random random(4);
  int masked = 0;
  for (int trial = 0; trial < 30; ++trial) {
    const Team team = random_team(random, 3, Feeling::anyone);
    const Ocp ocp(team, {});
    for (const PairFormula& pair : ocp.formulas().pairs) {
      const Model &a = team.model(pair.a), &b = team.model(pair.b);
      const int za = a.nx() + a.nu(), zb = b.nx() + b.nu();
      std::vector<double> point;
      const auto x = random_states(random, team, 1.0);
      for (const BodyId body : {pair.a, pair.b}) {
        const auto state = part(x, team.state_offset(body), team.model(body).nx());
        point.insert(point.end(), state.begin(), state.end());
        for (const double u : random_numbers(random, team.model(body).nu(), 1.0)) point.push_back(u);
      }
      point.push_back(uniform(random, 0, 2));

      const auto gradient = placed(pair.gradient, evaluate(*pair.first, point));
      const auto hessian = placed(pair.hessian, evaluate(*pair.second, point));
      const auto owner = [&](int i) { return i < za ? pair.a : pair.b; };
      std::array<bool, 2> felt{};
      for (const auto& [place, value] : gradient) felt[place.first < za ? 0 : 1] = true;
      masked += felt[0] != felt[1] ? 1 : 0;
      for (const auto& [place, value] : hessian) {
        EXPECT_TRUE(felt[place.first < za ? 0 : 1]) << "a row of one who does not feel it";
        EXPECT_TRUE(team.is_agent(owner(place.first)) && team.is_agent(owner(place.second)));
      }
      for (int j = 0; j < za + zb; ++j) {
        const auto moved = slopes(*pair.first, point, j);
        for (const Entry& e : pair.gradient) {
          const double expected = team.is_agent(owner(j)) ? moved[static_cast<std::size_t>(e.output)] : 0.0;
          EXPECT_LE(relative_error(value_at(hessian, e.row, j), expected), 1e-8) << e.row << ", " << j;
        }
      }
    }
  }
  EXPECT_GT(masked, 0);
}

TEST(Ocp, CouplingsOfOnePairFeltAlikeAreOneFormulaAndTheirSum) {
  const auto pairs_of = [](const std::vector<Weighted>& terms) {
    Team team;
    const AgentId a = team.add(Multirotor{}), b = team.add(Multirotor{});
    for (const Weighted& term : terms) team.couple(term, Between{a, b}, felt_by(a));
    return Ocp(team, {});
  };
  const Weighted cone = 0.4 * SensorCone{}, keep_out = 0.7 * KeepOut{}, pace = 0.2 * ChangingPace{};
  const Ocp together = pairs_of({cone, keep_out, pace});
  ASSERT_EQ(together.formulas().pairs.size(), 1u);
  Random random(5);
  for (int trial = 0; trial < 100; ++trial) {
    std::vector<double> point = random_numbers(random, 23, 1.0);
    std::map<int, double> sum;
    for (const Weighted& term : {cone, keep_out, pace}) {
      const Ocp single = pairs_of({term});
      for (const auto& [place, value] :
           placed(single.formulas().pairs[0].gradient, evaluate(*single.formulas().pairs[0].first, point))) {
        sum[place.first] += value;
      }
    }
    const PairFormula& pair = together.formulas().pairs[0];
    EXPECT_EQ(pair.gradient.size(), sum.size());
    for (const auto& [place, value] : placed(pair.gradient, evaluate(*pair.first, point))) {
      EXPECT_LE(relative_error(value, sum.at(place.first)), 1e-13);
    }
  }
}

TEST(Ocp, CouplingsFeltByOthersStandApart) {
  Team team;
  const AgentId a = team.add(Multirotor{}), b = team.add(Multirotor{});
  team.couple(0.4 * SensorCone{}, Between{a, b}, felt_by(a));
  team.couple(0.4 * KeepOut{}, Between{a, b}, felt_by({a, b}));
  team.couple(0.4 * SensorCone{}, Between{b, a}, felt_by(b));
  const Ocp ocp(team, {});
  EXPECT_EQ(ocp.formulas().pairs.size(), 3u);
}

TEST(Ocp, RobotsAndPairsOfOneKindShareTheirPrograms) {
  Team team;
  std::vector<AgentId> robots;
  for (int i = 0; i < 6; ++i) {
    robots.push_back(
        team.add(Multirotor{}, {.Q = {1.0 * i, 0, 0, 0, 0, 0, 0}, .x_ref = Circle{.radius = 0.1 * i}}));
  }
  for (std::size_t i = 0; i + 1 < robots.size(); ++i) {
    team.couple(0.4 * SensorCone{}, Between{robots[i], robots[i + 1]}, felt_by(robots[i]));
  }
  const Ocp ocp(team, {});
  for (const AgentFormula& formula : ocp.formulas().agents) {
    EXPECT_EQ(formula.first, ocp.formulas().agents[0].first);
    EXPECT_EQ(formula.second, ocp.formulas().agents[0].second);
  }
  for (const PairFormula& pair : ocp.formulas().pairs) {
    EXPECT_EQ(pair.first, ocp.formulas().pairs[0].first);
    EXPECT_EQ(pair.second, ocp.formulas().pairs[0].second);
  }
}

/// Counts how often it is traced, and fails as often as it is asked to.
struct CountedPotential {
  static constexpr std::string_view name = "counted_potential";
  static inline std::atomic<int> traced{0}, failures{0};

  template <class S>
  S operator()(const Sight<S>& a, const Sight<S>& b, const S&) const {
    if constexpr (std::is_same_v<S, Symbol>) {
      ++traced;
      if (failures > 0 && failures-- > 0) throw std::runtime_error("not now");
    }
    return dot(a.p - b.p, a.p - b.p);
  }
};

Team counted_pair() {
  Team team;
  const AgentId a = team.add(Multirotor{}), b = team.add(Multirotor{});
  team.couple(1.0 * CountedPotential{}, Between{a, b});
  CountedPotential::traced = 0;
  return team;
}

TEST(Ocp, FormulasAreTracedWhenFirstAskedForOnceForAllCopies) {
  const Ocp ocp(counted_pair(), {}), before = ocp;
  EXPECT_EQ(CountedPotential::traced, 0) << "none was asked for";
  EXPECT_FALSE(ocp.is_traced());
  const Formulas& formulas = before.formulas();
  const Ocp after = ocp;
  for (const Ocp* copy : {&ocp, &before, &after}) {
    EXPECT_TRUE(copy->is_traced());
    EXPECT_EQ(&copy->formulas(), &formulas);
  }
  EXPECT_EQ(CountedPotential::traced, 1);
}

TEST(Ocp, ThreadsThatAskAtOneTimeGetOneTracing) {
  for (int trial = 0; trial < 20; ++trial) {
    const Ocp ocp(counted_pair(), {});
    std::vector<const Formulas*> got(4);
    std::vector<std::thread> threads;
    for (const Formulas*& mine : got) threads.emplace_back([&mine, copy = ocp] { mine = &copy.formulas(); });
    for (std::thread& thread : threads) thread.join();
    EXPECT_EQ(CountedPotential::traced, 1);
    for (const Formulas* mine : got) EXPECT_EQ(mine, &ocp.formulas());
  }
}

TEST(Ocp, AFormulaThatThrowsOnceIsTracedByTheNextWhoAsks) {
  const Ocp ocp(counted_pair(), {});
  CountedPotential::failures = 1;
  EXPECT_THROW((void)ocp.formulas(), std::runtime_error);
  EXPECT_FALSE(ocp.is_traced());
  EXPECT_EQ(ocp.formulas().pairs.size(), 1u);
  EXPECT_EQ(ocp.formulas().agents.size(), 2u);
}

TEST(Ocp, ItsProgramsOutliveTheOcpTheyCameFrom) {
  Random random(6);
  std::shared_ptr<const Program> program;
  std::vector<double> inputs, before;
  {
    const Ocp ocp(one_robot(), {});
    const Ocp copy = ocp;
    program = copy.formulas().agents[0].first;
    inputs = random_numbers(random, 4 * 7 - 7 + 3 * 4 + 1, 1.0);
    before = evaluate(*program, inputs);
  }
  EXPECT_EQ(evaluate(*program, inputs), before);
}

TEST(StageCost, IsTheSumOfWhatStandsInTheTeam) {
  Random random(7);
  for (int trial = 0; trial < 50; ++trial) {
    const Team team = random_team(random, 3, Feeling::everyone);
    const auto x = random_states(random, team, 1.5), u = random_numbers(random, team.nu(), 1.0);
    const double t = uniform(random, 0, 3);
    const auto sight = [&](BodyId body) {
      return team.model(body).sight(x.data() + team.state_offset(body), u.data() + team.input_offset(body));
    };
    double sum = 0.0;
    for (const Constraint& c : team.constraints()) {
      sum += c.term.weight * c.term.potential(sight(c.agent), sight(c.agent), t);
    }
    for (const Coupling& c : team.couplings()) {
      sum += c.term.weight * c.term.potential(sight(c.between.first), sight(c.between.second), t);
    }
    for (int b = 0; b < team.bodies(); ++b) {
      if (!team.is_agent(BodyId{b})) continue;
      const Agent& agent = team.agent(BodyId{b});
      std::vector<double> x_ref(agent.Q.size());
      agent.x_ref(t, agent.model, x_ref);
      const auto own_x = part(x, team.state_offset(BodyId{b}), agent.model.nx());
      const auto own_u = part(u, team.input_offset(BodyId{b}), agent.model.nu());
      for (std::size_t i = 0; i < x_ref.size(); ++i) sum += agent.Q[i] * square(own_x[i] - x_ref[i]);
      for (std::size_t i = 0; i < own_u.size(); ++i) sum += agent.R[i] * square(own_u[i] - agent.u_ref[i]);
    }
    EXPECT_LE(relative_error(stage_cost(team, t, x, u), sum), 1e-13);
  }
}

TEST(StageCost, IsTheSameWhoeverFeelsIt) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    Team masked, joint;
    const AgentId a = masked.add(Multirotor{}), b = masked.add(Multirotor{});
    joint.add(Multirotor{});
    joint.add(Multirotor{});
    masked.couple(0.4 * SensorCone{}, Between{a, b}, felt_by(a));
    joint.couple(0.4 * SensorCone{}, Between{a, b});
    const auto x = random_states(random, masked, 1.0), u = random_numbers(random, 8, 1.0);
    EXPECT_TRUE(same_bits(stage_cost(masked, 0.3, x, u), stage_cost(joint, 0.3, x, u)));
  }
}

TEST(StageCost, ReadsTheReferenceAtItsTime) {
  Team team;
  team.add(Multirotor{},
           {.Q = {1, 1, 1, 0, 0, 0, 0}, .x_ref = Circle{.centre = {0, 0, 1}, .radius = 0.5, .rate = 0.3}});
  Random random(8);
  const std::vector<double> none(4);
  for (int trial = 0; trial < 100; ++trial) {
    const double t = uniform(random, 0, 100), later = t + uniform(random, 0.1, 2.0);
    const std::vector<double> on_path = {0.5 * std::cos(0.3 * t), 0.5 * std::sin(0.3 * t), 1, 1, 0, 0, 0};
    EXPECT_NEAR(stage_cost(team, t, on_path, none), 0.0, 1e-15);
    // A chord of the circle.
    EXPECT_NEAR(stage_cost(team, later, on_path, none), square(std::sin(0.15 * (later - t))), 1e-13);
  }
}

TEST(StageCost, OfStatesAndInputsOfAnotherTeamIsRefused) {
  Team team;
  team.add(Multirotor{});
  const std::vector<double> x(7, 0.5), u(4, 0.1);
  EXPECT_GT(stage_cost(team, 0.0, x, u), 0.0);
  EXPECT_THROW((void)stage_cost(team, 0.0, std::span(x).first(6), u), std::invalid_argument);
  EXPECT_THROW((void)stage_cost(team, 0.0, x, {}), std::invalid_argument);
}

}  // namespace
}  // namespace sightline
