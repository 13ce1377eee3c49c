// Section 7.3: ten flights in which an obstacle carried by hand comes at uav0 and follows it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/support/campaign.hpp"
#include "tests/support/command.hpp"
#include "tests/support/evasion.hpp"

namespace sightline {
namespace {

Scenario shipped(const std::string& name) {
  return read_scenario(std::filesystem::path(SIGHTLINE_SOURCE_DIR) / "scenarios" / (name + ".toml"));
}

int flights() { return whole_campaign() ? 500 : 10; }

TEST(Evasions, OurPotentialsKeepBothDistancesAndTheViewOnceItIsThere) {
  const Scenario scenario = shipped("paper_7_3_ours");
  Random random(1);
  for (int run = 0; run < flights(); ++run) {
    const EvasionRow row = evade(with_drawn_start(scenario, random, 0.3)).row();
    EXPECT_GE(row.min_obstacle, 1.0) << run;
    EXPECT_GE(row.min_target, 0.7) << run;
    EXPECT_LE(row.max_target, 2.0) << run;
    EXPECT_LE(row.first_view, 2.0) << run;
    EXPECT_EQ(row.lost, 0.0) << run;
  }
}

// As printed: no state cost, soft limits. The distance to the target holds, that to the obstacle
// need not.
TEST(Evasions, ThePapersPotentialsKeepTheTargetAndLetTheObstacleUpToItsStandoff) {
  const Scenario scenario = shipped("paper_7_3");
  Random random(1);
  int too_near = 0;
  for (int run = 0; run < flights(); ++run) {
    const EvasionRow row = evade(with_drawn_start(scenario, random, 0.3)).row();
    EXPECT_GE(row.min_target, 0.7) << run;
    EXPECT_LE(row.max_target, 2.1) << run;
    EXPECT_GE(row.min_obstacle, 0.5) << run;
    EXPECT_LE(row.max_angle, 0.8) << run;
    too_near += row.min_obstacle < 1.0;
  }
  EXPECT_GT(too_near, 0);
}

// The hand turns the robot round its target: the arc of Fig. 26.
TEST(Evasions, FollowedByTheHandTheRobotCirclesTheTargetFacingIt) {
  for (const char* name : {"paper_7_3", "paper_7_3_ours"}) {
    const EvasionSeries series = evade(shipped(name)).series();
    double swept = 0.0;
    for (std::size_t k = 151; k < series.time.size(); ++k) {
      const auto azimuth = [&](std::size_t i) {
        const Vec3<double> r = series.p[i] - series.target[i];
        return std::atan2(r.y, r.x);
      };
      swept += std::remainder(azimuth(k) - azimuth(k - 1), 2 * std::numbers::pi);
    }
    EXPECT_GT(std::fabs(swept), 1.5 * std::numbers::pi) << name;
  }
}

TEST(Evasions, TheCampaignOfOursBesideThePapersPrintsTheirTables) {
  const auto folder = test::fresh_folder();
  const auto run = test::sightline(
      "campaign scenarios/paper_7_3_ours.toml --compare-with scenarios/paper_7_3.toml --runs "
      "10 -o " +
          (folder / "out").string(),
      folder);
  EXPECT_EQ(run.code, 0) << run.err;
  for (const char* words : {"min d_O [m]", "published", "paper_7_3_ours", "max alpha_t,ns [rad]"})
    EXPECT_NE(run.out.find(words), std::string::npos) << words;
  const std::string page = test::read_file(folder / "out/campaign.html");
  EXPECT_NE(page.find("paper_7_3_ours: paths from above (Fig. 26)"), std::string::npos);
  EXPECT_NE(page.find("paper_7_3: inputs of uav0 (Fig. 32)"), std::string::npos);
}

}  // namespace
}  // namespace sightline
