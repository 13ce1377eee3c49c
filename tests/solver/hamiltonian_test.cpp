#include <gtest/gtest.h>

#include <functional>

#include "sightline/solvers.hpp"
#include "tests/support/error.hpp"
#include "tests/support/random_team.hpp"

namespace sightline {
namespace {

std::size_t at(int i, int n) { return static_cast<std::size_t>(i) * static_cast<std::size_t>(n); }

/// d f / d v_i by central differences of fourth order.
double slope(const std::function<double()>& f, double& v, double step = 4e-4) {
  const double here = v;
  const auto moved = [&](int steps) {
    v = here + steps * step;
    return f();
  };
  const double near = moved(1) - moved(-1), far = moved(2) - moved(-2);
  v = here;
  return (8 * near - far) / (12 * step);
}

/// A random problem and a point of it.
struct Case {
  Random random;
  Ocp ocp;
  Hamiltonian hamiltonian{ocp};
  int N, nx, nu;
  double t, h;
  std::vector<double> X, Lambda, u, F;

  Case(unsigned seed, int agents, int stages, Feeling feeling)
      : random(seed),
        ocp(random_team(random, agents, feeling), {.T = 1.0, .N = stages, .dt = 0.01}),
        N(stages),
        nx(ocp.nx()),
        nu(ocp.nu()),
        t(uniform(random, 0, 2)),
        h(uniform(random, 0.3, 1.0) * ocp.horizon().h()),
        X(at(N + 1, nx)),
        Lambda(X),
        u(random_numbers(random, N * nu, 0.8)),
        F(at(N, nu)) {
    hamiltonian.set_time(t, h);
    roll_out();
  }
  Case(const Case&) = delete;

  const Team& team() const { return ocp.team(); }
  void roll_out(const double* Z = nullptr, double scale = 0.0) {
    if (x0.empty()) x0 = random_states(random, team(), 1.5);
    hamiltonian.roll_out(x0.data(), u.data(), nu, Z, scale, X.data());
  }
  /// F of the inputs u, with the defects Z = (x, lambda) held.
  void sweep(const std::vector<double>& Z_x, const std::vector<double>& Z_lambda) {
    roll_out(Z_x.data(), 1.0);
    hamiltonian.linearise(X.data(), u.data(), nu);
    hamiltonian.costates(X.data(), Z_lambda.data(), 1.0, Lambda.data(), F.data(), nu);
  }

