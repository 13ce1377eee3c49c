#include "sightline/analysis/localization/localize_team.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sightline/analysis/localization/identify_noise.hpp"
#include "tests/support/recorded_team.hpp"

namespace sightline {
namespace {

using test::RecordedTeam;

RecordedTeam short_team(std::uint64_t seed) { return {.noise = test::noise_of_recordings(), .seed = seed}; }

TeamLocalization localized(const TeamRecording& recording, TeamRun run = {}) {
  run.noise = recording.noise;
  return localize_team(recording, run);
}

/// Estimates of a run, in the order of their times.
struct KeptEstimates final : TeamEstimates {
  std::vector<std::vector<PlanarPose>> poses;
  void estimate(double, int robot, const PoseGuess& pose, const std::optional<PlanarPose>&) override {
    poses.resize(std::max(poses.size(), static_cast<std::size_t>(robot) + 1));
    poses[static_cast<std::size_t>(robot)].push_back(pose.pose);
  }
  void fit(const TeamSighting&, const TeamFit&) override {}
};

double farthest(const std::vector<PlanarPose>& a, const std::vector<PlanarPose>& b) {
  if (a.size() != b.size()) return infinity;
  double most = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) most = std::max(most, norm(a[k].x - b[k].x, a[k].y - b[k].y));
  return most;
}

TEST(LocalizeTeam, IsConsistentWithErrorsThatLast) {
  double anees = 0.0, rmse = 0.0;
  const int teams = 12;
  for (std::uint64_t seed = 1; seed <= teams; ++seed) {
    const TeamLocalization result = localized(recorded(short_team(seed)));
    anees += result.anees / teams, rmse += result.rmse / teams;
  }
  EXPECT_GE(anees, 0.8 * 3);
  EXPECT_LE(anees, 1.25 * 3);
  EXPECT_LE(rmse, 0.15);
}

TEST(LocalizeTeam, ItsInnovationsAreWhiteAndOfTheSizeItExpects) {
  double range = 0.0, bearing = 0.0, correlated = 0.0;
  const int teams = 6;
  for (std::uint64_t seed = 1; seed <= teams; ++seed) {
    const TeamLocalization result = localized(recorded(short_team(seed)));
    for (const auto& robot : result.robots) {
      range += robot.range.mean_square / (3 * teams), bearing += robot.bearing.mean_square / (3 * teams);
      correlated += robot.range.autocorrelation.front().value / (3 * teams);
    }
  }
  EXPECT_NEAR(range, 1.0, 0.15);
  EXPECT_NEAR(bearing, 1.0, 0.15);
  EXPECT_NEAR(correlated, 0.0, 0.1);
}

TEST(LocalizeTeam, LastingErrorsTakenForWhiteNoiseShowInTheInnovations) {
  TeamRecording recording = recorded(short_team(2));
  TeamNoise& white = recording.noise;
  white.range_share = std::hypot(white.range_share, white.range_error), white.range_error = 0.0;
  const TeamLocalization result = localized(recording);
  for (const auto& robot : result.robots) {
    EXPECT_FALSE(robot.range.is_white());
    EXPECT_GE(robot.range.correlation_time(), 0.3);
  }
}

TEST(LocalizeTeam, ADepthTakenForADistanceIsOverconfident) {
  TeamNoise camera = test::noise_of_recordings();
  camera.range_depth = 1.0;
  double distance = 0.0, depth = 0.0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    TeamRecording recording = recorded(RecordedTeam{.noise = camera, .seed = seed});
    depth += localized(recording).anees / 8;
    recording.noise.range_depth = 0.0;
    distance += localized(recording).anees / 8;
  }
  EXPECT_LE(depth, 1.3 * 3);
  EXPECT_GE(distance, 1.2 * depth);
}

