/// From when to when a judgement of a run counted, and how long in all.
#pragma once

#include <string>
#include <string_view>

namespace sightline {

struct TimeInForce {
  double from = 0.0, to = 0.0;  ///< begin of the first and end of the last period that counted [s]
  double total = 0.0;           ///< of all that did [s]

  /// One more period, in the order of their times.
  void count(double time, double period);
  /// Whether it counted all the time from 0 to the end of a run [s].
  bool is_whole(double end) const;
  /// {"from", "to", "total"}.
  std::string json() const;
};

/// "24.0 s, 2.0 to 26.0 s" of that json.
/// @throws std::exception where it is none
std::string time_words(std::string_view json);

}  // namespace sightline
