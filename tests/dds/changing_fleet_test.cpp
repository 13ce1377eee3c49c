// Events over links: robots that join take off first, robots that leave land, the others fly on.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include "sightline/log.hpp"
#include "tests/dds/rig.hpp"
#include "tests/support/child.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/replayed_flight.hpp"

namespace sightline::dds {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

/// Two robots that fly and a third that joins by a signal.
Scenario fleet_with_a_joiner(double duration) {
  return row_of({"1.16", "1.15", "1.16"}, duration,
                "[[simulation.signal]]\nname = \"go\"\n[[event]]\nsignal = \"go\"\nadd = \"uav2\"\n", "model",
                "on", 2);
}

TEST(ChangingFleet, ARobotJoinsAnotherLeavesAndAReplayGivesTheSameCommands) {
  Scenario scenario = row_of({"1.16", "1.16", "1.16"}, 15.0,
                             "[[event]]\nat = 6.0\nadd = \"uav2\"\n[[event]]\nat = 8.0\nremove = \"uav0\"\n"
                             "[[event]]\nat = 8.5\nretune = { agent = \"uav1\", R = [2.0, 2.0, 2.0, 2.0] }\n",
                             "model", "on", 2);
  lift_deadline(scenario.solver);
  Rig rig(scenario);
  const test::Folder folder("changing_fleet");
  const Controls controls(rig.scenario);
  SteadyClock clock;
  std::atomic<bool> in_task{false}, over{false}, left_alone{false};
  FlightOptions options{.world = rig.world.get(),
                        .team_switcher = controls.team_switcher(),
                        .allocations = cli::allocations,
                        .stop = &rig.stop};
  options.fly = [&](ClosedLoop& loop, Sink<Sample>& sink) {
    LoopOutcome outcome;
    if (rig.take_off()) {
      EXPECT_EQ(rig.counts_of(2).arm_requests, 0);
      in_task = true;
      outcome = loop.fly();
      in_task = false;
      rig.land();
    }
    sink.close();
    return outcome;
  };
  std::thread observer([&] {
    while (!over && !left_alone) {
      const bool landed = rig.counts_of(0).setpoints > 100 && !rig.vehicle(0).armed();
      const bool others_fly = rig.vehicle(1).armed() && rig.vehicle(2).armed();
      left_alone = landed && others_fly && in_task;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
  });
  const LoggedFlight flown = fly_logged(rig.scenario, folder.path(), clock, controls.controllers(), options);
  over = true;
  observer.join();
  const std::string reported = fmt::format("{}", fmt::join(rig.reported, "\n"));
  EXPECT_TRUE(flown.outcome.finite) << reported;
  EXPECT_GE(flown.outcome.updates + flown.outcome.missed, 1500) << reported;
  EXPECT_EQ(flown.outcome.max_allocations, 0);
  EXPECT_THAT(rig.world->faults(), IsEmpty()) << reported;
  EXPECT_TRUE(left_alone) << "uav0 is on the ground, disarmed, while the others fly";

  std::map<std::string, std::vector<double>> times;
  const Recording run = read_recording(folder.path());
  for (const Recording::Event& event : run.events) times[event.kind].push_back(event.time);
  ASSERT_EQ(times["event_in_force"].size(), 3U) << reported;
  EXPECT_THAT(times["event_ignored"], IsEmpty());
  EXPECT_THAT(times["added_too_near"], IsEmpty());
  ASSERT_EQ(times["robot_ready"].size(), 1U);
  EXPECT_NEAR(times["robot_ready"][0], 6.0, 0.05) << "it has taken off before its time";
  EXPECT_GT(times["event_in_force"][0], times["robot_ready"][0]);
  // It joins in the air, where it holds.
  const auto row = std::lower_bound(run.time.begin(), run.time.end(), times["event_in_force"][0] - 1e-6);
  const Vec3<double> joined = run.bodies[2].p[static_cast<std::size_t>(row - run.time.begin())];
  EXPECT_NEAR(joined.z, 0.6, 0.15);
  EXPECT_NEAR(norm(joined.x - 6.0, joined.y), 0.0, 0.15);

  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(rig.state(i), LinkState::done) << i;
    EXPECT_EQ(rig.counts_of(static_cast<std::size_t>(i)).arm_requests, 1) << i;
    EXPECT_FALSE(rig.vehicle(static_cast<std::size_t>(i)).armed()) << i;
  }
  EXPECT_GT(rig.counts_of(2).setpoints, 700);
  expect_well_treated(rig);

  RecordedFlight flight(folder.path() / "run.mcap", scenario.team, scenario.x0, scenario.horizon.dt);
  const CommandComparison compared = test::replayed(scenario, flight);
  EXPECT_EQ(compared.updates(), flown.outcome.updates);
  EXPECT_EQ(compared.differing(), 0);
}

TEST(ChangingFleet, ARobotThatNoEventAddsStaysOnTheGroundWithoutARequestOrASetPoint) {
  Rig rig(fleet_with_a_joiner(3.0));
  const LoopOutcome outcome = rig.fly();
  EXPECT_GE(outcome.updates + outcome.missed, 300) << fmt::format("{}", fmt::join(rig.reported, "\n"));
  EXPECT_THAT(rig.world->faults(), IsEmpty());
  EXPECT_EQ(rig.counts_of(2).arm_requests, 0);
  EXPECT_EQ(rig.counts_of(2).offboard_requests, 0);
  EXPECT_EQ(rig.counts_of(2).setpoints, 0);
  EXPECT_FALSE(rig.vehicle(2).armed());
  EXPECT_NEAR(rig.vehicle(2).motion().p.z, 0.0, 1e-6);
  EXPECT_EQ(rig.state(2), LinkState::done);
  EXPECT_GT(rig.counts_of(1).setpoints, 250);
}

TEST(ChangingFleet, AnEventBySignalWaitsUntilItsRobotHolds) {
  Rig rig(fleet_with_a_joiner(12.0));
  const LoopOutcome outcome = rig.fly(1.0, [&] { rig.switcher->signal("go"); });
  const std::string reported = fmt::format("{}", fmt::join(rig.reported, "\n"));
  EXPECT_TRUE(outcome.finite) << reported;
  EXPECT_THAT(rig.world->faults(), IsEmpty()) << reported;
  EXPECT_EQ(rig.count(EventKind::robot_ready), 1) << reported;
  EXPECT_EQ(rig.count(EventKind::event_in_force), 1) << reported;
  EXPECT_THAT(rig.reported, Contains("uav2: flying"));
  EXPECT_FALSE(rig.vehicle(2).armed());
  expect_well_treated(rig);
}

TEST(ChangingFleet, ARobotWhoseChecksFailIsNotArmedAndTheOthersFlyOn) {
  Rig rig(fleet_with_a_joiner(7.0), {.ready = 4.0});
  const LoopOutcome outcome = rig.fly(0.3, [&] {
    rig.vehicle(2).fail_checks(true);
    rig.switcher->signal("go");
  });
  EXPECT_TRUE(outcome.finite);
  EXPECT_GE(outcome.updates + outcome.missed, 700);
  // Its status may be older than the fault: then it refuses the request.
  EXPECT_THAT(rig.world->faults(), testing::ElementsAre(testing::AnyOf("uav2: it was not ready in time",
                                                                       "uav2: it refused to arm")));
  EXPECT_THAT(rig.reported, Contains(HasSubstr(": it does not join, the others fly on")));
  EXPECT_EQ(rig.count(EventKind::robot_refused), 1);
  EXPECT_EQ(rig.count(EventKind::event_ignored), 1);
  EXPECT_EQ(rig.count(EventKind::event_in_force), 0);
  EXPECT_EQ(rig.counts_of(2).setpoints, 0);
}

/// The fleet as its vehicles really stand: uav2 so far to the east of its start [m].
Scenario with_uav2_beside(double east) {
  Scenario vehicles = fleet_with_a_joiner(1.0);
  vehicles.x0[static_cast<std::size_t>(vehicles.team.state_offset(BodyId{2}))] += east;
  return vehicles;
}

TEST(ChangingFleet, AFleetWhoseAbsentRobotIsNotAtItsStartStaysOnTheGround) {
  Rig rig(fleet_with_a_joiner(3.0), with_uav2_beside(0.7), {.ready = 3.0});
  EXPECT_EQ(rig.fly().updates, 0);
  EXPECT_THAT(rig.reported,
              Contains(AllOf(HasSubstr("uav2: "), HasSubstr("0.70 m beside its start, turned from it by 0.0"),
                             HasSubstr("expected 0.5 m and 0.5 rad at most of a robot that joins"))));
  for (const std::size_t i : {0u, 1u, 2u}) EXPECT_EQ(rig.counts_of(i).arm_requests, 0) << i;
}

TEST(ChangingFleet, ARobotThatIsNoMoreAtItsStartIsNotArmedAndTheOthersFlyOn) {
  Rig rig(fleet_with_a_joiner(8.0), {.ready = 4.0});
  const LoopOutcome outcome = rig.fly(0.3, [&] {
    rig.faults(2).begin(Kind::jump, 0.8);
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    rig.switcher->signal("go");
  });
  EXPECT_GE(outcome.updates + outcome.missed, 800);
  EXPECT_THAT(rig.world->faults(), testing::ElementsAre("uav2: it is not at its start"));
  EXPECT_THAT(rig.reported,
              Contains("uav2: done, it is not at its start: it does not join, the others fly on"));
  EXPECT_EQ(rig.counts_of(2).arm_requests, 0);
  EXPECT_EQ(rig.count(EventKind::robot_refused), 1);
  EXPECT_EQ(rig.count(EventKind::event_ignored), 1);
}

TEST(ChangingFleet, ARobotThatComesBackToItsStartInTimeJoins) {
  Rig rig(fleet_with_a_joiner(14.0));
  std::int64_t early = 0;
  const LoopOutcome outcome = rig.fly(0.3, [&] {
    rig.faults(2).begin(Kind::jump, 0.8);
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    rig.switcher->signal("go");
    std::this_thread::sleep_for(std::chrono::milliseconds(700));
    early = rig.counts_of(2).arm_requests;
    rig.faults(2).end(Kind::jump);
  });
  EXPECT_TRUE(outcome.finite);
  EXPECT_EQ(early, 0);
  EXPECT_THAT(rig.world->faults(), IsEmpty());
  EXPECT_EQ(rig.count(EventKind::event_in_force), 1) << fmt::format("{}", fmt::join(rig.reported, "\n"));
}

TEST(ChangingFleet, AnAbsentRobotWhoseBatteryIsLowIsNotArmed) {
  Rig rig(fleet_with_a_joiner(3.0));
  const LoopOutcome outcome = rig.fly(0.3, [&] {
    rig.faults(2).begin(Kind::battery_low);
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    rig.switcher->signal("go");
  });
  EXPECT_GE(outcome.updates + outcome.missed, 300);
  EXPECT_THAT(rig.world->faults(), testing::ElementsAre("uav2: its battery is low"));
  EXPECT_EQ(rig.counts_of(2).arm_requests, 0);
  EXPECT_EQ(rig.count(EventKind::event_ignored), 1);
}

TEST(ChangingFleet, ARobotThatLandsCannotJoinAgainAndTheOthersFlyOn) {
  Rig rig(row_of({"1.16", "1.16"}, 4.0,
                 "[[event]]\nat = 0.5\nremove = { agent = \"uav0\", then = \"hold\" }\n"
                 "[[event]]\nat = 1.0\nadd = \"uav0\"\n"
                 "[[event]]\nat = 1.5\nremove = { agent = \"uav0\", then = \"land\" }\n"
                 "[[event]]\nat = 2.0\nadd = \"uav0\"\n"));
  const LoopOutcome outcome = rig.fly();
  EXPECT_GE(outcome.updates + outcome.missed, 400) << fmt::format("{}", fmt::join(rig.reported, "\n"));
  EXPECT_THAT(rig.world->faults(), IsEmpty());
  EXPECT_EQ(rig.count(EventKind::event_in_force), 3);
  EXPECT_EQ(rig.count(EventKind::robot_refused), 1);
  EXPECT_EQ(rig.count(EventKind::event_ignored), 1);
}

TEST(ChangingFleet, ARobotThatIsLostWhileItClimbsDoesNotJoinAndTheOthersFlyOn) {
  Rig rig(fleet_with_a_joiner(8.0));
  const LoopOutcome outcome = rig.fly(0.3, [&] {
    rig.switcher->signal("go");
    EXPECT_TRUE(test::eventually([&] { return rig.vehicle(2).motion().p.z > 0.1; }, std::chrono::seconds(5)));
    rig.faults(2).begin(Kind::silent);
  });
  EXPECT_TRUE(outcome.finite);
  EXPECT_GE(outcome.updates + outcome.missed, 800);
  EXPECT_THAT(rig.world->faults(), testing::ElementsAre("uav2: nothing came from it any more"));
  EXPECT_THAT(rig.reported, Contains(HasSubstr("it does not join, the others fly on")));
  EXPECT_EQ(rig.count(EventKind::event_ignored), 1);
  EXPECT_EQ(rig.count(EventKind::event_in_force), 0);
  for (const std::size_t i : {0u, 1u}) EXPECT_FALSE(rig.vehicle(i).armed()) << i;
}

TEST(ChangingFleet, WhereOneRobotOfAnEventIsLostTheOneThatRoseWithItLandsAtOnceAndTheOthersFlyOn) {
  Rig rig(
      row_of({"1.16", "1.16", "1.16"}, 10.0,
             "[[simulation.signal]]\nname = \"go\"\n[[event]]\nsignal = \"go\"\nadd = [\"uav1\", \"uav2\"]\n",
             "model", "on", 1));
  bool landed = false;
  const LoopOutcome outcome = rig.fly(0.3, [&] {
    rig.switcher->signal("go");
    EXPECT_TRUE(test::eventually([&] { return rig.vehicle(2).motion().p.z > 0.3; }, std::chrono::seconds(6)));
    rig.faults(1).begin(Kind::silent);
    landed = test::eventually([&] { return !rig.vehicle(2).armed(); }, std::chrono::seconds(6));
  });
  const std::string reported = fmt::format("{}", fmt::join(rig.reported, "\n"));
  EXPECT_TRUE(landed) << reported;
  EXPECT_GE(outcome.updates + outcome.missed, 1000) << reported;
  EXPECT_THAT(rig.world->faults(), testing::ElementsAre("uav1: nothing came from it any more"));
  EXPECT_THAT(rig.reported, Contains("uav2: landing: its event is ignored")) << reported;
  EXPECT_EQ(rig.count(EventKind::event_ignored), 1) << reported;
  EXPECT_EQ(rig.count(EventKind::event_in_force), 0) << reported;
}

TEST(ChangingFleet, ARobotThatIsLostAfterItLeftDoesNotEndTheFlight) {
  Rig rig(row_of({"1.16", "1.16"}, 10.0,
                 "[[event]]\nat = 0.5\nremove = { agent = \"uav0\", then = \"land\" }\n"));
  const LoopOutcome outcome = rig.fly(1.0, [&] {
    EXPECT_TRUE(test::eventually([&] { return !rig.vehicle(0).armed(); }, std::chrono::seconds(6)));
    std::this_thread::sleep_for(std::chrono::milliseconds(500));  // until it is done
    rig.faults(0).begin(Kind::silent);
  });
  EXPECT_TRUE(outcome.finite);
  EXPECT_GE(outcome.updates + outcome.missed, 1000) << fmt::format("{}", fmt::join(rig.reported, "\n"));
  EXPECT_THAT(rig.world->faults(), IsEmpty());
  EXPECT_EQ(rig.count(EventKind::event_in_force), 1);
}

}  // namespace
}  // namespace sightline::dds
