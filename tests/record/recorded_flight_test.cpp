#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "sightline/log.hpp"
#include "sightline/loop.hpp"
#include "sightline/record/log.hpp"
#include "sightline/scenario.hpp"
#include "tests/support/applied.hpp"
#include "tests/support/copy_log.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using test::place;

/// Two robots, one of which sees the other late, with noise, dropouts and numbers that are none.
Scenario noisy() {
  return parse_scenario(R"([agent.a]
robot = "multirotor"
start = { p = [0, 0, 1], heading = 0.0 }
Q = [1, 1, 1, 0, 0, 0, 0]
[agent.b]
robot = "multirotor"
start = { p = [2, 0, 1], heading = 0.0 }
[[couple]]
potential = { keep_out = { d_min = 1.0 } }
between = ["a", "b"]
weight = 0.4
[simulation]
duration = 3.0
disturbance = { noise = { position = 0.01, heading = 0.01 }, delay = 0.04 }
fault = [{ kind = "dropout", probability = 0.2 }, { kind = "nan", body = "b", probability = 0.1 }]
[safety]
[safety.supervisor]
)",
                        "noisy.toml");
}

/// Flies a scenario into a folder on a clock; what each sample held.
std::vector<Sample> logged(const Scenario& scenario, const fs::path& folder, Clock& clock) {
  std::vector<Sample> flown;
  const Controls controls(scenario);
  const Controllers controllers = controls.controllers();
  SpscQueue<Sample> ring(320, sized_sample(scenario.team, controllers));
  const auto world = make_world(scenario);
  ClosedLoop loop(scenario, *world, controllers, clock, ring, nullptr);
  (void)loop.fly();
  SpscQueue<Sample> copies(320, sized_sample(scenario.team, controllers));
  Log log(scenario, folder, controllers, copies);
  log.start();
  while (const Sample* sample = ring.front()) {
    *copies.claim() = *sample;
    copies.publish();
    flown.push_back(*sample);
    ring.pop();
  }
  copies.close();
  log.finish();
  EXPECT_EQ(log.error(), "");
  return flown;
}

RecordedFlight recorded(const Scenario& scenario, const fs::path& folder) {
  return RecordedFlight(folder / "run.mcap", scenario.team, scenario.x0, scenario.horizon.dt);
}

std::string replay_refusal(const Scenario& scenario, const fs::path& folder) {
  return refusal_of<std::runtime_error>([&] { recorded(scenario, folder); });
}

/// Where a number is none in one, it is none in the other; all else is the same to the bit.
void expect_same(std::span<const double> a, std::span<const double> b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(std::isnan(a[i]), std::isnan(b[i]));
    if (!std::isnan(a[i])) {
      ASSERT_EQ(a[i], b[i]);
    }
  }
}

TEST(RecordedFlight, GivesBackWhatTheLoopMeasuredAndCommandedWithItsTimes) {
  const Scenario scenario = noisy();
  SimulatedClock clock;
  const auto flown = logged(scenario, place("noisy"), clock);
  RecordedFlight flight = recorded(scenario, place("noisy"));
  ASSERT_EQ(flight.periods().size(), flown.size());
  EXPECT_FALSE(flight.truncated());
  int nans = 0, old = 0;
  for (const Sample& sample : flown) {
    const Measured seen = flight.measure(sample.time);
    expect_same(seen.measured, sample.measured);
    expect_same(seen.stamps, sample.stamps);
    expect_same(seen.truth, sample.x);
    for (const double x : seen.measured) nans += std::isnan(x);
    old += seen.stamps[1] < sample.time - 0.045;
    (void)test::apply(flight, sample.time, {}, sample.u, 0.01, 1);
  }
  EXPECT_GT(nans, 10) << "the faults were there";
  EXPECT_GT(old, 10);
}

TEST(RecordedFlight, PeriodsThatWereMissedAreMissedAgain) {
  class Stumbling final : public Clock {
    void start(double) noexcept override {}
    std::int64_t wait(std::int64_t k) noexcept override { return k % 10 == 5 ? k + 3 : k; }
    bool waits_for_log() const noexcept override { return true; }
  } clock;
  const Scenario scenario = noisy();
  const auto flown = logged(scenario, place("missed"), clock);
  RecordedFlight flight = recorded(scenario, place("missed"));
  EXPECT_FALSE(flight.lost_after());
  ASSERT_EQ(flight.periods().size(), flown.size());
  for (const Sample& sample : flown) {
    const std::int64_t k = flight.number(sample.time);
    EXPECT_EQ(flight.wait(k % 10 == 8 ? k - 3 : k), k);
    (void)flight.measure(sample.time);
    (void)test::apply(flight, sample.time, {}, sample.u, 0.01, 1);
  }
}

TEST(RecordedFlight, SamplesThatTheLogLostEndWhatCanBeRepeatedAndAFlightWithoutItsStartIsRefused) {
  const Scenario scenario = noisy();
  SimulatedClock clock;
  (void)logged(scenario, place("whole"), clock);
  const auto without = [&](std::string_view name, std::string_view one, std::string_view next) {
    fs::create_directories(place(name));
    test::copy_log(place("whole") / "run.mcap", place(name) / "run.mcap",
                   [&](std::string_view, std::string& text) {
                     if (text.starts_with(one) || text.starts_with(next)) text.clear();
                   });
    return place(name);
  };
  const RecordedFlight flight = recorded(scenario, without("lost", "{\"time\":1.23,", "{\"time\":1.24,"));
  ASSERT_TRUE(flight.lost_after());
  EXPECT_DOUBLE_EQ(*flight.lost_after(), 1.22);
  EXPECT_EQ(flight.periods().size(), 123U);
  EXPECT_THAT(replay_refusal(scenario, without("later", "{\"time\":0,", "{\"time\":0.01,")),
              testing::HasSubstr("run.mcap holds no samples of the first period"));
}

