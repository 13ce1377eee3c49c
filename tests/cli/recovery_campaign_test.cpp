// Wherever the observer starts and looks, it finds its target and keeps it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/support/campaign.hpp"
#include "tests/support/command.hpp"
#include "tests/support/recovery.hpp"

namespace sightline {
namespace {

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

// The tie is broken: the ridge where left meets right is swept through, 165 to 175 degrees to the right.
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
