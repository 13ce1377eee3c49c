#include "bridges/dds/dds_world.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <chrono>
#include <cstring>
#include <random>
#include <thread>

#include "bridges/dds/px4_vehicle.hpp"
#include "bridges/dds/ros2_rover.hpp"
#include "cli/allocations.hpp"
#include "sightline/scenario/closed_loop.hpp"
#include "tests/dds/own_domain.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/scenario_text.hpp"

extern "C" {
#include "px4.h"
}

namespace sightline::dds {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using Fields = std::vector<std::string>;

/// Robots in a row, 3 m apart, of these releases.
Scenario row_of(const Fields& releases, double duration, const std::string& more = "",
                const std::string& kind = "model", const std::string& barrier = "on") {
  std::string text = fmt::format(
      "[fleet]\ndomain = {}\n[world]\nkind = \"{}\"\n[simulation]\nduration = {}\n"
      "[safety]\nbarrier = \"{}\"\nfloor = 0.2\nposition_sigma = 0.01\nheading_sigma = "
      "0.01\n[safety.supervisor]\nfresh = 0.05\n",
      test::own_domain(), kind, duration, barrier);
  for (std::size_t i = 0; i < releases.size(); ++i) {
    text += fmt::format(
        "[agent.uav{0}]\nrobot = \"multirotor\"\nstart = {{ p = [{1}, 0.0, 0.6], heading = 1.0 }}\nQ = [1.5, "
        "1.5, 1.6, 0, 0, 0, 0]\n"
        "reference = {{ circle = {{ centre = [{1}, 0.0, 0.8], radius = 0.3, rate = 0.5 }} }}\n"
        "[agent.uav{0}.link]\nkind = \"px4\"\nrelease = \"{2}\"\nnamespace = \"/px4_{0}\"\n"
        "origin = {{ p = [{1}, 0.1, 0.2], heading = 0.4 }}\n",
        i, 3.0 * static_cast<double>(i), releases[i]);
  }
  return test::scenario_of(text + more);
}

struct NullSink final : Sink<Sample> {
  explicit NullSink(Sample prototype) : sample(std::move(prototype)) {}
  Sample* claim() noexcept override { return &sample; }
  void publish() noexcept override {}
  void close() noexcept override {}
  Sample sample;
};

/// Vehicles and their flyer, on one domain of this program.
class Rig {
 public:
  explicit Rig(const Scenario& flown, const LinkTimes& times = {}) : Rig(flown, flown, times) {}
  Rig(const Scenario& flown, const Scenario& vehicles, const LinkTimes& times)
      : scenario(flown),
        domain(std::make_shared<Domain>(flown.fleet->network)),
        stand_ins(vehicles, domain),
        stepping([this] { stand_ins.run(1e9, stepped, {}); }),
        world(std::make_unique<DdsWorld>(scenario, domain, times)) {}
  ~Rig() {
    world.reset();
    stepped = 1;
    stepping.join();
  }

  bool take_off(Arming arming = Arming::real) {
    return world->take_off(arming, interrupts,
                           [this](std::string_view sentence) { told.emplace_back(sentence); });
  }
  void land() {
    world->land(interrupts, [this](std::string_view sentence) { told.emplace_back(sentence); });
  }
  /// Takes off, flies the task, lands; meanwhile `happens` after so long of the task [s].
  LoopOutcome fly(double after = 0, const std::function<void()>& happens = {}) {
    const Controls controls(scenario);
    SteadyClock clock;
    NullSink sink(sized_sample(*world, controls.controllers()));
    ClosedLoop loop(scenario, *world, controls.controllers(), clock, sink, cli::allocations, nullptr, &stop);
    LoopOutcome outcome;
    if (!take_off()) return outcome;
    std::thread other([&] {
      std::this_thread::sleep_for(std::chrono::duration<double>(after));
      if (happens) happens();
    });
    outcome = loop.fly();
    other.join();
    after_task = told_of(0);
    land();
    return outcome;
  }

