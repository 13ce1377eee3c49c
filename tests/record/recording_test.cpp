#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <functional>

#include "sightline/config.hpp"
#include "sightline/log.hpp"
#include "sightline/potentials.hpp"
#include "sightline/record/log.hpp"
#include "tests/support/closed_loop.hpp"
#include "tests/support/command.hpp"
#include "tests/support/copy_log.hpp"
#include "tests/support/folder.hpp"
#include "tests/support/paper_team.hpp"
#include "tests/support/refusal.hpp"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using test::read_file;

fs::path made_folder(std::string_view name) {
  fs::create_directories(test::place(name));
  return test::place(name);
}

void save(const fs::path& path, std::string_view bytes) {
  std::ofstream(path, std::ios::binary).write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
}

struct LoggedFlight {
  fs::path folder;
  std::vector<Sample> samples;
  Team team;
};

// The paper's two robots over 2 s, and a wall; the observer is sent round and round.
const LoggedFlight& flight() {
  static const LoggedFlight flown = [] {
    Scenario scenario;
    scenario.name = "paper";
    scenario.text = "text";
    scenario.team = paper::team(paper::Variant::joint);
    scenario.team.add(Obstacle{"wall"});
    scenario.simulation.seed = 18446744073709551615ULL;
    scenario.safety = Safety{.barrier = BarrierMode::report};
    const auto solver = make_solver(scenario.solver, scenario.team, scenario.horizon);
    std::vector<double> x = paper::start();
    x.insert(x.end(), {3, 4, 0, 0, 0, 0});
    const Controllers controllers = {*solver};
    SpscQueue<Sample> ring(300, sized_sample(scenario.team, controllers));
    LoggedFlight result{made_folder("flight"), {}, scenario.team};
    Log log(scenario, result.folder, controllers, ring);
    fly(*solver, x, 200, [&](double time, const std::vector<double>& state, const Solution& solution) {
      Sample& sample = *ring.claim();
      sample.time = time;
      sample.x = sample.measured = state;
      const double psi = 0.1 * time / 0.01;
      sample.x[3] = std::cos(psi), sample.x[4] = std::sin(psi);
      sample.u.assign(solution.u.begin(), solution.u.end());
      sample.raw_u.assign(solution.raw_u.begin(), solution.raw_u.end());
      sample.solvers[0] = {solution.status, solution.residual, solution.iterations, 30.0 + time, 0};
      sample.update_us = 40.0 + time;
      sample.barriers[1] = {time > 1.0, false, time > 1.0 ? 0.25 : std::numeric_limits<double>::infinity()};
      sample.event_count = time == 0.5 ? 1 : 0;
      sample.events[0] = {0.5, EventKind::samples_dropped, 0, 3.0};
      result.samples.push_back(sample);
      ring.publish();
    });
    ring.close();
    log.start();
    log.finish();
    EXPECT_EQ(log.error(), "");
    return result;
  }();
  return flown;
}

// Whether a row of the recording tells what the sample held.
void expect_row(const Recording& run, std::size_t row) {
  const Sample& sample = flight().samples.at(row);
  const Team& team = flight().team;
  EXPECT_EQ(run.time[row], sample.time);
  EXPECT_EQ(run.cost[row], stage_cost(team, sample.time, sample.x, sample.u));
  EXPECT_EQ(run.controllers[0].status[row], to_string(sample.solvers[0].status));
  EXPECT_EQ(run.controllers[0].residual[row], sample.solvers[0].residual);
  EXPECT_EQ(run.controllers[0].iterations[row], sample.solvers[0].iterations);
  for (int i = 0; i < team.bodies(); ++i) {
    const BodyId body{i};
    const Recording::Body& recorded = run.bodies[static_cast<std::size_t>(i)];
    const double* u = sample.u.data() + team.input_offset(body);
    const Sight<double> sight = team.model(body).sight(sample.x.data() + team.state_offset(body), u);
    EXPECT_EQ(norm(recorded.p[row] - sight.p), 0.0);
    EXPECT_EQ(norm(recorded.v[row] - sight.v), 0.0);
    EXPECT_NEAR(std::cos(recorded.heading[row]), sight.d.x, 1e-12);
    EXPECT_NEAR(std::sin(recorded.heading[row]), sight.d.y, 1e-12);
    for (std::size_t q = 0; q < recorded.u.size(); ++q) EXPECT_EQ(recorded.u[q][row], u[q]);
    if (!team.is_agent(body)) continue;
    const bool acts = &recorded == &run.bodies[1] && sample.time > 1.0;
    EXPECT_EQ(recorded.barrier.at(row), acts ? 1.0 : 0.0);
    EXPECT_EQ(std::isnan(recorded.reserve.at(row)), !acts);
  }
}

