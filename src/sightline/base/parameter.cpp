#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sightline/base.hpp"

namespace sightline {

std::string Bounds::expected(std::string_view unit) const {
  return unit.empty() ? std::string(words) : fmt::format("{} {}", words, unit);
}

void refuse_parameter(std::string_view part, std::string_view key, double value, std::string_view expected) {
  throw_invalid("{}.{} = {}, expected {}", part, key, value, expected);
}

std::string words_text(std::span<const std::string_view> words) {
  return fmt::format("one of {}", fmt::join(words, ", "));
}

std::string changed(std::span<const ParameterText> parameters) {
  std::string text;
  for (const ParameterText& p : parameters) {
    if (p.value == p.fallback) continue;
    text += fmt::format("{}{} = {}{}{}", text.empty() ? "" : ", ", p.key, p.value, p.unit.empty() ? "" : " ",
                        p.unit);
  }
  return text;
}

namespace detail {

std::string numbers_text(std::span<const double> numbers, bool in_brackets) {
  const std::string list = fmt::format("{}", fmt::join(numbers, ", "));
  return in_brackets ? fmt::format("[{}]", list) : list;
}

}  // namespace detail

}  // namespace sightline
