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

}  // namespace
}  // namespace sightline
