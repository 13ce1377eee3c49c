#include "bridges/dds/topics/remote_clock.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

namespace sightline::dds {

RemoteClock::Stamp RemoteClock::take(Nanoseconds stamp, Nanoseconds arrival) noexcept {
  const Message message = {stamp, arrival};
  const Stamp judged = begun_ ? judge(message) : Stamp::good;
  if (judged != Stamp::good && !is_jump(message)) {
    on_ours_ = stamp + std::min(line(arrival), message.delay());
    return judged;
  }
  suspects_ = 0;
  keep(message);
  fit();
  offset_ = std::min(line(arrival), message.delay());
  on_ours_ = stamp + offset_;
  last_ = message;
  begun_ = true;
  return Stamp::good;
}

RemoteClock::Stamp RemoteClock::judge(const Message& message) const noexcept {
  if (message.stamp <= last_.stamp) return Stamp::repeated;
  return message.delay() < line(message.arrival) - tolerance ? Stamp::ahead : Stamp::good;
}

bool RemoteClock::is_jump(const Message& message) noexcept {
  if (suspects_ > 0 && message.stamp == suspect_.stamp) return false;  // the suspect once more
  const bool agrees = suspects_ > 0 && message.stamp > suspect_.stamp &&
                      std::abs(message.delay() - suspect_.delay()) < tolerance;
  suspects_ = agrees ? suspects_ + 1 : 1;
  suspect_ = message;
  if (suspects_ < agreeing) return false;
  ++jumps_;
  slice_of_.fill(0);
  return true;
}

void RemoteClock::keep(const Message& message) noexcept {
  const std::int64_t number = message.arrival / slice + 1;
  const auto place = static_cast<std::size_t>(number) % slices;
  if (slice_of_[place] != number || message.delay() < fastest_[place].delay()) fastest_[place] = message;
  slice_of_[place] = number;
  from_ = message.arrival;
}

Nanoseconds RemoteClock::line(Nanoseconds at) const noexcept {
  return offset_at_from_ + std::llround(drift_ * static_cast<double>(at - from_));
}

void RemoteClock::fit() noexcept {
  // Times and delays relative to the newest message, so that doubles are exact.
  struct Point {
    double t, delay;
  };
  std::array<Point, slices> hull{};
  const std::int64_t newest = from_ / slice + 1;
  std::size_t corners = 0, points = 0;
  double sum = 0.0;
  const auto place_of = [](std::int64_t number) { return static_cast<std::size_t>(number) % slices; };
  const Message& any = fastest_[place_of(newest)];
  for (std::int64_t number = newest - static_cast<std::int64_t>(slices) + 1; number <= newest; ++number) {
    const std::size_t place = place_of(std::max<std::int64_t>(number, 0));
    if (number < 1 || slice_of_[place] != number) continue;
    const Point next = {static_cast<double>(fastest_[place].arrival - from_),
                        static_cast<double>(fastest_[place].delay() - any.delay())};
    sum += next.t, ++points;
    // The last corner goes while it is not below the line from the one before to the next point.
    const auto is_above = [&](const Point& a, const Point& b) {
      return (b.delay - a.delay) * (next.t - a.t) >= (next.delay - a.delay) * (b.t - a.t);
    };
    while (corners >= 2 && is_above(hull[corners - 2], hull[corners - 1])) --corners;
    hull[corners++] = next;
  }
  const Point* const first = hull.data();
  const Point* const last = first + corners - 1;
  if (last->t - first->t >= static_cast<double>(drift_from)) {
    const double mean = sum / static_cast<double>(points);
    const Point* const after =
        std::find_if(first + 1, last, [&](const Point& corner) { return corner.t >= mean; });
    const Point& before = *(after - 1);
    drift_ = std::clamp((after->delay - before.delay) / (after->t - before.t), -drift_max, drift_max);
  }
  double lowest = first->delay - drift_ * first->t;
  for (const Point* corner = first; corner <= last; ++corner)
    lowest = std::min(lowest, corner->delay - drift_ * corner->t);
  offset_at_from_ = any.delay() + std::llround(lowest);
}

}  // namespace sightline::dds
