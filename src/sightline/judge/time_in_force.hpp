/// Interval and total time in which a criterion of a run was evaluated.
#pragma once

#include <string>
#include <string_view>

namespace sightline {

struct TimeInForce {
  double from = 0.0, to = 0.0;  ///< start of the first and end of the last counted period [s]
  double total = 0.0;           ///< sum of all counted periods [s]

  /// Adds one period, in chronological order.
  void count(double time, double period);
  /// True if all time from 0 to `end` was counted; `end`: end of the run [s].
  bool is_whole(double end) const;
  /// JSON object {"from", "to", "total"}.
  std::string json() const;
};

/// Describes this JSON: "24.0 s, 2.0 to 26.0 s".
/// @throws std::exception if the text is no such object
std::string time_words(std::string_view json);

}  // namespace sightline
