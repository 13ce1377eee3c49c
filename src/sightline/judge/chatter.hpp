/// Detects inputs that oscillate at the control period, as when successive plans lie on different
/// sides of a corner.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace sightline {

/// Collects the applied inputs of a run, one by one.
///
/// An increment u_k - u_(k-1) is a reversal if the previous increment has the other sign. Both must
/// be at least 1 % of the input's range. Motors do not follow smaller increments. An input chatters
/// if 45 of 50 successive periods are reversals. White noise of any amplitude gives 32 of 50 with
/// standard deviation 2.9. A solver that changes direction in a transient gives fewer than 10.
class Chatter {
 public:
  explicit Chatter(std::size_t inputs) : inputs_(inputs) {}

  /// Adds the next period's u, applied at `time` [s]; `range` is u_max - u_min of this input.
  void add(std::size_t input, double time, double u, double range) noexcept;

  /// An input that chattered.
  struct Found {
    std::size_t input;
    double from;   ///< time at which chatter was first detected [s]
    double share;  ///< chattering periods over all periods of the input, (0, 1]
    double jump;   ///< mean |u_k - u_(k-1)| of the reversals during chatter, in the unit of u
  };
  std::vector<Found> found() const;
  /// Largest share of one input; 0 if no input chattered.
  double worst_share() const;

 private:
  struct Input {
    double u = 0.0, step = 0.0;   // last input and last increment
    std::uint64_t reversals = 0;  // of the last 50 periods, one bit each
    std::int64_t periods = 0, chattered = 0, counted_to = 0;
    std::int64_t jumps = 0;
    double from = 0.0, sum = 0.0;  // sum: of the jumps
  };
  std::vector<Input> inputs_;
};

}  // namespace sightline
