// More messages than any robot sends.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/dds/keys.hpp"
#include "tests/dds/rig.hpp"
#include "tests/support/campaign.hpp"

extern "C" {
#include "px4.h"
}

namespace sightline::dds {
namespace {

using testing::IsEmpty;

// By the network, from another program. The time of the control thread is judged where nothing else
// runs.
TEST(Flood, OfTenThousandMessagesASecondEachIsCountedAndTheFlightGoesOn) {
  constexpr int a_second = 10'000, seconds = 4;
  Rig rig(row_of({"1.16", "1.16"}, 7.0));
  std::int64_t sent = 0;
  const LoopOutcome outcome = rig.fly(1.0, [&] {
    const OtherProgram other(fleet_of(rig.scenario).network, Identity::flyer);
    Writer<px4_msgs_msg_dds__VehicleOdometry_> flood(other.participant(),
                                                     px4_msgs_msg_dds__VehicleOdometry__desc,
                                                     "/px4_0/fmu/out/vehicle_odometry", of_px4_output);
    while (flood.matched() == 0) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    const auto begin = std::chrono::steady_clock::now();
    px4_msgs_msg_dds__VehicleOdometry_ m{};
    m.pose_frame = m.velocity_frame = px4_frame_ned;
    m.q[0] = 1;
    for (int k = 0; k < 1000 * seconds; ++k) {
      std::this_thread::sleep_until(begin + k * std::chrono::milliseconds(1));
      for (int i = 0; i < a_second / 1000; ++i) sent += flood(m) ? 1 : 0;
    }
  });
  EXPECT_TRUE(outcome.finite) << fmt::format("{}", fmt::join(rig.reported, "\n"));
  EXPECT_THAT(rig.world->faults(), IsEmpty());
  EXPECT_EQ(outcome.max_allocations, 0);
  expect_well_treated(rig);
  const std::string counts = rig.counted("uav0: ");
  const std::size_t end = counts.find(" of a second writer");
  ASSERT_NE(end, std::string::npos) << counts;
  const std::int64_t counted = std::stoll(counts.substr(counts.rfind(' ', end - 1)));
  EXPECT_GT(sent, 9 * a_second * seconds / 10);
  EXPECT_LE(counted, sent);
  const double missed =
      100.0 * static_cast<double>(outcome.missed) / static_cast<double>(outcome.missed + outcome.updates);
  fmt::print("flood: {} of {} messages counted, {:.2f} % of the periods missed\n", counted, sent, missed);
  if (!whole_campaign()) return;
  EXPECT_GT(counted, sent / 2);
  EXPECT_LE(missed, 2.0);
}

}  // namespace
}  // namespace sightline::dds
