/// The Enter key as a control of a waiting flight.
#pragma once

#include <poll.h>
#include <unistd.h>

#include <atomic>

#include "sightline/base.hpp"
#include "sightline/server/paced_clock.hpp"

namespace sightline::cli {

/// Resumes a paused flight when the user presses Enter.
class EnterKey {
 public:
  EnterKey(PacedClock& clock, std::atomic<bool>& stop)
      : thread_("the Enter key", [this, &clock, &stop] {
          pollfd typed{STDIN_FILENO, POLLIN, 0};
          while (!done_ && !stop && clock.paused()) {
            if (::poll(&typed, 1, 100) <= 0) continue;
            char key = 0;
            if (::read(STDIN_FILENO, &key, 1) != 1) return;
            if (key == '\n') clock.resume();
          }
        }) {}
  ~EnterKey() {
    done_ = true;
    thread_.join();
  }
  EnterKey(const EnterKey&) = delete;
  EnterKey& operator=(const EnterKey&) = delete;

 private:
  std::atomic<bool> done_{false};
  ServiceThread thread_;
};

}  // namespace sightline::cli
