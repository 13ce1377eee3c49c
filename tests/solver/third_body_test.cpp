/// A coupling of two bodies that looks past a third: planned with where that will be, whoever
/// steers it.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "sightline/potentials.hpp"
#include "sightline/solvers.hpp"
#include "tests/support/default_horizon.hpp"

namespace sightline {
namespace {

/// Beyond the limit a ramp, with the third body where the formulas say.
Region past(const std::string& x, const std::string& y) {
  return Region("hypot(observer.p_x + at * r_x - third_x, observer.p_y + at * r_y - third_y) > 0.6 m",
                {{"third_x", x},
                 {"third_y", y},
                 {"along", "(third_x - observer.p_x) * r_x + (third_y - observer.p_y) * r_y"},
                 {"at", "max(0, min(1, along / (r_x^2 + r_y^2 + 0.0001 m^2)))"}})
      .slope(Softplus{4.0, 0.0})
      .sigmoid(8.0)
      .smoothed_over(0.02);
}
const Region past_third = past("third.p_x", "third.p_y");

/// uav0 looks at uav1, 2 m ahead of it.
struct Looking {
  Team team;
  AgentId uav0, uav1;

  Looking()
      : uav0(team.add(Multirotor{}, {.R = {1, 1, 1, 1}, .name = "uav0"})),
        uav1(team.add(Multirotor{}, {.R = {1, 1, 1, 1}, .name = "uav1"})) {}
  void look(const Region& region, BodyId third) {
    team.couple({.term = 6.0 * region, .between = {uav0, uav1}, .felt_by = {uav0}, .third = third});
  }
};
constexpr std::array<double, 14> robots = {0, 0, 1.5, 1, 0, 0, 0, /**/ 2, 0, 1.5, 1, 0, 0, 0};
constexpr std::array<double, 6> passer = {1.0, -0.4, 1.5, 0.1, 0.5, 0.0};  // p, v

/// A body passes between the two: known to the solver, or written into the formula.
Team with_passer(bool written) {
  Looking looking;
  const BodyId body = looking.team.add(Obstacle{.name = "passer"});
  looking.look(written ? past("1 m + 0.1 m/s * t", "-0.4 m + 0.5 m/s * t") : past_third,
               written ? BodyId{} : body);
  return looking.team;
}
std::vector<double> with_passer_at_start() {
  std::vector<double> x(robots.begin(), robots.end());
  x.insert(x.end(), passer.begin(), passer.end());
  return x;
}

/// The input after so many updates beside the standing robots; what moves moves on.
template <class AnySolver>
std::vector<double> input_after(int updates, AnySolver solver, std::vector<double> x) {
  for (int update = 0; update < updates; ++update) {
    (void)solver.solve(update * default_horizon.dt, x);
    for (std::size_t i = robots.size(); i + 3 < x.size(); ++i) x[i] += default_horizon.dt * x[i + 3];
  }
  const Solution solution = solver.solve(updates * default_horizon.dt, x);
  return {solution.u.begin(), solution.u.end()};
}

template <class AnySolver>
void is_as_one_written_in() {
  constexpr int updates = 60;
  const std::vector<double> x = with_passer_at_start();
  const std::vector<double> known = input_after(updates, AnySolver(with_passer(false), default_horizon), x),
                            written = input_after(updates, AnySolver(with_passer(true), default_horizon), x),
                            blind = input_after(updates, AnySolver(Looking().team, default_horizon),
                                                {robots.begin(), robots.end()});
  for (std::size_t i = 0; i < known.size(); ++i) EXPECT_NEAR(known[i], written[i], 1e-9);
  EXPECT_GT(std::abs(known[1] - blind[1]), 0.02) << "uav0 goes aside";
}

TEST(ThirdBody, IsPlannedWithAsOneWhoseWayIsWrittenIn) {
  is_as_one_written_in<NewtonRiccati>();
  is_as_one_written_in<Cgmres>();
}

/// uav2 crosses between the two, by its own reference.
AgentId add_crossing(Team& team) {
  constexpr std::array beyond = {1.0, 0.2, 1.5, 1.0, 0.0, 0.0, 0.0};
  return team.add(Multirotor{}, {.Q = {0.5, 0.5, 0.5}, .R = {1, 1, 1, 1}, .x_ref = beyond, .name = "uav2"});
}
Team with_robot() {
  Looking looking;
  looking.look(past_third, add_crossing(looking.team));
  return looking.team;
}
std::vector<double> with_robot_at_start() {
  std::vector<double> x(robots.begin(), robots.end());
  x.insert(x.end(), {1, -0.6, 1.5, 1, 0, 0, 0});
  return x;
}

std::vector<double> converged_input(NewtonRiccati solver, std::span<const double> x) {
  for (int update = 0; update < 100; ++update) (void)solver.solve(0.0, x);
  const Solution solution = solver.solve(0.0, x);
  EXPECT_EQ(solution.status, Status::converged);
  return {solution.u.begin(), solution.u.end()};
}

TEST(ThirdBody, ThatIsSteeredIsTakenAsItPlansAndFeelsNothing) {
  const std::vector<double> x = with_robot_at_start();
  Team alone;
  add_crossing(alone);
  const std::vector<double> all = converged_input(NewtonRiccati(with_robot(), default_horizon), x),
                            own = converged_input(NewtonRiccati(alone, default_horizon),
                                                  std::span(x).subspan(14));
  for (std::size_t i = 0; i < own.size(); ++i) EXPECT_NEAR(all[8 + i], own[i], 1e-6);
}

TEST(ThirdBody, OfAnotherPartIsOneThatIsNotSteeredThere) {
  const Team team = with_robot();
  const Team part = subteam_of(team, std::array{AgentId{team.find("uav0")}}, Others::felt);
  ASSERT_EQ(part.couplings().size(), 1U);
  EXPECT_EQ(part.name(part.couplings()[0].third), "uav2");
  EXPECT_FALSE(part.is_agent(part.couplings()[0].third));
}

TEST(ThirdBody, CostsWhatItsPotentialSays) {
  const Team team = with_robot();
  const std::vector<double> x = with_robot_at_start(), u(12, 0.0);
  Sight<double> a = team.model(BodyId{0}).sight(&x[0], &u[0]);
  const Sight<double> b = team.model(BodyId{1}).sight(&x[7], &u[4]);
  a.third = {x[14], x[15], x[16]};
  Looking blind;
  add_crossing(blind.team);
  EXPECT_NEAR(stage_cost(team, 0.0, x, u) - stage_cost(blind.team, 0.0, x, u), 6.0 * past_third(a, b, 0.0),
              1e-12);
}

}  // namespace
}  // namespace sightline
