// Robots that an event adds, in a world where absent robots stay and take off before they join.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sightline/log.hpp"
#include "sightline/scenario.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/replayed_flight.hpp"

namespace sightline {
namespace {

using testing::ElementsAre;

/// The simulated world of a scenario, but the take-off of an added robot lasts for `duration` [s].
/// Of several robots only the second body is refused.
class TakeOffWorld final : public World {
 public:
  TakeOffWorld(const Scenario& scenario, double duration, Joining outcome)
      : world_(make_world(scenario)), duration_(duration), outcome_(outcome) {}

  const Team& team() const noexcept override { return world_->team(); }
  std::span<const double> start() const noexcept override { return world_->start(); }
  void set_presence(std::span<const Presence> presence) noexcept override { world_->set_presence(presence); }
  bool absent_robots_stay() const noexcept override { return true; }
  Joining prepare(BodyId robot) noexcept override {
    if (began_ < 0) began_ = t_;
    const bool waits = outcome_ == Joining::refused && robot.index != 1;
    return waits || t_ - began_ < duration_ - 1e-9 ? Joining::waits : outcome_;
  }
  void call_off(BodyId robot) noexcept override { called_off.push_back(robot.index); }
  Measured measure(double t) noexcept override {
    t_ = t;
    return world_->measure(t);
  }
  bool apply(double t, std::span<const double> estimated, const Command& u, double period,
             std::int64_t periods) noexcept override {
    return world_->apply(t, estimated, u, period, periods);
  }
  std::span<const double> truth() const noexcept override { return world_->truth(); }

  std::vector<int> called_off;

 private:
  std::unique_ptr<World> world_;
  double duration_, t_ = 0.0, began_ = -1.0;
  Joining outcome_;
};

/// A flight with a log. Without a take-off absent robots do not stay.
struct FlightWithTakeOff {
  Scenario scenario;
  test::Folder folder{"joining_robots"};
  Recording run;
  std::vector<int> called_off;

  FlightWithTakeOff(const std::string& text, std::optional<double> duration, Joining outcome = Joining::ready)
      : scenario(parse_scenario(text, "joining.toml")) {
    lift_deadline(scenario.solver);
    std::optional<TakeOffWorld> world;
    if (duration) world.emplace(scenario, *duration, outcome);
    const Controls controls(scenario);
    SimulatedClock clock;
    const LoggedFlight flight =
        fly_logged(scenario, folder.path(), clock, controls.controllers(),
                   {.world = world ? &*world : nullptr, .team_switcher = controls.team_switcher()});
    EXPECT_TRUE(flight.logged);
    run = read_recording(folder.path());
    if (world) called_off = world->called_off;
  }

