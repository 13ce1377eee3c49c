/// The exception that ended a service beside the control thread: kept as a sentence and reported
/// once. Nothing here allocates or throws.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <string_view>

namespace sightline {

/// Receives a line, "sightline: the page has ended: ...\n", from any thread.
using FailureReport = void (*)(std::string_view line) noexcept;

/// Sets the destination of the lines for the whole process. Before the first call they go to stderr
/// by write(2).
/// @param report  null: stderr
void report_failures_to(FailureReport report) noexcept;

/// The first failure of one service. Any thread may record and read it.
class Failure {
 public:
  /// Records and reports the exception in flight. Only the first call has an effect.
  /// @param service  the failed service, "the page"; the text must outlive this object
  void record(const char* service) noexcept;

  bool occurred() const noexcept { return state_.load(std::memory_order_acquire) == State::kept; }
  /// "the page has ended: there is not enough memory"; empty if nothing failed. At most
  /// `length_max` bytes.
  std::string_view sentence() const noexcept;

  static constexpr std::size_t length_max = 400;

 private:
  enum class State { none, taken, kept };

  std::atomic<State> state_{State::none};
  std::array<char, length_max + 16> line_{};  // the reported line
  std::size_t length_ = 0;                    // bytes used of line_
};

}  // namespace sightline
