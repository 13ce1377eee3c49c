#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "sightline/barrier.hpp"
#include "tests/support/adversary.hpp"
#include "tests/support/campaign.hpp"
#include "tests/support/period.hpp"

namespace sightline {
namespace {

using test::control_period;
using test::Duel;
using test::DuelOutcome;
using test::Nominal;
using test::Pursuit;

Barrier barrier_of_duels() { return test::barrier({.floor = 0.3, .world = 100.0}); }

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
        "%-28s runs %d, below 1 m %d, worst %.4f m, 0.1 %% %.4f m, median %.3f m; lowest %.4f m, farthest "
        "%.1f m\n",
        what, count, below, worst, nearest[nearest.size() / 1000], nearest[nearest.size() / 2], floor,
        farthest);
    if (reserve < 1e6) {
      std::printf("%-28s least reserve %.6f m, runs with a conflict %d\n", "", reserve, with_conflict);
    }
  }
};

Summary campaign(Duel duel, int count, std::uint64_t seed) {
  const Barrier filter = barrier_of_duels();
  Summary summary;
  for (int i = 0; i < count; ++i) {
    duel.nominal = static_cast<Nominal>(i % 4);
    duel.pursuit = static_cast<Pursuit>(i / 4 % 3);
    summary.add(test::duel(filter, duel, seed + static_cast<std::uint64_t>(i)));
  }
  return summary;
}

void expect_all_kept(const Summary& on) {
  EXPECT_EQ(on.below, 0);
  EXPECT_EQ(on.with_conflict, 0);
  EXPECT_GE(on.reserve, -1e-3);
  EXPECT_GE(on.floor, 0.3 - 1e-9);
  EXPECT_LE(on.command, 1.0);
  EXPECT_TRUE(on.finite);
}

TEST(BarrierCampaign, NoAdversaryInThePlaneOrInSpaceComesBelowTheHardDistance) {
  for (const bool spatial : {false, true}) {
    const std::string where = spatial ? "space" : "plane";
    SCOPED_TRACE(where);
    Summary on = campaign({.spatial = spatial}, runs(20000, 40), 1);
    on.print((where + ", barrier on").c_str());
    campaign({.spatial = spatial, .filtered = false}, runs(20000, 40), 1)
        .print((where + ", barrier off").c_str());
    expect_all_kept(on);
  }
}

TEST(BarrierCampaign, NorFromAnyVelocityAtWhichItCanStillFlee) {
  Summary on = campaign({.spatial = true, .moving = true}, runs(20000, 40), 1);
  on.print("space, moving, barrier on");
  EXPECT_EQ(on.below, 0);
}

// One sample ahead of states near the boundary, with hostile commands and the worst neighbour.
TEST(BarrierCampaign, TheSafeSetIsLeftByNoSample) {
  const Barrier filter = barrier_of_duels();
  Random random(7);
  const int count = runs(1000000, 40);
  double worst = 1e9, violation = 0.0;
  for (int k = 0; k < count; ++k) {
    const double psi = uniform(random, -3.2, 3.2);
    test::State x = {0,
                     0,
                     uniform(random, 0.5, 3),
                     std::cos(psi),
                     std::sin(psi),
                     uniform(random, -2.5, 2.5),
                     uniform(random, -2.5, 2.5)};
    Neighbour n{.d_hard = uniform(random, 0.4, 1.2), .speed_max = uniform(random, 0.0, 1.5)};
    const Vec3<double> direction = test::any_direction(random, true), p = {0, 0, x[2]};
    const double wanted = k % 2 == 0 ? 0.0 : uniform(random, 0.0, 0.05);
    double near = 0.1, far = 30.0;
    for (int i = 0; i < 40; ++i) {
      const double middle = 0.5 * (near + far);
      n.p = p + middle * direction;
      (filter.reserve(x, n) < wanted ? near : far) = middle;
    }
    n.p = p + far * direction;
    const double before = filter.reserve(x, n);
    test::VehicleInput u = k % 3 == 0 ? test::towards(x, n.p) : uniform_array<4>(random, -1, 1);
    violation =
        std::max(violation, filter.filter(x, std::span(&n, 1), test::lowest, test::highest, u).violation);
    test::fly(Multirotor{}, x, u, control_period, [](const Vec3<double>&, double) {});
    const Vec3<double> r = Vec3<double>{x[0], x[1], x[2]} - n.p;
    n.p = n.p + (control_period * n.speed_max / norm(r)) * r;
    worst = std::min(worst, filter.reserve(x, n) - (1 - filter.options().rate * control_period) * before);
  }
  std::printf(
      "states near the boundary %d: least reserve less what was asked %.7f m, largest violation %.7f m\n",
      count, worst, violation);
  EXPECT_GE(worst, -1e-3);
  EXPECT_LE(violation, 5e-3);
}

TEST(BarrierCampaign, RobotsThatAllFilterNeverComeBelowTheHardDistance) {
  const Barrier filter = barrier_of_duels();
  for (const int robots : {2, 3, 4, 8}) {
    for (const auto nominal : {test::Swarm::Nominal::at_each_other, test::Swarm::Nominal::random,
                               test::Swarm::Nominal::antipodal}) {
      test::Swarm swarm{.robots = robots, .nominal = nominal};
      double nearest = 1e9, unfiltered = 1e9, travelled = 0.0, violation = 0.0;
      int below = 0, conflicts = 0;
      const int count = runs(2000, 40) / robots;
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
