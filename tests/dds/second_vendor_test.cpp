// Fast DDS, in a program of its own, where it is found: tests/dds/fast_peer.cpp.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <thread>

#include "bridges/dds/domain.hpp"
#include "bridges/dds/links/px4_layout.hpp"
#include "bridges/dds/links/px4_link.hpp"
#include "bridges/dds/topics/service.hpp"
#include "sightline/base/now.hpp"
#include "tests/dds/fly.hpp"

extern "C" {
#include "ros.h"
}

#ifdef SIGHTLINE_FAST_PEER

namespace sightline::dds {
namespace {

using testing::ContainsRegex;
using testing::HasSubstr;

class SecondVendor : public FlyTest {
 protected:
  std::thread peer(const std::string& what, double seconds) const {
    const std::string command = fmt::format("'{}' {} {} {} >'{}'", SIGHTLINE_FAST_PEER, test::own_domain(),
                                            what, seconds, (folder / "peer").string());
    return std::thread([command] { EXPECT_EQ(std::system(command.c_str()), 0); });
  }
};

// The robot is the other vendor's: it publishes its odometry, drives as commanded, reads its
// flyer's topics, and ends the task by a call.
TEST_F(SecondVendor, ARobotOfFastDdsDrivesAndIsShownAndCalls) {
  std::ofstream(folder / "rover.toml") << fmt::format(
      "[fleet]\ndomain = {}\n[simulation]\nduration = 30.0\n[agent.rover]\nrobot = \"unicycle\"\nstart = {{ "
      "p "
      "= [0, 0, 0] }}\nQ = [2, 2, 0, 0, 0, 0]\nreference = {{ constant = {{ p = [1.0, 0.5, 0.0], heading = "
      "0.0 "
      "}} }}\n[agent.rover.link]\nkind = \"ros2\"\nodometry = \"/r/odom\"\ncmd_vel = \"/r/cmd_vel\"\nframe = "
      "\"odom\"\n[target.post]\np = [3, 3, 0]\n[safety.supervisor]\nfresh = 0.05\n",
      test::own_domain());
  std::thread robot = peer("rover", 40);
  const auto flown = test::sightline(
      "fly " + (folder / "rover.toml").string() + " -o " + (folder / "flown").string(), folder);
  robot.join();
  EXPECT_EQ(flown.code, 0) << flown.out << flown.err;
  const std::string saw = printed("peer");
  EXPECT_THAT(saw, ContainsRegex("[0-9][0-9][0-9]+ commands, farthest (0.[3-9]|1)[0-9.]* m, at rest yes"));
  EXPECT_THAT(saw, ContainsRegex("[0-9][0-9]+ poses in map, where it is"));
  EXPECT_THAT(saw, ContainsRegex("[0-9]+ marker arrays of 5, whole"));
  EXPECT_THAT(saw, HasSubstr("1 replies: yes, the task ends, all land"));
  expect_replayed("flown");
}

TEST_F(SecondVendor, OdometryAndSetpointsOfPx4AndACallGoEitherWay) {
  std::thread vehicle = peer("px4", 4);
  const auto domain = std::make_shared<Domain>(test::own_network());
  Link link;
  link.kind = Px4Link{.name_space = "/px4_0"};
  Px4LinkEnd end(domain->participant(), link, Stamps::of_poses, 0.0, Inertial::unread);
  ServiceCaller caller(domain->participant(), trigger_service, "/land/trigger", [](const void* response) {
    const auto& r = *static_cast<const std_srvs_srv_dds__Trigger_Response_*>(response);
    return r.success && std::string(r.message) == "landing";
  });
  WriterList writers(domain->participant());
  SeenMotion seen;
  ASSERT_TRUE(test::eventually([&] {
    caller.watch(writers.look());
    return end.look(seen) && caller.there();
  }));
  EXPECT_NEAR(seen.motion.p.x, -2.5, 1e-6);  // NED to ENU
  EXPECT_NEAR(seen.motion.p.y, 1.5, 1e-6);
  EXPECT_NEAR(seen.motion.p.z, 0.5, 1e-6);
  // Its mode is published in its place: without it no set-point is sent.
  const int release = px4_first + static_cast<int>(std::get<Px4Link>(link.kind).release);
  const Px4Layout layout("VehicleStatus", release);
  Px4Message offboard(layout);
  offboard.set("nav_state", static_cast<std::uint8_t>(NavState::offboard));
  RawWriter status(domain->another_participant(), layout.descriptor(),
                   px4_topic("/px4_0", Px4Side::out, "VehicleStatus", release), of_px4_output);
  for (int k = 0; k < 50; ++k) {
    status.write(offboard.data());
    const LinkOutput output = {.heartbeat = true, .setpoint = Setpoint::task};
    end.send(output, {.lead = {.v = {0.25, 0.75, 0.0}}}, monotonic_now());
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  const std_srvs_srv_dds__Trigger_Request_ request{};
  EXPECT_TRUE(caller.call(&request));
  EXPECT_TRUE(test::eventually([&] { return caller.answer() == Answer::accepted; }));
  vehicle.join();
  EXPECT_THAT(printed("peer"), ContainsRegex("[1-9][0-9]+ set-points, north 0.75 m/s\n1 calls"));
}

}  // namespace
}  // namespace sightline::dds

#endif
