#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <tuple>

#include "cli/allocations.hpp"
#include "examples/own_potential.hpp"
#include "sightline/kernels.hpp"
#include "sightline/solvers.hpp"
#include "tests/support/chain_team.hpp"
#include "tests/support/closed_loop.hpp"
#include "tests/support/default_horizon.hpp"
#include "tests/support/paper_team.hpp"
#include "tests/support/random_team.hpp"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
extern "C" std::size_t __sanitizer_get_current_allocated_bytes();  // GCC's headers leave it out
#endif

namespace sightline {
namespace {

/// Newton to the end: as many steps and Krylov iterations as it takes.
NewtonRiccatiOptions converging() {
  return {
      .max_newton_steps = 40, .tolerance = 1e-10, .max_krylov = 80, .krylov_stop = 1e-12, .start_steps = 40};
}

/// The optimality conditions at the solver's plan by `Hamiltonian`, which shares no code with it.
double projected_gradient(const NewtonRiccati& solver, double time, const std::vector<double>& x) {
  const Ocp& ocp = solver.ocp();
  const int N = ocp.horizon().N, nx = ocp.nx(), nu = ocp.nu();
  const auto size = [](int a, int b) { return static_cast<std::size_t>(a) * static_cast<std::size_t>(b); };
  std::vector<double> U(size(N, nu)), X(size(N + 1, nx)), Lambda(size(N + 1, nx)), F(size(N, nu));
  for (int k = 0; k < N; ++k) solver.plan(k, {&U[size(k, nu)], size(nu, 1)});
  Hamiltonian hamiltonian(ocp);
  hamiltonian.set_time(time, ocp.horizon().h(), x.data());
  hamiltonian.roll_out(x.data(), U.data(), nu, nullptr, 0.0, X.data());
  hamiltonian.linearise(X.data(), U.data(), nu);
  hamiltonian.costates(X.data(), nullptr, 0.0, Lambda.data(), F.data(), nu);
  std::vector<double> scales;
  for (const Agent& agent : ocp.team().agents()) {
    const std::vector<double> own = input_scales(agent);
    scales.insert(scales.end(), own.begin(), own.end());
  }
  double worst = 0.0;
  for (int k = 0; k < N; ++k) {
    for (int j = 0; j < nu; ++j) {
      const double s = scales[size(j, 1)], u = U[size(k, nu) + size(j, 1)];
      const double next = u - F[size(k, nu) + size(j, 1)] * (s * s);
      worst =
          std::max(worst, std::fabs(u - clamp(next, hamiltonian.u_min(k)[j], hamiltonian.u_max(k)[j])) / s);
    }
  }
  return worst;
}

std::vector<double> normalised(const Team& team, std::vector<double> x) {
  for (int i = 0; i < team.bodies(); ++i)
    (void)team.model(BodyId{i}).normalise(&x[static_cast<std::size_t>(team.state_offset(BodyId{i}))]);
  return x;
}

/// Bytes on the heap.
std::size_t allocated() {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  return __sanitizer_get_current_allocated_bytes();
#else
  const auto info = mallinfo2();
  return info.uordblks + info.hblkhd;
#endif
}

TEST(NewtonRiccati, TakesLessThan64KiBOfMemoryForEachOf64Robots) {
  const Team team = chain(64, paper::Variant::joint);
  const std::size_t before = allocated();
  const auto solver = std::make_unique<NewtonRiccati>(team, default_horizon);
  EXPECT_LE(allocated() - before, 64u * 64u * 1024u);
}

TEST(NewtonRiccati, ItsKktIsThatOfTheHamiltonianForEveryTeam) {
  Random random(1);
  for (int trial = 0; trial < 40; ++trial) {
    const Team team = random_team(random, 1 + static_cast<int>(random() % 5), Feeling::anyone);
    NewtonRiccati solver(team, default_horizon, {.start_steps = 1});
    const std::vector<double> x = normalised(team, random_states(random, team, 2.0));
    const double t = uniform(random, 0, 2);
    solver.solve(t, x);
    EXPECT_NEAR(solver.kkt(t, x), projected_gradient(solver, t, x), 1e-11 * (1 + solver.kkt(t, x))) << trial;
  }
}

TEST(NewtonRiccati, ConvergesToAStationaryPointOfEveryTeam) {
  Random random(2);
  int converged = 0;
  constexpr int trials = 60;
  for (int trial = 0; trial < trials; ++trial) {
    const Feeling feeling = trial % 2 == 0 ? Feeling::everyone : Feeling::anyone;
    const Team team = random_team(random, 1 + static_cast<int>(random() % 5), feeling);
    NewtonRiccati solver(team, default_horizon, converging());
    const std::vector<double> x = normalised(team, random_states(random, team, 2.0));
    const Solution s = solver.solve(0.3, x);
    if (s.status != Status::converged) continue;
    ++converged;
    EXPECT_LE(projected_gradient(solver, 0.3, x), 1e-8) << trial;
  }
  EXPECT_GE(converged, trials * 95 / 100);
}

TEST(NewtonRiccati, FliesThePairAtTheCostOfTheConvergedOptimum) {
  for (const auto& [variant, expected] :
       {std::pair{paper::Variant::joint, 75.755}, {paper::Variant::masked, 76.22}}) {
    const Team team = paper::team(variant);
    NewtonRiccati solver(team, default_horizon);
    double cost = 0.0;
    fly(solver, paper::start(), 6000, [&](double t, const std::vector<double>& x, const Solution& s) {
      cost += default_horizon.dt * stage_cost(team, t, x, s.u);
    });
    EXPECT_NEAR(cost, expected, 0.01);
  }
}

TEST(NewtonRiccati, OneStepAnUpdateFollowsTheOptimumOfAPairAndOfADeepCascade) {
  for (const auto& [team, start] : {std::pair{paper::team(paper::Variant::joint), paper::start()},
                                    std::pair{chain(8, paper::Variant::masked), chain_start(8)}}) {
    NewtonRiccati solver(team, default_horizon), optimum(team, default_horizon, converging());
    double worst = 0.0;
    fly(solver, start, 400, [&](double t, const std::vector<double>& x, const Solution& s) {
      const std::vector<double> u(s.u.begin(), s.u.end());
      const Solution best = optimum.solve(t, x);
      for (std::size_t i = 0; t > 2.0 && i < u.size(); ++i)
        worst = std::max(worst, std::fabs(u[i] - best.u[i]));
    });
    EXPECT_LE(worst, 1e-5) << team.agents().size() << " robots";
  }
}

TEST(NewtonRiccati, APotentialOfOnesOwnBesideOthersIsFlownToTheOptimum) {
  for (const int robots : {2, 6}) {
    Team team = chain(robots, paper::Variant::joint);
    for (int i = 1; i < robots; ++i) team.couple(0.7 * Downwash{}, Between{AgentId{{i}}, AgentId{{i - 1}}});
    NewtonRiccati solver(team, default_horizon, converging()), interpreted(team, default_horizon, [] {
      NewtonRiccatiOptions o = converging();
      o.kernels = KernelChoice::interpreted;
      return o;
    }());
    const std::vector<double> x = chain_start(robots);
    EXPECT_EQ(solver.solve(0.0, x).status, Status::converged);
    EXPECT_LE(projected_gradient(solver, 0.0, x), 1e-8);
    const Solution a = solver.solve(0.01, x), b = (interpreted.solve(0.0, x), interpreted.solve(0.01, x));
    for (std::size_t i = 0; i < a.u.size(); ++i) EXPECT_EQ(a.u[i], b.u[i]);
  }
}

TEST(NewtonRiccati, AnAgentThatFeelsNothingFliesAsIfAlone) {
  NewtonRiccati together(paper::team(paper::Variant::masked), default_horizon),
      alone(paper::target_alone(), default_horizon);
  fly(together, paper::start(), 1000, [&](double t, const std::vector<double>& x, const Solution& s) {
    const Solution single = alone.solve(t, std::span<const double>(x).subspan(7));
    for (std::size_t i = 0; i < 4; ++i) ASSERT_NEAR(s.u[4 + i], single.u[i], 1e-9) << t;
  });
}

TEST(NewtonRiccati, EveryStatusIsGivenWhereItIsDue) {
  const Team team = paper::team(paper::Variant::joint);
  NewtonRiccati solver(team, default_horizon);
  std::vector<double> x = paper::start();
  EXPECT_EQ(solver.solve(0.0, x).status, Status::converged);
  x[0] += 0.05;
  const Solution next = solver.solve(0.01, x);
  EXPECT_EQ(next.status, Status::stepped);
  EXPECT_GT(next.residual, 1e-6);
  const std::vector<double> planned(next.u.begin(), next.u.end());
  x[0] = std::nan("");
  const Solution refused = solver.solve(0.01, x);
  EXPECT_EQ(refused.status, Status::invalid_state);
  for (std::size_t i = 0; i < planned.size(); ++i) EXPECT_EQ(refused.u[i], planned[i]);

  NewtonRiccati impatient(team, default_horizon,
                          {.max_newton_steps = 2, .tolerance = 1e-12, .start_steps = 2});
  EXPECT_EQ(impatient.solve(0.0, paper::start()).status, Status::iteration_limit) << "asked to converge";

  NewtonRiccati hurried(team, default_horizon, {.deadline = 1e-9});
  const Solution late = hurried.solve(0.0, paper::start());
  EXPECT_EQ(late.status, Status::deadline);
  EXPECT_TRUE(std::isfinite(late.residual));
  for (const double u : late.u) EXPECT_LE(std::fabs(u), 1.0);

  x = paper::start();
  x[0] = 1e200;
  const Solution overflowing = solver.solve(0.02, x);
  EXPECT_EQ(overflowing.status, Status::not_finite);
  for (const double u : overflowing.u) EXPECT_LE(std::fabs(u), 1.0);
  EXPECT_EQ(solver.solve(0.03, paper::start()).status, Status::converged) << "it starts anew";
}

TEST(NewtonRiccati, AFlightThatGoesWellStepsAndAStepThatWasShortenedSaysSo) {
  for (const paper::Variant variant : {paper::Variant::joint, paper::Variant::masked}) {
    NewtonRiccati solver(paper::team(variant), default_horizon);
    fly(solver, paper::start(), 600, [](double t, const std::vector<double>&, const Solution& s) {
      EXPECT_EQ(s.status, s.residual <= 1e-6 ? Status::converged : Status::stepped) << t;
    });
    // Far from the optimum a whole step overshoots: it is the first ones that are watched.
    NewtonRiccati cold(paper::team(variant), default_horizon, {.step_cap = 1e-3, .start_steps = 1});
    int shortened = 0, whole = 0;
    fly(cold, paper::saturating_start(), 300, [&](double, const std::vector<double>&, const Solution& s) {
      shortened += s.status == Status::iteration_limit ? 1 : 0;
      whole += s.status == Status::stepped ? 1 : 0;
    });
    EXPECT_GT(shortened, 0);
    EXPECT_GT(whole, 100);
  }
}

// Before, an update that ended before its first step flew the first input of an old plan for ever.
TEST(NewtonRiccati, AnUpdateThatIsAlwaysLateStillFlies) {
  NewtonRiccati calm(paper::team(paper::Variant::masked), default_horizon);
  NewtonRiccati hurried(paper::team(paper::Variant::masked), default_horizon, {.deadline = 1e-9});
  const std::vector<double> there = fly(calm, paper::start(), 600);
  const std::vector<double> late =
      fly(hurried, paper::start(), 600, [](double t, const std::vector<double>&, const Solution& s) {
        EXPECT_EQ(s.status, Status::deadline) << t;
      });
  for (std::size_t i : {0U, 1U, 2U, 7U, 8U, 9U}) EXPECT_NEAR(late[i], there[i], 0.2) << i;
}

TEST(NewtonRiccati, ALargeTeamThatIsLateFromItsFirstUpdateOnFliesToo) {
  constexpr int robots = 40, updates = 300;
  for (const paper::Variant variant : {paper::Variant::joint, paper::Variant::masked}) {
    const Team team = chain(robots, variant);
    NewtonRiccati calm(team, default_horizon), hurried(team, default_horizon, {.deadline = 1e-9});
    const std::vector<double> there = fly(calm, chain_start(robots), updates);
    const std::vector<double> late = fly(hurried, chain_start(robots), updates,
                                         [](double t, const std::vector<double>&, const Solution& s) {
                                           EXPECT_EQ(s.status, Status::deadline) << t;
                                           EXPECT_EQ(s.iterations, 0) << t;
                                           for (const double u : s.u) EXPECT_LE(std::fabs(u), 1.0) << t;
                                         });
    double off = 0.0;
    for (std::size_t i = 0; i < late.size(); ++i) off = std::max(off, std::fabs(late[i] - there[i]));
    EXPECT_LE(off, 0.3);
  }
}

/// A robot whose inputs are written in another unit: u = s v.
struct OtherUnit {
  static constexpr std::size_t nx = Multirotor::nx, nu = Multirotor::nu;
  static constexpr std::string_view name = "other_unit";
  static constexpr int heading_at = Multirotor::heading_at;
  double s = 1.0;

