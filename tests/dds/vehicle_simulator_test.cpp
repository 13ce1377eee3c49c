#include "bridges/dds/simulators/vehicle_simulator.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/dds/rig.hpp"

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
  // 20 poses, a status, 2 of each slow message; the same each time.
  EXPECT_EQ(vehicle_simulators.faults(0).counts().dropped, 25);
  EXPECT_THAT(vehicle_simulators.counts()[0], HasSubstr("; 25 messages lost"));
}

TEST(VehicleSimulator, ARestartedOneBeginsAnewAndWhatItDidBeforeIsTold) {
  const Scenario scenario = row_of({"1.16"}, 1.0, fault("kind = \"restart\"\nat = 0.1\nsize = 0.1\n"));
  DdsVehicleSimulators vehicle_simulators(scenario, std::make_shared<Domain>(fleet_of(scenario).network));
  const Interrupts never{0};
  vehicle_simulators.run(0.15, never, {});
  EXPECT_THAT(vehicle_simulators.counts(),
              testing::ElementsAre(HasSubstr("uav0, before it began anew: 0 set-points"), "uav0: gone"));
  vehicle_simulators.run(0.3, never, {});
  EXPECT_THAT(vehicle_simulators.counts()[1], HasSubstr("uav0: 0 set-points"));
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
