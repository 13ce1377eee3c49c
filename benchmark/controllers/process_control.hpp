/// Observers that a program outside steers: numbers to its standard input, numbers from its standard output.
#pragma once

#include <string>

#include "benchmark/controllers/observer_solver.hpp"

namespace sightline::benchmark {

struct ProcessOptions {
  double wait = 0.2, start = 10.0;

  static constexpr auto parameters() {
    using O = ProcessOptions;
    return Parameters{
        parameter("wait", &O::wait, "s", {1e-3, 60.0, "0.001 to 60"}, "longest time of an answer"),
        parameter("start", &O::start, "s", {1e-3, 600.0, "0.001 to 600"},
                  "longest time of the first answer")};
  }
};

/// Starts `sh -c COMMAND` and writes one line of JSON that describes the tasks, as task_line(). Then, for each update,
/// it writes a line of numbers, the time [s] and the states of all bodies (nx), and reads a line of numbers: the inputs
/// of the observers, in the order of the tasks.
///
/// An answer that is late, or not that many finite numbers within the limits of the inputs, gives the status
/// `not_finite`: the last inputs remain. After a late answer, or if the program has ended, all later updates do so,
/// until restart(), which starts the program again. Blocks up to `wait`; for simulated time alone.
class ProcessControl final : public ObserverControl {
 public:
  ProcessControl(const Team& team, const Horizon& horizon, std::vector<ViewTask> tasks, std::string command,
                 const ProcessOptions& options);
  ~ProcessControl() override;
  ProcessControl(const ProcessControl&) = delete;
  ProcessControl& operator=(const ProcessControl&) = delete;

  Status inputs(double time, std::span<const double> states, std::span<double> u) noexcept override;
  void restart() noexcept override;

 private:
  void begin() noexcept;
  void end() noexcept;
  bool write(std::string_view line) noexcept;
  /// Reads up to the end of a line; false if it does not arrive in time [s].
  bool read(double wait) noexcept;
  bool parse(double time, std::span<double> u) noexcept;

  Team team_;
  std::vector<ViewTask> tasks_;
  std::string command_, first_line_, line_, answer_;
  ProcessOptions options_;
  std::vector<double> wanted_, u_min_, u_max_;
  int socket_ = -1, process_ = -1;
  bool answered_ = false, failed_ = false;
};

/// {"period": s, "observers": [{"robot": "uav0", "state": 0, "target_state": 7, "pitch": rad, "offset": m,
/// "alpha": rad, "d_min": m, "d_max": m}, ...]}: `state` and `target_state` are the places of their first numbers.
std::string task_line(const Team& team, const std::vector<ViewTask>& tasks, const Horizon& horizon);

}  // namespace sightline::benchmark
