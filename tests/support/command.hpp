/// Runs the command line as a user does: exit code, stdout and stderr of a shell command.
#pragma once

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace sightline::test {

struct CommandResult {
  int code = -1;
  std::string out, err;
};

inline std::string read_file(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

/// An empty folder of the running test.
inline std::filesystem::path fresh_folder() {
  const auto* info = testing::UnitTest::GetInstance()->current_test_info();
  const auto folder =
      std::filesystem::temp_directory_path() / "sightline_cli" / info->test_suite_name() / info->name();
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder;
}

/// Runs `command` in a shell from the root of the tree; its streams go through files in `folder`.
inline CommandResult shell(const std::string& command, const std::filesystem::path& folder) {
  const auto out = folder / "stdout.txt", err = folder / "stderr.txt";
  const std::string line = "cd '" SIGHTLINE_SOURCE_DIR "' && ( " + command + " ) >'" + out.string() +
                           "' 2>'" + err.string() + "' </dev/null";
  const int status = std::system(line.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_file(out), read_file(err)};
}

inline CommandResult sightline(const std::string& arguments, const std::filesystem::path& folder) {
  return shell("'" SIGHTLINE_BINARY "' " + arguments, folder);
}

}  // namespace sightline::test
