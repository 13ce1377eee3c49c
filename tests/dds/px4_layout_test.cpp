#include "bridges/dds/links/px4_layout.hpp"

#include <gtest/gtest.h>

#include "bridges/dds/links/px4_release.hpp"
#include "tests/support/refusal.hpp"

extern "C" {
#include "px4.h"
}

namespace sightline::dds {
namespace {

TEST(Px4Layout, FieldsAreWhereTheCompilerPutsThem) {
  px4_msgs_msg_dds__BatteryStatus_17_ battery{};
  battery.remaining = 0.75F, battery.warning = 2, battery.id = 9;
  const Px4Layout layout("BatteryStatus", 18);
  EXPECT_EQ(layout.size(), 176u);
  EXPECT_EQ(read_at<float>(&battery, layout.place("remaining")), 0.75F);
  EXPECT_EQ(read_at<std::uint8_t>(&battery, layout.place("warning")), 2);
  EXPECT_EQ(read_at<std::uint8_t>(&battery, layout.place("id")), 9);
  Px4Message filled(layout);
  filled.set("remaining", 0.5F);
  EXPECT_EQ(static_cast<const px4_msgs_msg_dds__BatteryStatus_17_*>(filled.data())->remaining, 0.5F);
}

TEST(Px4Layout, EachReleaseHasAllThatAVehicleSaysBeside) {
  for (int release = px4_first; release <= px4_last; ++release) {
    for (const char* message :
         {"VehicleStatus", "VehicleLocalPosition", "VehicleOdometry", "FailsafeFlags", "BatteryStatus",
          "VehicleCommand", "OffboardControlMode", "TrajectorySetpoint", "SensorCombined"})
      EXPECT_EQ(Px4Layout(message, release).size(), *payload_size(px4_type(message, release))) << message;
    EXPECT_TRUE(Px4Layout("FailsafeFlags", release).has("manual_control_signal_lost"));
    EXPECT_TRUE(Px4Layout("BatteryStatus", release).has("remaining"));
  }
  EXPECT_FALSE(Px4Layout("FailsafeFlags", 14).has("gnss_lost"));
  EXPECT_EQ(refusal_of([] { (void)Px4Layout("BatteryStatus", 16).place("gnss_lost"); }),
            "px4_msgs::msg::dds_::BatteryStatus_16_ has no field gnss_lost");
}

}  // namespace
}  // namespace sightline::dds