  std::vector<double> x0;
};

/// What one agent feels at a stage: its own cost, its constraints and the couplings that it feels.
double felt_cost(const Team& team, AgentId agent, double tau, const double* x, const double* u) {
  const auto sight = [&](BodyId body) {
    return team.model(body).sight(x + team.state_offset(body), u + team.input_offset(body));
  };
  const Agent& own = team.agent(agent);
  std::vector<double> x_ref(own.Q.size());
  own.x_ref(tau, own.model, x_ref);
  double l = 0.0;
  for (std::size_t j = 0; j < own.Q.size(); ++j) {
    l += own.Q[j] * square(x_ref[j] - x[at(team.state_offset(agent), 1) + j]);
  }
  for (std::size_t j = 0; j < own.R.size(); ++j) {
    l += own.R[j] * square(own.u_ref[j] - u[at(team.input_offset(agent), 1) + j]);
  }
  for (const Constraint& c : team.constraints()) {
    if (c.agent == agent) l += c.term.weight * c.term.potential(sight(agent), sight(agent), tau);
  }
  for (const Coupling& c : team.couplings()) {
    if (std::find(c.felt_by.begin(), c.felt_by.end(), agent) == c.felt_by.end()) continue;
    l += c.term.weight * c.term.potential(sight(c.between.first), sight(c.between.second), tau);
  }
  return l;
}

double terminal_cost(const Team& team, AgentId agent, double tau, const double* x) {
  const Agent& own = team.agent(agent);
  std::vector<double> x_ref(own.Q_f.size());
  own.x_ref(tau, own.model, x_ref);
  double phi = 0.0;
  for (std::size_t j = 0; j < x_ref.size(); ++j) {
    phi += own.Q_f[j] * square(x_ref[j] - x[at(team.state_offset(agent), 1) + j]);
  }
  return phi;
}

/// sum h l + phi along the explicit Euler roll-out of the models.
double horizon_cost(const Case& c, const std::function<double(double, const double*, const double*)>& l,
                    const std::function<double(double, const double*)>& phi) {
  std::vector<double> x = c.x0, rate(x.size());
  double cost = 0.0;
  for (int i = 0; i < c.N; ++i) {
    const double* const u = &c.u[at(i, c.nu)];
    cost += c.h * l(c.t + i * c.h, x.data(), u);
    for (int b = 0; b < c.team().bodies(); ++b) {
      const BodyId body{b};
      const int x_at = c.team().state_offset(body);
      c.team().model(body).f(&x[at(x_at, 1)], u + c.team().input_offset(body), &rate[at(x_at, 1)]);
    }
    for (std::size_t j = 0; j < x.size(); ++j) x[j] += c.h * rate[j];
  }
  return cost + phi(c.t + c.N * c.h, x.data());
}

class RandomTeams : public testing::TestWithParam<unsigned> {};

TEST_P(RandomTeams, RollOutIsExplicitEulerOfTheModelsWithItsDefects) {
  Case c(GetParam(), 2 + static_cast<int>(GetParam() % 4), 20, Feeling::anyone);
  const auto Z = random_numbers(c.random, (c.N + 1) * c.nx, 0.1);
  c.roll_out(Z.data(), 0.7);
  std::vector<double> rate(at(c.nx, 1));
  for (int i = 0; i < c.N; ++i) {
    c.hamiltonian.flow(&c.X[at(i, c.nx)], &c.u[at(i, c.nu)], rate.data());
    for (int j = 0; j < c.nx; ++j) {
      const double defect =
          c.X[at(i + 1, c.nx) + at(j, 1)] - c.X[at(i, c.nx) + at(j, 1)] - c.h * rate[at(j, 1)];
      EXPECT_NEAR(defect, 0.7 * Z[at(i + 1, c.nx) + at(j, 1)], 1e-13);
    }
  }
}

TEST_P(RandomTeams, TheGradientIsTheSlopeOfWhatEachAgentFeelsPlusItsCostatesAlongF) {
  Case c(GetParam(), 2 + static_cast<int>(GetParam() % 4), 5, Feeling::anyone);
  c.hamiltonian.linearise(c.X.data(), c.u.data(), c.nu);
  const Team& team = c.team();
  std::vector<double> H_z(at(c.nx + c.nu, 1)), rate(at(c.nx, 1));
  for (int i = 0; i < c.N; ++i) {
    const auto lambda = random_numbers(c.random, c.nx, 1.0);
    c.hamiltonian.gradient(i, lambda.data(), H_z.data());
    double *const x = &c.X[at(i, c.nx)], *const u = &c.u[at(i, c.nu)];
    for (const BodyId body : c.ocp.agent_bodies()) {
      const Model& model = team.model(body);
      const int x_at = team.state_offset(body), u_at = team.input_offset(body);
      const auto H = [&] {
        double value = felt_cost(team, AgentId{body}, c.t + i * c.h, x, u);
        model.f(x + x_at, u + u_at, rate.data());
        for (int j = 0; j < model.nx(); ++j) value += lambda[at(x_at + j, 1)] * rate[at(j, 1)];
        return value;
      };
      for (int j = 0; j < model.nx(); ++j) {
        EXPECT_LE(relative_error(H_z[at(x_at + j, 1)], slope(H, x[x_at + j])), 1e-8)
            << team.name(body) << " x" << j;
      }
      for (int j = 0; j < model.nu(); ++j) {
        EXPECT_LE(relative_error(H_z[at(c.nx + u_at + j, 1)], slope(H, u[u_at + j])), 1e-8)
            << team.name(body) << " u" << j;
      }
    }
  }
}

TEST_P(RandomTeams, FIsTheSlopeOfTheRolledOutCostThatEachAgentFeels) {
  Case c(GetParam(), 2 + static_cast<int>(GetParam() % 4), 7, Feeling::anyone);
  const std::vector<double> none(c.X.size());
  c.sweep(none, none);
  for (const BodyId body : c.ocp.agent_bodies()) {
    const AgentId agent{body};
    const auto J = [&] {
      return horizon_cost(
          c,
          [&](double tau, const double* x, const double* u) { return felt_cost(c.team(), agent, tau, x, u); },
          [&](double tau, const double* x) { return terminal_cost(c.team(), agent, tau, x); });
    };
    for (int i = 0; i < c.N; ++i) {
      for (int j = 0; j < c.team().model(body).nu(); ++j) {
        const std::size_t k = at(i, c.nu) + at(c.team().input_offset(body) + j, 1);
        EXPECT_LE(relative_error(c.F[k], slope(J, c.u[k]) / c.h), 2e-8)
            << c.team().name(body) << " stage " << i;
      }
    }
  }
}

TEST_P(RandomTeams, TheTangentIsTheDirectionalDerivativeOfTheSweepsWithDefectsHeld) {
  for (const double defects : {0.0, 0.05}) {
    Case c(GetParam(), 2 + static_cast<int>(GetParam() % 4), 6, Feeling::anyone);
    const auto Z_x = random_numbers(c.random, (c.N + 1) * c.nx, defects);
    const auto Z_lambda = random_numbers(c.random, (c.N + 1) * c.nx, defects);
    const auto du = random_numbers(c.random, c.N * c.nu, 1.0), u = c.u;
    const auto F_at = [&](double step) {
      for (std::size_t k = 0; k < u.size(); ++k) c.u[k] = u[k] + step * du[k];
      c.sweep(Z_x, Z_lambda);
      return c.F;
    };
    const double step = 4e-4;
    const auto ahead = F_at(step), behind = F_at(-step), far_ahead = F_at(2 * step),
               far_behind = F_at(-2 * step);
    F_at(0.0);
    std::vector<double> dF(c.F.size());
    c.hamiltonian.second_order(c.Lambda.data());
    c.hamiltonian.tangent(du.data(), dF.data(), c.nu);
    for (std::size_t k = 0; k < dF.size(); ++k) {
      const double expected = (8 * (ahead[k] - behind[k]) - (far_ahead[k] - far_behind[k])) / (12 * step);
      EXPECT_LE(relative_error(dF[k], expected), 5e-8) << "row " << k << ", defects " << defects;
    }
  }
}

TEST_P(RandomTeams, FeltByEveryoneTheTangentIsSymmetric) {
  Case c(GetParam(), 2 + static_cast<int>(GetParam() % 4), 8, Feeling::everyone);
  const std::vector<double> none(c.X.size());
  c.sweep(none, none);
  c.hamiltonian.second_order(c.Lambda.data());
  const auto a = random_numbers(c.random, c.N * c.nu, 1.0), b = random_numbers(c.random, c.N * c.nu, 1.0);
  std::vector<double> A_a(a.size()), A_b(a.size());
  c.hamiltonian.tangent(a.data(), A_a.data(), c.nu);
  c.hamiltonian.tangent(b.data(), A_b.data(), c.nu);
  double left = 0.0, right = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) {
    left += b[k] * A_a[k];
    right += a[k] * A_b[k];
  }
  EXPECT_LE(relative_error(left, right), 1e-12);
}

INSTANTIATE_TEST_SUITE_P(Hamiltonian, RandomTeams, testing::Range(1u, 21u));

TEST(Hamiltonian, TheHorizonMayHaveAnyNumberOfStages) {
  // Without a terminal cost, the last stage sees what a horizon of one stage from there sees.
  for (const int N : {1, 7, 20, 100}) {
    Random random(static_cast<unsigned>(N));
    const Team team = [&] {
      Team t;
      const AgentId a = t.add(Multirotor{}, {.Q = {1, 1, 1, 1, 1, 1, 1}, .x_ref = Circle{}});
      const AgentId b = t.add(AngleMultirotor{}, {.Q = {1, 1, 1, 1, 1, 1}});
      t.couple(1.0 * SensorCone{}, Between{a, b});
      t.couple(0.5 * KeepOut{}, Between{a, b});
      return t;
    }();
    const Ocp long_ocp(team, {.T = 0.05 * N, .N = N}), short_ocp(team, {.T = 0.05, .N = 1});
    Hamiltonian whole(long_ocp), last(short_ocp);
    const int nx = team.nx(), nu = team.nu();
    const auto x = random_states(random, team, 1.0), u = random_numbers(random, N * nu, 0.5);
    std::vector<double> X(at(N + 1, nx)), Lambda(X), F(at(N, nu)), F_last(at(1, nu));
    whole.set_time(0.3, 0.05);
    whole.roll_out(x.data(), u.data(), nu, nullptr, 0.0, X.data());
    whole.linearise(X.data(), u.data(), nu);
    whole.costates(X.data(), nullptr, 0.0, Lambda.data(), F.data(), nu);
    last.set_time(0.3 + (N - 1) * 0.05, 0.05);
    last.linearise(&X[at(N - 1, nx)], &u[at(N - 1, nu)], nu);
    last.costates(&X[at(N - 1, nx)], nullptr, 0.0, Lambda.data(), F_last.data(), nu);
    for (int j = 0; j < nu; ++j) EXPECT_TRUE(same_bits(F_last[at(j, 1)], F[at(N - 1, nu) + at(j, 1)])) << N;
  }
}

}  // namespace
}  // namespace sightline
