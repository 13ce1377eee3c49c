#include "sightline/record/log.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "sightline/log.hpp"
#include "sightline/potentials.hpp"
#include "sightline/readers/cdr.hpp"
#include "tests/support/command.hpp"
#include "tests/support/folder.hpp"

namespace sightline {
namespace {

namespace fs = std::filesystem;
using test::place;
using test::read_file;
using Json = nlohmann::json;

// One robot sees another; both, and a wall, are in the log.
Scenario some_scenario() {
  Scenario scenario;
  scenario.name = "some";
  scenario.text = "[horizon]\nduration = 1.0 # \"text\"\n";
  Team& team = scenario.team;
  const AgentId a = team.add(Multirotor{}, {.name = "watcher"});
  const AgentId b =
      team.add(AngleMultirotor{}, {.Q = {1, 1, 1, 1, 0, 0}, .x_ref = Circle{}, .name = "target"});
  team.add(Obstacle{"wall"});
  team.couple(1.0 * SensorCone{}, Between{a, b});
  return scenario;
}

constexpr int stages = 3;

Sample sized(const Scenario& scenario) {
  Sample sample;
  sample.x.resize(static_cast<std::size_t>(scenario.team.nx()));
  sample.u.resize(static_cast<std::size_t>(scenario.team.nu()));
  sample.raw_u = sample.u;
  sample.measured = sample.x;
  sample.stamps.resize(static_cast<std::size_t>(scenario.team.bodies()));
  sample.solvers.resize(1);
  sample.path.resize(stages * sample.x.size());
  sample.path_step = 0.05;
  sample.presence.assign(static_cast<std::size_t>(scenario.team.bodies()), Presence::steered);
  return sample;
}

// A flight that no model would make, but whose every number has all its digits.
void fill(Sample& sample, int k, const Scenario& scenario) {
  sample.time = k * scenario.horizon.dt;
  for (std::size_t i = 0; i < sample.x.size(); ++i) {
    sample.x[i] = std::sin(0.37 * k + static_cast<double>(i));
    sample.measured[i] = sample.x[i] + 0.01;
  }
  for (std::size_t i = 0; i < sample.u.size(); ++i) {
    sample.raw_u[i] = 1.3 * std::cos(0.21 * k + static_cast<double>(i));
    sample.u[i] = std::clamp(sample.raw_u[i], -1.0, 1.0);
  }
  sample.solvers[0] = {Status::stepped, 0.1 / (1 + k), 7, 12.5 + k, 0};
  sample.update_us = 20.25 + k;
  sample.has_path = k % 10 == 0;
  for (std::size_t i = 0; i < sample.path.size(); ++i) sample.path[i] = sample.x[i % sample.x.size()];
  sample.event_count = k == 5 ? 1 : 0;
  sample.events[0] = {sample.time, EventKind::missed_period, 0, 2.0};
}

struct Written {
  std::string error;
  SummaryValues values;
};

// Runs `samples` periods through the log; `change` sees each before it goes into the ring.
Written write(
    const Scenario& scenario, const fs::path& folder, int samples,
    const std::function<void(double)>& written = {},
    const std::function<void(int, Sample&)>& change = [](int, Sample&) {}) {
  SpscQueue<Sample> ring(4, sized(scenario));
  // The log counts controllers and asks them nothing.
  class Nobody final : public Solver {
    std::string_view name() const override { return "nobody"; }
    const Ocp& ocp() const override { return *ocp_; }
    Solution solve(double, std::span<const double>) noexcept override { return {}; }
    double kkt(double, std::span<const double>) noexcept override { return 0.0; }
    void planned(double, std::span<double>) const noexcept override {}
    void restart() noexcept override {}
    const Ocp* ocp_ = nullptr;
  } nobody;
  Log log(scenario, folder, {nobody}, ring, written);
  log.start();
  for (int k = 0; k < samples; ++k) {
    Sample* sample = ring.claim();
    while (sample == nullptr) sample = ring.claim();
    fill(*sample, k, scenario);
    change(k, *sample);
    ring.publish();
  }
  ring.close();
  log.finish();
  return {log.error(), log.summary().values()};
}

std::map<std::string, std::vector<Json>> json_of(const fs::path& folder) {
  std::map<std::string, std::vector<Json>> topics;
  McapReader reader(folder / "run.mcap");
  reader.visit([&](const McapMessage& m) {
    const auto* text = reinterpret_cast<const char*>(m.bytes.data());
    if (m.encoding == "json") {
      topics[std::string(m.topic)].push_back(Json::parse(text, text + m.bytes.size()));
    } else {
      topics[std::string(m.topic)].push_back(m.log_time);
    }
  });
  EXPECT_TRUE(reader.ok()) << reader.error();
  return topics;
}

TEST(Log, EveryNumberIsReadBackToTheSameBits) {
  const Scenario scenario = some_scenario();
  const Written flown = write(scenario, place("bits"), 57);
  EXPECT_EQ(flown.error, "");
  auto topics = json_of(place("bits"));
  Sample sample = sized(scenario);
  for (int k = 0; k < 57; ++k) {
    fill(sample, k, scenario);
    const auto row = static_cast<std::size_t>(k);
    std::vector<double> x, u, raw;
    for (const char* body : {"/watcher/", "/target/", "/wall/"}) {
      const Json& state = topics[std::string(body) + "state"].at(row);
      EXPECT_EQ(state.at("time").get<double>(), sample.time);
      for (const double value : state.at("x")) x.push_back(value);
    }
    for (const char* body : {"/watcher/", "/target/"}) {
      const Json& input = topics[std::string(body) + "input"].at(row);
      for (const double value : input.at("u")) u.push_back(value);
      for (const double value : input.at("raw")) raw.push_back(value);
    }
    EXPECT_EQ(x, sample.x);
    EXPECT_EQ(u, sample.u);
    EXPECT_EQ(raw, sample.raw_u);
    const Json& solver = topics["/solver"].at(row);
    EXPECT_EQ(solver.at("status"), "stepped");
    EXPECT_EQ(solver.at("residual").get<double>(), sample.solvers[0].residual);
    EXPECT_EQ(solver.at("cost").get<double>(), stage_cost(scenario.team, sample.time, sample.x, sample.u));
  }
  EXPECT_EQ(topics["/watcher/path"].size(), 6U);
  EXPECT_EQ(topics["/target/reference"].size(), 6U);
  EXPECT_FALSE(topics.contains("/watcher/reference"));
  EXPECT_FALSE(topics.contains("/watcher/measured"));
  EXPECT_EQ(topics["/events"].at(0).at("kind"), "missed_period");
}

TEST(Log, TheMeasuredPoseIsThereWhereItDiffersFromTheTrueOne) {
  Scenario scenario = some_scenario();
  scenario.simulation.disturbances.noise.position = 0.01;
  write(scenario, place("noise"), 12);
  EXPECT_EQ(json_of(place("noise"))["/watcher/measured"].size(), 12U);
}

TEST(Log, EqualRunsGiveEqualBytesWhateverTheirTimes) {
  const Scenario scenario = some_scenario();
  write(scenario, place("one"), 200);
  write(scenario, place("two"), 200, {}, [](int k, Sample& sample) {
    sample.update_us += 3.0 * k;
    sample.solvers[0].solve_us += 1.0;
    sample.solvers[0].allocations = 9;
  });
  EXPECT_EQ(read_file(place("one") / "run.mcap"), read_file(place("two") / "run.mcap"));
  EXPECT_NE(read_file(place("one") / "timing.csv"), read_file(place("two") / "timing.csv"));
}

TEST(Log, WhatIsSaidToBeWrittenIsInTheFilesByThen) {
  const Scenario scenario = some_scenario();
  const fs::path folder = place("kill"), copy = place("killed");
  fs::create_directories(copy);
  int said = 0;
  double last = -1.0;
  write(scenario, folder, 155, [&](double time) {
    ++said;
    EXPECT_GT(time, last);
    EXPECT_LE(time, last < 0 ? 0.0 : last + 0.1 + 1e-9);
    last = time;
    fs::copy_file(folder / "run.mcap", copy / "run.mcap", fs::copy_options::overwrite_existing);
    const auto topics = json_of(copy);
    const Json& state = topics.at("/wall/state").back();
    EXPECT_GE(state.at("time").get<double>(), time - scenario.horizon.dt - 1e-9);
    const std::string timing = read_file(folder / "timing.csv");
    const auto rows = static_cast<std::size_t>(std::count(timing.begin(), timing.end(), '\n')) - 1;
    EXPECT_EQ(rows, topics.at("/wall/state").size());
  });
  EXPECT_EQ(said, 17);
  EXPECT_NEAR(last, 1.55, 1e-9);
}

TEST(Log, TimingHasARowForEachPeriod) {
  write(some_scenario(), place("timing"), 8);
  std::ifstream file(place("timing") / "timing.csv");
  std::vector<std::string> rows;
  for (std::string row; std::getline(file, row);) rows.push_back(row);
  ASSERT_EQ(rows.size(), 9U);
  EXPECT_EQ(rows[0], "time,update_us,solve_us,allocations,iterations,missed");
  EXPECT_EQ(rows[1], "0,20.250,12.500,0,7,0");
  EXPECT_EQ(rows[6], "0.05,25.250,17.500,0,7,2");
}

TEST(Log, NumbersThatAreNotFiniteAreNullAndNeverInARosMessage) {
  const double bad = std::numeric_limits<double>::quiet_NaN();
  const Written flown = write(some_scenario(), place("nan"), 30, {}, [&](int k, Sample& sample) {
    if (k == 10) sample.x[0] = sample.raw_u[1] = sample.path[2] = bad;
  });
  EXPECT_EQ(flown.values.not_finite, 1);
  auto topics = json_of(place("nan"));
  EXPECT_TRUE(topics["/watcher/state"].at(10).at("x").at(0).is_null());
  EXPECT_TRUE(topics["/watcher/input"].at(10).at("raw").at(1).is_null());
  EXPECT_EQ(topics["/watcher/pose"].size(), 29U);
  EXPECT_EQ(topics["/watcher/path"].size(), 2U);
  EXPECT_EQ(topics["/target/pose"].size(), 30U);
}

TEST(Log, AFullDiskIsSaidOnceAndTheLoopGoesOn) {
  const auto ignored = std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ::getrlimit(RLIMIT_FSIZE, &before);
  const rlimit small{40'000, before.rlim_max};
  ::setrlimit(RLIMIT_FSIZE, &small);
  double said = 0.0;
  const Written flown = write(some_scenario(), place("full"), 1000, [&](double time) { said = time; });
  ::setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, ignored);
  EXPECT_NE(flown.error.find("run.mcap"), std::string::npos) << flown.error;
  EXPECT_EQ(flown.values.updates, 1000);
  // What was said before the disk was full is there.
  EXPECT_LT(said, 9.0);
  EXPECT_GE(json_of(place("full")).at("/wall/state").back().at("time").get<double>(), said - 1e-9);
}

TEST(Log, AFolderThatCannotBeMadeIsSaidAndTheLoopGoesOn) {
  std::ofstream(place("file")) << "no folder";
  const Written flown = write(some_scenario(), place("file") / "run", 20);
  EXPECT_NE(flown.error.find("file/run/run.mcap"), std::string::npos) << flown.error;
  EXPECT_EQ(flown.values.updates, 20);
}

TEST(Log, AnEarlierRunsSummaryAndReportAreRemoved) {
  fs::create_directories(place("again"));
  for (const char* name : {"summary.json", "report.html"}) std::ofstream(place("again") / name) << "old";
  write(some_scenario(), place("again"), 3);
  EXPECT_FALSE(fs::exists(place("again") / "summary.json"));
  EXPECT_FALSE(fs::exists(place("again") / "report.html"));
}

TEST(Log, AnEarlierLogStandsUntilTheFirstSampleOfTheNextOne) {
  const fs::path folder = place("earlier"), part = folder / "run.mcap.part";
  write(some_scenario(), folder, 50);
  std::ofstream(folder / "summary.json") << "of it";
  const std::string earlier = read_file(folder / "run.mcap"), rows = read_file(folder / "timing.csv");
  EXPECT_EQ(write(some_scenario(), folder, 0).error, "");
  EXPECT_EQ(read_file(folder / "run.mcap"), earlier);
  EXPECT_EQ(read_file(folder / "timing.csv"), rows);
  EXPECT_EQ(read_file(folder / "summary.json"), "of it");
  EXPECT_FALSE(fs::exists(part) || fs::exists(folder / "timing.csv.part"));
  fs::create_directories(part / "full");
  const Written refused = write(some_scenario(), folder, 5);
  EXPECT_NE(refused.error, "");
  EXPECT_EQ(refused.values.updates, 5);
  EXPECT_EQ(read_file(folder / "run.mcap"), earlier);
  EXPECT_EQ(read_file(folder / "summary.json"), "of it");
  fs::remove_all(part);
  double first = -1.0;
  EXPECT_EQ(write(some_scenario(), folder, 5,
                  [&](double time) {
                    if (first >= 0) return;
                    first = time;
                    EXPECT_EQ(json_of(folder).at("/wall/state").size(), 1U);
                  })
                .error,
            "");
  EXPECT_EQ(first, 0.0);
  EXPECT_FALSE(fs::exists(part) || fs::exists(folder / "timing.csv.part") ||
               fs::exists(folder / "summary.json"));
}

TEST(Log, WhoeverLooksOnMayFailWithoutHarm) {
  const Written flown = write(some_scenario(), place("onlooker"), 100, [](double time) {
    if (time > 0.25) throw std::runtime_error("the terminal has gone");
  });
  EXPECT_EQ(flown.error, "");
  EXPECT_EQ(flown.values.updates, 100);
  EXPECT_EQ(json_of(place("onlooker")).at("/wall/state").size(), 100U);
}

TEST(Log, AReferenceThatThrowsEndsNeitherJudgingNorWhatIsWritten) {
  const fs::path folder = place("thrown");
  Scenario scenario = some_scenario();
  Team team;
  for (Agent agent : scenario.team.agents()) {
    if (agent.name == "target") {
      agent.x_ref = Reference([](double t) -> Pose<double> {
        if (t > 0.599) throw std::runtime_error("no such place");
        return {};
      });
    }
    team.add(std::move(agent));
  }
  team.add(Obstacle{"wall"});
  scenario.team = std::move(team);
  const Written flown = write(scenario, folder, 65);
  EXPECT_EQ(flown.error, "");
  EXPECT_EQ(json_of(folder).at("/wall/state").size(), 65U);
  EXPECT_EQ(flown.values.updates, 65);
}

TEST(Log, TheFormatsOwnLibraryReadsEveryMessage) {
  const fs::path npm = fs::path(SIGHTLINE_SOURCE_DIR) / "tests" / "npm";
  ASSERT_TRUE(fs::exists(npm / "node_modules"))
      << "tests/npm/node_modules is missing, run scripts/test.sh, which installs it";
  Scenario scenario = some_scenario();
  scenario.simulation.disturbances.noise.heading = 0.01;
  write(scenario, place("npm"), 250);
  const fs::path said = place("npm") / "said";
  const std::string command = fmt::format("node '{}' '{}' > '{}' 2>&1", (npm / "read_mcap.mjs").string(),
                                          (place("npm") / "run.mcap").string(), said.string());
  EXPECT_EQ(std::system(command.c_str()), 0) << read_file(said);
  EXPECT_NE(read_file(said).find("/watcher/pose 250"), std::string::npos) << read_file(said);
}

}  // namespace
}  // namespace sightline
