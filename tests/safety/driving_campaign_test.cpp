#include <gtest/gtest.h>

#include "tests/support/campaign.hpp"
#include "tests/support/driving.hpp"

namespace sightline {
namespace {

TEST(DrivingCampaign, TheSafeSetOfRobotsThatDriveIsLeftByNoSample) {
  const test::OneStep found = test::one_steps(runs(200000, 20), 17);
  std::printf(
      "states near the boundary: least reserve less what was asked %.9f m, least distance %.6f m beyond\n",
      found.least_reserve, found.least_distance);
  EXPECT_GE(found.least_reserve, -1e-7);
  EXPECT_GE(found.least_distance, 0.0);
  EXPECT_EQ(found.conflicts, 0);
}

TEST(DrivingCampaign, NoRobotDrivesIntoAnotherOrARockAndAllStandBeforeAPursuerIsNear) {
  for (const double dt : {0.01, 0.1, 0.5}) {
    for (const int rovers : {2, 6, 12}) {
      double nearest = infinity, fastest = 0.0, travelled = 0.0, unfiltered = infinity;
      int conflicts = 0, below = 0;
      const int count = runs(800, 20) / rovers;
      for (int i = 0; i < count; ++i) {
        test::Drive drive{.rovers = rovers, .pursuers = i % 2 == 0 ? 0 : 3, .duration = 20.0, .dt = dt};
        const test::DriveOutcome on = test::drive_among(drive, static_cast<std::uint64_t>(i));
        nearest = std::min(nearest, on.nearest);
        below += on.nearest < on.d_hard;
        fastest = std::max(fastest, on.fastest_when_near);
        travelled += on.travelled / count;
        conflicts += drive.pursuers == 0 ? on.conflicts : 0;
        drive.filtered = false;
        unfiltered = std::min(unfiltered, test::drive_among(drive, static_cast<std::uint64_t>(i)).nearest);
      }
      std::printf(
          "%2d rovers, period %.2f s: runs %d, below %d, nearest %.4f m (off: %.4f m), speed with a pursuer "
          "within "
          "d_hard %.1e m/s, driven %.1f m\n",
          rovers, dt, count, below, nearest, unfiltered, fastest, travelled);
      EXPECT_EQ(below, 0);
      EXPECT_EQ(conflicts, 0);
      EXPECT_LE(fastest, 1e-5);
      EXPECT_GT(travelled, 0.5);
    }
  }
}

}  // namespace
}  // namespace sightline
