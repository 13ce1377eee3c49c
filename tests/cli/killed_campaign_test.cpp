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

#include "sightline/io/mcap.hpp"
#include "sightline/io/recording.hpp"
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
  const char* campaign = std::getenv("SIGHTLINE_CAMPAIGN");
  const int kills = campaign != nullptr && std::string(campaign) == "whole" ? 20 : 5;
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

}  // namespace
}  // namespace sightline
