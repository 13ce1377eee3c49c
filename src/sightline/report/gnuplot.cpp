#include "sightline/report/gnuplot.hpp"

#include <fmt/format.h>
#include <signal.h>
#include <spawn.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <stdexcept>
#include <system_error>

#include "sightline/base/reason.hpp"

namespace sightline {
namespace {

[[noreturn]] void fail(std::string_view what, int error) {
  throw std::runtime_error(fmt::format("{}: {}", what, reason(error)));
}

/// An anonymous file in memory.
class Sheet {
 public:
  Sheet() : file_(::memfd_create("sightline", MFD_CLOEXEC)) {
    if (file_ < 0) fail("no memory for gnuplot's figures", errno);
  }
  ~Sheet() { ::close(file_); }
  Sheet(const Sheet&) = delete;
  Sheet& operator=(const Sheet&) = delete;

  int file() const { return file_; }

  void write(std::string_view text) const {
    while (!text.empty()) {
      const ssize_t count = ::write(file_, text.data(), text.size());
      if (count < 0 && errno != EINTR) fail("the figures' data cannot be written", errno);
      if (count > 0) text.remove_prefix(static_cast<std::size_t>(count));
    }
    ::lseek(file_, 0, SEEK_SET);
  }

  std::string text() const {
    std::string all;
    char block[1 << 16];
    for (;;) {
      const ssize_t count = ::pread(file_, block, sizeof block, static_cast<off_t>(all.size()));
      if (count == 0) return all;
      if (count < 0 && errno != EINTR) fail("the figures cannot be read", errno);
      if (count > 0) all.append(block, static_cast<std::size_t>(count));
    }
  }

 private:
  int file_;
};

/// @return the status of waitpid(2); exit code 127 if gnuplot is missing
int spawn_and_wait(const Sheet& in, const Sheet& out, const Sheet& err) {
  posix_spawn_file_actions_t streams;
  posix_spawn_file_actions_init(&streams);
  posix_spawn_file_actions_adddup2(&streams, in.file(), STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&streams, out.file(), STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&streams, err.file(), STDERR_FILENO);
  posix_spawnattr_t manners;  // resets signals that this process ignores or blocks
  posix_spawnattr_init(&manners);
  sigset_t all;
  sigfillset(&all);
  posix_spawnattr_setsigdefault(&manners, &all);
  posix_spawnattr_setflags(&manners, POSIX_SPAWN_SETSIGDEF);
  char name[] = "gnuplot", no_settings[] = "-d";
  char* const words[] = {name, no_settings, nullptr};
  pid_t child = 0;
  const int error = ::posix_spawnp(&child, name, &streams, &manners, words, environ);
  posix_spawn_file_actions_destroy(&streams);
  posix_spawnattr_destroy(&manners);
  if (error == ENOENT)
    throw std::runtime_error("gnuplot is missing, which draws the figures; scripts/deps.sh installs it");
  if (error != 0) fail("gnuplot cannot be started", error);
  int status = 0;
  while (::waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) fail("gnuplot", errno);
  }
  return status;
}

}  // namespace

std::string run_gnuplot(std::string_view script) {
  const Sheet in, out, err;
  in.write(script);
  if (spawn_and_wait(in, out, err) != 0)
    throw std::runtime_error(fmt::format("gnuplot failed to draw the figures: {}", err.text()));
  return out.text();
}

}  // namespace sightline
