// What a run takes of memory, however long it is.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/support/folder.hpp"
#include "tests/support/view_scenario.hpp"

namespace sightline {
namespace {

/// The most memory that `run` of so many minutes holds, its report included [kB].
long most_memory(int minutes) {
  const std::filesystem::path folder = test::fresh_folder(), file = folder / "long.toml";
  std::ofstream(file) << test::view_scenario;
  std::array<std::string, 7> words = {SIGHTLINE_BINARY,
                                      "run",
                                      file.string(),
                                      "--set",
                                      fmt::format("simulation.duration={}.0", 60 * minutes),
                                      "-o",
                                      (folder / "out").string()};
  std::array<char*, 8> arguments{};
  for (std::size_t i = 0; i < words.size(); ++i) arguments[i] = words[i].data();
  const pid_t child = ::fork();
  if (child == 0) {
    ::execv(arguments[0], arguments.data());
    std::_Exit(127);
  }
  int status = 0;
  rusage used{};
  EXPECT_EQ(::wait4(child, &status, 0, &used), child);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
  EXPECT_TRUE(std::filesystem::exists(folder / "out" / "run.mcap"));
  std::filesystem::remove_all(folder);
  return used.ru_maxrss;
}

TEST(Memory, OfARunDoesNotGrowWithItsLength) {
  // The report holds as many rows of the one as of the other: each eighth row of four times as many
  // as each second.
  const long of_15_min = most_memory(15), of_60_min = most_memory(60);
  EXPECT_LT(of_60_min, of_15_min + 1'024) << of_15_min;
}

}  // namespace
}  // namespace sightline
