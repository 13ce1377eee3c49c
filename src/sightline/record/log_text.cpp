#include <fmt/compile.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <iterator>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <system_error>

#include "sightline/base/json_text.hpp"
#include "sightline/base/now.hpp"
#include "sightline/log.hpp"

namespace sightline {

std::uint64_t nanoseconds(double time) { return static_cast<std::uint64_t>(to_nanoseconds(time)); }

namespace {

void append(std::string& to, double value) {
  if (std::isfinite(value)) {
    fmt::format_to(std::back_inserter(to), FMT_COMPILE("{}"), value);
  } else {
    to += "null";
  }
}

}  // namespace

void LogMessage::begin(double time) {
  text_ = "{\"time\":";
  append(text_, time);
}

void LogMessage::put_key(std::string_view key) {
  text_ += ",\"";
  text_ += key;
  text_ += "\":";
}

void LogMessage::put(std::string_view key, double value) {
  put_key(key);
  append(text_, value);
}

void LogMessage::put(std::string_view key, std::span<const double> values) {
  put_key(key);
  text_ += '[';
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (i > 0) text_ += ',';
    append(text_, values[i]);
  }
  text_ += ']';
}

void LogMessage::put(std::string_view key, std::string_view word) {
  put_key(key);
  text_ += '"';
  text_ += word;
  text_ += '"';
}

std::string_view LogMessage::end() { return text_ += '}'; }

void LogMessage::send(McapChannel& channel, double time) {
  to_.message(channel.id, channel.sequence++, nanoseconds(time), std::as_bytes(std::span(end())));
}

std::string json_schema(std::string_view fields) {
  nlohmann::ordered_json schema = {{"type", "object"}, {"properties", {{"time", {{"type", "number"}}}}}};
  while (!fields.empty()) {
    const std::string_view field = fields.substr(0, fields.find(", ")),
                           name = field.substr(0, field.find_first_of("[:"));
    nlohmann::ordered_json& property = schema["properties"][std::string(name)];
    if (field.ends_with("[]")) {
      property = {{"type", "array"}, {"items", {{"type", "number"}}}};
    } else {
      property = {{"type", field == name ? "number" : field.substr(name.size() + 2)}};
    }
    fields.remove_prefix(std::min(fields.size(), field.size() + 2));
  }
  return json_text(schema);
}

void LogText::throw_invalid() const {
  throw Error(
      fmt::format("byte {} of a message, expected a JSON object of numbers, words and "
                  "lists of numbers",
                  at_));
}

void LogText::skip_space() noexcept {
  while (at_ < text_.size() && std::string_view(" \t\r\n").find(text_[at_]) != std::string_view::npos) ++at_;
}

bool LogText::take(char c) noexcept {
  skip_space();
  if (at_ >= text_.size() || text_[at_] != c) return false;
  ++at_;
  return true;
}

std::string_view LogText::quoted() {
  if (!take('"')) throw_invalid();
  const std::size_t from = at_;
  for (; at_ < text_.size() && text_[at_] != '"'; ++at_) {
    if (text_[at_] == '\\') ++at_;
  }
  if (at_ >= text_.size()) throw_invalid();
  return text_.substr(from, at_++ - from);
}

/// Reads a number or null.
void LogText::value() {
  skip_space();
  if (text_.substr(at_).starts_with("null")) {
    at_ += 4;
    numbers_.push_back(std::numeric_limits<double>::quiet_NaN());
    return;
  }
  double number = 0.0;
  const auto [next, fault] = std::from_chars(text_.data() + at_, text_.data() + text_.size(), number);
  if (fault != std::errc() || !std::isfinite(number)) throw_invalid();  // JSON has no "inf"
  at_ = static_cast<std::size_t>(next - text_.data());
  numbers_.push_back(number);
}

void LogText::read(std::string_view text) {
  text_ = text;
  at_ = 0;
  entries_.clear();
  numbers_.clear();
  if (!take('{')) throw_invalid();
  if (!take('}')) {
    do {
      Entry entry{quoted(), {}, Kind::number, numbers_.size(), 0};
      if (!take(':')) throw_invalid();
      skip_space();
      if (at_ < text_.size() && text_[at_] == '"') {
        entry.kind = Kind::word;
        entry.word = quoted();
      } else if (text_.substr(at_).starts_with("true") || text_.substr(at_).starts_with("false")) {
        entry.kind = Kind::truth;
        entry.word = text_.substr(at_, text_[at_] == 't' ? 4 : 5);
        at_ += entry.word.size();
      } else if (take('[')) {
        entry.kind = Kind::numbers;
        if (!take(']')) {
          do value();
          while (take(','));
          if (!take(']')) throw_invalid();
        }
      } else {
        value();
      }
      entry.count = numbers_.size() - entry.first;
      entries_.push_back(entry);
    } while (take(','));
    if (!take('}')) throw_invalid();
  }
  skip_space();
  if (at_ != text_.size()) throw_invalid();
}

const LogText::Entry& LogText::find(std::string_view key, Kind kind) const {
  const auto found =
      std::find_if(entries_.begin(), entries_.end(), [&](const Entry& entry) { return entry.key == key; });
  if (found != entries_.end() && found->kind == kind) return *found;
  constexpr const char* what[] = {"a number", "a list of numbers", "a word", "true or false"};
  throw Error(fmt::format("a message without \"{}\", expected {}", key, what[static_cast<int>(kind)]));
}

bool LogText::has(std::string_view key) const noexcept {
  return std::any_of(entries_.begin(), entries_.end(), [&](const Entry& one) { return one.key == key; });
}

double LogText::number(std::string_view key) const { return numbers_[find(key, Kind::number).first]; }

int LogText::whole(std::string_view key) const {
  const double value = number(key);
  if (value == std::nearbyint(value) && std::abs(value) <= std::numeric_limits<int>::max())
    return static_cast<int>(value);
  throw Error(fmt::format("a message with \"{}\" = {}, expected a whole number", key, value));
}

std::span<const double> LogText::numbers(std::string_view key) const {
  const Entry& entry = find(key, Kind::numbers);
  return std::span(numbers_).subspan(entry.first, entry.count);
}

std::span<const double> LogText::numbers(std::string_view key, std::size_t count) const {
  const std::span<const double> list = numbers(key);
  if (list.size() != count)
    throw Error(fmt::format("a message with {} numbers of \"{}\", expected {}", list.size(), key, count));
  return list;
}

bool LogText::truth(std::string_view key) const { return find(key, Kind::truth).word == "true"; }

std::string_view LogText::word(std::string_view key) const { return find(key, Kind::word).word; }

}  // namespace sightline
