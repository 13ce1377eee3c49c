#include "cli/commands.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>

#include "sightline/log.hpp"
#include "tests/support/command.hpp"
#include "tests/support/refused_scenarios.hpp"

namespace sightline::cli {
namespace {

using nlohmann::json;
using test::fresh_folder;
using test::read_file;
using test::shell;
using test::short_scenario;
using test::sightline;
using testing::HasSubstr;
using testing::Not;
namespace fs = std::filesystem;

/// The summary of paper_7_1 as a solver flew it: the same task, done well.
void expect_paper_7_1(const json& s, const std::string& solver, double cost, double in_view_from) {
  EXPECT_EQ(s.at("scenario"), "paper_7_1");
  EXPECT_EQ(s.at("solver"), solver);
  EXPECT_EQ(s.at("updates"), 6000);
  EXPECT_NEAR(s.at("cost").get<double>(), cost, 0.05);
  EXPECT_EQ(s.at("allocations_per_update"), 0);
  EXPECT_EQ(s.at("not_finite"), 0);
  EXPECT_EQ(s.at("input_violations"), 0);
  EXPECT_LE(s.at("max_abs_input").get<double>(), 1.0);
  const json& pair = s.at("pairs").at(0);
  EXPECT_EQ(pair.at("observer"), "uav0");
  EXPECT_GE(pair.at("distance").at("min").get<double>(), 1.41);
  EXPECT_LE(pair.at("distance").at("max").get<double>(), 1.83);
  EXPECT_LE(pair.at("in_view_from").get<double>(), in_view_from);
  EXPECT_NEAR(s.at("agents").at(1).at("rms_position_error").get<double>(), 0.070, 0.005);
}

TEST(Run, FliesThePaperAndLeavesItsFiles) {
  const fs::path folder = fresh_folder(), out = folder / "out";
  const auto run = sightline("run scenarios/paper_7_1.toml -o " + out.string(), folder);
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(run.err, "");
  for (const char* file : {"run.mcap", "timing.csv", "summary.json", "report.html"}) {
    EXPECT_GT(fs::file_size(out / file), 1000u) << file;
  }
  expect_paper_7_1(json::parse(read_file(out / "summary.json")), "newton_riccati", 76.22, 11.0);
  expect_paper_7_1(json::parse(read_file(out / "cmscgmres" / "summary.json")), "cmscgmres", 79.82, 21.0);
}

TEST(Run, AComparisonIsTheFlightThatTheOtherSolverAloneWouldMake) {
  const fs::path folder = fresh_folder(), scenario = short_scenario(folder, "paper_7_1", "2.0");
  ASSERT_NE(sightline("run " + scenario.string() + " -o " + (folder / "a").string(), folder).code, 2);
  ASSERT_NE(
      sightline("run " + scenario.string() + " --solver cmscgmres -o " + (folder / "b").string(), folder)
          .code,
      2);
  EXPECT_TRUE(read_file(folder / "a" / "cmscgmres" / "run.mcap") == read_file(folder / "b" / "run.mcap"));
  EXPECT_TRUE(read_file(folder / "b" / "newton_riccati" / "run.mcap") ==
              read_file(folder / "a" / "run.mcap"));
  EXPECT_FALSE(fs::exists(folder / "b" / "cmscgmres"));
  const Recording recording = read_recording(folder / "a");
  ASSERT_FALSE(recording.comparisons.empty());
  for (const auto& other : recording.comparisons) {
    EXPECT_EQ(other.solve_us.size(), 200u);
    EXPECT_NE(read_file(folder / "a" / "report.html").find(other.solver + ": mean"), std::string::npos);
  }
}

TEST(Run, TheExampleFliesTheSameTrajectoryAsTheScenario) {
  const fs::path folder = fresh_folder();
  ASSERT_EQ(sightline("run scenarios/paper_7_1.toml -o " + (folder / "out").string(), folder).code, 0);
  const auto example = shell("'" SIGHTLINE_EXAMPLES "/sensor_tracking'", folder);
  ASSERT_EQ(example.code, 0);
  std::istringstream numbers(example.out);
  std::vector<double> x;  // one period after the last sample
  for (double v; numbers >> v;) x.push_back(v);
  ASSERT_EQ(x.size(), 14u);
  const Recording recording = read_recording(folder / "out");
  for (std::size_t body = 0; body < 2; ++body) {
    // 0.01 s at these speeds is less than 0.1 mm off a straight line.
    const auto& p = recording.bodies.at(body).p;
    const Vec3<double> next = p.back() + (p.back() - p[p.size() - 2]);
    EXPECT_NEAR(next.x, x[7 * body], 1e-4);
    EXPECT_NEAR(next.y, x[7 * body + 1], 1e-4);
    EXPECT_NEAR(next.z, x[7 * body + 2], 1e-4);
  }
}

TEST(Run, ThePaperSPotentialsAsTextFlyTheSameTrajectory) {
  const fs::path folder = fresh_folder();
  for (const std::string solver : {"cmscgmres", "newton_riccati"}) {
    std::vector<Recording> recordings;
    for (const char* name : {"paper_7_1", "paper_7_1_text"}) {
      const fs::path out = folder / (name + solver);
      const auto run = sightline(
          fmt::format("run scenarios/{}.toml --solver {} -o {}", name, solver, out.string()), folder);
      ASSERT_EQ(run.code, 0) << run.err;
      recordings.push_back(read_recording(out));
    }
    for (std::size_t body = 0; body < 2; ++body) {
      const auto &a = recordings[0].bodies.at(body).p, &b = recordings[1].bodies.at(body).p;
      ASSERT_EQ(a.size(), b.size());
      double apart = 0.0;
      for (std::size_t k = 0; k < a.size(); ++k) apart = std::max(apart, norm(a[k] - b[k]));
      EXPECT_LE(apart, 1e-7) << solver;
    }
  }
}

TEST(Run, ACameraThatIsTextKeepsTheTargetInItsImage) {
  const fs::path folder = fresh_folder();
  for (const std::string solver : {"cmscgmres", "newton_riccati"}) {
    const fs::path out = folder / solver;
    const auto run =
        sightline("run scenarios/pyramid_camera.toml --solver " + solver + " -o " + out.string(), folder);
    EXPECT_EQ(run.code, 0) << run.err;
    const json s = json::parse(read_file(out / "summary.json"));
    EXPECT_EQ(s.at("allocations_per_update"), 0);
    EXPECT_EQ(s.at("input_violations"), 0);
    EXPECT_EQ(s.at("limits").at(0).at("name"), "camera uav0-uav1");
    EXPECT_LE(s.at("pairs").at(0).at("in_view_from").get<double>(), 15.0) << solver;
  }
}

TEST(Run, ARoverAndTwoMultirotorsOfTwoKindsAreOneTeam) {
  const fs::path folder = fresh_folder();
  const auto run = sightline("run scenarios/ground_and_air.toml -o " + folder.string(), folder);
  EXPECT_EQ(run.code, 0) << run.err;
  const json s = json::parse(read_file(folder / "summary.json"));
  EXPECT_EQ(s.at("allocations_per_update"), 0);
  EXPECT_EQ(s.at("input_violations"), 0);
  EXPECT_GE(s.at("min_distance").get<double>(), 1.0);
  for (const json& pair : s.at("pairs")) EXPECT_LE(pair.at("in_view_from").get<double>(), 2.0);
  const Recording recording = read_recording(folder);
  const auto& rover = recording.bodies.at(2).p;
  for (std::size_t k = 0; k < rover.size(); ++k) {
    EXPECT_EQ(rover[k].z, 0.2);
    if (recording.time.at(k) < 6.0) continue;
    for (const std::size_t uav : {0U, 1U})
      EXPECT_NEAR(norm(recording.bodies.at(uav).p.at(k) - rover[k]), 1.5, 0.5);
  }
}

TEST(Run, TheExampleOfASensorOfOneSOwnKeepsItsTargetInView) {
  const auto example = shell("'" SIGHTLINE_EXAMPLES "/own_sensor'", fresh_folder());
  EXPECT_EQ(example.code, 0);
  EXPECT_EQ(example.out, "after 30 s: in view\n");
}

TEST(Run, TheExampleOfARobotOfOneSOwnIsKeptInViewAtADistance) {
  const auto example = shell("'" SIGHTLINE_EXAMPLES "/own_robot'", fresh_folder());
  EXPECT_EQ(example.code, 0);
  double least = 0, most = 0, angle = 0;
  ASSERT_EQ(std::sscanf(example.out.c_str(), "distance %lf to %lf m, at most %lf rad from the axis", &least,
                        &most, &angle),
            3)
      << example.out;
  EXPECT_GE(least, 1.0);
  EXPECT_LE(most, 2.0);
  EXPECT_LE(angle, 0.5);
}

TEST(Run, TheLogIsTheSameByteForByteWhateverTheThreads) {
  const fs::path folder = fresh_folder();
  for (const char* threads : {"1", "3"}) {
    const auto run = sightline(std::string("run scenarios/swarm128.toml --set simulation.duration=0.3 "
                                           "--set safety.barrier=\"on\" --threads ") +
                                   threads + " -o " + (folder / threads).string(),
                               folder);
    EXPECT_LT(run.code, 2) << run.err;
  }
  const std::string one = read_file(folder / "1" / "run.mcap");
  EXPECT_GT(one.size(), 100000u);
  EXPECT_TRUE(one == read_file(folder / "3" / "run.mcap"));
}

// 500 of 600 updates without a plan ended with exit code 0.
TEST(Run, ASolverThatGivesNoPlanForLongIsAFailureAndALatePlanIsTold) {
  const fs::path folder = fresh_folder();
  const std::string text = std::regex_replace(read_file(SIGHTLINE_SOURCE_DIR "/scenarios/yaw_step.toml"),
                                              std::regex("duration = 20.0"), "duration = 5.0");
  const auto flown = [&](const std::string& name, const std::string& fault) {
    std::ofstream(folder / (name + ".toml")) << text << "\n[[simulation.fault]]\n" << fault;
    return sightline("run " + (folder / (name + ".toml")).string() + " -o " + (folder / name).string(),
                     folder);
  };
  const auto gap = [&](const std::string& name) {
    return json::parse(read_file(folder / name / "summary.json")).at("without_plan");
  };
  const auto blind = flown("blind", "kind = \"nan\"\nfrom = 1.0\nuntil = 2.0\n");
  EXPECT_EQ(blind.code, 1);
  EXPECT_NE(
      blind.err.find(
          "the solver gave no plan for 1.00 s from 1.00 s on (invalid_state), expected one within 0.5 s"),
      std::string::npos)
      << blind.err;
  EXPECT_EQ(gap("blind").at("status"), "invalid_state");
  EXPECT_NE(blind.out.find("without a plan"), std::string::npos);

  const auto shortly = flown("shortly", "kind = \"nan\"\nfrom = 1.0\nuntil = 1.4\n");
  EXPECT_EQ(shortly.code, 0) << shortly.err;
  EXPECT_NEAR(gap("shortly").at("longest").get<double>(), 0.4, 0.011);

  const auto late = flown("late", "kind = \"late_plan\"\nfrom = 1.0\nuntil = 1.5\ndelay = 0.8\n");
  EXPECT_EQ(late.err.find("gave no plan"), std::string::npos) << late.err;
  EXPECT_NEAR(gap("late").at("longest").get<double>(), 0.8, 0.011);
}

TEST(Run, RealTimeTakesTheTimeItSays) {
  const fs::path folder = fresh_folder();
  const fs::path scenario = short_scenario(folder, "paper_7_1", "2.0");
  const auto begin = std::chrono::steady_clock::now();
  const auto run =
      sightline("run --realtime " + scenario.string() + " -o " + (folder / "out").string(), folder);
  const double took = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  EXPECT_GE(took, 1.98);  // the last period ends the run at its start
  EXPECT_NE(run.code, 2) << run.err;
  const json s = json::parse(read_file(folder / "out" / "summary.json"));
  EXPECT_EQ(s.at("allocations_per_update"), 0);
}

TEST(Report, IsMadeAgainFromTheFilesAlone) {
  const fs::path folder = fresh_folder();
  const fs::path out = folder / "out", scenario = short_scenario(folder, "paper_7_1", "3.0");
  sightline("run " + scenario.string() + " -o " + out.string(), folder);
  fs::remove(scenario);
  const std::string first = read_file(out / "report.html");
  fs::remove(out / "report.html");
  const auto report = sightline("report " + out.string(), folder);
  EXPECT_EQ(report.code, 0) << report.err;
  EXPECT_TRUE(first == read_file(out / "report.html"));
  EXPECT_NE(report.out.find("report.html"), std::string::npos);
}

TEST(Report, RefusesWhatIsNoRun) {
  const fs::path folder = fresh_folder();
  for (const fs::path& bad : {folder, folder / "nowhere"})
    (void)test::refused("report " + bad.string(), folder);
}

TEST(Check, SaysOkAndDescribesEachShippedScenario) {
  const fs::path folder = fresh_folder();
  for (const auto& entry : fs::directory_iterator(SIGHTLINE_SOURCE_DIR "/scenarios")) {
    if (entry.path().extension() != ".toml") continue;
    const auto check = sightline("check " + entry.path().string(), folder);
    EXPECT_EQ(check.code, 0) << check.err;
    EXPECT_EQ(check.out.rfind("ok\n", 0), 0u) << check.out;
    for (const char* word : {"agent", "states", "inputs", "stages"}) {
      EXPECT_NE(check.out.find(word), std::string::npos) << entry.path() << " " << word;
    }
  }
}

TEST(Commands, ACommandThatIsNoneOrMissingEndsWithTwoAndTheNamesThatThereAre) {
  const fs::path folder = fresh_folder();
  EXPECT_THAT(test::refused("chekc scenarios/paper_7_1.toml", folder),
              testing::MatchesRegex("sightline: chekc is no command, .*, the nearest is check\n"));
  EXPECT_THAT(test::refused("", folder),
              testing::MatchesRegex("sightline: the command is missing, .*, bench\n"));
}

TEST(Check, EachRefusedScenarioEndsWithTwoAndOneLine) {
  const fs::path folder = fresh_folder();
  for (const test::RefusedScenario& c : test::refused_scenarios()) {
    const fs::path file = folder / (c.name + ".toml");
    std::ofstream(file, std::ios::binary) << c.text;
    // What is wrong with a campaign alone stops no other flight.
    const auto commands = c.table == "campaigns" ? std::vector<std::string>{"campaign "}
                                                 : std::vector<std::string>{"check ", "run "};
    for (const std::string& command : commands) {
      const auto result = sightline(command + file.string(), folder);
      EXPECT_EQ(result.code, 2) << c.name;
      EXPECT_EQ(result.err, file.string() + ":" + c.sentence + "\n");
      EXPECT_EQ(result.out, "");
    }
  }
}

TEST(Check, AFormulaThatIsNoNumberSomewhereIsFoundWithThePlace) {
  const fs::path folder = fresh_folder();
  std::string text = read_file(SIGHTLINE_SOURCE_DIR "/scenarios/paper_7_1.toml");
  text = std::regex_replace(text, std::regex("potential = \\{ cohesion = .*"),
                            "potential = { region = { inside = \"sqrt(x * 1 m) < 2 m\" } }");
  std::ofstream(folder / "root.toml") << text;
  EXPECT_THAT(
      test::refused("check " + (folder / "root.toml").string(), folder),
      testing::ContainsRegex("root.toml:[0-9]+: couple.2. region is no finite number with observer at"));
}

TEST(Check, SaysWhichCornersOfARegionAreRoundedOff) {
  const fs::path folder = fresh_folder();
  const auto check = sightline("check scenarios/pyramid_camera.toml", folder);
  EXPECT_NE(check.out.find("couple[0] camera: corners of abs, norm are rounded off over 0.001 (m, rad)\n"),
            std::string::npos)
      << check.out;
}

TEST(Check, WarnsOfAnObstacleFasterThanTheBarrierReckonsWith) {
  const fs::path folder = fresh_folder();
  std::string text = read_file(fs::path(SIGHTLINE_SOURCE_DIR) / "scenarios/paper_7_3_ours.toml");
  const std::string words = "the barrier reckons with speed_max";
  EXPECT_THAT(sightline("check scenarios/paper_7_3_ours.toml", folder).out, Not(HasSubstr(words)));
  text.replace(text.find("speed_max = 0.3"), 15, "speed_max = 0.2");
  std::ofstream(folder / "fast.toml") << text;
  const auto done = sightline("check " + (folder / "fast.toml").string(), folder);
  EXPECT_EQ(done.code, 0);
  EXPECT_THAT(done.out, HasSubstr("warning     hand moves at up to 0.3 m/s, " + words + " = 0.2 m/s"));
}

TEST(Commands, BadWordsEndWithTwo) {
  const fs::path folder = fresh_folder();
  for (const char* words :
       {"run", "check", "report", "run scenarios/paper_7_1.toml --seed x",
        "run scenarios/paper_7_1.toml --seed -1", "run scenarios/paper_7_1.toml --seed 9223372036854775808",
        "run scenarios/paper_7_1.toml --seed 1.5", "run scenarios/paper_7_1.toml --solver best",
        "check nowhere.toml", "version now"}) {
    const auto result = sightline(words, folder);
    EXPECT_EQ(result.code, 2) << words;
    EXPECT_NE(result.err, "") << words;
  }
}

TEST(Commands, VersionNamesItself) {
  const fs::path folder = fresh_folder();
  const auto version = sightline("version", folder);
  EXPECT_EQ(version.code, 0);
  EXPECT_EQ(version.out.rfind("sightline ", 0), 0u) << version.out;
  const auto flag = sightline("--version", folder);
  EXPECT_EQ(flag.code, 0);
  EXPECT_EQ(flag.out, version.out);
}

}  // namespace
}  // namespace sightline::cli
