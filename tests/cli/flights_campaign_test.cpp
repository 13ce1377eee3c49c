#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sightline/log.hpp"
#include "tests/support/campaign.hpp"
#include "tests/support/command.hpp"

namespace sightline {
namespace {

Recording flown(const std::string& scenario, const std::string& options = "") {
  const auto folder = test::fresh_folder();
  const auto run = test::sightline(
      "run scenarios/" + scenario + ".toml " + options + " -o " + (folder / "out").string(), folder);
  EXPECT_EQ(run.code, 0) << run.err;
  return read_recording(folder / "out");
}

// 7.2: both nearer their limits than in 7.1, but within them.
TEST(Flights, Paper72KeepsDistanceAndViewOnEverySeed) {
  for (int seed = 1; seed <= runs(20, 4); ++seed) {
    const Recording r = flown("paper_7_2", "--seed " + std::to_string(seed));
    const Recording::Pair& pair = r.pairs.at(0);
    const Recording::Body &observer = r.bodies[pair.observer], &target = r.bodies[pair.target];
    double nearest = 1e9, farthest = 0.0;
    int late = 0, seen = 0;
    for (std::size_t k = 0; k < r.time.size(); ++k) {
      const double D = norm(observer.p[k] - target.p[k]), psi = observer.heading[k];
      if (r.time[k] >= 6) {
        nearest = std::min(nearest, D);
        farthest = std::max(farthest, D);
      }
      if (r.time[k] < 25) continue;
      ++late;
      const Pose<double> pose{observer.p[k], {std::cos(psi), std::sin(psi)}};
      seen += view_angle(pair.mount, pose, target.p[k]) <= pair.alpha;
    }
    EXPECT_GE(nearest, 0.9) << "seed " << seed;
    EXPECT_LE(farthest, 2.1) << "seed " << seed;
    EXPECT_GE(seen, 0.95 * late) << "seed " << seed;
  }
}

// Figs 4 and 6: the angle jumps at pi and the robot turns on; the direction vector knows no such
// place.
TEST(Flights, TheAngleModelSpinsAndTheDirectionVectorSettles) {
  const Recording r = flown("yaw_step");
  const Recording::Body &angle = r.bodies.at(0), &direction = r.bodies.at(1);
  const auto at = [&](double t) {
    return static_cast<std::size_t>(std::lower_bound(r.time.begin(), r.time.end(), t - 1e-9) -
                                    r.time.begin());
  };
  EXPECT_GT(angle.heading.back() - angle.heading[at(2.8)], 2 * std::numbers::pi);
  // Until the horizon sees the next step, at 8 s.
  for (std::size_t k = at(5.8); k < at(7.0); ++k) {
    EXPECT_NEAR(direction.heading[k], std::numbers::pi, 0.1) << r.time[k];
  }
}

}  // namespace
}  // namespace sightline