TEST(Recording, EveryRowTellsWhatTheSampleHeld) {
  const Recording run = read_recording(flight().folder);
  EXPECT_TRUE(run.complete);
  ASSERT_EQ(run.time.size(), 200U);
  for (std::size_t row = 0; row < 200; ++row) expect_row(run, row);
  EXPECT_NEAR(run.solve_us[150], 31.5, 1e-3);
}

TEST(Recording, TeamPairsAndWordsAreThoseOfTheScenario) {
  const Recording run = read_recording(flight().folder);
  EXPECT_EQ(run.name, "paper");
  EXPECT_EQ(run.scenario, "text");
  EXPECT_EQ(run.version, version);
  EXPECT_EQ(run.compiler, compiler);
  EXPECT_EQ(run.solver, "newton_riccati");
  EXPECT_EQ(run.seed, 18446744073709551615ULL);
  EXPECT_EQ(run.period, 0.01);
  ASSERT_EQ(run.bodies.size(), 3U);
  EXPECT_EQ(run.bodies[0].name, "uav0");
  EXPECT_EQ(run.bodies[0].robot, "multirotor");
  EXPECT_EQ(run.bodies[0].inputs, (std::vector<std::string>{"u_f", "u_s", "u_z", "u_psi"}));
  EXPECT_EQ(run.bodies[0].u_max, std::vector<double>(4, 1.0));
  EXPECT_TRUE(run.bodies[1].is_agent);
  EXPECT_FALSE(run.bodies[2].is_agent);
  ASSERT_EQ(run.pairs.size(), 1U);
  EXPECT_EQ(run.pairs[0].observer, 0U);
  EXPECT_EQ(run.pairs[0].target, 1U);
  EXPECT_EQ(run.pairs[0].alpha, SensorCone{}.alpha);
  EXPECT_EQ(run.pairs[0].mount.offset, SensorMount{}.offset);
  EXPECT_EQ(run.pairs[0].d_min, 1.0);
  EXPECT_EQ(run.pairs[0].d_max, 2.0);
  ASSERT_EQ(run.events.size(), 1U);
  EXPECT_EQ(run.events[0].kind, "samples_dropped");
  EXPECT_EQ(run.events[0].time, 0.5);
  EXPECT_EQ(run.events[0].value, 3.0);
}

TEST(Recording, AReferenceIsThereWhereQAsksForItAndItsHeadingOnlyWhereItHasOne) {
  const Recording run = read_recording(flight().folder);
  EXPECT_TRUE(run.bodies[0].reference_time.empty());
  const Recording::Body& target = run.bodies[1];
  ASSERT_EQ(target.reference_time.size(), 20U);
  ASSERT_EQ(target.reference_p.size(), 20U);
  EXPECT_TRUE(target.reference_heading.empty());
  for (std::size_t i = 0; i < 20; ++i) {
    EXPECT_NEAR(target.reference_time[i], 0.1 * static_cast<double>(i), 1e-12);
    EXPECT_EQ(norm(target.reference_p[i] - paper::target_path()(target.reference_time[i]).p), 0.0);
  }
}

TEST(Recording, HeadingsGoOnWithoutJumpsOverMoreThanATurn) {
  const Recording run = read_recording(flight().folder);
  for (std::size_t row = 0; row < 200; ++row) {
    EXPECT_NEAR(run.bodies[0].heading[row], 0.1 * static_cast<double>(row), 1e-9);
  }
}

