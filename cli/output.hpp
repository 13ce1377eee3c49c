/// What the commands say: results on stdout, messages on stderr. A stream may be closed, full, or a terminal that has
/// gone or was stopped: nothing here throws, and nothing holds up a flight.
#pragma once

#include <fmt/format.h>

#include <chrono>
#include <string>
#include <string_view>

namespace sightline::cli {

/// How long all writing to a stream may wait, in sum, for somebody who takes it.
inline constexpr std::chrono::seconds patience{2};

/// First of all: standard streams that were closed become ones that take nothing, so that no file of ours is opened
/// in their place; and a reader that leaves, a file that may not grow and a terminal that is not ours become errors
/// instead of signals.
void open_streams();
/// A terminal that hangs up ends neither a flight nor a campaign. Results that their files hold as well wait for a
/// stopped terminal no longer than `patience`; all others wait, as those of any program.
void outlive_the_terminal();

void write_result(std::string_view text) noexcept;
void write_message(std::string_view text) noexcept;
/// A message that waits for nobody: progress, by any thread.
void offer_message(std::string_view text) noexcept;

template <class... Args>
void print(fmt::format_string<Args...> format, Args&&... args) {
  write_result(fmt::format(format, std::forward<Args>(args)...));
}
/// A message as it is.
template <class... Args>
void tell(fmt::format_string<Args...> format, Args&&... args) {
  write_message(fmt::format(format, std::forward<Args>(args)...));
}
/// A sentence, in a line that begins with the program's name.
void say(std::string_view sentence) noexcept;
/// The same where nothing may wait: it is left out where nobody reads.
void offer_sentence(std::string_view sentence) noexcept;

/// At the end: the exit code, which is 1 instead of 0 where results were lost; says so.
int finish(int code);

}  // namespace sightline::cli
