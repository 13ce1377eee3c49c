// What a flight's exit code and summary claim of distances and walls: between samples, at the end, at the start.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "sightline/campaign/judge.hpp"
#include "sightline/record/logged_flight.hpp"
#include "sightline/record/mcap.hpp"
#include "sightline/record/recording.hpp"
#include "sightline/record/replay.hpp"
#include "tests/support/folder.hpp"

namespace sightline {
namespace {

using Json = nlohmann::json;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;

/// Two that fly straight at each other with 3 m/s each.
std::string head_on(double from, double every, double duration, double d_hard) {
  const auto robot = [&](const char* name, double sign) {
    return fmt::format(
        "[agent.{}]\nrobot = \"point_mass\"\nstart = {{ p = [{}, 0.0, 1.0], heading = 0.0, v = [{}, 0.0] }}\n"
        "Q = [0.0, 0.0, 1.0, 1.0, 0.0, 0.0]\nR = [1.0, 1.0, 1.0]\n"
        "reference = {{ state = [0.0, 0.0, 1.0, {}, 0.0, 0.0] }}\n",
        name, -sign * from, 3.0 * sign, 3.0 * sign);
  };
  return fmt::format("[horizon]\nduration = {}\nstages = 4\nperiod = {}\n", 4 * every, every) +
         robot("a", 1) + robot("b", -1) +
         fmt::format("[safety]\nd_hard = {}\n[simulation]\nduration = {}\n", d_hard, duration);
}

Scenario flyable(const std::string& text) {
  Scenario scenario = parse_scenario(text, "head_on.toml");
  scenario.name = "head_on";
  lift_deadline(scenario.solver);
  return scenario;
}

LoggedFlight flown(const Scenario& scenario, const std::filesystem::path& folder,
                   Clock&& clock = SimulatedClock()) {
  const Controls controls(scenario);
  return fly_logged(scenario, folder, clock, controls.controllers());
}

RunResult judged(const Scenario& scenario) {
  const Controls controls(scenario);
  const auto world = make_world(scenario);
  SimulatedClock clock;
  const CampaignPlan plan{.duration = scenario.simulation.duration, .d_hard = 0.1, .braking = 100.0};
  Judge judge(scenario, plan, sized_sample(*world, controls.controllers()));
  const LoopOutcome outcome = ClosedLoop(scenario, *world, controls.controllers(), clock, judge).fly();
  return judge.result(outcome);
}

TEST(JudgedFlight, TwoThatPassThroughEachOtherBetweenSamplesAreTooClose) {
  const Scenario scenario = flyable(head_on(2.25, 0.5, 4.0, 1.4));
  const test::Folder folder("judged_between");
  const LoggedFlight flight = flown(scenario, folder.path());
  EXPECT_THAT(flight.faults, Contains(HasSubstr("d_hard is 1.4 m")));
  const Json summary = Json::parse(flight.summary);
  EXPECT_NEAR(summary.at("min_distance").get<double>(), 0.0, 1e-3);
  EXPECT_EQ(summary.at("safety").at("hard_distances").at(0).at("kept"), false);
  const RunResult result = judged(scenario);
  EXPECT_EQ(result.outcome, Outcome::too_close);
  EXPECT_EQ(result.min_distance, summary.at("min_distance").get<double>()) << "one judge";
}

TEST(JudgedFlight, TheStatesAfterTheLastCommandAreLoggedAndJudged) {
  const Scenario scenario = flyable(head_on(2.0, 0.1, 0.6, 0.5));
  const test::Folder folder("judged_last");
  const LoggedFlight flight = flown(scenario, folder.path());
  EXPECT_THAT(flight.faults, Contains("a came within 0.4 m of b at 0.60 s, d_hard is 0.5 m, for 0.02 s"));
  EXPECT_EQ(flight.outcome.updates, 6);
  EXPECT_EQ(Json::parse(flight.summary).at("updates"), 6);
  EXPECT_EQ(judged(scenario).outcome, Outcome::too_close);
  EXPECT_EQ(read_recording(folder.path()).time.size(), 6U) << "a row a period";
  std::size_t states = 0, inputs = 0;
  McapReader log(folder.path() / "run.mcap");
  log.visit([&](const McapMessage& message) {
    states += message.topic == "/a/state" ? 1 : 0;
    inputs += message.topic == "/a/input" ? 1 : 0;
  });
  EXPECT_EQ(states, 7U);
  EXPECT_EQ(inputs, 6U);
}

TEST(JudgedFlight, ALogWithTheStatesAfterTheLastCommandIsReplayedBitForBit) {
  const Scenario scenario = flyable(head_on(2.0, 0.1, 0.6, 0.1));
  const test::Folder folder("judged_replayed");
  (void)flown(scenario, folder.path());
  RecordedFlight recorded(folder.path() / "run.mcap", scenario.team, scenario.x0, scenario.horizon.dt);
  EXPECT_EQ(recorded.periods().size(), 6U);
  EXPECT_FALSE(recorded.lost_after());
  const Controls controls(scenario);
  CommandComparison compared(recorded, sized_sample(recorded, controls.controllers()));
  (void)ClosedLoop(scenario, recorded, controls.controllers(), recorded, compared).fly();
  EXPECT_EQ(compared.updates(), 6);
  EXPECT_EQ(compared.differing(), 0);
}

/// A clock that sleeps through periods.
class Sleeper final : public Clock {
 public:
  Sleeper(std::int64_t from, std::int64_t until) : from_(from), until_(until) {}
  void start(double) noexcept override {}
  std::int64_t wait(std::int64_t k) noexcept override { return k >= from_ && k < until_ ? until_ : k; }
  bool waits_for_log() const noexcept override { return true; }

