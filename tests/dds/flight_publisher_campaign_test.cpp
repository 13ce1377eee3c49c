// What it costs to be seen, with 16 vehicles and somebody who looks at all of it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>

#include "tests/dds/rig.hpp"

extern "C" {
#include "ros.h"
}

namespace sightline::dds {
namespace {

TEST(TopicsOutCampaign, SixteenVehiclesAreShownForAFewPercentOfACore) {
  std::string pairs;
  for (int i = 0; i < 15; ++i)
    pairs += fmt::format(
        "[agent.uav{0}.sensor]\npitch = 0.1\n[[couple]]\npotential = {{ sensor_cone = {{ alpha = 0.5 }} "
        "}}\nbetween = [\"uav{0}\", \"uav{1}\"]\n"
        "felt_by = [\"uav{0}\"]\nweight = 0.001\n",
        i, i + 1);
  Rig rig(row_of(Fields(16, "1.16"), 20.0, pairs));
  const dds_entity_t at = rig.domain->another_participant();
  std::atomic<int> poses{0}, markers{0};
  std::vector<std::unique_ptr<RawReader>> readers;
  for (int i = 0; i < 16; ++i)
    readers.push_back(std::make_unique<RawReader>(
        at, geometry_msgs_msg_dds__PoseStamped__desc, fmt::format("/sightline/uav{}/pose", i), of_shown,
        std::nullopt, Writers::all, [&](const void*, const Arrival&) { ++poses; }));
  readers.push_back(std::make_unique<RawReader>(at, visualization_msgs_msg_dds__MarkerArray__desc,
                                                "/sightline/markers", of_shown, std::nullopt, Writers::all,
                                                [&](const void*, const Arrival&) { ++markers; }));
  const LoopOutcome outcome = rig.fly();
  EXPECT_TRUE(outcome.finite) << fmt::format("{}", fmt::join(rig.reported, "\n"));
  EXPECT_EQ(outcome.max_allocations, 0);
  EXPECT_GT(poses, 16 * 500);
  EXPECT_GT(markers, 150);
  const std::string counted = rig.counted(" messages for others, ");
  std::smatch share;
  ASSERT_TRUE(std::regex_search(counted, share, std::regex("([0-9.]+) % of a core")));
  EXPECT_LT(std::stod(share[1]), 15.0);
}

}  // namespace
}  // namespace sightline::dds
