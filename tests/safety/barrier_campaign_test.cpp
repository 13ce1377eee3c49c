#include <gtest/gtest.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "sightline/safety/barrier.hpp"
#include "tests/support/adversary.hpp"

namespace sightline {
namespace {

using test::Duel;
using test::DuelOutcome;
using test::Nominal;
using test::Pursuit;

constexpr double dt = 0.01;

int runs(int whole) {
  const char* campaign = std::getenv("SIGHTLINE_CAMPAIGN");
  return campaign != nullptr && std::string(campaign) == "whole" ? whole : whole / 20;
}

Barrier barrier() {
  return Barrier(Multirotor{}, test::lowest, test::highest, dt, {.floor = 0.3, .world = 100.0});
}

struct Summary {
  int count = 0, below = 0, with_conflict = 0;
  double worst = 1e9, floor = 1e9, reserve = 1e9, command = 0, farthest = 0;
  std::vector<double> nearest{};
  bool finite = true;

  void add(const DuelOutcome& o) {
    ++count;
    below += o.nearest < 1.0;
    with_conflict += o.conflicts > 0;
    worst = std::min(worst, o.nearest);
    floor = std::min(floor, o.lowest);
    reserve = std::min(reserve, o.least_reserve);
    command = std::max(command, o.largest_command);
    farthest = std::max(farthest, o.farthest);
    nearest.push_back(o.nearest);
    finite = finite && o.finite;
  }
  void print(const char* what) {
    std::sort(nearest.begin(), nearest.end());
    std::printf(
        "%-40s runs %d, below 1 m %d, worst %.4f m, 0.1 %% %.4f m, median %.3f m; least reserve %.5f m, "
        "lowest %.4f m, farthest %.1f m, runs with a conflict %d\n",
        what, count, below, worst, nearest[nearest.size() / 1000], nearest[nearest.size() / 2], reserve,
        floor, farthest, with_conflict);
  }
};

Summary campaign(Duel duel, int count, std::uint64_t seed) {
  const Barrier filter = barrier();
  Summary summary;
  for (int i = 0; i < count; ++i) {
    duel.nominal = static_cast<Nominal>(i % 4);
    duel.pursuit = static_cast<Pursuit>(i / 4 % 3);
    summary.add(test::duel(filter, duel, seed + static_cast<std::uint64_t>(i)));
  }
  return summary;
}

TEST(BarrierCampaign, NoAdversaryInThePlaneComesBelowTheHardDistance) {
  Summary on = campaign({}, runs(20000), 1);
  on.print("plane, barrier on");
  campaign({.filtered = false}, runs(20000), 1).print("plane, barrier off");
  EXPECT_EQ(on.below, 0);
  EXPECT_GE(on.floor, 0.3 - 1e-9);
  EXPECT_LE(on.command, 1.0);
  EXPECT_TRUE(on.finite);
}

TEST(BarrierCampaign, NoAdversaryInSpaceComesBelowTheHardDistance) {
  Summary on = campaign({.spatial = true}, runs(20000), 1);
  on.print("space, barrier on");
  campaign({.spatial = true, .filtered = false}, runs(20000), 1).print("space, barrier off");
  EXPECT_EQ(on.below, 0);
  EXPECT_GE(on.floor, 0.3 - 1e-9);
  EXPECT_LE(on.command, 1.0);
  EXPECT_TRUE(on.finite);
}

TEST(BarrierCampaign, NorFromAnyVelocityAtWhichItCanStillFlee) {
  Summary on = campaign({.spatial = true, .moving = true}, runs(20000), 1);
  on.print("space, moving, barrier on");
  EXPECT_EQ(on.below, 0);
}

TEST(BarrierCampaign, RobotsThatAllFilterNeverComeBelowTheHardDistance) {
  const Barrier filter = barrier();
  for (const int robots : {2, 3, 4, 8}) {
    for (const auto nominal : {test::Swarm::Nominal::at_each_other, test::Swarm::Nominal::random,
                               test::Swarm::Nominal::antipodal}) {
      test::Swarm swarm{.robots = robots, .nominal = nominal};
      double nearest = 1e9, unfiltered = 1e9, travelled = 0.0, violation = 0.0;
      int below = 0, conflicts = 0;
      const int count = runs(2000) / robots;
      for (int i = 0; i < count; ++i) {
        swarm.filtered = true;
        swarm.head_on = robots == 2 && i % 2 == 0;
        const test::SwarmOutcome on = test::fly_swarm(filter, swarm, static_cast<std::uint64_t>(i));
        nearest = std::min(nearest, on.nearest);
        below += on.nearest < swarm.d_hard;
        conflicts += on.conflicts > 0;
        violation = std::max(violation, on.violation);
        travelled += on.travelled / count;
        EXPECT_LE(on.largest_command, 1.0);
        swarm.filtered = false;
        unfiltered =
            std::min(unfiltered, test::fly_swarm(filter, swarm, static_cast<std::uint64_t>(i)).nearest);
      }
      std::printf(
          "%d robots, nominal %d: runs %d, below 0.6 m %d, worst %.4f m (off: %.4f m), at their goals %.2f, "
          "runs with a "
          "conflict %d, largest violation %.5f m\n",
          robots, static_cast<int>(nominal), count, below, nearest, unfiltered, travelled, conflicts,
          violation);
      if (robots == 2) {
        EXPECT_EQ(below, 0);
        EXPECT_EQ(conflicts, 0);
      }
    }
  }
}

}  // namespace
}  // namespace sightline
