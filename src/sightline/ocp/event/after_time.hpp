/// Trigger `after = 2.0`: a time after the begin of a stage.
#pragma once

#include <fmt/format.h>

#include <array>
#include <string>
#include <vector>

#include "sightline/base/range.hpp"
#include "sightline/base/same_time.hpp"
#include "sightline/ocp/event/moment.hpp"

namespace sightline {

/// Occurs at this time after its stage began; for an event of all stages, after the run began.
struct AfterTime {
  static constexpr std::array<std::string_view, 1> keys = {"after"};
  static constexpr bool may_repeat = false;

  double delay = 0.0;  ///< [s], >= 0

  std::vector<std::string> faults(bool /*repeats*/) const {
    if (at_least_zero(delay)) return {};
    return {fmt::format("after = {}, expected >= 0 s", delay)};
  }
  bool takes_no_time() const { return delay <= 0; }
  bool occurs(const EventInstant& moment) const noexcept {
    return moment.known.t - moment.began >= delay - same_time;
  }
  std::string describe(const Team& /*all*/) const { return fmt::format("after {} s", delay); }

  template <class Text>
  static AfterTime read(const Text& event, std::string_view key) {
    return {event.number(key, not_negative(">= 0 s"))};
  }
};

}  // namespace sightline
