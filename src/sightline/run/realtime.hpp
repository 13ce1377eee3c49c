/// What a control thread asks of the machine, where the machine lets it.
#pragma once

#include <string>

namespace sightline {

/// Of the thread that flies; threads that receive for it are below.
inline constexpr int control_priority = 20;

/// Whether a thread of this process may have a priority of SCHED_FIFO.
bool may_be_realtime(int priority);

struct Realtime {
  bool first_come = false;  ///< SCHED_FIFO
  bool locked = false;      ///< all memory stays in memory
  std::string sentence() const;
};

/// Gives the calling thread SCHED_FIFO, and locks the memory of the process. What is not allowed stays as it was.
/// @param priority  1 to 99
Realtime become_realtime(int priority);

}  // namespace sightline