  Px4Vehicle& vehicle(std::size_t i) { return dynamic_cast<Px4Vehicle&>(stand_ins.of(i)); }
  Px4VehicleCounts told_of(std::size_t i) { return vehicle(i).told(); }
  LinkState state(int i) const { return world->state(BodyId{i}); }

  Scenario scenario;
  Interrupts interrupts{0}, stepped{0};
  std::atomic<bool> stop{false};
  std::shared_ptr<Domain> domain;
  DdsStandIns stand_ins;
  std::thread stepping;
  std::unique_ptr<DdsWorld> world;
  Fields told;
  Px4VehicleCounts after_task;
};

/// Of each vehicle: armed at most once, never a set-point where it takes none, all numbers fit.
void expect_well_treated(Rig& rig) {
  for (std::size_t i = 0; i < rig.scenario.fleet->links.size(); ++i) {
    const Px4VehicleCounts n = rig.told_of(i);
    EXPECT_LE(n.arm_requests, 1) << i;
    EXPECT_LE(n.offboard_requests, 1) << i;
    EXPECT_EQ(n.setpoints_outside, 0) << i;
    EXPECT_EQ(n.bad_setpoints, 0) << i;
  }
}

TEST(DdsWorld, AFleetOfAllReleasesTakesOffFliesItsTaskAndLands) {
  Rig rig(row_of({"1.14", "1.15", "1.16", "1.17", "1.18"}, 8.0));
  const LoopOutcome outcome = rig.fly();
  EXPECT_GE(outcome.updates + outcome.missed, 800) << fmt::format("{}", fmt::join(rig.told, "\n"));
  EXPECT_TRUE(outcome.finite);
  EXPECT_EQ(outcome.max_allocations, 0);
  EXPECT_THAT(rig.world->faults(), IsEmpty());
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(rig.state(static_cast<int>(i)), LinkState::done) << i;
    EXPECT_EQ(rig.told_of(i).arm_requests, 1) << i;
    EXPECT_GT(rig.told_of(i).setpoints, 700) << i;
    EXPECT_FALSE(rig.vehicle(i).armed()) << i;
    const Motion m = rig.vehicle(i).motion();  // where its circle ended
    EXPECT_NEAR(norm(m.p.x - 3.0 * static_cast<double>(i), m.p.y), 0.3, 0.2) << i;
  }
  expect_well_treated(rig);
}

// Commands go to the vehicle in its own frame, and come back as measurements in G: a wrong sign anywhere would lead away.
TEST(DdsWorld, AVehicleWithRotorsFollowsItsReference) {
  Rig rig(row_of({"1.16"}, 8.0, "[agent.uav0.vehicle]\npreset = \"x500\"\n", "rotors"));
  std::vector<double> error;
  const LoopOutcome outcome = rig.fly(7.5, [&] {
    const Motion m = rig.vehicle(0).motion();
    error.push_back(std::abs(norm(m.p.x, m.p.y) - 0.3));
    error.push_back(std::abs(m.p.z - 0.8));
  });
  EXPECT_TRUE(outcome.finite);
  ASSERT_EQ(error.size(), 2u);
  EXPECT_LT(error[0], 0.15);
  EXPECT_LT(error[1], 0.1);
  EXPECT_THAT(rig.world->faults(), IsEmpty());
}

