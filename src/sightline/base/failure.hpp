/// What ended a service beside the control thread: kept as a sentence and reported once. Nothing here allocates or throws.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <string_view>

namespace sightline {

/// Takes a line, "sightline: the page has ended: ...\n", of any thread.
using FailureReport = void (*)(std::string_view line) noexcept;

/// Sets where lines go for the whole process. Before the first call they go to stderr by write(2).
/// @param report  null: stderr
void report_failures_to(FailureReport report) noexcept;

/// The first failure of one service. Any thread records and reads it.
class Failure {
 public:
  /// Records and reports the exception that is being handled. Only the first call counts.
  /// @param service  that failed, "the page"; text that lives as long as this
  void record(const char* service) noexcept;

  bool occurred() const noexcept { return state_.load(std::memory_order_acquire) == State::kept; }
  /// "the page has ended: there is not enough memory"; empty where nothing failed. At most `length_max` bytes.
  std::string_view sentence() const noexcept;

  static constexpr std::size_t length_max = 400;

 private:
  enum class State { none, taken, kept };

  std::atomic<State> state_{State::none};
  std::array<char, length_max + 16> line_{};  // of the report
  std::size_t length_ = 0;                    // of it
};

}  // namespace sightline
