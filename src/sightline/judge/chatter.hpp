/// Inputs that oscillate at the control period, as where successive plans lie on different sides of a corner.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace sightline {

/// Gathers the applied inputs of a run, one by one.
///
/// An increment u_k - u_(k-1) is a reversal where the one before had the other sign and both are at least 1 %
/// of the input's range: less is nothing that a motor follows. An input chatters where 45 of 50 periods in a row
/// are reversals. White noise makes 32 of 50, give or take 2.9 (standard deviation), however strong it is; a
/// solver that turns round in a transient makes fewer than 10.
class Chatter {
 public:
  explicit Chatter(std::size_t inputs) : inputs_(inputs) {}

  /// The next period's u, applied at `time` [s]; `range`: its u_max - u_min.
  void add(std::size_t input, double time, double u, double range) noexcept;

  /// An input that chattered.
  struct Found {
    std::size_t input;
    double from;   ///< the first time [s]
    double share;  ///< of its periods, (0, 1]
    double jump;   ///< mean |u_k - u_(k-1)| meanwhile, as u
  };
  std::vector<Found> found() const;
  /// The largest share of an input; 0: none chattered.
  double worst_share() const;

 private:
  struct Input {
    double u = 0.0, step = 0.0;   // the last ones
    std::uint64_t reversals = 0;  // of the last 50 periods, a bit each
    std::int64_t periods = 0, chattered = 0, counted_to = 0;
    std::int64_t jumps = 0;
    double from = 0.0, sum = 0.0;  // of the jumps
  };
  std::vector<Input> inputs_;
};

}  // namespace sightline