// A rover by Twist, one by TwistStamped whose odometry begins elsewhere and turned, and a multirotor of PX4.
TEST(DdsWorld, AMixedFleetFliesAndDrives) {
  const auto rover = [](std::string_view name, std::string_view robot, double x, std::string_view more) {
    return fmt::format(
        "[agent.{0}]\nrobot = \"{1}\"\nstart = {{ p = [{2}, 5.0, 0.0], heading = 0.5 }}\nQ = [2, 2, 0, 0, 0, "
        "0{3}]\n"
        "reference = {{ constant = {{ p = [{4}, 5.5, 0.0], heading = 0.0 }} }}\n[agent.{0}.link]\nkind = "
        "\"ros2\"\n"
        "odometry = \"/{0}/odom\"\ncmd_vel = \"/{0}/cmd_vel\"\n{5}",
        name, robot, x, robot == "omni_rover" ? ", 0" : "", x + 1.0, more);
  };
  Scenario scenario =
      row_of({"1.16"}, 8.0,
             rover("rover0", "omni_rover", 0.0, "") +
                 rover("rover1", "unicycle", 3.0,
                       "stamped = true\nframe = \"odom\"\norigin = { p = [3.0, 4.0, 0.1], heading = 2.0 }\n"),
             "model", "off");
  Rig rig(scenario);
  const LoopOutcome outcome = rig.fly();
  EXPECT_TRUE(outcome.finite) << fmt::format("{}", fmt::join(rig.told, "\n"));
  EXPECT_THAT(rig.world->faults(), IsEmpty());
  EXPECT_EQ(outcome.max_allocations, 0);
  for (std::size_t i = 1; i < 3; ++i) {
    const auto& driven = dynamic_cast<Ros2Rover&>(rig.stand_ins.of(i));
    const Motion m = driven.motion();
    EXPECT_NEAR(m.p.x, i == 1 ? 1.0 : 4.0, 0.2) << i;
    EXPECT_NEAR(m.p.y, 5.5, 0.2) << i;
    EXPECT_LT(norm(m.v), 0.05) << i;
    EXPECT_FALSE(driven.stopped_itself()) << i;
    EXPECT_EQ(rig.state(static_cast<int>(i)), LinkState::done) << i;
  }
  EXPECT_FALSE(rig.vehicle(0).armed());
}

TEST(DdsWorld, ARoverWhoseOdometryIsInAnotherFrameIsNotDriven) {
  const std::string robot =
      "[agent.r]\nrobot = \"unicycle\"\nstart = { p = [0, 0, 0] }\n[agent.r.link]\nkind = \"ros2\"\nodometry "
      "= \"/r/odom\"\n"
      "cmd_vel = \"/r/cmd_vel\"\nframe = \"";
  const std::string head = fmt::format("[fleet]\ndomain = {}\n", test::own_domain());
  Rig rig(test::scenario_of(head + robot + "map\"\n"), test::scenario_of(head + robot + "odom\"\n"),
          {.ready = 2.0});
  EXPECT_FALSE(rig.take_off());
  EXPECT_THAT(rig.told, Contains(HasSubstr("poses in other frames than frame, body_frame say")));
  EXPECT_EQ(dynamic_cast<Ros2Rover&>(rig.stand_ins.of(0)).commands(), 0);
}

// A fifth is lost, a tenth is no number, some come twice or out of order, all late: the task goes on, and distances are kept.
TEST(DdsWorld, OverABadLinkTheTaskIsCompletedAndTheHardDistanceKept) {
  const std::string couple =
      "[agent.uav0.sensor]\npitch = 0.5\n[[couple]]\npotential = { too_far = { d_max = 2.0, kappa = 10.0 } "
      "}\nbetween = [\"uav0\", \"uav1\"]\n"
      "felt_by = [\"uav0\"]\nweight = 8.0\n";
  Rig rig(row_of({"1.16", "1.14"}, 8.0, couple));
  double least = 100.0;
  const OdometryFaults bad{.drop = 0.2, .duplicate = 0.1, .not_finite = 0.1, .reorder = 0.1, .delay = 0.05};
  const LoopOutcome outcome = rig.fly(0.5, [&] {
    rig.vehicle(0).disturb(bad);
    rig.vehicle(1).disturb(bad);
    for (int k = 0; k < 140; ++k) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      least = std::min(least, norm(rig.vehicle(0).motion().p - rig.vehicle(1).motion().p));
    }
  });
  EXPECT_TRUE(outcome.finite);
  EXPECT_GE(outcome.updates + outcome.missed, 800);
  EXPECT_GT(least, 0.6);
  EXPECT_THAT(rig.world->faults(), IsEmpty());
  expect_well_treated(rig);
  EXPECT_THAT(rig.world->counts()[0], testing::Not(HasSubstr(" 0 not finite")));
}

