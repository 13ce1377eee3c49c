#include <unistd.h>

#include <algorithm>
#include <exception>
#include <new>

#include "sightline/base.hpp"

namespace sightline {
namespace {

constexpr std::string_view begin_of_line = "sightline: ";

void report_on_stderr(std::string_view line) noexcept {
  (void)!::write(STDERR_FILENO, line.data(), line.size());
}

std::atomic<FailureReport> report_to{report_on_stderr};

}  // namespace

void report_failures_to(FailureReport report) noexcept {
  report_to = report != nullptr ? report : report_on_stderr;
}

void Failure::record(const char* service) noexcept {
  State none = State::none;
  if (!state_.compare_exchange_strong(none, State::taken)) return;
  const auto put = [this](std::string_view text) {
    const std::size_t fits = std::min(text.size(), begin_of_line.size() + length_max - length_);
    for (const char c : text.substr(0, fits)) line_[length_++] = c == '\n' ? ' ' : c;
  };
  put(begin_of_line);
  put(service);
  put(" has ended: ");
  try {
    throw;
  } catch (const std::bad_alloc&) {
    put("there is not enough memory");
  } catch (const std::exception& error) {
    put(error.what());
  } catch (...) {
    put("an exception without words");
  }
  line_[length_++] = '\n';
  state_.store(State::kept, std::memory_order_release);
  report_to.load()({line_.data(), length_});
}

std::string_view Failure::sentence() const noexcept {
  if (!occurred()) return {};
  return {line_.data() + begin_of_line.size(), length_ - begin_of_line.size() - 1};
}

}  // namespace sightline
