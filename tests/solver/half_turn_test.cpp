/// The heading of a reference steps, by half a turn and by any other angle: every solver turns
/// every robot there.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "sightline/model.hpp"
#include "sightline/model/state_roles.hpp"
#include "sightline/robots.hpp"
#include "sightline/solvers.hpp"
#include "tests/support/closed_loop.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

using std::numbers::pi;

constexpr double deg = pi / 180, step_at = 1.0;  // [s]

enum class Kind { newton_riccati, cmscgmres, cgmres };
constexpr std::array kinds = {Kind::newton_riccati, Kind::cmscgmres, Kind::cgmres};

std::unique_ptr<Solver> solver_of(Kind kind, const Team& team) {
  const Horizon horizon;
  if (kind == Kind::newton_riccati) return std::make_unique<NewtonRiccati>(team, horizon);
  if (kind == Kind::cmscgmres) return std::make_unique<Cmscgmres>(team, horizon);
  return std::make_unique<Cgmres>(team, horizon);
}

/// A ship that is text, 1.6 rad/s at most; its heading stands backwards in the state.
Model ship() {
  return TextRobot{
      .name = "ship",
      .states = {"d_y", "p_x", "p_y", "p_z", "d_x", "v"},
      .inputs = {"thrust", "rudder"},
      .f = {"1.6 * rudder * d_x", "v * d_x", "v * d_y", "0", "-1.6 * rudder * d_y", "thrust - v"},
      .position = {"p_x", "p_y", "p_z"},
      .heading = {"d_x", "d_y"}}
      .model();
}

std::vector<Model> robots() {
  constexpr VelocityMultirotor drone = VelocityMultirotor::ar_drone();
  return {Multirotor{},
          OmniRover{},
          Unicycle{},
          HoverMultirotor{},
          drone,
          LaggedMultirotor<Lags::plane>::of(drone),
          LaggedMultirotor<Lags::yaw>::of(drone),
          ship(),
          AngleMultirotor{}};
}

/// A turn on the spot, to the left [rad], 3 s after the reference has stepped.
struct Turn {
  double by_3_s = 0.0;
  int changes = 0;  ///< of the side to which the robot turns, until it turns slowly
};

Turn turn(Solver& solver, const Model& model, double from) {
  std::vector<double> x(static_cast<std::size_t>(model.nx()));
  model.at_rest({{0.0, 0.0, 1.0}, {std::cos(from), std::sin(from)}}, x.data());
  Turn result;
  const std::vector<double> at_rest(static_cast<std::size_t>(model.nu()));
  Vec2<double> before = model.sight(x.data(), at_rest.data()).d;
  double side = 0.0;
  solver.restart();
  fly(solver, x, 401, [&](double, const std::vector<double>& now, const Solution&) {
    constexpr double slow = 0.002;  // [rad] a period
    const Vec2<double> d = model.sight(now.data(), at_rest.data()).d;
    const double turned = std::atan2(before.x * d.y - before.y * d.x, before.x * d.x + before.y * d.y);
    before = d;
    result.by_3_s += turned;
    if (std::abs(turned) < slow) return;
    result.changes += side * turned < 0 ? 1 : 0;
    side = turned;
  });
  return result;
}

/// The heading's weight is 1; an input costs 1 at its limit, in whatever unit it is.
Team team_of(const Model& model, const Reference& reference) {
  const StateRoles roles = roles_of(model);
  Agent agent{.name = {},
              .model = model,
              .Q = std::vector<double>(static_cast<std::size_t>(model.nx())),
              .R = {},
              .Q_f = {},
              .x_ref = reference,
              .limits = InputLimits({model.u_min().begin(), model.u_min().end()},
                                    {model.u_max().begin(), model.u_max().end()})};
  for (const double most : model.u_max()) agent.R.push_back(1.0 / (most * most));
  for (const int state : {roles.direction[0], roles.direction[1], roles.angle}) {
    if (state >= 0) agent.Q[static_cast<std::size_t>(state)] = 1.0;
  }
  for (const int state : roles.position) {
    if (state >= 0) agent.Q[static_cast<std::size_t>(state)] = 1.0;
  }
  Team team;
  team.add(std::move(agent));
  return team;
}

Turn step(Kind kind, const Model& model, double from, double by) {
  const Vec3<double> p = {0.0, 0.0, 1.0};
  const Team team = team_of(model, Steps{.times = {0.0, step_at}, .p = {p, p}, .heading = {from, from + by}});
  return turn(*solver_of(kind, team), model, from);
}

