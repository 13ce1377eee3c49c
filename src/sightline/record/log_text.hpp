/// JSON messages of the log, with numbers that read back to the same bits.
#pragma once

#include <fmt/format.h>

#include <concepts>
#include <cstdint>
#include <initializer_list>
#include <iterator>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sightline/record/mcap.hpp"

namespace sightline {

/// Converts a time [s] to log time [ns].
std::uint64_t nanoseconds(double time);

/// Writes messages {time, ...} of the log in one buffer; allocates nothing once the buffer has
/// reached its final size.
class LogMessage {
 public:
  explicit LogMessage(MessageSink& to) : to_(to) {}

  /// @param time  [s]
  void begin(double time);
  /// Adds the shortest text that reads back to the same bits; null for a number that is not finite.
  void put(std::string_view key, double value);
  void put(std::string_view key, std::span<const double> values);
  /// Adds a word without quotes and backslashes.
  void put(std::string_view key, std::string_view word);
  template <std::integral T>
  void put(std::string_view key, T value) {
    fmt::format_to(std::back_inserter(text_), ",\"{}\":{}", key, value);
  }
  /// Closes the message and returns its text, valid until the next begin().
  std::string_view end();
  /// Ends the message and writes it.
  /// @param time  [s]
  void send(McapChannel& channel, double time);

 private:
  MessageSink& to_;
  std::string text_;
};

/// Schema of a message {time, ...}: each property with its type; "numbers" is a list of numbers.
std::string json_schema(std::initializer_list<std::pair<const char*, std::string_view>> properties);

/// Reads the flat JSON object of a message into reused memory; trusts no byte of the text.
class LogText {
 public:
  /// @throws std::runtime_error if the text is no object of numbers, words, null, true, false and
  ///   lists of numbers
  void read(std::string_view text);

  bool has(std::string_view key) const noexcept;
  /// Number with this key; NaN for null. @throws std::runtime_error if the key is missing
  double number(std::string_view key) const;
  /// List with this key; null reads as NaN. @throws std::runtime_error if the key is missing
  std::span<const double> numbers(std::string_view key) const;
  /// Word with this key, without escapes. @throws std::runtime_error if the key is missing
  std::string_view word(std::string_view key) const;

 private:
  enum class Kind { number, numbers, word, truth };
  struct Entry {
    std::string_view key, word;
    Kind kind;
    std::size_t first, count;  // in numbers_
  };
  const Entry& find(std::string_view key, Kind kind) const;
  [[noreturn]] void throw_invalid() const;
  void skip_space() noexcept;
  bool take(char c) noexcept;
  std::string_view quoted();
  void value();

  std::string_view text_;
  std::size_t at_ = 0;
  std::vector<Entry> entries_;
  std::vector<double> numbers_;
};

}  // namespace sightline
