/// Stamps of a remote clock, converted to the local clock.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "bridges/dds/topics/conversion.hpp"

namespace sightline::dds {

/// Follows a remote clock by the stamps and arrivals of its messages: a constant offset, a drift up
/// to `drift_max`, and jumps.
///
///   offset  arrival - stamp of the fastest messages: of all lines below the delays of the last
///           10 s, the one nearest to them on average (an edge of their lower convex hull)
///   drift   slope of that line; from 2 s of messages on, before that the last known one
///   jump    stamps that do not rise, or that come more than `tolerance` sooner than the line:
///           the third message in a row that agrees on it begins a new line
///
/// Transport delay beyond that of the fastest messages stays in the result. Single thread;
/// allocates nothing.
class RemoteClock {
 public:
  static constexpr double drift_max = 0.05;                 ///< [s/s]
  static constexpr Nanoseconds tolerance = 20'000'000;      ///< of a stamp that is too new
  static constexpr Nanoseconds drift_from = 2'000'000'000;  ///< span of messages that gives a drift

  enum class Stamp : std::uint8_t {
    good,
    repeated,  ///< not newer than the last
    ahead,     ///< too new
  };

  /// Takes a message. One whose stamp is not good is not to be used: it is a repetition, comes out
  /// of order, or announces a jump.
  /// @param stamp    by the remote clock
  /// @param arrival  by the local clock, increasing
  Stamp take(Nanoseconds stamp, Nanoseconds arrival) noexcept;
  /// The last stamp by the local clock, not after its arrival.
  Nanoseconds on_ours() const noexcept { return on_ours_; }
  /// Local time minus remote time, less the delay of the fastest messages.
  Nanoseconds offset() const noexcept { return offset_; }
  /// Rate of the offset [s/s].
  double drift() const noexcept { return drift_; }
  std::int64_t jumps() const noexcept { return jumps_; }

 private:
  struct Message {
    Nanoseconds stamp, arrival;
    Nanoseconds delay() const noexcept { return arrival - stamp; }
  };
  static constexpr Nanoseconds slice = 500'000'000;
  static constexpr std::size_t slices = 20;
  static constexpr int agreeing = 3;

  Stamp judge(const Message& message) const noexcept;
  bool is_jump(const Message& message) noexcept;
  void keep(const Message& message) noexcept;
  Nanoseconds line(Nanoseconds at) const noexcept;
  void fit() noexcept;

  std::array<Message, slices> fastest_{};        // one per slice of time
  std::array<std::int64_t, slices> slice_of_{};  // number of the slice, from 1; 0: empty
  Message last_{}, suspect_{};
  int suspects_ = 0;
  bool begun_ = false;
  Nanoseconds from_ = 0, offset_at_from_ = 0;  // the line begins here
  Nanoseconds on_ours_ = 0, offset_ = 0;
  double drift_ = 0.0;
  std::int64_t jumps_ = 0;
};

}  // namespace sightline::dds