void PrintTo(Kind kind, std::ostream* to) {
  *to << (kind == Kind::newton_riccati ? "newton_riccati" : kind == Kind::cmscgmres ? "cmscgmres" : "cgmres");
}

class HalfTurn : public testing::TestWithParam<Kind> {};

TEST_P(HalfTurn, EveryRobotTurns150DegreesIn3Seconds) {
  for (const Model& model : robots()) {
    for (const double from : {0.0, 2.5}) {
      for (const double by : {pi, -pi, pi - 1e-9, pi + 1e-9, 179 * deg, -179 * deg, 170 * deg, -170 * deg}) {
        const bool is_angle = roles_of(model).angle >= 0;
        if (is_angle && from > 0 && by != pi && by != -pi) continue;  // the long way round, (15)
        const Turn t = step(GetParam(), model, from, by);
        EXPECT_GE(std::abs(t.by_3_s), 150 * deg) << model.name() << " " << from << " " << by / deg;
        EXPECT_LE(std::abs(t.by_3_s), 190 * deg) << model.name() << " " << from << " " << by / deg;
        EXPECT_LE(t.changes, 1) << model.name() << " " << from << " " << by / deg;
        if (is_angle) continue;
        EXPECT_EQ(t.by_3_s < 0, by == -170 * deg) << model.name() << " " << by / deg;
      }
    }
  }
}

TEST_P(HalfTurn, NearlyEqualStepsTurnTheRobotNearlyAlike) {
  const Model model = Multirotor{};
  const double exact = step(GetParam(), model, 0.0, pi).by_3_s;
  for (const double off : {1e-9, -1e-9, 1e-12, -1e-12})
    EXPECT_NEAR(step(GetParam(), model, 0.0, pi + off).by_3_s, exact, 1e-6);
  EXPECT_NEAR(step(GetParam(), model, 0.0, -pi).by_3_s, exact, 1e-6);
  EXPECT_NEAR(step(GetParam(), model, 0.0, pi + 1 * deg).by_3_s, exact, 2 * deg);
  EXPECT_NEAR(step(GetParam(), model, 0.0, pi - 1 * deg).by_3_s, exact, 2 * deg);
}

TEST_P(HalfTurn, AnyStepTakesTheShorterWayAndEndsNearTheReference) {
  Random random(7);
  const std::vector<Model> all = robots();
  for (int n = 0; n < 60; ++n) {
    const Model& model = all[random() % (all.size() - 1)];  // all with a heading vector
    const double from = uniform(random, -pi, pi), by = uniform(random, -174, 180) * deg;
    const Turn t = step(GetParam(), model, from, by);
    EXPECT_NEAR(t.by_3_s, by, 30 * deg) << model.name() << " " << from << " " << by / deg;
    EXPECT_LE(t.changes, 2) << model.name() << " " << from << " " << by / deg;
  }
}

/// A robot that begins opposite to where a reference that stays is to head.
TEST_P(HalfTurn, ItNeedNotBeAStepAndTheReferenceMayBeOfAnyForm) {
  const Vec3<double> p = {0.0, 0.0, 1.0};
  const std::vector<Reference> forms = {
      Constant{.p = p, .heading = pi}, std::array<double, 7>{0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0},
      Waypoints{.times = {0.0}, .p = {p}, .heading = {-pi}},
      Reference([](double) { return std::array<double, 7>{0.0, 0.0, 1.0, -1.0, 1e-12, 0.0, 0.0}; }),
      Reference::between(Constant{.p = p, .heading = 0.0}, Constant{.p = p, .heading = pi},
                         {.begin = 0.0, .duration = 1.0, .from = 0.0, .to = 1.0})};
  for (std::size_t form = 0; form < forms.size(); ++form) {
    const Team team = team_of(Multirotor{}, forms[form]);
    const Turn t = turn(*solver_of(GetParam(), team), Multirotor{}, 0.0);
    EXPECT_GE(t.by_3_s, 150 * deg) << form;
    EXPECT_LE(t.by_3_s, 181 * deg) << form;
  }
}

INSTANTIATE_TEST_SUITE_P(Solvers, HalfTurn, testing::ValuesIn(kinds));

}  // namespace
}  // namespace sightline
