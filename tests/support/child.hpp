/// A command of ours that runs beside the test.
#pragma once

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <functional>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

namespace sightline::test {

/// Waits until something is so.
/// @return whether it was within this time
template <class Condition>
bool eventually(Condition&& so, std::chrono::duration<double> within = std::chrono::seconds(60)) {
  const auto end = std::chrono::steady_clock::now() + within;
  while (!so()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

/// `sightline WORDS`, killed at the end of its life if it still runs.
class Child {
 public:
  /// @param prepare  called in the child, before the command takes over
  explicit Child(std::vector<std::string> words, const std::function<void()>& prepare = {}) {
    words.insert(words.begin(), SIGHTLINE_BINARY);
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    pid_ = ::fork();
    if (pid_ < 0) throw std::system_error(errno, std::generic_category(), "fork");
    if (pid_ > 0) return;
    if (::chdir(SIGHTLINE_SOURCE_DIR) != 0) ::_exit(126);
    if (prepare) prepare();
    ::execv(SIGHTLINE_BINARY, arguments.data());
    ::_exit(127);
  }
  ~Child() { end(SIGKILL); }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  pid_t pid() const { return pid_; }
  /// Whether it runs no more; code() then says how it ended.
  bool ended() {
    if (!done_) done_ = ::waitpid(pid_, &status_, WNOHANG) == pid_;
    return done_;
  }
  /// Sends a signal and waits for the end.
  void end(int signal) {
    if (!ended()) ::kill(pid_, signal);
    while (!done_) done_ = ::waitpid(pid_, &status_, 0) == pid_ || errno != EINTR;
  }
  /// The exit code; -1 where a signal ended it.
  int code() const { return done_ && WIFEXITED(status_) ? WEXITSTATUS(status_) : -1; }

 private:
  pid_t pid_ = -1;
  int status_ = 0;
  bool done_ = false;
};

}  // namespace sightline::test
