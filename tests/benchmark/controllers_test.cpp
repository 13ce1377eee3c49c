// Laws of the benchmark's controllers: their closed forms against finite differences and
// independent formulas.
#include "benchmark/controllers/controllers.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <random>

#include "benchmark/controllers/mpc_laws.hpp"
#include "benchmark/controllers/process_control.hpp"
#include "benchmark/controllers/view_barrier.hpp"
#include "benchmark/controllers/visual_servo.hpp"
#include "sightline/potentials.hpp"
#include "sightline/robots.hpp"
#include "sightline/scenario.hpp"
#include "tests/support/refusal.hpp"

namespace sightline::benchmark {
namespace {

using testing::HasSubstr;

const SensorMount mount = {.pitch = 0.4, .offset = 0.17},
                  askew = {.pitch = 0.4, .offset = {0.1, -0.2, 0.05}, .yaw = -0.3, .roll = 0.8};

/// An observer, its target, and a third body that it keeps away from.
struct Pair {
  Team team;
  AgentId observer, target;
  BodyId obstacle;

  Pair() {
    observer = team.add(Multirotor{}, {.R = {0.1, 0.1, 0.1, 0.1}, .name = "observer"});
    target = team.add(Multirotor{}, {.Q = {1, 1, 1, 0, 0, 0, 0},
                                     .x_ref = std::array{3.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0},
                                     .name = "target"});
    obstacle = team.add(Obstacle{"obstacle"});
    team.couple(1.0 * Bearing{.alpha = 0.5, .mount = mount}, Between{observer, target}, felt_by(observer));
    team.couple(1.0 * TooNear{.d_min = 1.0}, Between{observer, target}, felt_by(observer));
    team.couple(1.0 * TooFar{.d_max = 3.0}, Between{target, observer}, felt_by(observer));
    team.couple(1.0 * TooNear{.d_min = 0.7}, Between{observer, obstacle}, felt_by(observer));
  }
  std::vector<double> states() const {
    return {0.1, -0.2, 1.3, std::cos(0.2), std::sin(0.2), 0.2, -0.1, 2.1, 0.4,  1.0,
            1,   0,    0.3, 0.1,           1.0,           2.0, 1.0,  0.0, -0.1, 0.0};
  }
};

/// A pose moved for a time by v = (forward, left, up, yaw rate) in its own frame.
Pose<double> moved(const Pose<double>& pose, const std::array<double, 4>& v, double time) {
  const Vec2<double> way = rotate<double>(pose.d, {v[0] * time, v[1] * time});
  const double c = std::cos(v[3] * time), s = std::sin(v[3] * time);
  return {{pose.p.x + way.x, pose.p.y + way.y, pose.p.z + v[2] * time}, rotate<double>({c, s}, pose.d)};
}

struct Draw {
  std::mt19937 random{7};
  double operator()(double low, double high) { return std::uniform_real_distribution<>(low, high)(random); }
  Pose<double> pose() {
    const double yaw = (*this)(-3, 3);
    return {{(*this)(-2, 2), (*this)(-2, 2), (*this)(0, 2)}, {std::cos(yaw), std::sin(yaw)}};
  }
  Vec3<double> vector(double most) {
    return {(*this)(-most, most), (*this)(-most, most), (*this)(-most, most)};
  }
  std::array<double, 4> velocity() {
    return {(*this)(-1, 1), (*this)(-1, 1), (*this)(-1, 1), (*this)(-1, 1)};
  }
};

TEST(ViewTasks, AreReadFromTheCouplings) {
  const Pair pair;
  const std::vector<ViewTask> tasks = view_tasks(pair.team);
  ASSERT_EQ(tasks.size(), 1U);
  EXPECT_EQ(tasks[0].robot, pair.observer);
  EXPECT_EQ(tasks[0].target, pair.target);
  EXPECT_EQ(tasks[0].alpha, 0.5);
  EXPECT_EQ(tasks[0].mount, mount);
  EXPECT_EQ(tasks[0].d_min, 1.0);
  EXPECT_EQ(tasks[0].d_max, 3.0);
  ASSERT_EQ(tasks[0].others.size(), 1U);
  EXPECT_EQ(tasks[0].others[0].body, pair.obstacle);
  EXPECT_EQ(tasks[0].others[0].d_min, 0.7);
  const Vec3<double> best = best_place(tasks[0]);
  EXPECT_NEAR(norm(best), 2.0, 1e-12);
  EXPECT_NEAR(off_axis(mount(Pose<double>{{0, 0, 0}, {1, 0}}, best)), 0.0, 1e-7);
}

TEST(ViewTasks, WithoutOneOrWithTwoForARobotAreRefused) {
  Team alone;
  alone.add(Multirotor{}, {});
  EXPECT_THAT(refusal_of([&] { view_tasks(alone); }), HasSubstr("no robot observes another body"));
  Pair pair;
  pair.team.couple(1.0 * Bearing{}, Between{pair.observer, pair.obstacle}, felt_by(pair.observer));
  EXPECT_EQ(refusal_of([&] { view_tasks(pair.team); }),
            "observer observes two bodies, expected one target for each robot");
}

TEST(VelocityLoop, FollowsItsCommandsExactly) {
  Draw draw;
  const VelocityLoop loop{Model(Multirotor{})};
  for (int i = 0; i < 100; ++i) {
    const double yaw = draw(-3, 3);
    const State x = {0, 0, 1, std::cos(yaw), std::sin(yaw), draw(-1, 1), draw(-1, 1)};
    const VelocityCommand command = {draw(-1, 1), draw(-1, 1), draw(-1, 1), draw(-1, 1)};
    const State rate = loop.rate(x.data(), loop.inputs(x.data(), command, 0.4));
    EXPECT_NEAR(rate[5], (command.forward - x[5]) / 0.4, 1e-12);
    EXPECT_NEAR(rate[6], (command.left - x[6]) / 0.4, 1e-12);
    EXPECT_NEAR(rate[2], command.up, 1e-12);
    EXPECT_NEAR(x[3] * rate[4] - x[4] * rate[3], command.yaw, 1e-12);
  }
  EXPECT_THAT(refusal_of([] { VelocityLoop{Model(OmniRover{})}; }),
              HasSubstr("robot = \"omni_rover\" observes"));
}

TEST(Interaction, IsTheDerivativeOfTheFeatures) {
  Draw draw;
  for (int i = 0; i < 200; ++i) {
    const Pose<double> robot = draw.pose();
    const Vec2<double> ahead = rotate<double>(robot.d, {draw(1, 4), draw(-0.5, 0.5)});
    const Vec3<double> target = robot.p + Vec3<double>{ahead.x, ahead.y, draw(-1, 0.2)};
    const std::array<double, 4> v = draw.velocity();
    const SensorMount& seen_by = i % 2 == 0 ? mount : askew;
    const auto at_time = [&](double t) { return features(seen_by(moved(robot, v, t), target)); };
    const Column<4> command = {{{{v[0]}, {v[1]}, {v[2]}, {v[3]}}}};
    const Vec3<double> rate = vec3(interaction(seen_by, at_time(0)) * command);
    constexpr double dt = 1e-6;
    EXPECT_LT(norm(rate - (0.5 / dt) * (at_time(dt) - at_time(-dt))), 1e-6 * (1 + norm(rate)));
  }
}

TEST(VisualServo, LeadsToTheWantedPictureOfATargetAtRest) {
  const Pair pair;
  const ViewTask task = view_tasks(pair.team)[0];
  VisualServoLaw law(pair.team, task, {});
  State x = {0, 0, 1.2, 1, 0, 0, 0};
  const Sight<double> target = {{{2.5, 0.6, 0.5}, {1, 0}}, {0, 0, 0}};
  std::array<double, 4> u{};
  for (int k = 0; k < 1500; ++k) {
    law.inputs(x.data(), {&target, 1}, u);
    for (double& one : u) one = std::clamp(one, -1.0, 1.0);
    Model(Multirotor{}).step(x.data(), u.data(), 0.01);
    ASSERT_TRUE(Model(Multirotor{}).normalise(x.data()));
  }
  const Relative seen = relative({{x[0], x[1], x[2]}, {x[3], x[4]}}, target);
  EXPECT_LT(norm(seen.q - best_place(task)), 1e-2);
}

TEST(Barriers, RowsAreTheirDerivatives) {
  Draw draw;
  for (int i = 0; i < 300; ++i) {
    const Pose<double> robot = draw.pose();
    const Sight<double> body = {{draw.vector(3), {1, 0}}, draw.vector(1)};
    if (norm(body.p - robot.p) < 0.5) continue;
    const std::array<double, 4> v = draw.velocity();
    const auto barrier = [&](int kind, double t) {
      Sight<double> then = body;
      then.p = body.p + t * body.v;
      const Vec3<double> q = relative(moved(robot, v, t), then).q;
      return kind == 0 ? view_barrier(i % 2 == 0 ? mount : askew, 0.5, q)
                       : distance_barrier(q, 1.2, kind == 1 ? 1 : -1);
    };
    for (int kind = 0; kind < 3; ++kind) {
      constexpr double dt = 1e-6, gamma = 1.7;
      const Barrier now = barrier(kind, 0);
      const BarrierRow row = row_of(now, relative(robot, body), gamma);
      // a' v - b = h' + gamma h
      const double left = row.a[0] * v[0] + row.a[1] * v[1] + row.a[2] * v[2] + row.a[3] * v[3] - row.b;
      const double rate = (barrier(kind, dt).h - barrier(kind, -dt).h) / (2 * dt);
      EXPECT_NEAR(left, rate + gamma * now.h, 1e-6 * (1 + std::abs(left))) << kind;
    }
  }
}

TEST(Barriers, AreZeroAtTheirLimitsAndPositiveWithin) {
  for (const double angle : {0.1, 0.49, 0.5, 0.51, 2.0}) {
    // A point of S at this angle off the axis, in V.
    const Vec3<double> q = {0.17 + 2 * std::cos(angle), 2 * std::sin(angle), 0.0};
    const double h = view_barrier({.pitch = 0.0, .offset = 0.17}, 0.5, q).h;
    EXPECT_NEAR(h, 2 * (std::cos(angle) - std::cos(0.5)), 1e-12);
  }
  EXPECT_NEAR(distance_barrier({0, 2, 0}, 2, 1).h, 0.0, 1e-15);
  EXPECT_GT(distance_barrier({0, 3, 0}, 2, 1).h, 0.0);
  EXPECT_LT(distance_barrier({0, 3, 0}, 2, -1).h, 0.0);
  EXPECT_EQ(barrier_shortfall(1.0, 0.9, 0.1), 0.0);
  EXPECT_NEAR(barrier_shortfall(1.0, 0.5, 0.1), 0.4, 1e-15);
}

TEST(BarrierQp, IsTheMinimumThatDescentFinds) {
  Draw draw;
  for (int i = 0; i < 200; ++i) {
    const int n = i % 5;
    std::vector<BarrierRow> rows(at(n));
    for (BarrierRow& row : rows) row = {draw.velocity(), draw(-1, 1)};
    const std::array<double, 4> v_0 = draw.velocity(),
                                W = {draw(0.5, 2), draw(0.5, 2), draw(0.5, 2), draw(0.5, 2)};
    constexpr double rho = 10.0;
    const std::array<double, 4> v = nearest_within(v_0, W, rows, rho);
    // The slacks eliminated, the value is smooth and strictly convex.
    const auto slope = [&](const std::array<double, 4>& at_v) {
      std::array<double, 4> g{};
      for (std::size_t k = 0; k < 4; ++k) g[k] = W[k] * (at_v[k] - v_0[k]);
      for (const BarrierRow& row : rows) {
        double short_of = row.b;
        for (std::size_t k = 0; k < 4; ++k) short_of -= row.a[k] * at_v[k];
        for (std::size_t k = 0; k < 4; ++k) g[k] -= rho * std::max(0.0, short_of) * row.a[k];
      }
      return g;
    };
    std::array<double, 4> found = v_0;
    for (int step = 0; step < 20000; ++step) {
      const std::array<double, 4> g = slope(found);
      for (std::size_t k = 0; k < 4; ++k) found[k] -= 0.006 * g[k];
    }
    for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR(v[k], found[k], 1e-6) << i;
  }
}

TEST(BarrierQp, KeepsWhatIsWantedWhereAllRowsHold) {
  const std::array<double, 4> v_0 = {0.1, 0.2, 0.3, 0.4};
  const std::array<BarrierRow, 1> holds = {BarrierRow{{1, 0, 0, 0}, 0.0}};
  EXPECT_EQ(nearest_within(v_0, {1, 1, 1, 1}, holds, 1e3), v_0);
}

TEST(StageMinimum, IsTheBestOfAllActiveSets) {
  Draw draw;
  for (int i = 0; i < 300; ++i) {
    Mat<nu, nu> root;
    Mat<nu, 1> g, d;
    for (int r = 0; r < nu; ++r) {
      g(r, 0) = draw(-3, 3);
      for (int c = 0; c < nu; ++c) root(r, c) = draw(-1, 1);
    }
    const Mat<nu, nu> H = root * transposed(root) + identity<nu>(0.1);
    const Input low = {-1, -0.5, -1, -0.2}, high = {0.3, 1, 1, 0.2};
    std::array<bool, nu> free{};
    ASSERT_TRUE(minimise_within(H, g, low, high, d, free));
    const Mat<nu, 1> slope = H * d + g;
    for (int k = 0; k < nu; ++k) {
      EXPECT_TRUE(d(k, 0) >= low[at(k)] && d(k, 0) <= high[at(k)]);
      EXPECT_TRUE(d(k, 0) <= low[at(k)] + 1e-9 || slope(k, 0) < 1e-5) << k;
      EXPECT_TRUE(d(k, 0) >= high[at(k)] - 1e-9 || slope(k, 0) > -1e-5) << k;
    }
  }
}

/// Value of a plan by its definition, without the class's own sweep.
double value_of(const VelocityLoop& robot, const Horizon& horizon, const StageCost& cost, State x,
                const std::vector<Input>& plan) {
  double sum = 0.0;
  for (int k = 0; k < horizon.N; ++k) {
    const State rate = robot.rate(x.data(), plan[at(k)]);
    State next = x;
    for (std::size_t i = 0; i < nx; ++i) next[i] += horizon.h() * rate[i];
    for (const double r : cost(k, x, plan[at(k)], next)) sum += r * r;
    x = next;
  }
  return sum;
}

TEST(GaussNewtonSteps, ReachAStationaryPlanWithinItsLimits) {
  struct ToAPlace final : StageCost {
    Residuals operator()(int, const State&, const Input& u, const State& next) const noexcept override {
      return {next[0] - 1.5, next[1] + 1.0, next[2] - 1.2, 0.5 * (next[4] - 0.6),
              0.2 * u[0],    0.2 * u[1],    0.2 * u[2],    0.2 * u[3]};
    }
  } cost;
  const VelocityLoop robot{Model(Multirotor{})};
  const Horizon horizon;
  GaussNewton mpc(robot, horizon);
  const State x = {0, 0, 1, 1, 0, 0, 0};
  mpc.update(x.data(), cost, {-1, -1, -1, -1}, {1, 0.4, 1, 1}, 60);
  const double value = value_of(robot, horizon, cost, x, mpc.plan());
  EXPECT_NEAR(mpc.cost(), value, 1e-12);
  bool limited = false;
  for (std::size_t k = 0; k < mpc.plan().size(); ++k) {
    for (std::size_t i = 0; i < nu; ++i) {
      std::vector<Input> plan = mpc.plan();
      constexpr double step = 1e-5;
      plan[k][i] += step;
      const double above = value_of(robot, horizon, cost, x, plan);
      plan[k][i] -= 2 * step;
      const double slope = (above - value_of(robot, horizon, cost, x, plan)) / (2 * step);
      const double u = mpc.plan()[k][i], most = i == 1 ? 0.4 : 1.0;
      limited = limited || u == most;
      EXPECT_TRUE(u <= -1 || slope < 1e-4) << k << ' ' << i;
      EXPECT_TRUE(u >= most || slope > -1e-4) << k << ' ' << i;
    }
  }
  EXPECT_TRUE(limited);
}

TEST(Projection, IsThatOfAPinholeFarAheadAndFiniteBehind) {
  const std::array<double, 2> far = projection({4.0, 1.0, -0.5}, 0.01);
  EXPECT_NEAR(far[0], 0.25, 1e-5);
  EXPECT_NEAR(far[1], -0.125, 1e-5);
  const std::array<double, 2> behind = projection({-2.0, 1.0, 0.0}, 0.2);
  EXPECT_TRUE(std::isfinite(behind[0]) && behind[0] > 10);
}

Registry with_controllers(const std::string& command = "") {
  Registry registry;
  add_controllers(registry, command);
  return registry;
}

TEST(Controllers, MoveTheOtherRobotsAsTheWholeTeamDoes) {
  const Registry registry = with_controllers();
  const Pair pair;
  NewtonRiccati whole(pair.team, Horizon{});
  const auto target = static_cast<std::size_t>(pair.team.input_offset(pair.target));
  for (const char* name : {"cbf_qp", "visual_servo", "pampc", "cbf_mpc"}) {
    const auto solver = make_solver(solver_named(name, registry), pair.team, Horizon{});
    EXPECT_EQ(solver->name(), name);
    whole.restart();
    for (int k = 0; k < 5; ++k) {
      const Solution own = solver->solve(0.01 * k, pair.states()),
                     of_whole = whole.solve(0.01 * k, pair.states());
      for (std::size_t i = target; i < target + 4; ++i) EXPECT_NEAR(own.u[i], of_whole.u[i], 1e-6) << name;
      for (const double u : own.u) EXPECT_TRUE(u >= -1 && u <= 1) << name;
      EXPECT_TRUE(gives_plan(own.status)) << name;
    }
  }
}

TEST(Controllers, RefuseWhatIsNoStateAndStartAgainAsTheyBegan) {
  const Registry registry = with_controllers();
  const Pair pair;
  for (const char* name : {"cbf_qp", "visual_servo", "pampc", "cbf_mpc"}) {
    const auto solver = make_solver(solver_named(name, registry), pair.team, Horizon{});
    const std::span<const double> first = solver->step(0.0, pair.states());
    const std::vector<double> begun(first.begin(), first.end());
    std::vector<double> bad = pair.states();
    bad[2] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(solver->solve(0.01, bad).status, Status::invalid_state) << name;
    solver->solve(0.02, pair.states());
    solver->restart();
    const std::span<const double> again = solver->step(0.0, pair.states());
    EXPECT_EQ(begun, std::vector<double>(again.begin(), again.end())) << name;
  }
}

/// Status and inputs of the observer with a command as controller, at three updates.
struct Answers {
  std::vector<Status> status;
  std::vector<double> u;
};
Answers answers_of(const std::string& command, const ProcessOptions& options = {}) {
  const Pair pair;
  ProcessControl control(pair.team, Horizon{}, view_tasks(pair.team), command, options);
  Answers answers{{}, std::vector<double>(8)};
  for (int k = 0; k < 3; ++k) answers.status.push_back(control.inputs(0.01 * k, pair.states(), answers.u));
  return answers;
}

TEST(Process, SteersTheObserverByItsLines) {
  const Answers answers = answers_of("read task; while read t x y z rest; do echo $x $y 0.25 -1; done");
  EXPECT_EQ(answers.status, std::vector(3, Status::converged));
  EXPECT_EQ(answers.u, (std::vector{0.1, -0.2, 0.25, -1.0, 0.0, 0.0, 0.0, 0.0}));
}

TEST(Process, ReceivesItsTaskAsJson) {
  const Pair pair;
  EXPECT_EQ(
      task_line(pair.team, view_tasks(pair.team), Horizon{}),
      R"({"period": 0.01, "observers": [{"robot": "observer", "state": 0, "target_state": 7, "pitch": 0.4, )"
      R"("offset": 0.17, "alpha": 0.5, "d_min": 1, "d_max": 3}]})"
      "\n");
}

TEST(Process, AnAnswerThatIsNoInputKeepsTheLastOnes) {
  const std::vector<double> none(8);
  for (const char* answer : {"0 0 0", "0 0 0 0 0", "0 0 0 2", "0 0 nan 0", "zero", "1e999 0 0 0"}) {
    const Answers answers = answers_of("while read line; do echo " + std::string(answer) + "; done");
    EXPECT_EQ(answers.status, std::vector(3, Status::not_finite)) << answer;
    EXPECT_EQ(answers.u, none) << answer;
  }
}

TEST(Process, ThatIsLateOrEndsIsWaitedForOnce) {
  const auto begin = std::chrono::steady_clock::now();
  EXPECT_EQ(answers_of("sleep 20", {.start = 0.2}).status, std::vector(3, Status::not_finite));
  EXPECT_EQ(answers_of("exit 0").status, std::vector(3, Status::not_finite));
  EXPECT_EQ(answers_of("no_such_program").status, std::vector(3, Status::not_finite));
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(10));
  const Pair pair;
  EXPECT_THAT(
      refusal_of([&] { make_solver(solver_named("process", with_controllers()), pair.team, Horizon{}); }),
      HasSubstr("expected --process COMMAND"));
}

TEST(Process, StartsAgainForAnotherFlight) {
  const Pair pair;
  ProcessControl control(pair.team, Horizon{}, view_tasks(pair.team), "read task; read x; echo 1 0 0 0", {});
  std::vector<double> u(8);
  EXPECT_EQ(control.inputs(0.0, pair.states(), u), Status::converged);
  EXPECT_EQ(control.inputs(0.01, pair.states(), u), Status::not_finite);  // it has ended
  control.restart();
  EXPECT_EQ(control.inputs(0.0, pair.states(), u), Status::converged);
}

}  // namespace
}  // namespace sightline::benchmark
