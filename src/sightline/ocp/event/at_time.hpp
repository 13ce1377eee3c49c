/// Trigger `at = 20.0`: a time of the run.
#pragma once

#include <fmt/format.h>

#include <array>
#include <string>
#include <vector>

#include "sightline/base/range.hpp"
#include "sightline/base/same_time.hpp"
#include "sightline/ocp/event/moment.hpp"

namespace sightline {

/// Occurs at this time of the run.
struct AtTime {
  static constexpr std::array<std::string_view, 1> keys = {"at"};
  static constexpr bool may_repeat = false;

  double t = 0.0;  ///< [s], >= 0

  std::vector<std::string> faults(bool /*repeats*/) const {
    if (at_least_zero(t)) return {};
    return {fmt::format("at = {}, expected >= 0 s", t)};
  }
  bool takes_no_time() const { return false; }  // it occurs once
  bool occurs(const EventInstant& moment) const noexcept { return moment.known.t >= t - same_time; }
  std::string describe(const Team& /*all*/) const { return fmt::format("at {} s", t); }

  template <class Text>
  static AtTime read(const Text& event, std::string_view key) {
    return {event.number(key, not_negative(">= 0 s"))};
  }
};

}  // namespace sightline
