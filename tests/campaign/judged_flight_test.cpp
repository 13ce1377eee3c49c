// What a flight's exit code and summary claim of distances and walls: between samples, at the end,
// at the start. A campaign and a summary claim the same.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "sightline/judge/run_evaluator.hpp"
#include "sightline/judge/summary.hpp"
#include "sightline/log.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/sample_sink.hpp"

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
  RunEvaluator judge(scenario, plan, sized_sample(*world, controls.controllers()));
  const LoopOutcome outcome = ClosedLoop(scenario, *world, controls.controllers(), clock, judge).fly();
  return judge.result(outcome);
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

/// A robot that follows another which leaves, one that is tuned anew and narrowed while it flies,
/// and one that is held.
std::string with_events(double duration) {
  return fmt::format("[simulation]\nduration = {:.1f}\n", duration) + R"toml(
rms_from = 1.0
settle = 0.5
[agent.eye]
robot = "multirotor"
start = { p = [-1.6, 0.0, 1.0], heading = 0.4 }
sensor = { pitch = 0.0, offset = 0.17 }
[agent.seen]
robot = "multirotor"
start = { p = [0.0, 0.0, 1.0], heading = 0.5 }
Q = [1.5, 1.5, 1.6, 1.0, 1.0, 0.0, 0.0]
reference = { circle = { centre = [0.0, 0.0, 1.0], radius = 0.5, rate = 0.4 } }
[agent.tuned]
robot = "multirotor"
start = { p = [3.0, 0.0, 1.0], heading = 0.0 }
Q = [1.5, 1.5, 1.6, 1.0, 1.0, 0.0, 0.0]
R = [1.0, 1.0, 1.0, 1.0]
reference = { constant = { p = [3.0, 6.0, 1.0], heading = 1.0 } }
[agent.held]
robot = "multirotor"
start = { p = [0.0, -3.0, 1.0], heading = 0.0 }
Q = [1.5, 1.5, 1.6, 1.0, 1.0, 0.0, 0.0]
reference = { constant = { p = [4.0, -3.0, 1.0], heading = 0.0 } }
[[couple]]
potential = { bearing = { alpha = 0.5 } }
between = ["eye", "seen"]
felt_by = ["eye"]
[[event]]
at = 1.0
retune = { agent = "tuned", R = [4.0, 4.0, 4.0, 4.0], u_min = [-0.2, -0.2, -0.2, -0.2], u_max = [0.2, 0.2, 0.2, 0.2] }
[[event]]
at = 1.2
remove = { agent = "held", then = "hold" }
[[event]]
at = 1.5
remove = "seen"
)toml";
}

struct KeptSamples final : test::AllSamples {
  using AllSamples::AllSamples;
  bool takes_between() const noexcept override { return true; }
  Sample* claim_between() noexcept override { return &sample_; }
};

TEST(JudgedFlight, ACampaignAndASummaryClaimTheSameOfTheSameFlightWhateverChangesInIt) {
  // Drift is judged from the last event on, which 6 s leave too short a time for.
  for (const std::string& text : {with_events(6.0), with_events(8.0), head_on(2.0, 0.1, 2.0, 0.5)}) {
    const Scenario scenario = flyable(text);
    const Controls controls(scenario);
    const auto world = make_world(scenario);
    SimulatedClock clock;
    const Sample sized = sized_sample(*world, controls.controllers(), controls.team_switcher());
    KeptSamples kept(sized);
    const LoopOutcome outcome =
        ClosedLoop(scenario, *world, controls.controllers(), clock, kept, nullptr, controls.team_switcher())
            .fly();
    const CampaignPlan plan{.duration = scenario.simulation.duration, .d_hard = 0.1, .braking = 100.0};
    // As it flew; with an input beyond a limit that an event narrowed, and one that is no number.
    const bool narrowed = scenario.team.agents().size() > 2;
    const auto input =
        static_cast<std::size_t>(scenario.team.input_offset(scenario.team.find(narrowed ? "tuned" : "a")));
    for (const double tampered : {0.0, narrowed ? 0.6 : 1e3, std::nan("")}) {
      RunEvaluator judge(scenario, plan, sized);
      Summary summary(scenario, controls.controllers().size());
      for (std::size_t k = 0; k < kept.all.size(); ++k) {
        Sample& sample = *judge.claim();
        sample = kept.all[k];
        if (k == kept.all.size() / 2 && tampered != 0.0) sample.u[input] = tampered;
        judge.publish();
        summary.add(sample);
      }
      const RunResult run = judge.result(outcome);
      const SummaryValues values = summary.values();
      EXPECT_EQ(run.min_distance, values.min_distance);
      EXPECT_EQ(run.outcome == Outcome::failed, values.applied_violations + values.not_finite > 0);
      EXPECT_EQ(run.outcome == Outcome::failed, tampered != 0.0);
      double energy = 0.0, chatter = 0.0;
      ASSERT_EQ(run.robots.size(), values.robots.size());
      const auto same = [](double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); };
      for (std::size_t i = 0; i < run.robots.size(); ++i) {
        const RobotResult& one = run.robots[i];
        EXPECT_TRUE(same(one.energy, values.robots[i].energy)) << i;
        EXPECT_TRUE(same(one.rms_position_error, values.robots[i].rms_position_error)) << i;
        EXPECT_TRUE(same(one.rms_heading_error, values.robots[i].rms_heading_error)) << i;
        energy += one.energy;
      }
      EXPECT_TRUE(same(run.energy, energy));
      for (const auto& one : values.chatter) chatter = std::max(chatter, one.share);
      EXPECT_EQ(run.chatter, chatter);
      ASSERT_EQ(std::isnan(run.drift), !values.drift.has_value());
      if (values.drift) {
        EXPECT_EQ(run.drift, values.drift->empty() ? 0.0 : norm(values.drift->front().v));
      }
    }
  }
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

TEST(JudgedFlight, PeriodsThatWereMissedAreJudgedAtTheEndToo) {
  const Scenario scenario = flyable(head_on(2.0, 0.1, 2.0, 0.5));
  for (const auto& [until, missed] : {std::pair{15, 12}, {30, 17}}) {
    const test::Folder folder("judged_missed");
    const LoggedFlight flight = flown(scenario, folder.path(), Sleeper(3, until));
    EXPECT_EQ(flight.outcome.updates, 20 - missed);
    EXPECT_EQ(flight.outcome.missed, missed);
    EXPECT_THAT(flight.faults, Contains(HasSubstr("d_hard is 0.5 m")));
    EXPECT_NEAR(Json::parse(flight.summary).at("min_distance").get<double>(), 0.0, 1e-3);
    EXPECT_EQ(read_recording(folder.path()).time.size(), 20U - static_cast<std::size_t>(missed));
    RecordedFlight recorded(folder.path() / "run.mcap", scenario.team, scenario.x0, scenario.horizon.dt);
    EXPECT_EQ(recorded.periods().size(), 20U - static_cast<std::size_t>(missed));
    EXPECT_FALSE(recorded.lost_after());
  }
}

}  // namespace
}  // namespace sightline
