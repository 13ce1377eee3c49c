// Who writes into which folder, and what is there at any moment.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <map>

#include "sightline/log.hpp"
#include "tests/support/child.hpp"
#include "tests/support/command.hpp"

namespace sightline::cli {
namespace {

namespace fs = std::filesystem;
using test::Child;
using test::eventually;
using test::fresh_folder;
using test::read_file;
using test::short_scenario;
using test::sightline;
using testing::AllOf;
using testing::HasSubstr;

const std::string paper_7_1 = SIGHTLINE_SOURCE_DIR "/scenarios/paper_7_1.toml";

/// All files within a folder, but for locks, with their contents.
std::map<std::string, std::string> contents(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file() && entry.path().filename() != ".lock")
      files[entry.path().native()] = read_file(entry.path());
  return files;
}

TEST(Folders, WhoeverWouldWriteWhereAFlightWritesIsRefusedBeforeItTouchesAnything) {
  const fs::path folder = fresh_folder(), out = folder / "out";
  const std::string scenario = short_scenario(folder, "paper_7_1", "60.0").string();
  Child flight({"run", "--realtime", scenario, "-o", out});
  ASSERT_TRUE(eventually([&] { return fs::exists(out / "run.mcap"); }));
  const auto inode = [&] {
    struct stat status {};
    ::stat((out / "run.mcap").c_str(), &status);
    return status.st_ino;
  };
  const auto log = inode();
  const std::string other = "scenarios/cooperative_localization.toml";
  for (const auto& [words, where] :
       {std::pair{"run " + scenario + " -o " + out.string(), out},
        {"run " + scenario + " -o " + (out / "cmscgmres").string(), out / "cmscgmres"},
        {"report " + out.string(), out},
        {"potential " + scenario + " -o " + out.string(), out},
        {"campaign " + other + " --only 1 -o " + out.string(), out},
        {"campaign " + other + " --runs 2 -o " + out.string(), out}}) {
    const auto second = sightline(words, folder);
    EXPECT_EQ(second.code, 2) << words;
    EXPECT_EQ(second.out, "") << words;
    EXPECT_THAT(second.err,
                AllOf(HasSubstr(where.native() + ": another sightline (process "),
                      HasSubstr(std::to_string(flight.pid()) + ")"), HasSubstr("give another folder by -o")))
        << words;
  }
  EXPECT_EQ(inode(), log);
  EXPECT_FALSE(fs::exists(out / "report.html") || fs::exists(out / "index.html") ||
               fs::exists(out / "campaign.sqlite"));
  flight.end(SIGKILL);
  EXPECT_FALSE(read_recording(out).time.empty());
  EXPECT_EQ(sightline("report " + out.string(), folder).code, 0) << "the lock went with the flight";
  EXPECT_FALSE(fs::exists(out / ".lock"));
}

TEST(Folders, AFlightAgainReplacesAllOfTheOneBefore) {
  const fs::path folder = fresh_folder(), out = folder / "out", fresh = folder / "fresh";
  const std::string scenario = short_scenario(folder, "paper_7_1", "1.0").string();
  (void)sightline("run " + scenario + " --seed 2 -o " + out.string(), folder);
  std::ofstream(out / "partition.json") << "of another flight";
  (void)sightline("run " + scenario + " --solver cmscgmres -o " + out.string(), folder);
  (void)sightline("run " + scenario + " --solver cmscgmres -o " + fresh.string(), folder);
  EXPECT_TRUE(read_file(out / "run.mcap") == read_file(fresh / "run.mcap"));
  EXPECT_TRUE(read_recording(out).comparisons.size() == read_recording(fresh).comparisons.size());
  EXPECT_FALSE(fs::exists(out / "partition.json") || fs::exists(out / "cmscgmres" / "summary.json"));
}

TEST(Folders, WhatIsNoFileIsRefusedAndNotWaitedFor) {
  const fs::path folder = fresh_folder(), out = folder / "out";
  const std::string scenario = short_scenario(folder, "paper_7_1", "1.0").string();
  const auto refused = [&](const std::string& words, const fs::path& place) {
    fs::create_directories(place.parent_path());
    for (const char* make : {"mkfifo ", "mkdir ", "ln -s /dev/full ", "ln -s /dev/zero "}) {
      ASSERT_EQ(test::shell(make + place.string(), folder).code, 0);
      const auto done =
          test::shell("timeout 20 '" SIGHTLINE_BINARY "' " + words + " -o " + out.string(), folder);
      EXPECT_EQ(done.code, 2) << make << place;
      EXPECT_THAT(done.err, AllOf(HasSubstr(place.native()), HasSubstr("expected a regular file or none\n")));
      EXPECT_EQ(std::count(done.err.begin(), done.err.end(), '\n'), 1) << done.err;
      fs::remove_all(place);
    }
  };
  for (const char* name : {"run.mcap", "timing.csv", "summary.json", "report.html", "cmscgmres/run.mcap",
                           "run.mcap.part", ".lock"})
    refused("run " + scenario, out / name);
  for (const char* name : {"campaign.sqlite", "campaign.html"})
    refused("campaign scenarios/cooperative_localization.toml --runs 1", out / name);
  refused("potential " + scenario, out / "index.html");
  EXPECT_TRUE(contents(out).empty());
}

TEST(Folders, AReportWaitsForNoPipe) {
  const fs::path folder = fresh_folder(), out = folder / "out";
  (void)sightline("run " + short_scenario(folder, "paper_7_1", "1.0").string() + " -o " + out.string(),
                  folder);
  const std::string report = "timeout 20 '" SIGHTLINE_BINARY "' report " + out.string();
  for (const auto& [name, code] : {std::pair{"timing.csv", 2},
                                   {"summary.json", 2},
                                   {"report.html", 2},
                                   {"cmscgmres/timing.csv", 1},
                                   {"cmscgmres/summary.json", 0}}) {
    const fs::path file = out / name, kept = folder / "kept";
    fs::rename(file, kept);
    ASSERT_EQ(::mkfifo(file.c_str(), 0666), 0);
    EXPECT_EQ(test::shell(report, folder).code, code) << name;
    fs::rename(kept, file);
  }
}

TEST(Folders, AFolderThatTakesNoFilesIsNoticedBeforeTheFlight) {
  const fs::path folder = fresh_folder();
  for (const std::string& words :
       {"run " + short_scenario(folder, "paper_7_1", "1.0").string(), "potential " + paper_7_1,
        std::string("campaign scenarios/cooperative_localization.toml --runs 1")}) {
    const auto done = sightline(words + " -o /proc/self", folder);
    EXPECT_EQ(done.code, 2) << words;
    EXPECT_THAT(done.err, testing::MatchesRegex(
                              "/proc/self: cannot be written \\(.*\\), expected a folder that can\n"));
  }
}

TEST(Folders, AReportThatFailsLeavesTheOneBefore) {
  const fs::path folder = fresh_folder(), out = folder / "out";
  (void)sightline("run " + short_scenario(folder, "paper_7_1", "1.0").string() + " -o " + out.string(),
                  folder);
  const auto before = contents(out);
  EXPECT_EQ(test::shell("ulimit -f 8; '" SIGHTLINE_BINARY "' report " + out.string(), folder).code, 1);
  EXPECT_TRUE(contents(out) == before);
}

// Ended at any moment, by whatever signal: nothing is left elsewhere, and in the folder what opens.
TEST(Folders, ASignalLeavesNothingInTheFolderForTemporaryFiles) {
  const fs::path folder = fresh_folder(), out = folder / "out", temporary = folder / "tmp";
  const std::string scenario = short_scenario(folder, "paper_7_1", "1.0").string();
  fs::create_directory(temporary);
  ::setenv("TMPDIR", temporary.c_str(), 1);
  for (const int signal : {SIGTERM, SIGINT, SIGKILL}) {
    for (const int ms : {20, 60, 120}) {
      Child flight({"run", scenario, "-o", out}, [] { (void)!::freopen("/dev/null", "w", stdout); });
      std::this_thread::sleep_for(std::chrono::milliseconds(ms));
      flight.end(signal);
    }
  }
  ::unsetenv("TMPDIR");
  EXPECT_TRUE(fs::is_empty(temporary));
}

}  // namespace
}  // namespace sightline::cli