TEST(Recording, ALogCutOffAnywhereIsReadToItsLastWholeChunk) {
  const std::string log = read_file(flight().folder / "run.mcap");
  const fs::path folder = made_folder("cut");
  fs::copy_file(flight().folder / "timing.csv", folder / "timing.csv");
  std::size_t most = 0;
  for (std::size_t size = log.size() - 1; size > log.size() / 20; size -= log.size() / 97) {
    save(folder / "run.mcap", std::string_view(log).substr(0, size));
    const Recording run = read_recording(folder);
    EXPECT_FALSE(run.complete);
    ASSERT_EQ(run.bodies[0].p.size(), run.time.size());
    ASSERT_EQ(run.controllers[0].status.size(), run.time.size());
    for (std::size_t row = 0; row < run.time.size(); row += 17) expect_row(run, row);
    most = std::max(most, run.time.size());
  }
  EXPECT_EQ(most, 200U);
}

TEST(Recording, ALogThatIsReadWhileItGrowsGivesTheSameRows) {
  const std::string log = read_file(flight().folder / "run.mcap"),
                    times = read_file(flight().folder / "timing.csv");
  const Recording whole = read_recording(flight().folder);
  const fs::path folder = made_folder("grows");
  const std::size_t pieces = 23, first = log.size() / 20;
  const auto grow_to = [&](std::size_t piece) {
    save(folder / "run.mcap", std::string_view(log).substr(0, first + piece * (log.size() - first) / pieces));
    save(folder / "timing.csv", std::string_view(times).substr(0, piece * times.size() / pieces));
  };
  grow_to(0);
  RecordingReader reader(folder);
  std::size_t rows = 0;
  for (std::size_t piece = 0; piece <= pieces; ++piece) {
    grow_to(piece);
    reader.read_on();
    EXPECT_GE(reader.rows(), rows);
    rows = reader.rows();
    EXPECT_EQ(reader.run().complete, piece == pieces);
  }
  EXPECT_EQ(rows, whole.time.size());
  EXPECT_EQ(reader.run().time, whole.time);
  EXPECT_EQ(reader.run().solve_us, whole.solve_us);
  EXPECT_EQ(reader.run().bodies[0].u, whole.bodies[0].u);
  EXPECT_EQ(reader.run().events.size(), whole.events.size());
}

TEST(Recording, ARowOfTimesThatWasCutOffIsLeftOut) {
  const std::string times = read_file(flight().folder / "timing.csv");
  const fs::path folder = made_folder("times");
  fs::copy_file(flight().folder / "run.mcap", folder / "run.mcap");
  for (std::size_t size = times.size() - 1; size > times.size() - 60; --size) {
    const std::string part = times.substr(0, size);
    save(folder / "timing.csv", part);
    EXPECT_EQ(read_recording(folder).solve_us.size() + 1,
              static_cast<std::size_t>(std::count(part.begin(), part.end(), '\n')));
  }
}

// The sentence of what cannot be read.
std::string read_refusal(const fs::path& folder) {
  return refusal_of<std::runtime_error>([&] { read_recording(folder); });
}

/// The folder of the flight with another log.
fs::path edited(std::string_view name,
                const std::function<void(std::string_view topic, std::string& text)>& edit) {
  const fs::path folder = made_folder(name);
  fs::copy_file(flight().folder / "timing.csv", folder / "timing.csv", fs::copy_options::overwrite_existing);
  test::copy_log(flight().folder / "run.mcap", folder / "run.mcap", edit);
  return folder;
}
/// Without the messages of a topic at one time.
std::string refusal_without(std::string_view name, std::string_view without, std::string_view time) {
  return read_refusal(edited(name, [&](std::string_view topic, std::string& text) {
    if (topic == without && text.starts_with(fmt::format("{{\"time\":{},", time))) text.clear();
  }));
}

