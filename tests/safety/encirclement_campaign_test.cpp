#include <gtest/gtest.h>

#include <string>

#include "tests/support/campaign.hpp"
#include "tests/support/encirclement.hpp"

namespace sightline {
namespace {

TEST(EncirclementCampaign, TheDistanceIsKeptWhereThereIsAWayOutAndTheFloorAlways) {
  const Barrier filter = test::barrier_of_encirclements();
  const int count = runs(300, 20);
  int ways = 0, kept = 0;
  double worst = 1e9, below_off = 0.0;
  std::array<int, 7> flown{}, safe{};
  for (int i = 0; i < count; ++i) {
    const test::Encirclement e = test::any_encirclement(static_cast<std::uint64_t>(i));
    const test::Fate on = test::fly_filtered(filter, e);
    const bool way = test::has_maneuver(e), whole = on.nearest >= e.d_hard;
    ways += way;
    kept += whole;
    worst = std::min(worst, on.nearest);
    ++flown[e.pursuers.size()];
    safe[e.pursuers.size()] += whole;
    EXPECT_GE(on.lowest, e.floor - 1e-9) << "encirclement " << i;
    EXPECT_LE(on.largest_command, 1.0);
    if (way) {
      EXPECT_GE(on.nearest, e.d_hard) << "encirclement " << i;
    }
    if (whole) continue;
    EXPECT_LE(on.reported, on.broken) << "encirclement " << i;
    const double off = test::fly_wish(e).nearest;
    below_off = std::max(below_off, off - on.nearest);
    EXPECT_GE(on.nearest, off - 0.01) << "encirclement " << i;
  }
  std::printf(
      "encirclements %d: with a way out %d, kept %d, worst %.4f m, at most %.4f m below that with the "
      "barrier "
      "off\n",
      count, ways, kept, worst, below_off);
  for (std::size_t n = 2; n < flown.size(); ++n)
    std::printf("%zu pursuers: %d of %d kept\n", n, safe[n], flown[n]);
  EXPECT_GE(3 * ways, 2 * count);
}

TEST(EncirclementCampaign,
     UncooperativeOnesThatTurnAtWillNeverComeBelowTheHardDistanceWhileAPlanIsSafeFromAll) {
  const Barrier filter = test::barrier_of_encirclements();
  const int count = runs(2000, 20);
  int flown = 0, conflicts = 0;
  double worst = 1e9, lowest = 1e9;
  for (int i = 0; i < count; ++i) {
    const test::Encirclement e = test::any_adversaries(static_cast<std::uint64_t>(i));
    if (!test::is_safe_from_all(filter, e)) continue;
    ++flown;
    const test::Fate on = test::fly_filtered(filter, e);
    worst = std::min(worst, on.nearest - e.d_hard);
    lowest = std::min(lowest, on.lowest);
    conflicts += std::isfinite(on.reported);
  }
  std::printf(
      "several adversaries, where a plan is safe from all: runs %d, least distance %.4f m above d_hard, "
      "lowest %.4f m, runs with a conflict %d\n",
      flown, worst, lowest, conflicts);
  EXPECT_GE(2 * flown, count / 2);
  EXPECT_GE(worst, 0.0);
  EXPECT_GE(lowest, 0.3 - 1e-9);
  EXPECT_LE(50 * conflicts, flown);
}

}  // namespace
}  // namespace sightline
