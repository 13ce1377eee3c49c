/// Faults of simulated vehicles: [[fleet.fault]], and keys of `sightline vehicles`.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>

#include "sightline/base.hpp"
#include "sightline/events.hpp"

namespace sightline {

enum class LinkFaultKind : std::uint8_t {
  drop,
  delay,
  reorder,
  duplicate,
  not_finite,
  frozen,
  jump,
  jump_reported,
  restart,
  silent,
  disarm,
  pilot,
  battery_low,
  estimator_invalid,
  wrong_release,
  blind,
  request_lost,
  clock_jump,
};

/// Robots that can have a fault.
struct FaultOf {
  std::span<const std::string_view> kinds{};  ///< only behind links of these kinds; empty: all
  bool camera = false;                        ///< only robots with a camera
};

/// Description of a kind of fault, for files, keys and documents.
struct LinkFaultText {
  std::string_view name;
  char key;  ///< a letter
  FaultOf of;
  std::string_view size;  ///< unit or meaning of its size; empty: no size
  Bounds bounds;          ///< of the size
  double fallback;        ///< the default size
  std::string_view meaning;
};

inline constexpr Bounds share_bounds = {0.0, 1.0, "0 to 1"};
inline constexpr std::size_t link_fault_kinds = 18;
inline constexpr std::array<std::string_view, 1> px4_alone = {"px4"};
inline constexpr std::array<std::string_view, 2> with_battery = {"px4", "crazyswarm2"};
/// In the order of LinkFaultKind.
inline constexpr std::array<LinkFaultText, link_fault_kinds> link_faults = [] {
  constexpr FaultOf all = {}, px4 = {px4_alone};
  return std::array<LinkFaultText, link_fault_kinds>{{
      {"drop", 'd', all, "share", share_bounds, 0.2, "messages are lost"},
      {"delay", 'l', all, "s", {0.0, 10.0, "0 to 10"}, 0.05, "messages come later"},
      {"reorder", 'o', all, "share", share_bounds, 0.1, "messages come 25 ms after those behind them"},
      {"duplicate", 'u', all, "share", share_bounds, 0.1, "messages come twice"},
      {"not_finite", 'n', all, "share", share_bounds, 0.1, "poses have a NaN"},
      {"frozen", 'f', all, "", {}, 0.0, "the same pose comes again and again, with new stamps"},
      {"jump", 'j', all, "m", {-100.0, 100.0, "-100 to 100"}, 0.5, "poses are off to the east"},
      {"jump_told",
       'k',
       px4,
       "m",
       {-100.0, 100.0, "-100 to 100"},
       0.2,
       "the same, and the estimator counts a reset"},
      {"restart",
       'r',
       all,
       "s",
       {0.0, 60.0, "0 to 60"},
       0.0,
       "it ends, and after so long begins anew, disarmed on the ground at its start"},
      {"silent", 's', all, "", {}, 0.0, "nothing comes from it"},
      {"disarm", 'x', px4, "", {}, 0.0, "it is disarmed"},
      {"pilot", 'p', px4, "", {}, 0.0, "a pilot takes it"},
      {"battery_low", 'b', {with_battery}, "", {}, 0.0, "its battery is critical"},
      {"estimator_invalid", 'e', px4, "", {}, 0.0, "its estimator is not valid"},
      {"wrong_release",
       'w',
       px4,
       "1.N",
       {14.0, 18.0, "14 to 18", true},
       0.0,
       "it begins anew with the firmware 1.N; 0: the next one"},
      {"blind", 'c', {.camera = true}, "", {}, 0.0, "its camera finds no tags"},
      {"request_lost", 'q', px4, "share", share_bounds, 0.2, "requests to it are lost"},
      {"clock_jump", 't', px4, "s", {-100.0, 100.0, "-100 to 100"}, -2.0, "the stamps of its poses jump"},
  }};
}();

inline const LinkFaultText& text_of(LinkFaultKind kind) {
  return link_faults[static_cast<std::size_t>(kind)];
}

/// Time origin of a fault.
enum class FaultClock : std::uint8_t {
  start,   ///< of the vehicle simulators
  flight,  ///< since the robot received its first command
};
inline constexpr std::array<std::string_view, 2> fault_clocks = {"start", "flight"};

struct LinkFault {
  BodyId robot{};
  LinkFaultKind kind{};
  FaultClock since = FaultClock::start;
  double at = 0.0;                                            ///< [s]
  double duration = std::numeric_limits<double>::infinity();  ///< [s]
  double size = 0.0;                                          ///< in the unit of its kind
};

/// "drop 0.2 for 2 s, 5 s after it is first steered"
std::string describe(const LinkFault& fault);
/// The table of all kinds, in Markdown.
std::string link_fault_table();

}  // namespace sightline
