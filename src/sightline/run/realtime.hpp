/// Real-time scheduling and memory locking of a control thread, as far as permitted.
#pragma once

#include <string>

namespace sightline {

/// Priority of the control thread; receiver threads have lower ones.
inline constexpr int control_priority = 20;

/// Whether a thread of this process may use SCHED_FIFO with this priority.
bool may_be_realtime(int priority);

struct Realtime {
  bool first_come = false;  ///< SCHED_FIFO
  bool locked = false;      ///< all memory stays resident
  std::string sentence() const;
};

/// Gives the calling thread SCHED_FIFO, and locks the memory of the process. Settings that are not
/// permitted stay unchanged.
/// @param priority  1 to 99
Realtime become_realtime(int priority);

}  // namespace sightline
