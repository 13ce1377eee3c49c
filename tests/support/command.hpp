/// Runs the command line as a user does: exit code, stdout and stderr of a shell command.
#pragma once

#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>

#include "tests/support/folder.hpp"

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

inline long lines(const std::string& text) { return std::count(text.begin(), text.end(), '\n'); }

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

/// What a refused command says on stderr beside exit code 2: one line, and a hint after a wrong
/// option.
inline std::string refused(const std::string& arguments, const std::filesystem::path& folder) {
  const CommandResult done = sightline(arguments, folder);
  EXPECT_EQ(done.code, 2) << arguments;
  EXPECT_EQ(done.out, "") << arguments;
  const bool hints = done.err.ends_with("\nRun with --help or --help-all for more information.\n");
  EXPECT_EQ(lines(done.err), hints ? 2 : 1) << arguments << ": " << done.err;
  return done.err;
}

/// A shipped scenario of 60 s with another duration [s], in a file of its name in `folder`.
inline std::filesystem::path short_scenario(const std::filesystem::path& folder, const std::string& name,
                                            const std::string& duration) {
  std::filesystem::path file = folder / (name + ".toml");
  std::ofstream(file) << std::regex_replace(read_file(SIGHTLINE_SOURCE_DIR "/scenarios/" + name + ".toml"),
                                            std::regex("duration = 60.0"), "duration = " + duration);
  return file;
}

}  // namespace sightline::test
