#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <pty.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <random>
#include <regex>
#include <system_error>

#include "sightline/campaign/database.hpp"
#include "sightline/log.hpp"
#include "tests/support/campaign.hpp"
#include "tests/support/child.hpp"
#include "tests/support/command.hpp"

namespace sightline {
namespace {

/// What a terminal showed of a run that was killed after some time.
std::string shown_until_killed(const std::string& scenario, const std::string& folder,
                               std::chrono::milliseconds after) {
  int terminal = -1;
  const pid_t child = forkpty(&terminal, nullptr, nullptr, nullptr);
  if (child < 0) throw std::system_error(errno, std::generic_category(), "forkpty");
  if (child == 0) {
    execl(SIGHTLINE_BINARY, "sightline", "run", "--realtime", scenario.c_str(), "-o", folder.c_str(),
          nullptr);
    _exit(127);
  }
  std::string shown;
  const auto read_for = [&](std::chrono::steady_clock::time_point end) {
    for (;;) {
      const auto left =
          std::chrono::duration_cast<std::chrono::milliseconds>(end - std::chrono::steady_clock::now());
      pollfd waiting = {terminal, POLLIN, 0};
      if (left.count() <= 0 || poll(&waiting, 1, static_cast<int>(left.count())) <= 0) return;
      char buffer[4096];
      const ssize_t n = read(terminal, buffer, sizeof buffer);
      if (n <= 0) return;
      shown.append(buffer, static_cast<std::size_t>(n));
    }
  };
  read_for(std::chrono::steady_clock::now() + after);
  kill(child, SIGKILL);
  read_for(std::chrono::steady_clock::now() + std::chrono::milliseconds(50));
  waitpid(child, nullptr, 0);
  close(terminal);
  return shown;
}

TEST(Killed, AtAnyMomentTheLogHoldsWhatTheTerminalSaid) {
  const std::filesystem::path folder = test::fresh_folder();
  const int kills = whole_campaign() ? 20 : 5;
  std::mt19937 random(1);
  for (int i = 0; i < kills; ++i) {
    const auto after = std::chrono::milliseconds(300 + random() % 2500);
    const std::string out = (folder / std::to_string(i)).string();
    const std::string shown =
        shown_until_killed(SIGHTLINE_SOURCE_DIR "/scenarios/paper_7_1.toml", out, after);
    double printed = -1;
    const std::regex time("([0-9.]+) s of");
    for (std::sregex_iterator match(shown.begin(), shown.end(), time), end; match != end; ++match) {
      printed = std::stod((*match)[1]);
    }
    ASSERT_GE(printed, 0.0) << shown;
    const Recording recording = read_recording(out);
    EXPECT_FALSE(recording.complete);
    ASSERT_FALSE(recording.time.empty());
    EXPECT_GE(recording.time.back(), printed - 0.2) << "killed after " << after.count() << " ms";
  }
}

/// Rows of a campaign as any reader of SQLite sees them; -1 where there is no file yet.
int rows_of(const std::filesystem::path& table) {
  if (!std::filesystem::exists(table)) return -1;
  Database database(table, Database::Open::as_it_is);
  Database::Statement count(database, "SELECT count(*), max(\"index\") FROM runs");
  count.step();
  EXPECT_TRUE(count.integer(0) == 0 || count.integer(1) == count.integer(0) - 1) << "one after another";
  return static_cast<int>(count.integer(0));
}

// A terminal tells of each run as it lands; a second later its row is there.
TEST(Killed, ACampaignHoldsWhatTheTerminalSaidASecondBeforeAndGoesOnToTheSameBytes) {
  const std::filesystem::path folder = test::fresh_folder(), whole = folder / "whole",
                              killed = folder / "killed";
  const std::string scenario = SIGHTLINE_SOURCE_DIR "/scenarios/cooperative_localization.toml";
  const int runs = whole_campaign() ? 400 : 200, kills = whole_campaign() ? 20 : 3;
  const std::vector<std::string> words = {"campaign",  scenario, "--runs", std::to_string(runs),
                                          "--threads", "2",      "-o"};
  std::mt19937 random(2);
  for (int i = 0; i < kills; ++i) {
    using Clock = std::chrono::steady_clock;
    int terminal = -1, there = -1;
    ASSERT_EQ(::openpty(&terminal, &there, nullptr, nullptr, nullptr), 0);
    std::vector<std::string> all = words;
    all.push_back(killed.native());
    test::Child child(all, [there = there] {
      ::dup2(there, STDERR_FILENO);
      ::dup2(::open("/dev/null", O_WRONLY), STDOUT_FILENO);
    });
    const auto end = Clock::now() + std::chrono::milliseconds(200 + random() % 2800);
    std::vector<std::pair<Clock::time_point, int>> said;
    std::string shown;
    while (Clock::now() < end && !child.ended()) {
      pollfd waiting = {terminal, POLLIN, 0};
      if (::poll(&waiting, 1, 20) <= 0) continue;
      char buffer[4096];
      const ssize_t n = ::read(terminal, buffer, sizeof buffer);
      if (n <= 0) break;
      shown.assign(buffer, static_cast<std::size_t>(n));
      std::smatch match;
      if (std::regex_search(shown, match, std::regex(": ([0-9]+) of ")))
        said.emplace_back(Clock::now(), std::stoi(match[1]));
    }
    const auto killed_at = Clock::now();
    child.end(SIGKILL);
    ::close(terminal);
    ::close(there);
    const int rows = rows_of(killed / "campaign.sqlite");
    for (const auto& [when, done] : said) {
      // A second, and what a machine under load takes to commit.
      if (killed_at - when < std::chrono::milliseconds(1500)) continue;
      EXPECT_GE(rows, done) << "kill " << i;
    }
    if (child.code() >= 0) break;  // it was faster
  }
  const auto flown = [&](const std::filesystem::path& where) {
    std::string line;
    for (const std::string& word : words) line += "'" + word + "' ";
    return test::sightline(line + where.native(), folder).code;
  };
  EXPECT_EQ(flown(killed), flown(whole));
  EXPECT_TRUE(test::read_file(killed / "campaign.sqlite") == test::read_file(whole / "campaign.sqlite"));
}

// In a folder that holds a finished flight, another begins and is killed: the old log, or one that
// opens.
TEST(Killed, AFlightAgainLeavesTheOldLogOrOneThatOpens) {
  const std::filesystem::path folder = test::fresh_folder(), out = folder / "out";
  const std::string scenario = SIGHTLINE_SOURCE_DIR "/scenarios/yaw_step.toml";
  ASSERT_LE(test::sightline("run " + scenario + " --seed 1 -o " + out.native(), folder).code, 1);
  std::mt19937 random(3);
  for (int i = 0; i < (whole_campaign() ? 20 : 6); ++i) {
    test::Child child({"run", "--realtime", scenario, "--seed", std::to_string(2 + i), "-o", out});
    std::this_thread::sleep_for(std::chrono::milliseconds(random() % 400));
    child.end(SIGKILL);
    const Recording recording = read_recording(out);
    EXPECT_EQ(recording.complete, recording.seed == 1U);
    EXPECT_FALSE(!recording.complete && std::filesystem::exists(out / "report.html"))
        << "that of another log";
    ASSERT_LE(test::sightline("run " + scenario + " --seed 1 -o " + out.native(), folder).code, 1);
  }
}

// Ctrl-S: the flight is whole, and the command ends although nobody takes its table.
TEST(Killed, ATerminalThatIsStoppedHoldsUpNeitherTheFlightNorItsEnd) {
  const std::filesystem::path folder = test::fresh_folder();
  const std::string scenario = folder / "short.toml", out = folder / "out";
  std::ofstream(scenario) << std::regex_replace(
      test::read_file(SIGHTLINE_SOURCE_DIR "/scenarios/yaw_step.toml"), std::regex("duration = 20.0"),
      "duration = 2.0");
  int terminal = -1;
  const pid_t child = ::forkpty(&terminal, nullptr, nullptr, nullptr);
  ASSERT_GE(child, 0);
  if (child == 0) {
    ::execl(SIGHTLINE_BINARY, "sightline", "run", "--realtime", scenario.c_str(), "-o", out.c_str(), nullptr);
    ::_exit(127);
  }
  EXPECT_TRUE(
      test::eventually([&] { return std::filesystem::exists(std::filesystem::path(out) / "run.mcap"); }));
  ASSERT_EQ(::write(terminal, "\x13", 1), 1);
  int status = -1;
  EXPECT_TRUE(test::eventually([&] { return ::waitpid(child, &status, WNOHANG) == child; }));
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 1) << "the results could not be shown";
  ::close(terminal);
  EXPECT_TRUE(read_recording(out).complete);
}

}  // namespace
}  // namespace sightline
