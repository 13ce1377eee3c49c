// Wherever the observer starts and looks, it finds its target and keeps it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>
#include <string>
#include <vector>

#include "sightline/scenario.hpp"
#include "tests/support/campaign.hpp"
#include "tests/support/closed_loop.hpp"
#include "tests/support/command.hpp"
#include "tests/support/random.hpp"

namespace sightline {
namespace {

enum class TargetMotion { at_rest, circling };

/// The scenario with its target at rest, or on its circle of 0.5 m at 0.3 m/s.
Scenario with_target(std::string text, TargetMotion motion) {
  const std::string path = "radius = 0.5, rate = 0.3";
  const std::size_t at = text.find(path);
  text.replace(at, path.size(),
               motion == TargetMotion::at_rest ? "radius = 0.0, rate = 0.0" : "radius = 0.5, rate = 0.6");
  return parse_scenario(std::move(text), "recovery.toml");
}

struct RecoveryStart {
  double range;     ///< horizontal distance of the target [m]
  double bearing;   ///< of the target off the nose [rad]
  double height;    ///< of the observer above the target [m]
  double v_f, v_s;  ///< velocity of the observer [m/s]
  double heading;   ///< [rad]
};

/// 0.3 to 6 m, any bearing, one in ten straight behind, 1 m below to 2 m above, up to 1 m/s each
/// way.
RecoveryStart recovery_start(Random& random, int trial) {
  constexpr double pi = std::numbers::pi;
  const double any = uniform(random, -pi, pi);
  return {uniform(random, 0.3, 6), trial % 10 == 0 ? pi : any, uniform(random, -1, 2),
          uniform(random, -1, 1),  uniform(random, -1, 1),     uniform(random, -pi, pi)};
}

struct Recovery {
  double first_view = infinite_time;  ///< [s]
  bool in_view_at_end = false, sound = true;
  double least_distance = infinite_time, last_distance = 0.0;

  static constexpr double infinite_time = std::numeric_limits<double>::infinity();
  bool recovered() const { return first_view <= 20.0 && in_view_at_end && sound; }
};

/// One closed loop of 25 s. `sound`: every input finite and within 1.
Recovery recover(const Scenario& scenario, const RecoveryStart& start) {
  const Team& team = scenario.team;
  const auto solver = make_solver(scenario.solver, team, scenario.horizon);
  std::vector<double> x = scenario.x0;
  x[7] = 0.5, x[8] = 0.0, x[9] = 1.0;
  const Vec2<double> ahead = {std::cos(start.heading), std::sin(start.heading)};
  Vec2<double> to_target = rotate(ahead, Vec2<double>{std::cos(start.bearing), std::sin(start.bearing)});
  if (start.bearing == std::numbers::pi) to_target = {-ahead.x, -ahead.y};
  const std::array<double, 7> observer = {x[7] - start.range * to_target.x,
                                          x[8] - start.range * to_target.y,
                                          x[9] + start.height,
                                          ahead.x,
                                          ahead.y,
                                          start.v_f,
                                          start.v_s};
  std::copy(observer.begin(), observer.end(), x.begin());
  const SensorMount mount{.pitch = 0.5, .offset = 0.17};
  Recovery result;
  const int updates = static_cast<int>(25.0 / scenario.horizon.dt);
  (void)fly(*solver, x, updates, [&](double t, const std::vector<double>& now, const Solution& solution) {
    for (const double u : solution.u) result.sound = result.sound && std::fabs(u) <= 1.0;
    const Pose<double> pose{{now[0], now[1], now[2]}, {now[3], now[4]}};
    const Vec3<double> target{now[7], now[8], now[9]};
    result.in_view_at_end = view_angle(mount, pose, target) <= 0.5;
    if (result.in_view_at_end) result.first_view = std::min(result.first_view, t);
    result.last_distance = norm(pose.p - target);
    result.least_distance = std::min(result.least_distance, result.last_distance);
  });
  return result;
}

struct RecoveryCount {
  int starts = 0, recovered = 0, unsound = 0;
  double last_view = 0.0;  ///< latest first view [s]
  std::string lost{};
};

RecoveryCount campaign(const std::string& scenario, TargetMotion motion) {
  const std::filesystem::path file =
      std::filesystem::path(SIGHTLINE_SOURCE_DIR) / "scenarios" / (scenario + ".toml");
  const Scenario flown = with_target(test::read_file(file), motion);
  Random random(7);
  RecoveryCount outcome{.starts = whole_campaign() ? 2000 : 100};
  for (int trial = 0; trial < outcome.starts; ++trial) {
    const RecoveryStart start = recovery_start(random, trial);
    const Recovery flight = recover(flown, start);
    outcome.recovered += flight.recovered();
    outcome.unsound += !flight.sound;
    outcome.last_view = std::max(outcome.last_view, flight.first_view);
    if (!flight.recovered()) {
      outcome.lost += fmt::format("{:.2f} m, bearing {:.4f} rad, {:.2f} m above\n", start.range,
                                  start.bearing, start.height);
    }
  }
  return outcome;
}

void PrintTo(TargetMotion motion, std::ostream* to) {
  *to << (motion == TargetMotion::at_rest ? "at_rest" : "circling");
}

class Recoveries : public testing::TestWithParam<TargetMotion> {};
INSTANTIATE_TEST_SUITE_P(Targets, Recoveries, testing::Values(TargetMotion::at_rest, TargetMotion::circling));

TEST_P(Recoveries, WithSlopesEveryStartEndsWithTheTargetInView) {
  const RecoveryCount outcome = campaign("cooperative_localization", GetParam());
  EXPECT_EQ(outcome.lost, "");
  EXPECT_EQ(outcome.unsound, 0);
  EXPECT_LE(outcome.last_view, 5.0);
  RecordProperty("first_view_at_most_ms", static_cast<int>(1000 * outcome.last_view));
}

TEST_P(Recoveries, WithThePapersPotentialsMostStartsLoseTheTarget) {
  const RecoveryCount outcome = campaign("paper_7_1", GetParam());
  RecordProperty("recovered", outcome.recovered);
  EXPECT_LT(outcome.recovered, outcome.starts * 6 / 10);
  EXPECT_GT(outcome.recovered, outcome.starts / 4);
  EXPECT_EQ(outcome.unsound, 0);
}

// The tie is broken: the ridge where left meets right is swept through, 165 to 175 degrees to the
// right.
TEST_P(Recoveries, NearTheRidgeBehindItTurnsAtOnceToo) {
  const Scenario flown = with_target(test::read_file(std::filesystem::path(SIGHTLINE_SOURCE_DIR) /
                                                     "scenarios/cooperative_localization.toml"),
                                     GetParam());
  Random random(8);
  const int starts = whole_campaign() ? 1000 : 50;
  for (int trial = 0; trial < starts; ++trial) {
    RecoveryStart start = recovery_start(random, trial);
    start.bearing = -(165.0 + 10.0 * trial / starts) * std::numbers::pi / 180;
    const Recovery flight = recover(flown, start);
    EXPECT_TRUE(flight.recovered()) << start.bearing;
    EXPECT_LE(flight.first_view, 5.0) << start.bearing;
  }
}

}  // namespace
}  // namespace sightline
