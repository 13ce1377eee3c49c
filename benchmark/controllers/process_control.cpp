#include "benchmark/controllers/process_control.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <spawn.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <iterator>
#include <utility>

extern char** environ;

namespace sightline::benchmark {

std::string task_line(const Team& team, const std::vector<ViewTask>& tasks, const Horizon& horizon) {
  std::string line = fmt::format(R"({{"period": {}, "observers": [)", horizon.dt);
  for (const ViewTask& task : tasks) {
    if (!task.mount.is_in_plane())
      throw_invalid("the sensor of \"{}\" has a yaw, a roll or an offset to the side, expected none",
                    team.name(task.robot));
    line += fmt::format(
        R"({}{{"robot": "{}", "state": {}, "target_state": {}, "pitch": {}, "offset": {}, "alpha": {}, "d_min": {}, "d_max": {}}})",
        &task == tasks.data() ? "" : ", ", team.name(task.robot), team.state_offset(task.robot),
        team.state_offset(task.target), task.mount.pitch, task.mount.offset.x, task.alpha, task.d_min,
        task.d_max);
  }
  return line + "]}\n";
}

ProcessControl::ProcessControl(const Team& team, const Horizon& horizon, std::vector<ViewTask> tasks,
                               std::string command, const ProcessOptions& options)
    : team_(team),
      tasks_(std::move(tasks)),
      command_(std::move(command)),
      first_line_(task_line(team_, tasks_, horizon)),
      options_(options) {
  if (command_.empty())
    throw_invalid("solver = process, expected --process COMMAND before the other arguments");
}

ProcessControl::~ProcessControl() { end(); }

void ProcessControl::begin() noexcept {
  failed_ = true;
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) return;
  posix_spawn_file_actions_t actions;
  posix_spawnattr_t attributes;
  ::posix_spawn_file_actions_init(&actions);
  ::posix_spawn_file_actions_adddup2(&actions, ends[1], STDIN_FILENO);
  ::posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
  // A group of its own, so that end() also ends what the command has started.
  ::posix_spawnattr_init(&attributes);
  ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP);
  std::string shell = "sh", flag = "-c";
  const std::array<char*, 4> arguments = {shell.data(), flag.data(), command_.data(), nullptr};
  const int error = ::posix_spawn(&process_, "/bin/sh", &actions, &attributes, arguments.data(), environ);
  ::posix_spawn_file_actions_destroy(&actions);
  ::posix_spawnattr_destroy(&attributes);
  ::close(ends[1]);
  socket_ = ends[0];
  if (error != 0) {
    process_ = -1;
    return;
  }
  answered_ = false;
  failed_ = !write(first_line_);
}

void ProcessControl::end() noexcept {
  if (socket_ >= 0) ::close(std::exchange(socket_, -1));
  if (process_ < 0) return;
  ::kill(-process_, SIGKILL);
  ::waitpid(std::exchange(process_, -1), nullptr, 0);
}

void ProcessControl::restart() noexcept {
  end();
  failed_ = false;
}

bool ProcessControl::write(std::string_view line) noexcept {
  while (!line.empty()) {
    const ssize_t sent = ::send(socket_, line.data(), line.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    if (sent <= 0) return false;
    line.remove_prefix(static_cast<std::size_t>(sent));
  }
  return true;
}

bool ProcessControl::read(double wait) noexcept {
  using Clock = std::chrono::steady_clock;
  const Clock::time_point until =
      Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(wait));
  constexpr std::size_t longest = 1 << 16;
  answer_.clear();
  while (answer_.empty() || answer_.back() != '\n') {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(until - Clock::now()).count();
    pollfd of = {socket_, POLLIN, 0};
    if (left < 0 || ::poll(&of, 1, static_cast<int>(left)) <= 0) return false;
    std::array<char, 4096> part;
    const ssize_t got = ::recv(socket_, part.data(), part.size(), 0);
    if (got <= 0 || answer_.size() > longest) return false;
    answer_.append(part.data(), static_cast<std::size_t>(got));
  }
  return true;
}

bool ProcessControl::parse(double time, std::span<double> u) noexcept {
  wanted_.assign(u.begin(), u.end());
  const char* at_text = answer_.data();
  const char* const end_of_text = at_text + answer_.size();
  const auto skip_blanks = [&] {
    while (at_text != end_of_text && (*at_text == ' ' || *at_text == ',' || *at_text == '\n')) ++at_text;
  };
  for (const ViewTask& task : tasks_) {
    const Agent& agent = team_.agent(task.robot);
    const std::size_t first = at(team_.input_offset(task.robot)), n = at(agent.model.nu());
    u_min_.resize(n), u_max_.resize(n);
    agent.limits.at(time, u_min_, u_max_);
    for (std::size_t i = 0; i < n; ++i) {
      skip_blanks();
      const auto [next, error] = std::from_chars(at_text, end_of_text, wanted_[first + i]);
      if (error != std::errc() || !(wanted_[first + i] >= u_min_[i] && wanted_[first + i] <= u_max_[i]))
        return false;
      at_text = next;
    }
  }
  skip_blanks();
  if (at_text != end_of_text) return false;
  std::copy(wanted_.begin(), wanted_.end(), u.begin());
  return true;
}

Status ProcessControl::inputs(double time, std::span<const double> states, std::span<double> u) noexcept {
  try {
    if (socket_ < 0 && !failed_) begin();
    if (failed_) return Status::not_finite;
    line_.clear();
    fmt::format_to(std::back_inserter(line_), "{}", time);
    for (const double x : states) fmt::format_to(std::back_inserter(line_), " {}", x);
    line_ += '\n';
    if (!write(line_) || !read(answered_ ? options_.wait : options_.start)) {
      end();
      failed_ = true;
      return Status::not_finite;
    }
    answered_ = true;
    return parse(time, u) ? Status::converged : Status::not_finite;
  } catch (const std::exception&) {  // no memory for a line
    failed_ = true;
    return Status::not_finite;
  }
}

}  // namespace sightline::benchmark
