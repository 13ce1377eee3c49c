#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "sightline/base.hpp"
#include "sightline/supervisor.hpp"

namespace sightline {

std::string_view to_string(FallbackLevel level) {
  constexpr std::array<std::string_view, fallback_level_count> names = {"valid", "predicted", "slowed",
                                                                        "hold",  "land",      "grounded"};
  return names[static_cast<std::size_t>(level)];
}

FallbackLevel level_at(const LadderTimes& times, double age) noexcept {
  if (age <= times.fresh + same_time) return FallbackLevel::valid;
  if (age <= times.slow_after + same_time) return FallbackLevel::predicted;
  if (age <= times.hold_after + same_time) return FallbackLevel::slowed;
  if (age <= times.land_after + same_time) return FallbackLevel::hold;
  return FallbackLevel::land;
}

FallbackLevel level_at(const LadderSigmas& sigmas, double sigma) noexcept {
  if (sigma <= sigmas.hold) return FallbackLevel::valid;
  return sigma <= sigmas.land || std::isinf(sigma) ? FallbackLevel::hold : FallbackLevel::land;
}

FallbackLevel next_level(FallbackLevel now, const LadderTimes& times, const Ages& ages, bool on_ground,
                         FallbackLevel by_sigma) noexcept {
  if (now == FallbackLevel::grounded) return now;
  if (now == FallbackLevel::land) return on_ground ? FallbackLevel::grounded : now;
  return std::max({level_at(times, ages.own), std::min(level_at(times, ages.partners), FallbackLevel::hold),
                   level_at(times, ages.plan), by_sigma});
}

}  // namespace sightline
