#include "sightline/safety/ladder.hpp"

#include <algorithm>
#include <array>
#include <cstddef>

#include "sightline/base/same_time.hpp"

namespace sightline {

std::string_view to_string(Rung rung) {
  constexpr std::array<std::string_view, rung_count> names = {"valid", "predicted", "slowed",
                                                              "hold",  "land",      "grounded"};
  return names[static_cast<std::size_t>(rung)];
}

Rung rung_at(const LadderTimes& times, double age) noexcept {
  if (age <= times.fresh + same_time) return Rung::valid;
  if (age <= times.slow_after + same_time) return Rung::predicted;
  if (age <= times.hold_after + same_time) return Rung::slowed;
  if (age <= times.land_after + same_time) return Rung::hold;
  return Rung::land;
}

Rung next_rung(Rung now, const LadderTimes& times, const Ages& ages, bool on_ground) noexcept {
  if (now == Rung::grounded) return now;
  if (now == Rung::land) return on_ground ? Rung::grounded : now;
  return std::max({rung_at(times, ages.own), std::min(rung_at(times, ages.partners), Rung::hold),
                   rung_at(times, ages.plan)});
}

}  // namespace sightline