TEST(DdsWorld, EachWrongPairOfReleasesIsRefusedBeforeArming) {
  const Fields releases = {"1.14", "1.15", "1.16", "1.17", "1.18"};
  for (std::size_t shift = 1; shift < releases.size(); ++shift) {
    Fields flown;
    for (std::size_t i = 0; i < releases.size(); ++i)
      flown.push_back(releases[(i + shift) % releases.size()]);
    Rig rig(row_of(flown, 1.0), row_of(releases, 1.0), {.ready = 2.5});
    EXPECT_FALSE(rig.take_off());
    for (std::size_t i = 0; i < releases.size(); ++i) {
      EXPECT_EQ(rig.state(static_cast<int>(i)), LinkState::done);
      EXPECT_EQ(rig.told_of(i).arm_requests, 0);
      EXPECT_THAT(rig.told, Contains(HasSubstr(fmt::format("uav{}: ", i))))
          << flown[i] << " of " << releases[i];
      EXPECT_THAT(rig.told,
                  Contains(testing::AnyOf(HasSubstr(fmt::format("of PX4 {}", flown[i])),
                                          HasSubstr(fmt::format("which PX4 {} does not have", flown[i])))));
    }
  }
}

TEST(DdsWorld, ADryRunArmsNothing) {
  Rig rig(row_of({"1.16", "1.16"}, 1.0));
  EXPECT_FALSE(rig.take_off(Arming::dry_run));
  EXPECT_THAT(rig.told, Contains("all are ready, none is armed: a dry run"));
  EXPECT_THAT(rig.world->faults(), IsEmpty());
  for (std::size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(rig.told_of(i).arm_requests, 0);
    EXPECT_EQ(rig.told_of(i).setpoints, 0);
  }
}

TEST(DdsWorld, APilotWhoTakesOneHasItForGoodAndTheOtherLands) {
  Rig rig(row_of({"1.16", "1.15"}, 20.0));
  const LoopOutcome outcome = rig.fly(2.0, [&] { rig.vehicle(0).take_over(); });
  EXPECT_FALSE(outcome.finite);
  EXPECT_LT(outcome.updates, 300);
  EXPECT_EQ(rig.state(0), LinkState::pilot);
  EXPECT_EQ(rig.state(1), LinkState::done);
  EXPECT_FALSE(rig.vehicle(1).armed());
  EXPECT_TRUE(rig.vehicle(0).armed());
  EXPECT_EQ(rig.told_of(0).heartbeats, rig.after_task.heartbeats);  // nothing since
  EXPECT_LE(rig.told_of(0).setpoints_outside, 1);                   // that was on its way
  EXPECT_THAT(rig.world->faults(), Contains("uav0: a pilot has it"));
  EXPECT_EQ(rig.world->ended(), "uav0: a pilot has it; the others landed");
}

TEST(DdsWorld, WhatIsDisarmedIsNotArmedAgain) {
  Rig rig(row_of({"1.18", "1.14"}, 20.0));
  rig.fly(1.5, [&] { rig.vehicle(1).disarm(); });
  EXPECT_EQ(rig.told_of(1).arm_requests, 1);
  EXPECT_EQ(rig.state(0), LinkState::done);
  EXPECT_EQ(rig.state(1), LinkState::done);
  EXPECT_THAT(rig.world->faults(), Contains("uav1: it was disarmed"));
  EXPECT_FALSE(rig.vehicle(0).armed());
}

TEST(DdsWorld, AVehicleThatFallsSilentIsGivenUpInTimeAndTheOtherLands) {
  Rig rig(row_of({"1.16", "1.16"}, 20.0), {.landing = 5.0});
  rig.fly(1.5, [&] { rig.vehicle(0).be_silent(true); });
  EXPECT_EQ(rig.state(0), LinkState::done);
  EXPECT_EQ(rig.state(1), LinkState::done);
  EXPECT_FALSE(rig.vehicle(1).armed());
  EXPECT_THAT(rig.world->faults(), Contains("uav0: nothing came from it any more"));
}

