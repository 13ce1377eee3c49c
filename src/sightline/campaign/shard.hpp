/// A part of a campaign's runs, flown independently of the others.
#pragma once

#include <string>
#include <string_view>

namespace sightline {

/// Every `of`-th run, from `number` on. Shards 1 to N of N cover all runs, each once; number 0
/// equals N.
struct Shard {
  int number = 0;  ///< from 0 to `of`
  int of = 1;      ///< >= 1; 1: all runs

  int first() const { return number % of; }
  /// Index of its i-th run in the campaign.
  int run(int i) const { return first() + i * of; }
  /// Number of its runs in a campaign of `runs` runs.
  int size(int runs) const { return runs > first() ? (runs - first() - 1) / of + 1 : 0; }
  bool is_whole() const { return of == 1; }
  bool operator==(const Shard&) const = default;
};

inline constexpr int shards_max = 10'000;

/// Parses "3/8".
/// @throws std::invalid_argument
Shard shard_of(std::string_view text);

/// "3/8"
std::string to_string(const Shard& shard);

}  // namespace sightline