// Rows of bodies would be those of other times.
TEST(Recording, APeriodThatLacksWhatEachHasIsRefused) {
  EXPECT_THAT(refusal_without("no_state", "/uav1/state", "0.17"),
              testing::EndsWith(
                  "run.mcap is no sound log of a run: no message of /uav1/state at 0.17 s, expected one"));
  EXPECT_THAT(refusal_without("no_first_state", "/uav1/state", "0"),
              testing::HasSubstr("a message of /uav1/pose is no pose of a state"));
  EXPECT_THAT(refusal_without("no_last_state", "/wall/state", "1.99"),
              testing::HasSubstr("/wall/state at 1.99 s"));
  EXPECT_THAT(refusal_without("no_input", "/uav0/input", "1.2"), testing::HasSubstr("/uav0/input at 1.2 s"));
}

TEST(Recording, TwoMessagesOfOnePeriodAreRefused) {
  // What is left of the second one's period has the time of the first.
  const auto twice = [](std::string_view name, std::string_view of) {
    return read_refusal(edited(name, [&](std::string_view topic, std::string& text) {
      if (topic == of && text.starts_with("{\"time\":0.01,")) text.replace(0, 13, "{\"time\":0.0,");
    }));
  };
  EXPECT_THAT(twice("first_twice", "/uav0/state"), testing::HasSubstr("/uav0/state at 0 s after one at 0 s"));
  EXPECT_THAT(read_refusal(edited("state_twice",
                                  [n = 0](std::string_view topic, std::string& text) mutable {
                                    if (topic == "/uav0/state" && ++n == 2) text.clear();
                                  })),
              testing::HasSubstr("two messages of /uav0/input at 0.01 s, expected one"));
}

TEST(Recording, ALogThatLacksPeriodsSaysFromWhereOn) {
  const fs::path folder = edited("lost", [](std::string_view, std::string& text) {
    if (text.starts_with("{\"time\":1.23,") || text.starts_with("{\"time\":1.24,")) text.clear();
  });
  for (const std::size_t stride : {1U, 10U}) {
    const Recording run = read_recording(folder, {}, stride);
    EXPECT_TRUE(run.complete);
    ASSERT_TRUE(run.lost_after);
    EXPECT_NEAR(*run.lost_after, 1.22, 1e-12);
    EXPECT_EQ(run.time.size(), stride == 1 ? 198U : 20U);
  }
  EXPECT_FALSE(read_recording(flight().folder).lost_after);
}

TEST(Recording, PeriodsThatTheLoopMissedAndSaidSoAreNoGap) {
  const fs::path folder = edited("missed", [](std::string_view topic, std::string& text) {
    if (text.starts_with("{\"time\":1.23,") || text.starts_with("{\"time\":1.24,")) text.clear();
    if (topic == "/events") text = "{\"time\":1.25,\"kind\":\"missed_period\",\"controller\":0,\"value\":2}";
  });
  EXPECT_FALSE(read_recording(folder).lost_after);
  EXPECT_EQ(read_recording(folder).time.size(), 198U);
}

TEST(Recording, WhatCannotBeReadIsNamed) {
  const std::string log = read_file(flight().folder / "run.mcap");
  EXPECT_NE(read_refusal(made_folder("empty")).find("empty/run.mcap"), std::string::npos);
  save(made_folder("no_times") / "run.mcap", log);
  EXPECT_NE(read_refusal(made_folder("no_times")).find("no_times/timing.csv"), std::string::npos);
  save(made_folder("text") / "run.mcap", "no log at all");
  EXPECT_NE(read_refusal(made_folder("text")).find("text/run.mcap"), std::string::npos);
  std::string damaged = log;
  damaged[damaged.size() / 2] = static_cast<char>(damaged[damaged.size() / 2] ^ 0x10);
  save(made_folder("damaged") / "run.mcap", damaged);
  EXPECT_NE(read_refusal(made_folder("damaged")).find("damaged/run.mcap"), std::string::npos);
  save(made_folder("rows") / "run.mcap", log);
  save(made_folder("rows") / "timing.csv",
       "time,update_us,solve_us,allocations,iterations,missed\n0,1,2,none,4,5\n");
  EXPECT_NE(read_refusal(made_folder("rows")).find("\"0,1,2,none,4,5\", expected 6 numbers"),
            std::string::npos);
}

}  // namespace
}  // namespace sightline
