#include "cli/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>

namespace sightline::cli {

Progress::Progress(double duration) : terminal_(isatty(STDERR_FILENO) == 1), duration_(duration) {}

void Progress::end() {
  if (shown_) fmt::print(stderr, "\n");
  shown_ = false;
}

void Progress::show(double simulated) {
  const auto now = Clock::now();
  const bool last = simulated >= duration_;
  if (!terminal_ || (now < next_ && !last)) return;
  next_ = now + std::chrono::milliseconds(100);
  shown_ = true;
  const double elapsed = std::chrono::duration<double>(now - begin_).count();
  const double speed = elapsed > 0 ? simulated / elapsed : 0.0;
  const double left = speed > 0 ? (duration_ - simulated) / speed : 0.0;
  fmt::print(stderr, "\r{:3.0f} %  {:.2f} s of {:.2f} s  {:.1f} x real time  {:.0f} s left   ",
             100.0 * simulated / duration_, simulated, duration_, speed, left);
  std::fflush(stderr);
}

}  // namespace sightline::cli