  /// What happened to events and their robots: "1.50 robot_ready 1".
  std::vector<std::string> occurred() const {
    std::vector<std::string> all;
    for (const Recording::Event& event : run.events)
      if (event.kind.starts_with("event_") || event.kind.starts_with("robot_"))
        all.push_back(fmt::format("{:.2f} {} {}", event.time, event.kind, event.value));
    return all;
  }
  void expect_same_commands_again() const {
    RecordedFlight flight(folder.path() / "run.mcap", scenario.team, scenario.x0, scenario.horizon.dt);
    const CommandComparison compared = test::replayed(scenario, flight);
    EXPECT_EQ(compared.updates(), 250);
    EXPECT_EQ(compared.differing(), 0);
  }
};

std::string hovering_robot(std::string_view name, std::string_view p, std::string_view more = {}) {
  return fmt::format(
      "[agent.{0}]\nrobot = \"multirotor\"\nstart = {{ p = {1} }}\nQ = [1.5, 1.5, 1.6, 1, 1, 0, 0]\n"
      "reference = {{ constant = {{ p = {1}, heading = 0.5 }} }}\n{2}\n",
      name, p, more);
}

/// A robot that flies, one that joins at 1 s, and other events.
std::string joining_at_1_s(std::string_view events) {
  return "[simulation]\nduration = 2.5\n" + hovering_robot("a", "[0.0, 0.0, 1.0]") +
         hovering_robot("b", "[2.0, 0.0, 1.0]", "present = false") +
         "[[couple]]\npotential = { too_far = { d_max = 1.5 } }\nbetween = [\"a\", \"b\"]\n"
         "[[event]]\nat = 1.0\nadd = \"b\"\n" +
         std::string(events);
}

const std::string two_events =
    joining_at_1_s("[[event]]\nat = 1.2\nretune = { agent = \"a\", R = [2.0, 2.0, 2.0, 2.0] }\n");
const std::string joins_and_leaves = joining_at_1_s(
    "[[event]]\nat = 1.2\nremove = \"b\"\n"
    "[[event]]\nat = 1.3\nretune = { agent = \"b\", R = [2.0, 2.0, 2.0, 2.0] }\n");

/// Flies with a take-off of 0.5 s that has this outcome, and replays it.
void expect_events(const std::string& text, Joining outcome, const std::vector<std::string>& occurred) {
  const FlightWithTakeOff flight(text, 0.5, outcome);
  EXPECT_EQ(flight.occurred(), occurred);
  flight.expect_same_commands_again();
}

TEST(JoiningRobots, AnEventWaitsForItsRobotAndOtherEventsDoNotWait) {
  expect_events(two_events, Joining::ready,
                {"1.00 event_happened 0", "1.20 event_happened 1", "1.21 event_in_force 1",
                 "1.50 robot_ready 1", "1.51 event_in_force 0"});
}

TEST(JoiningRobots, AnEventWhoseRobotCannotJoinIsIgnored) {
  expect_events(two_events, Joining::refused,
                {"1.00 event_happened 0", "1.20 event_happened 1", "1.21 event_in_force 1",
                 "1.50 robot_refused 1", "1.50 event_ignored 0"});
}

TEST(JoiningRobots, LaterEventsOfTheRobotWaitAndKeepTheirOrder) {
  expect_events(
      joins_and_leaves, Joining::ready,
      {"1.00 event_happened 0", "1.20 event_happened 1", "1.30 event_happened 2", "1.50 robot_ready 1",
       "1.51 event_in_force 0", "1.52 event_in_force 1", "1.53 event_in_force 2"});
}

TEST(JoiningRobots, LaterEventsOfARobotThatCannotJoinGoOnInTheirOrder) {
  expect_events(
      joins_and_leaves, Joining::refused,
      {"1.00 event_happened 0", "1.20 event_happened 1", "1.30 event_happened 2", "1.50 robot_refused 1",
       "1.50 event_ignored 0", "1.51 event_ignored 1", "1.52 event_in_force 2"});
}

TEST(JoiningRobots, AnEventOfWhichOneRobotCannotJoinIsIgnoredAsAWholeAndNoneWaitsForIt) {
  const FlightWithTakeOff flight("[simulation]\nduration = 2.5\n" + hovering_robot("a", "[0.0, 0.0, 1.0]") +
                                     hovering_robot("b", "[2.0, 0.0, 1.0]", "present = false") +
                                     hovering_robot("c", "[4.0, 0.0, 1.0]", "present = false") +
                                     "[[event]]\nat = 1.0\nadd = [\"b\", \"c\"]\n",
                                 0.5, Joining::refused);
  EXPECT_THAT(flight.occurred(),
              ElementsAre("1.00 event_happened 0", "1.50 robot_refused 1", "1.50 event_ignored 0"));
  EXPECT_THAT(flight.called_off, ElementsAre(1, 2));
  flight.expect_same_commands_again();
}

TEST(JoiningRobots, ARobotThatLandsCannotJoinAgain) {
  const std::string text = "[simulation]\nduration = 2.5\n" + hovering_robot("a", "[0.0, 0.0, 1.0]") +
                           hovering_robot("b", "[2.0, 0.0, 1.0]") +
                           "[[event]]\nat = 0.5\nremove = { agent = \"b\", then = \"land\" }\n"
                           "[[event]]\nat = 1.0\nadd = \"b\"\n";
  const FlightWithTakeOff flight(text, 0.0, Joining::refused);
  EXPECT_THAT(flight.occurred(),
              ElementsAre("0.50 event_happened 0", "0.51 event_in_force 0", "1.00 event_happened 1",
                          "1.00 robot_refused 1", "1.00 event_ignored 1"));
  flight.expect_same_commands_again();
  EXPECT_THAT(FlightWithTakeOff(text, std::nullopt).occurred(), testing::Contains("1.01 event_in_force 1"));
}

TEST(JoiningRobots, AFlightThatEndsDuringTheTakeOffIsReplayed) {
  const FlightWithTakeOff flight(two_events, 99.0);
  EXPECT_THAT(flight.occurred(),
              ElementsAre("1.00 event_happened 0", "1.20 event_happened 1", "1.21 event_in_force 1"));
  flight.expect_same_commands_again();
}

TEST(JoiningRobots, WithoutATakeOffARobotJoinsAtOnceAndNothingIsReported) {
  const FlightWithTakeOff flight(two_events, std::nullopt);
  EXPECT_THAT(flight.occurred(), ElementsAre("1.00 event_happened 0", "1.01 event_in_force 0",
                                             "1.20 event_happened 1", "1.21 event_in_force 1"));
  flight.expect_same_commands_again();
}

TEST(JoiningRobots, TheBarrierKeepsTheDistanceFromAnAbsentRobotThatStays) {
  for (const char* supervisor : {"", "[safety.supervisor]\n"}) {
    const std::string text =
        "[simulation]\nduration = 6.0\n[[simulation.signal]]\nname = \"go\"\n"
        "[safety]\nd_hard = 0.6\nbarrier = \"on\"\n" +
        std::string(supervisor) +
        "[agent.a]\nrobot = \"multirotor\"\nstart = { p = [-2.0, 0.05, 1.0] }\nQ = [1.5, 1.5, 1.6, 1, 1, 0, "
        "0]\n"
        "reference = { waypoints = { times = [0.5, 5.5], p = [[-2.0, 0.05, 1.0], [2.0, 0.05, 1.0]], heading "
        "= [0.0, 0.0] } }\n" +
        hovering_robot("b", "[0.0, 0.0, 1.0]", "present = false") +
        "[[event]]\nsignal = \"go\"\nadd = \"b\"\n";
    const auto nearest = [](const FlightWithTakeOff& flight) {
      double least = 1e9;
      for (const Vec3<double>& p : flight.run.bodies[0].p)
        least = std::min(least, norm(p - Vec3<double>{0.0, 0.0, 1.0}));
      return least;
    };
    EXPECT_GE(nearest(FlightWithTakeOff(text, 1.0)), 0.6) << supervisor;
    EXPECT_LT(nearest(FlightWithTakeOff(text, std::nullopt)), 0.3) << supervisor;
  }
}

// Only the robot below can make way: the other one is landed by its autopilot.
TEST(JoiningRobots, ARobotMakesWayForOneThatLandsOntoIt) {
  const auto nearest = [](const char* barrier) {
    const FlightWithTakeOff flight(
        "[simulation]\nduration = 6.0\n[safety]\nd_hard = 0.5\nbarrier = \"" + std::string(barrier) + "\"\n" +
            hovering_robot("a", "[0.0, 0.0, 0.6]") + hovering_robot("b", "[0.1, 0.0, 1.8]") +
            "[[event]]\nat = 0.5\nremove = { agent = \"b\", then = \"land\" }\n",
        0.0);
    double least = 1e9;
    const auto& bodies = flight.run.bodies;
    for (std::size_t k = 0; k < flight.run.time.size(); ++k)
      least = std::fmin(least, norm(bodies[0].p[k] - bodies[1].p[k]));
    return least;
  };
  EXPECT_GE(nearest("on"), 0.5);
  EXPECT_LT(nearest("off"), 0.3);
}

// Its autopilot lands it, so there is no command on which the barrier could act.
TEST(JoiningRobots, TheBarrierLeavesARobotAloneThatLandsInAWorldWhereAbsentRobotsStay) {
  const FlightWithTakeOff flight("[simulation]\nduration = 2.5\n[safety]\nd_hard = 0.6\nbarrier = \"on\"\n" +
                                     hovering_robot("a", "[0.0, 0.0, 1.0]") +
                                     hovering_robot("b", "[0.8, 0.0, 1.0]") +
                                     "[[event]]\nat = 1.0\nremove = { agent = \"b\", then = \"land\" }\n",
                                 0.0);
  const auto sees_others = [&](std::size_t robot, double t) {
    const std::vector<double>& times = flight.run.time;
    const auto row = std::lower_bound(times.begin(), times.end(), t) - times.begin();
    return !std::isnan(flight.run.bodies[robot].reserve[static_cast<std::size_t>(row)]);
  };
  for (const double t : {0.9, 1.5, 2.0}) {
    EXPECT_TRUE(sees_others(0, t)) << t;
    EXPECT_EQ(sees_others(1, t), t < 1.0) << t;
  }
}

}  // namespace
}  // namespace sightline