TEST(RecordedFlight, DetectionsComeBackAsTheyWere) {
  const Scenario scenario = noisy();
  Team team = scenario.team;
  McapWriter mcap(place("detections.mcap"), "ros2", "test");
  MeasurementLog log(team, mcap);
  const auto state = mcap.channel(mcap.schema("s", "jsonschema", "{}"), "/a/state", "json", {});
  const auto state_b = mcap.channel(mcap.schema("t", "jsonschema", "{}"), "/b/state", "json", {});
  Sample sample;
  sample.measured.assign(14, 1.5);
  sample.stamps = {0.0, -std::numeric_limits<double>::infinity()};
  sample.detections = {{.observer = BodyId{0},
                        .target = BodyId{1},
                        .stamp = -0.02,
                        .arrival = 0.01,
                        .p = {1, 2, 3},
                        .q = {0.6, 0, 0, 0.8},
                        .covariance = {1e-3, 0, 0, 2e-3, 0, 3e-3},
                        .tags = 2},
                       {.observer = BodyId{1}, .target = BodyId{0}, .stamp = -0.01, .p = {0.1, 0, -1}}};
  sample.detection_count = 2;
  const std::string x = "{\"time\":0,\"x\":[0,0,0,0,0,0,0]}";
  mcap.message(state, 0, 0, std::as_bytes(std::span(x)));
  mcap.message(state_b, 0, 0, std::as_bytes(std::span(x)));
  log.add(sample);
  const auto input = mcap.channel(mcap.schema("i", "jsonschema", "{}"), "/a/input", "json", {});
  const auto input_b = mcap.channel(mcap.schema("j", "jsonschema", "{}"), "/b/input", "json", {});
  const std::string u = "{\"time\":0,\"u\":[0,0,0,0]}";
  mcap.message(input, 0, 0, std::as_bytes(std::span(u)));
  mcap.message(input_b, 0, 0, std::as_bytes(std::span(u)));
  mcap.close();
  RecordedFlight flight(place("detections.mcap"), team, scenario.x0, 0.01);
  EXPECT_EQ(flight.measured_max().detections, 2U);
  const Measured seen = flight.measure(0.0);
  ASSERT_EQ(seen.detections.size(), 2U);
  EXPECT_EQ(seen.detections[0].p.z, 3.0);
  EXPECT_EQ(seen.detections[0].covariance[3], 2e-3);
  EXPECT_EQ(seen.detections[0].q, (Quaternion{0.6, 0, 0, 0.8}));
  EXPECT_EQ(seen.detections[0].arrival, 0.01);
  EXPECT_EQ(seen.detections[0].tags, 2);
  EXPECT_FALSE(seen.detections[1].is_oriented());
  EXPECT_EQ(seen.detections[1].stamp, -0.01);
  EXPECT_EQ(seen.detections[1].target, BodyId{0});
  EXPECT_EQ(seen.stamps[1], -std::numeric_limits<double>::infinity()) << "never seen";
}

TEST(RecordedFlight, LogsWithoutWhatAReplayNeedsAreRefusedBySentencesWithTheirName) {
  const Scenario scenario = noisy();
  SimulatedClock clock;
  (void)logged(scenario, place("good"), clock);
  const auto spoilt = [&](std::string_view name,
                          const std::function<void(std::string_view, std::string&)>& edit) {
    fs::create_directories(place(name));
    test::copy_log(place("good") / "run.mcap", place(name) / "run.mcap", edit);
    return replay_refusal(scenario, place(name));
  };
  EXPECT_THAT(spoilt("old",
                     [](std::string_view topic, std::string& text) {
                       if (topic.ends_with("/measurement")) text.clear();
                     }),
              testing::HasSubstr("cannot be replayed: it holds no measurements"));
  EXPECT_THAT(
      spoilt("half",
             [](std::string_view topic, std::string& text) {
               if (topic == "/b/measurement") text.clear();
             }),
      testing::HasSubstr("2 states, 1 measurements and 2 inputs of the period at 0 s, expected 2, 2 and 2"));
  EXPECT_THAT(spoilt("no_first",
                     [](std::string_view topic, std::string& text) {
                       if (topic == "/a/measurement" && text.starts_with("{\"time\":0.5,")) text.clear();
                     }),
              testing::HasSubstr("the measurement 1 of the period at 0.5 s where 0 is expected"));
  EXPECT_THAT(spoilt("short",
                     [](std::string_view topic, std::string& text) {
                       if (topic == "/b/input") text = "{\"time\":0,\"u\":[1,2]}";
                     }),
              testing::HasSubstr("2 numbers in a message, expected 4"));
  EXPECT_THAT(spoilt("words", [](std::string_view, std::string& text) { text = "hello"; }),
              testing::HasSubstr("expected a JSON object"));
  EXPECT_THAT(replay_refusal(scenario, place("nowhere")), testing::HasSubstr("run.mcap"));
}

}  // namespace
}  // namespace sightline
