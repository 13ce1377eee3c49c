#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>
#include <optional>

#include "sightline/log.hpp"
#include "tests/support/command.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/passing_sink.hpp"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

Scenario paper_for(double duration) {
  Scenario scenario = read_scenario(SIGHTLINE_SOURCE_DIR "/scenarios/paper_7_1.toml");
  scenario.simulation.duration = duration;
  scenario.simulation.compare.clear();
  lift_deadline(scenario.solver);
  return scenario;
}

LoggedFlight flown(const Scenario& scenario, const fs::path& folder, const FlightOptions& options = {}) {
  const Controls controls(scenario);
  SimulatedClock clock;
  return fly_logged(scenario, folder, clock, controls.controllers(), options);
}

TEST(LoggedFlight, OfOneScenarioTwiceHasTheSameBytesWhoeverLooksOn) {
  const Scenario scenario = paper_for(2.0);
  const test::Folder once("logged_once"), watched("logged_watched");
  std::optional<test::PassingSink> sink;
  int samples = 0, between = 0;
  double written = 0.0;
  FlightOptions options;
  options.watched = [&](Sink<Sample>& log, const Sample& prototype) -> Sink<Sample>& {
    EXPECT_EQ(prototype.x.size(), static_cast<std::size_t>(scenario.team.nx()));
    return sink.emplace(log, [&](const Sample& s) { ++(s.of == Sample::Of::update ? samples : between); });
  };
  options.written = [&](double time) { written = time; };
  options.summarised = [](const std::string& summary) { return summary + " "; };
  const LoggedFlight a = flown(scenario, once.path()), b = flown(scenario, watched.path(), options);
  EXPECT_TRUE(a.logged && b.logged);
  EXPECT_EQ(a.outcome.updates, 200);
  EXPECT_EQ(samples, 200);
  EXPECT_EQ(between, 1) << "the states after the last command";
  EXPECT_NEAR(written, 2.0, 0.02);
  EXPECT_EQ(test::read_file(once.path() / "run.mcap"), test::read_file(watched.path() / "run.mcap"));
  EXPECT_EQ(test::read_file(watched.path() / "summary.json"), b.summary);
  EXPECT_EQ(b.summary.back(), ' ');
}

TEST(LoggedFlight, ThatIsStoppedHasALogUpToThere) {
  const Scenario scenario = paper_for(60.0);
  const test::Folder folder("logged_stopped");
  std::atomic<bool> stop = false;
  FlightOptions options{.stop = &stop};
  options.written = [&](double time) { stop = time > 0.5; };
  const LoggedFlight flight = flown(scenario, folder.path(), options);
  EXPECT_TRUE(flight.logged);
  EXPECT_TRUE(flight.outcome.stopped);
  const Recording recording = read_recording(folder.path());
  EXPECT_TRUE(recording.complete);
  EXPECT_EQ(recording.time.size(), static_cast<std::size_t>(flight.outcome.updates));
  EXPECT_GT(recording.time.back(), 0.5);
}

TEST(LoggedFlight, TellsWhatWentWrong) {
  Scenario scenario = paper_for(4.0);
  scenario.x0[0] = -40.0;  // too far away to come into view
  const test::Folder folder("logged_lost");
  const LoggedFlight flight = flown(scenario, folder.path());
  EXPECT_TRUE(flight.logged);
  ASSERT_FALSE(flight.faults.empty());
  EXPECT_THAT(flight.faults.front(), HasSubstr("uav1"));
}

TEST(LoggedFlight, WithAnAppliedInputBeyondItsLimitsFails) {
  const test::Folder folder("logged_beyond");
  std::optional<test::PassingSink> sink;
  int published = 0;
  FlightOptions options;
  options.watched = [&](Sink<Sample>& log, const Sample&) -> Sink<Sample>& {
    return sink.emplace(log, [&](Sample& sample) {
      if (published++ == 3) sample.u[0] = 1e3;
    });
  };
  EXPECT_THAT(flown(paper_for(0.1), folder.path(), options).faults,
              testing::Contains("1 applied inputs were beyond the limits in force"));
}

TEST(LoggedFlight, SaysEachCauseOfAFailureAndNothingElse) {
  const std::string pair = R"(
[agent.a]
robot = "multirotor"
start = { p = [0.0, 0.0, 1.0], heading = 0.0 }
R = [1.0, 1.0, 1.0, 1.0]
[agent.b]
robot = "multirotor"
start = { p = [3.0, 0.0, 1.0], heading = 0.0 }
R = [1.0, 1.0, 1.0, 1.0]
[simulation]
duration = 1.0
)";
  const std::pair<std::string, std::string> cases[] = {
      {"", ""},
      {"[safety]\nd_hard = 3.5\n", "came within 3 m of"},
      {"[[simulation.fault]]\nkind = \"nan\"\nfrom = 0.2\n", "gave no plan for"},
      {R"toml(
[agent.c]
start = { p = [9.0, 0.0, 1.0], heading = 0.0 }
[agent.c.robot.text]
states = ["p_x", "p_y", "p_z", "psi", "load"]
inputs = ["u"]
position = ["p_x", "p_y", "p_z"]
heading = "psi"
f.p_x = 0
f.p_y = 0
f.p_z = 0
f.psi = "u"
f.load = "1000 * (1 + load) * (1 + load)"
)toml",
       "was not finite"}};
  for (const auto& [more, sentence] : cases) {
    const test::Folder folder("logged_causes");
    const LoggedFlight flight = flown(parse_scenario(pair + more, "causes.toml"), folder.path());
    if (sentence.empty())
      EXPECT_TRUE(flight.faults.empty()) << flight.faults.front();
    else
      EXPECT_THAT(flight.faults, testing::Contains(HasSubstr(sentence)));
  }
}

TEST(RunFolder, IsForOneFlightAtATime) {
  const Scenario scenario = paper_for(1.0);
  const test::Folder folder("run_folder");
  const RunFolder first(folder.path(), scenario);
  EXPECT_EQ(first.path(), folder.path());
  EXPECT_THROW(RunFolder(folder.path(), scenario), std::invalid_argument);
}

}  // namespace
}  // namespace sightline
