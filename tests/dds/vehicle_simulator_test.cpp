#include "bridges/dds/simulators/vehicle_simulator.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/dds/rig.hpp"
#include "tests/support/child.hpp"

extern "C" {
#include "px4.h"
}

namespace sightline::dds {
namespace {

using testing::HasSubstr;

std::string fault(std::string_view text) {
  return fmt::format("[[fleet.fault]]\nrobot = \"uav0\"\n{}", text);
}

TEST(VehicleSimulator, FaultsOfTheFileBeginAndEndInTheirTime) {
  const Scenario scenario = row_of({"1.16"}, 1.0,
                                   fault("kind = \"drop\"\nat = 0.1\nduration = 0.2\nsize = 1.0\n") +
                                       fault("kind = \"battery_low\"\nat = 0.0\n") +
                                       fault("kind = \"pilot\"\nsince = \"flight\"\nat = 0.0\n"));
  DdsVehicleSimulators vehicle_simulators(scenario, std::make_shared<Domain>(fleet_of(scenario).network));
  EXPECT_TRUE(vehicle_simulators.faults(0).on(Kind::battery_low)) << "from the first message on";
  Fields reported;
  const Interrupts never{0};
  vehicle_simulators.run(0.5, never, [&](std::string_view sentence) { reported.emplace_back(sentence); });
  EXPECT_EQ(reported, (Fields{"uav0: drop begins", "uav0: drop ends"})) << "it was never steered";
  // 20 poses, 40 of its IMU, a status, 2 of each slow message; the same each time.
  EXPECT_EQ(vehicle_simulators.faults(0).counts().dropped, 65);
  EXPECT_THAT(vehicle_simulators.counts()[0], HasSubstr("; 65 messages lost"));
}

TEST(VehicleSimulator, ARestartedOneBeginsAnewAndWhatItDidBeforeIsReported) {
  const Scenario scenario = row_of({"1.16"}, 1.0, fault("kind = \"restart\"\nat = 0.1\nsize = 0.1\n"));
  DdsVehicleSimulators vehicle_simulators(scenario, std::make_shared<Domain>(fleet_of(scenario).network));
  const Interrupts never{0};
  vehicle_simulators.run(0.15, never, {});
  EXPECT_THAT(vehicle_simulators.counts(),
              testing::ElementsAre(HasSubstr("uav0, before it began anew: 0 set-points"), "uav0: gone"));
  vehicle_simulators.run(0.3, never, {});
  EXPECT_THAT(vehicle_simulators.counts()[1], HasSubstr("uav0: 0 set-points"));
}

// On the ground it measures that of gravity, upwards.
TEST(VehicleSimulator, TheImuOfAPx4VehicleMeasuresFromOneStampToTheNextInItsOwnAxes) {
  const Scenario scenario = row_of({"1.14"}, 1.0);
  const auto domain = std::make_shared<Domain>(fleet_of(scenario).network);
  std::vector<px4_msgs_msg_dds__SensorCombined_> all;
  const RawReader reader(
      domain->another_participant(), px4_msgs_msg_dds__SensorCombined__desc, "/px4_0/fmu/out/sensor_combined",
      {.depth = 100}, 48u, Writers::all,
      taking<px4_msgs_msg_dds__SensorCombined_>([&](const auto& m, const auto&) { all.push_back(m); }));
  DdsVehicleSimulators vehicle_simulators(scenario, domain);
  ASSERT_TRUE(test::eventually([&] { return reader.matched() > 0; }));
  const Interrupts never{0};
  vehicle_simulators.run(1.0, never, {});
  ASSERT_GT(all.size(), 150u);
  double up = 0.0, turn = 0.0;
  for (std::size_t i = 1; i < all.size(); ++i) {
    EXPECT_EQ(all[i].timestamp, all[i - 1].timestamp + all[i].gyro_integral_dt);
    EXPECT_EQ(all[i].gyro_integral_dt, all[i].accelerometer_integral_dt);
    const double dt = 1e-6 * all[i].gyro_integral_dt;
    up -= dt * all[i].accelerometer_m_s2[2];
    turn += dt * (std::abs(all[i].gyro_rad[0]) + std::abs(all[i].gyro_rad[2]));
  }
  const double seconds = 1e-6 * static_cast<double>(all.back().timestamp - all.front().timestamp);
  EXPECT_NEAR(up / seconds, gravity, 5 * Imu::bmi088().accelerometer_bias);
  EXPECT_LT(turn / seconds, 0.05);
  EXPECT_NE(all[10].accelerometer_m_s2[0], all[11].accelerometer_m_s2[0]) << "it has noise";
}

TEST(VehicleSimulator, KeysBeginAndEndTheFaultsThatARobotCanHave) {
  const Scenario scenario =
      row_of({"1.16"}, 1.0,
             "[agent.r]\nrobot = \"unicycle\"\nstart = { p = [0, 5, 0] }\n[agent.r.link]\nkind = \"ros2\"\n"
             "odometry = \"/r/odom\"\ncmd_vel = \"/r/cmd_vel\"\n",
             "model", "off");
  DdsVehicleSimulators vehicle_simulators(scenario, std::make_shared<Domain>(fleet_of(scenario).network));
  EXPECT_EQ(vehicle_simulators.toggle(0, Kind::drop), "uav0: drop 0.2 begins");
  EXPECT_TRUE(vehicle_simulators.faults(0).on(Kind::drop));
  EXPECT_EQ(vehicle_simulators.toggle(0, Kind::drop), "uav0: drop ends");
  EXPECT_FALSE(vehicle_simulators.faults(0).on(Kind::drop));
  EXPECT_EQ(vehicle_simulators.toggle(1, Kind::pilot), "r: no robot behind ros2 has the fault pilot");
  EXPECT_EQ(vehicle_simulators.toggle(1, Kind::silent), "r: silent begins");
  EXPECT_EQ(vehicle_simulators.toggle(2, Kind::silent), "there is no robot 3, expected 1 to 2");
}

}  // namespace
}  // namespace sightline::dds