  template <class S>
  std::array<S, nx> f(const std::array<S, nx>& x, std::array<S, nu> u) const {
    for (S& of : u) of = of * (1.0 / s);
    return Multirotor{}.f(x, u);
  }
  template <class S>
  Pose<S> pose(const std::array<S, nx>& x) const {
    return Multirotor{}.pose(x);
  }
  template <class S>
  std::array<S, nx> at_rest(const Pose<S>& pose) const {
    return Multirotor{}.at_rest(pose);
  }
};

/// The inputs of a flight of the paper's pair, in the unit of limits of +-1.
std::vector<double> flown_in_unit(double s, std::pair<double, double> limits, double R,
                                  paper::Variant variant, std::vector<Status>& statuses) {
  Team team;
  std::vector<AgentId> ids;
  for (const bool target : {false, true}) {
    AgentOptions<OtherUnit> o;
    o.Q = target ? std::array<double, 7>{1.5, 1.5, 1.6, 1, 1, 0, 0}
                 : std::array<double, 7>{0, 0, 0, 0, 0, 0.7, 0.7};
    o.R.fill(R / (s * s));
    o.u_min.fill(s * limits.first);
    o.u_max.fill(s * limits.second);
    if (target) o.x_ref = paper::target_path();
    ids.push_back(team.add(OtherUnit{s}, o));
  }
  const auto couple = [&](const Weighted& term) {
    if (variant == paper::Variant::joint) return team.couple(term, Between{ids[0], ids[1]});
    team.couple(term, Between{ids[0], ids[1]}, felt_by(ids[0]));
  };
  couple(0.4 * SensorCone{.alpha = 0.5, .kappa_G = 0.01, .kappa_A = 2});
  couple(0.4 * KeepOut{.d_min = 1, .kappa_H = 4.5, .kappa_G = 0.001, .kappa_A = 3});
  couple(0.4 * Cohesion{.d_max = 2, .kappa_H = 1.5, .kappa_G = 0.001, .kappa_A = 3});
  NewtonRiccati solver(team, default_horizon, {.step_cap = 1e-3, .start_steps = 1});
  std::vector<double> all;
  fly(solver, paper::saturating_start(), 300, [&](double, const std::vector<double>&, const Solution& u) {
    for (const double of : u.u) all.push_back(of / s);
    statuses.push_back(u.status);
  });
  return all;
}

// Where thresholds are absolute, +-3 m/s is watched where +-1 is not, and +-0.1 is trusted where it
// should not be.
TEST(NewtonRiccati, TheUnitOfAnInputChangesNothing) {
  std::ptrdiff_t watched = 0;  // steps
  for (const paper::Variant variant : {paper::Variant::joint, paper::Variant::masked}) {
    for (const auto& [low, high, R] :
         {std::tuple{-1.0, 1.0, 1.0}, std::tuple{-0.4, 0.8, 1.0}, std::tuple{-1e5, 1e5, 1.0}}) {
      std::vector<Status> expected_statuses;
      const auto expected = flown_in_unit(1.0, {low, high}, R, variant, expected_statuses);
      watched += std::count(expected_statuses.begin(), expected_statuses.end(), Status::iteration_limit);
      for (const double s : {0.1, 3.0, 10.0}) {
        std::vector<Status> statuses;
        const auto flown = flown_in_unit(s, {low, high}, R, variant, statuses);
        double worst = 0.0;
        for (std::size_t i = 0; i < flown.size(); ++i)
          worst = std::max(worst, std::fabs(flown[i] - expected[i]));
        EXPECT_LE(worst, 1e-8) << s << " of [" << low << ", " << high << "]";
        EXPECT_EQ(statuses, expected_statuses) << s;
      }
    }
  }
  EXPECT_GT(watched, 0);
}

/// Flies a chain for 5 s, then goes on with another team. @return KKT after each of three updates
/// there
std::array<double, 3> kkt_after_change(
    NewtonRiccati& before, NewtonRiccati& after,
    const std::function<std::vector<double>(std::vector<double>)>& change) {
  const int n = static_cast<int>(before.ocp().agent_bodies().size());
  const std::vector<double> x_before = fly(before, chain_start(n), 500);
  std::vector<double> x = change(x_before);
  after.solve(5.0, x);  // off the control path
  after.take_over(before.ocp().team(), before.whole_plan());
  std::vector<double> u_before(static_cast<std::size_t>(before.ocp().nu())), u(4 * x.size() / 7);
  before.plan(3, u_before);
  after.plan(3, u);
  for (std::size_t i = 0; i < std::min(u.size(), u_before.size()); ++i)
    EXPECT_EQ(u[i], u_before[i]) << "those who stay keep their plan";
  std::array<double, 3> kkt{};
  int k = 0;
  fly(
      after, x, 3,
      [&](double t, const std::vector<double>& now, const Solution&) {
        kkt[static_cast<std::size_t>(k++)] = after.kkt(t, now);
      },
      5.0);
  return kkt;
}

TEST(NewtonRiccati, ARobotThatJoinsOrLeavesAChainIsTakenInWithinThreeUpdates) {
  for (const paper::Variant variant : {paper::Variant::joint, paper::Variant::masked}) {
    const auto joined = [](std::vector<double> x) {
      const std::vector<double> next = behind(std::span<const double>(x).last(7));
      x.insert(x.end(), next.begin(), next.end());
      return x;
    };
    const auto left = [](std::vector<double> x) {
      x.resize(x.size() - 7);
      return x;
    };
    NewtonRiccati a(chain(8, variant), default_horizon),
        nine(chain(9, variant), default_horizon, {.start_steps = 30});
    const auto after_joining = kkt_after_change(a, nine, joined);
    EXPECT_LE(after_joining[0], 0.3);
    EXPECT_LE(after_joining[2], 1e-4);
    NewtonRiccati b(chain(8, variant), default_horizon),
        seven(chain(7, variant), default_horizon, {.start_steps = 30});
    const auto after_leaving = kkt_after_change(b, seven, left);
    EXPECT_LE(after_leaving[0], 0.3);
    EXPECT_LE(after_leaving[2], 1e-4);
  }
}

TEST(NewtonRiccati, AnOptionOutOfItsRangeIsNamed) {
  const Team team = paper::target_alone();
  EXPECT_THROW(NewtonRiccati(team, default_horizon, {.max_newton_steps = 0}), std::invalid_argument);
  EXPECT_THROW(NewtonRiccati(team, default_horizon, {.tolerance = 0.0}), std::invalid_argument);
  EXPECT_THROW(NewtonRiccati(team, default_horizon, {.step_cap = -1.0}), std::invalid_argument);
  EXPECT_THROW(NewtonRiccati(team, default_horizon, {.deadline = std::nan("")}), std::invalid_argument);
}

TEST(NewtonRiccati, ABodyMovesOnInThePlanAsMeasuredOrPredictedAndARestartEndsItsPrediction) {
  Team team;
  const AgentId uav = team.add(Multirotor{}, {.Q = {1, 1, 1, 0, 0, 0.5, 0.5}});
  const BodyId body = team.add(Obstacle{.name = "passer"});
  team.couple(2.0 * KeepOut{.d_min = 0.8}, Between{uav, body}, felt_by(uav));
  const std::vector<double> x = {0, 0, 1, 1, 0, 0, 0, /**/ 1.2, -0.6, 1, 0.1, 0.5, -0.2};
  const double h = default_horizon.h();
  NewtonRiccati solver(team, default_horizon), fresh(team, default_horizon);
  const auto expect_way = [&](const Solution& s, double moves) {
    ASSERT_EQ(s.x.size(), 13u * static_cast<std::size_t>(default_horizon.N + 1));
    for (std::size_t k = 0; k <= static_cast<std::size_t>(default_horizon.N); ++k) {
      for (std::size_t i = 7; i < 10; ++i)
        EXPECT_NEAR(s.x[13 * k + i], x[i] + moves * static_cast<double>(k) * h * x[i + 3], 1e-12) << k;
    }
  };
  expect_way(solver.solve(0.0, x), 1.0);
  const Sight<double> stays = {{{x[7], x[8], x[9]}, {1, 0}}, {0, 0, 0}};
  solver.set_prediction({.who = body, .time = 0.0, .h = h, .sights = {stays, stays, stays}});
  expect_way(solver.solve(0.0, x), 0.0);
  solver.restart();
  const Solution again = solver.solve(0.0, x), first = fresh.solve(0.0, x);
  EXPECT_TRUE(std::equal(again.u.begin(), again.u.end(), first.u.begin()));
  expect_way(again, 1.0);
}

/// A robot that is sent to a place 3 m off, with limits.
Team sent_to(const Vec3<double>& p, InputLimits limits) {
  Team team;
  team.add(Agent{.name = "uav",
                 .model = Multirotor{},
                 .Q = {4, 4, 4, 0, 0, 0, 0},
                 .R = std::vector<double>(4, 0.1),
                 .Q_f = {},
                 .x_ref = Constant{.p = p},
                 .limits = std::move(limits)});
  return team;
}
const std::vector<double> at_origin = {0, 0, 0, 1, 0, 0, 0};

TEST(NewtonRiccati, EachStageOfThePlanKeepsTheLimitsOfItsTime) {
  const InputLimits limits({0.0, 0.7, 1.4}, {{-1, -1, -1, -1}, {-0.3, -0.2, -1, -0.1}, {-1, -1, -0.1, -1}},
                           {{1, 1, 1, 1}, {0.2, 1, 0.1, 0.5}, {0.4, 1, 1, 1}});
  NewtonRiccati solver(sent_to({3, -2, 2}, limits), default_horizon);
  std::vector<double> u(4), low(4), high(4);
  fly(solver, at_origin, 150, [&](double t, const std::vector<double>&, const Solution&) {
    for (int k = 0; k < default_horizon.N; ++k) {
      solver.plan(k, u);
      limits.at(t + k * default_horizon.h(), low, high);
      for (std::size_t i = 0; i < 4; ++i) ASSERT_TRUE(u[i] >= low[i] && u[i] <= high[i]) << t << ", " << k;
    }
  });
}

TEST(NewtonRiccati, LowerAndUpperLimitsAreAlike) {
  const InputLimits limits(std::vector<double>(4, -0.6), std::vector<double>(4, 0.6));
  NewtonRiccati there(sent_to({3, -2, 1.5}, limits), default_horizon),
      back(sent_to({-3, 2, -1.5}, limits), default_horizon);
  std::vector<std::vector<double>> flown;
  std::vector<Status> statuses;
  fly(there, at_origin, 200, [&](double, const std::vector<double>&, const Solution& s) {
    flown.emplace_back(s.u.begin(), s.u.end());
    statuses.push_back(s.status);
  });
  std::size_t k = 0;
  fly(back, at_origin, 200, [&](double, const std::vector<double>&, const Solution& s) {
    EXPECT_EQ(s.status, statuses[k]) << k;
    for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(s.u[i], -flown[k][i], 1e-9) << k;
    EXPECT_NEAR(s.u[3], flown[k][3], 1e-9) << k << ", it turns as the other does";
    ++k;
  });
}

TEST(NewtonRiccati, CompiledAndInterpretedFunctionsGiveTheSameBits) {
  const Team team = paper::team(paper::Variant::joint);
  NewtonRiccati compiled(team, {}), interpreted(team, {}, {.kernels = KernelChoice::interpreted});
  fly(compiled, paper::saturating_start(), 300,
      [&](double t, const std::vector<double>& x, const Solution& s) {
        const Solution other = interpreted.solve(t, x);
        for (std::size_t i = 0; i < s.u.size(); ++i) ASSERT_EQ(s.u[i], other.u[i]) << t;
        ASSERT_EQ(s.residual, other.residual) << t;
      });
}

TEST(NewtonRiccati, MovedItFliesOnBitForBit) {
  const Team team = chain(5, paper::Variant::joint);
  NewtonRiccati stays(team, default_horizon);
  std::vector<NewtonRiccati> solvers;
  const auto make = [&] {
    NewtonRiccati made(team, default_horizon);
    std::vector<double> x = chain_start(5);
    (void)made.solve(0.0, x);
    return std::optional<NewtonRiccati>(std::move(made));
  };
  for (int i = 0; i < 5; ++i) solvers.push_back(std::move(*make()));  // the list grows and moves all
  std::swap(solvers[1], solvers[3]);
  std::vector<double> x = chain_start(5);
  (void)stays.solve(0.0, x);
  for (int k = 1; k < 50; ++k) {
    const Solution expected = stays.solve(0.01 * k, x);
    for (NewtonRiccati& solver : solvers) {
      const Solution s = solver.solve(0.01 * k, x);
      ASSERT_TRUE(std::equal(s.u.begin(), s.u.end(), expected.u.begin()));
      ASSERT_EQ(s.residual, expected.residual);
    }
    advance(team, x, expected.u, 0.01);
  }
}

}  // namespace
}  // namespace sightline
