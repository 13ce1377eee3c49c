#include "sightline/run/realtime.hpp"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include "sightline/base.hpp"

namespace sightline {
namespace {

bool set_priority(int priority) {
  sched_param parameters{};
  parameters.sched_priority = priority;
  return ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &parameters) == 0;
}

}  // namespace

bool may_be_realtime(int priority) {
  bool may = false;
  run_apart([&] { may = set_priority(priority); });
  return may;
}

std::string Realtime::sentence() const {
  if (first_come && locked) return "real time: SCHED_FIFO, memory locked";
  if (first_come)
    return "real time: SCHED_FIFO; memory is not locked, which ulimit -l or CAP_IPC_LOCK allows";
  if (locked) return "real time: memory locked; no SCHED_FIFO, which ulimit -r or CAP_SYS_NICE allows";
  return "real time: neither SCHED_FIFO nor locked memory, which ulimit -r and -l allow";
}

Realtime become_realtime(int priority) {
  Realtime got;
  // With a limit on locked memory, later allocations could fail: lock only without one.
  rlimit limit{};
  const bool unlimited = ::getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY;
  got.locked = (unlimited || ::geteuid() == 0) && ::mlockall(MCL_CURRENT | MCL_FUTURE) == 0;
  got.first_come = set_priority(priority);
  return got;
}

}  // namespace sightline