TEST(DdsWorld, AnotherProgramThatWritesSetpointsEndsTheFlight) {
  Rig rig(row_of({"1.16"}, 20.0));
  std::optional<RawWriter> rival;
  rig.fly(1.5, [&] {
    rival.emplace(rig.domain->another_participant(), px4_msgs_msg_dds__TrajectorySetpoint__desc,
                  "/px4_0/fmu/in/trajectory_setpoint", of_sensors);
  });
  EXPECT_EQ(rig.state(0), LinkState::done);
  EXPECT_FALSE(rig.vehicle(0).armed());
  EXPECT_THAT(rig.world->faults(), Contains("uav0: another program writes set-points to it"));
}

TEST(DdsWorld, ASecondFlyerAndASecondOdometryAreRefusedBeforeArming) {
  const Scenario scenario = row_of({"1.16"}, 1.0);
  {
    Rig rig(scenario, {.ready = 2.5});
    RawWriter rival(rig.domain->another_participant(), px4_msgs_msg_dds__TrajectorySetpoint__desc,
                    "/px4_0/fmu/in/trajectory_setpoint", of_sensors);
    EXPECT_FALSE(rig.take_off());
    EXPECT_THAT(rig.told, Contains(HasSubstr("another program writes set-points")));
    EXPECT_EQ(rig.told_of(0).arm_requests, 0);
  }
  Rig rig(scenario, {.ready = 2.5});
  Writer<px4_msgs_msg_dds__VehicleOdometry_> second(rig.domain->another_participant(),
                                                    px4_msgs_msg_dds__VehicleOdometry__desc,
                                                    "/px4_0/fmu/out/vehicle_odometry", of_px4_output);
  std::atomic<bool> done{false};
  std::thread writing([&] {
    while (!done) second({}), std::this_thread::sleep_for(std::chrono::milliseconds(5));
  });
  EXPECT_FALSE(rig.take_off());
  done = true;
  writing.join();
  EXPECT_EQ(rig.told_of(0).arm_requests, 0);
  EXPECT_THAT(rig.told,
              Contains(testing::AnyOf(HasSubstr("second writer"), HasSubstr("in frames that are not NED"))));
}

TEST(DdsWorld, ChecksThatDoNotPassKeepItOnTheGround) {
  Rig rig(row_of({"1.17"}, 1.0), {.ready = 2.5});
  rig.vehicle(0).fail_checks(true);
  EXPECT_FALSE(rig.take_off());
  EXPECT_THAT(rig.told, Contains("uav0: its own checks before a flight do not pass"));
  EXPECT_THAT(rig.world->faults(), Contains("uav0: it was not ready in time"));
  EXPECT_FALSE(rig.vehicle(0).armed());
}

TEST(DdsWorld, ThePersonWhoAsksToEndSeesAllLand) {
  Rig rig(row_of({"1.16", "1.18"}, 20.0));
  const LoopOutcome outcome = rig.fly(2.0, [&] {
    ++rig.interrupts;
    rig.stop = true;
  });
  EXPECT_TRUE(outcome.stopped);
  EXPECT_THAT(rig.world->faults(), IsEmpty());
  for (std::size_t i = 0; i < 2; ++i) EXPECT_FALSE(rig.vehicle(i).armed());
  expect_well_treated(rig);
}

TEST(DdsWorld, WithoutItsFlyerAVehicleFailsSafeASecondAfterTheLastHeartbeat) {
  Rig rig(row_of({"1.16"}, 20.0));
  ASSERT_TRUE(rig.take_off());
  std::this_thread::sleep_for(std::chrono::milliseconds(1500));  // nobody flies
  const Px4VehicleCounts n = rig.told_of(0);
  EXPECT_GE(n.failsafe_after, 1.0);
  EXPECT_LE(n.failsafe_after, 1.1);
  rig.land();  // and what comes back does not take it again
  EXPECT_EQ(rig.state(0), LinkState::pilot);
  EXPECT_EQ(rig.told_of(0).heartbeats, n.heartbeats);
}

