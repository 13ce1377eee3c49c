#include "sightline/base/now.hpp"

#include <time.h>

namespace sightline {
namespace {

std::int64_t now_of(clockid_t clock) noexcept {
  timespec t{};
  ::clock_gettime(clock, &t);
  return t.tv_sec * one_second + t.tv_nsec;
}

}  // namespace

std::int64_t monotonic_now() noexcept { return now_of(CLOCK_MONOTONIC); }
std::int64_t realtime_now() noexcept { return now_of(CLOCK_REALTIME); }
std::int64_t process_time() noexcept { return now_of(CLOCK_PROCESS_CPUTIME_ID); }
std::int64_t thread_time() noexcept { return now_of(CLOCK_THREAD_CPUTIME_ID); }

void sleep_until(std::int64_t t) noexcept {
  const timespec wake = {t / one_second, t % one_second};
  while (monotonic_now() < t) ::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &wake, nullptr);
}

}  // namespace sightline
