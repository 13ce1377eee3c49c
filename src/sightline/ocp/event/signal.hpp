/// Trigger `signal = "go"`: a message from outside.
#pragma once

#include <fmt/format.h>

#include <array>
#include <string>
#include <vector>

#include "sightline/ocp/event/moment.hpp"

namespace sightline {

/// A message from outside, by its name; it is lost if no event waits for it.
struct Signal {
  static constexpr std::array<std::string_view, 1> keys = {"signal"};
  static constexpr bool may_repeat = true;

  std::string name;

  std::vector<std::string> faults(bool /*repeats*/) const { return {}; }
  bool takes_no_time() const { return false; }  // it comes from outside
  bool occurs(const EventInstant& moment) const noexcept { return moment.signalled; }
  std::string describe(const Team& /*all*/) const { return fmt::format("on the signal {}", name); }

  template <class Text>
  static Signal read(const Text& event, std::string_view key) {
    const std::vector<std::string_view> known = event.signals();
    if (known.empty()) event.throw_invalid(key, "a signal of simulation.signal, there is none");
    return {std::string(event.word(key, known, "a signal of simulation.signal"))};
  }
};

}  // namespace sightline