// Numbers of any kind, in frames of any kind: what is believed of the robot is finite, and nothing of it is lost uncounted.
TEST(DdsWorld, OfAnyPoseThatComesOnlyThoseThatAreFiniteAreBelieved) {
  const Scenario scenario = row_of({"1.16"}, 1.0);
  const auto domain = std::make_shared<Domain>(scenario.fleet->network);
  DdsWorld world(scenario, domain);
  using Odometry = px4_msgs_msg_dds__VehicleOdometry_;
  Writer<Odometry> vehicle(domain->another_participant(), px4_msgs_msg_dds__VehicleOdometry__desc,
                           "/px4_0/fmu/out/vehicle_odometry", of_px4_output);
  ASSERT_TRUE([&] {
    for (int k = 0; k < 500 && vehicle.matched() == 0; ++k)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    return vehicle.matched() > 0;
  }());
  std::mt19937_64 random(3);
  for (int k = 0; k < 20'000; ++k) {
    Odometry m{};
    std::array<std::uint64_t, (sizeof m + 7) / 8> bits;
    for (std::uint64_t& word : bits) word = random();
    if (k % 2 == 0) std::memcpy(&m, bits.data(), sizeof m);  // else one number alone is any
    if (k % 2 == 1)
      m.q[0] = 1, m.position[k / 2 % 3] = std::bit_cast<float>(static_cast<std::uint32_t>(bits[0]));
    if (k % 4 != 0) m.pose_frame = m.velocity_frame = 1;
    vehicle(m);
    const Measured seen = world.measure(0.01 * k);
    for (const double x : seen.measured) ASSERT_TRUE(std::isfinite(x)) << k;
    ASSERT_TRUE(std::isfinite(seen.stamps[0]) || seen.measured[0] == scenario.x0[0]) << k;
  }
  EXPECT_THAT(world.counts()[0], testing::Not(HasSubstr(" 0 not finite")));
  EXPECT_THAT(world.counts()[0], testing::Not(HasSubstr(" 0 in other frames")));
}

TEST(DdsWorld, WhatItCannotFlyIsRefusedWithASentence) {
  const auto domain = std::make_shared<Domain>(test::own_network(1));
  const auto refusal = [&](const Scenario& scenario) {
    return refusal_of([&] { DdsWorld world(scenario, domain); });
  };
  EXPECT_THAT(
      refusal(row_of({"1.16"}, 1.0,
                     "[target.t]\nmotion = { circle = { centre = [9, 9, 1], radius = 1, rate = 1 } }\n")),
      HasSubstr("t moves, and no topic says where it is"));
  EXPECT_EQ(refusal(row_of({"1.16"}, 1.0, "[target.t]\np = [9, 9, 1]\n")), "");
  EXPECT_THAT(refusal(row_of({"1.16", "1.16"}, 1.0, "[[event]]\nat = 0.5\nremove = \"uav0\"\n")),
              HasSubstr("changes in flight"));
  EXPECT_THAT(
      refusal(test::scenario_of(
          "[fleet]\n[agent.a]\nrobot = \"multirotor\"\nstart = { p = [0, 0, 1] }\n[agent.a.link]\n"
          "kind = \"crazyswarm2\"\n")),
      HasSubstr("agent.a.link.kind = crazyswarm2, which this bridge does not fly yet, expected px4 or ros2"));
  EXPECT_THAT(refusal(test::scenario_of("[agent.a]\nrobot = \"multirotor\"\nstart = { p = [0, 0, 1] }\n")),
              HasSubstr("fleet is missing"));
}

}  // namespace
}  // namespace sightline::dds
