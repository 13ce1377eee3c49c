/// One line on a terminal that says how far a run is; silent where stderr is no terminal.
#pragma once

#include <chrono>

namespace sightline::cli {

class Progress {
 public:
  /// @param duration  simulated time of the whole run [s]
  explicit Progress(double duration);
  ~Progress() { end(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// All up to this simulated time [s] is done and on disk. At most ten lines a second are written.
  void show(double simulated);
  /// Ends the line, if there is one.
  void end();

 private:
  using Clock = std::chrono::steady_clock;
  bool terminal_, shown_ = false;
  double duration_;
  Clock::time_point begin_ = Clock::now(), next_ = begin_;
};

}  // namespace sightline::cli
