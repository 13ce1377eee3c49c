/// Output of the commands: results on stdout, messages on stderr. A stream may be closed, full, or
/// a terminal that is gone or stopped. Nothing here throws, and nothing delays a flight.
#pragma once

#include <fmt/format.h>

#include <chrono>
#include <functional>
#include <string>
#include <string_view>

namespace sightline::cli {

/// Total time that writing to a stream may wait for a reader.
inline constexpr std::chrono::seconds patience{2};

/// Called first. Closed standard streams are opened so that no later file takes their numbers;
/// writes to them fail. A reader that leaves, a file at its size limit and a terminal of another
/// process group cause errors instead of signals.
void open_streams();
/// A terminal that hangs up ends neither a flight nor a campaign. Results that are also in files
/// wait at most `patience` for a stopped terminal. All other results wait, as in any program.
void outlive_the_terminal();

void write_result(std::string_view text) noexcept;
void write_message(std::string_view text) noexcept;
/// Writes a message without waiting: progress, from any thread.
void offer_message(std::string_view text) noexcept;

template <class... Args>
void print(fmt::format_string<Args...> format, Args&&... args) {
  write_result(fmt::format(format, std::forward<Args>(args)...));
}
/// Writes a message unchanged.
template <class... Args>
void print_message(fmt::format_string<Args...> format, Args&&... args) {
  write_message(fmt::format(format, std::forward<Args>(args)...));
}
/// Writes a sentence in a line that begins with the program's name.
void print_sentence(std::string_view sentence) noexcept;
/// The same without waiting: the sentence is dropped if the stream is not writable.
void offer_sentence(std::string_view sentence) noexcept;

/// Exit code of `body`; an exception of it is bad input: its sentence is printed, and the code is 2.
int refusing(const std::function<int()>& body);

/// Called at the end: returns the exit code. It is 1 instead of 0 if results were lost, and a
/// message reports the loss.
int finish(int code);

}  // namespace sightline::cli