TEST(LocalizeTeam, NumbersOfRobotsChangeNothing) {
  RecordedTeam of = short_team(3);
  of.staggered = true;
  const TeamRecording recording = recorded(of);
  const std::array<int, 3> to = {2, 0, 1};
  TeamRecording other = recording;
  for (std::size_t i = 0; i < 3; ++i) other.robots[static_cast<std::size_t>(to[i])] = recording.robots[i];
  for (TeamSighting& z : other.sightings) {
    z.observer = to[static_cast<std::size_t>(z.observer)];
    if (z.subject < 3) z.subject = to[static_cast<std::size_t>(z.subject)];
  }
  const TeamRun run{.sees_robots = {false, false, false}, .start_known = false, .noise = of.noise};
  KeptEstimates a, b;
  localize_team(recording, run, &a);
  localize_team(other, run, &b);
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_LE(farthest(a.poses[i], b.poses[static_cast<std::size_t>(to[i])]), 1e-6) << i;
}

TEST(LocalizeTeam, AShiftOfAllStampsChangesNothing) {
  RecordedTeam of = short_team(4);
  const TeamLocalization a = localized(recorded(of));
  of.start = 1'048'576.0;
  const TeamLocalization b = localized(recorded(of));
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t k = 0; k < robot_states; ++k)
      EXPECT_NEAR(a.robots[i].states[k], b.robots[i].states[k], 1e-3) << i << " " << k;
}

TEST(LocalizeTeam, EqualRunsGiveEqualBits) {
  const TeamRecording recording = recorded(short_team(5));
  EXPECT_EQ(localized(recording).cost, localized(recording).cost);
  EXPECT_NE(localized(recording, {.seed = 2}).cost, localized(recording).cost);
}

TEST(LocalizeTeam, FindsUnknownStartsFromLandmarks) {
  const TeamLocalization result = localized(recorded(short_team(6)), {.start_known = false});
  for (const auto& robot : result.robots) {
    EXPECT_GE(robot.located, 1U);
    EXPECT_GE(robot.samples, 300U);
    EXPECT_LE(robot.rmse, 0.3);
  }
}

TEST(LocalizeTeam, AnAnchorLocalizesRobotsThatSeeRobotsAlone) {
  RecordedTeam of = short_team(7);
  of.seconds = 120.0;
  const TeamRecording recording = recorded(of);
  TeamRun run{.sees_landmarks = {false, false, false}, .anchor = 0};
  const TeamLocalization seeing = localized(recording, run);
  run.sees_robots = {false, false, false};
  const TeamLocalization blind = localized(recording, run);
  EXPECT_LE(seeing.rmse_without_anchor, 0.5 * blind.rmse_without_anchor);
  EXPECT_LE(seeing.robots[0].rmse, 0.05);
}

TEST(LocalizeTeam, IgnoredIdentitiesCostLittle) {
  double known = 0.0, unknown = 0.0;
  for (std::uint64_t seed = 8; seed <= 11; ++seed) {
    const TeamRecording recording = recorded(short_team(seed));
    known += localized(recording).rmse, unknown += localized(recording, {.identities = false}).rmse;
  }
  EXPECT_LE(unknown, 1.3 * known);
}

TEST(IdentifyNoise, IsAsLikelyAsTheDrawnNoiseFromAnyFactor) {
  RecordedTeam of = short_team(12);
  of.robots = 1, of.seconds = 120.0;
  const TeamRecording recording = recorded(of);
  TeamRun run{.noise = of.noise};
  run.noise.range_share *= 3, run.noise.bearing_noise /= 3;
  const IdentifiedNoise found = identify_noise(recording, run);
  EXPECT_LT(found.cost, found.cost_before - 10);
  EXPECT_LE(found.cost, localized(recording).cost + 10) << "as likely as the noise that was drawn";
  // White noise and lasting errors that are short are much the same.
  const double found_sigma = std::hypot(found.noise.bearing_noise, found.noise.bearing_error);
  EXPECT_NEAR(found_sigma / std::hypot(of.noise.bearing_noise, of.noise.bearing_error), 1.0, 0.4);
  EXPECT_EQ(found.noise.speed_scale, of.noise.speed_scale);
}

}  // namespace
}  // namespace sightline