 private:
  std::int64_t from_, until_;
};

TEST(JudgedFlight, PeriodsThatWereMissedAreJudged) {
  const Scenario scenario = flyable(head_on(2.0, 0.1, 2.0, 0.5));
  const test::Folder folder("judged_missed");
  const LoggedFlight flight = flown(scenario, folder.path(), Sleeper(3, 15));
  EXPECT_EQ(flight.outcome.missed, 12);
  EXPECT_THAT(flight.faults, Contains(HasSubstr("d_hard is 0.5 m")));
  EXPECT_NEAR(Json::parse(flight.summary).at("min_distance").get<double>(), 0.0, 1e-3);
  EXPECT_EQ(read_recording(folder.path()).time.size(), 8U);
  RecordedFlight recorded(folder.path() / "run.mcap", scenario.team, scenario.x0, scenario.horizon.dt);
  EXPECT_EQ(recorded.periods().size(), 8U);
  EXPECT_FALSE(recorded.lost_after());
}

TEST(JudgedFlight, MissedPeriodsAtTheEndAreJudged) {
  const Scenario scenario = flyable(head_on(2.0, 0.1, 2.0, 0.5));
  const test::Folder folder("judged_missed_end");
  const LoggedFlight flight = flown(scenario, folder.path(), Sleeper(3, 30));
  EXPECT_EQ(flight.outcome.updates, 3);
  EXPECT_EQ(flight.outcome.missed, 17);
  EXPECT_NEAR(Json::parse(flight.summary).at("min_distance").get<double>(), 0.0, 1e-3);
}

TEST(JudgedFlight, AStartOutsideTheRoomFailsUnlessItIsMeant) {
  const auto faults = [](const std::string& safety, const std::string& z) {
    const Scenario scenario = flyable("[agent.a]\nrobot = \"multirotor\"\nstart = { p = [0.0, 0.0, " + z +
                                      "] }\nQ = [1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0]\nreference = { constant "
                                      "= { p = [0.0, 0.0, 1.0] } }\n[safety]\n" +
                                      safety + "[simulation]\nduration = 6.0\n");
    const test::Folder folder("judged_start");
    return flown(scenario, folder.path()).faults;
  };
  for (const auto& [wall, z] : {std::pair{"floor = 0.3\n", "-0.6"}, {"ceiling = 1.5\n", "2.4"}}) {
    EXPECT_THAT(faults(wall, z),
                Contains(testing::AllOf(HasSubstr(" at 0.00 s, the "), HasSubstr(", for "))));
    EXPECT_THAT(faults(wall + std::string("start_outside = true\n"), z), IsEmpty());
  }
}

}  // namespace
}  // namespace sightline
