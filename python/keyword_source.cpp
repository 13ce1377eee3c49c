#include "python/keyword_source.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sightline/base/nearest.hpp"
#include "sightline/scenario.hpp"

namespace sightline::python {
namespace {

py::str key_of(std::string_view key) { return {key.data(), key.size()}; }

/// An argument as text for an error message.
std::string shown(const py::handle& value) {
  return shortened(one_line(std::string(py::str(py::repr(value)))), shown_size);
}

bool all_finite(const Numbers& numbers) {
  const std::span<const double> all = view(numbers);
  return std::all_of(all.begin(), all.end(), [](double v) { return std::isfinite(v); });
}

}  // namespace

bool KeywordSource::has(std::string_view key) const {
  return given_.contains(key_of(key)) && !given_[key_of(key)].is_none();
}

void KeywordSource::expect_only(std::span<const std::string_view> keys) const {
  for (const auto& [key, value] : given_) {
    const std::string name = utf8(key, part_);
    if (std::find(keys.begin(), keys.end(), name) != keys.end()) continue;
    const std::string expected =
        keys.empty() ? std::string("no argument") : "a known one" + hint(shortened(name, shown_size), keys);
    throw py::type_error(fmt::format("{}.{} = {}, expected {}", part_, name, shown(value), expected));
  }
}

void KeywordSource::throw_invalid(std::string_view sentence) const {
  throw std::invalid_argument(std::string(sentence));
}

void KeywordSource::throw_invalid(std::string_view key, std::string_view expected) const {
  throw_invalid(fmt::format("{}.{} = {}, expected {}", part_, key, shown(given_[key_of(key)]), expected));
}

py::object KeywordSource::at(std::string_view key, std::string_view expected) const {
  if (!has(key)) throw_invalid(fmt::format("{}.{} is missing, expected {}", part_, key, expected));
  return given_[key_of(key)];
}

Numbers KeywordSource::array_at(std::string_view key, std::string_view expected) const {
  const py::object value = at(key, expected);
  // Strings and booleans are not numbers, although numpy converts some of them.
  const bool is_other = py::isinstance<py::str>(value) || py::isinstance<py::bool_>(value);
  Numbers numbers = is_other ? py::reinterpret_steal<Numbers>(py::handle()) : Numbers::ensure(value);
  if (!numbers) throw_invalid(key, expected);
  if (!all_finite(numbers)) throw_invalid(key, expected);
  return numbers;
}

double KeywordSource::number(std::string_view key, const Bounds& bounds, std::string_view unit) const {
  const std::string expected = bounds.expected(unit);
  const Numbers value = array_at(key, fmt::format("a number, {}", expected));
  if (value.ndim() != 0) throw_invalid(key, fmt::format("a number, {}", expected));
  if (!bounds.hold(*value.data())) throw_invalid(key, expected);
  return *value.data();
}

int KeywordSource::integer(std::string_view key, const Bounds& bounds) const {
  constexpr double most = 2147483647.0;
  const double value = number(key, bounds, "");
  if (value != std::floor(value) || std::fabs(value) > most)
    throw_invalid(key, fmt::format("a whole number, {}", bounds.expected("")));
  return static_cast<int>(value);
}

std::vector<double> KeywordSource::numbers(std::string_view key, std::size_t length, const Bounds& bounds,
                                           std::string_view unit) const {
  const std::string expected = length == any_length
                                   ? fmt::format("numbers, each {}", bounds.expected(unit))
                                   : fmt::format("{} numbers, each {}", length, bounds.expected(unit));
  const Numbers value = array_at(key, expected);
  const std::span<const double> all = view(value);
  if (value.ndim() != 1 || (length != any_length && all.size() != length)) throw_invalid(key, expected);
  if (!std::all_of(all.begin(), all.end(), [&](double v) { return bounds.hold(v); }))
    throw_invalid(key, expected);
  return {all.begin(), all.end()};
}

std::vector<double> KeywordSource::rising(std::string_view key) const {
  constexpr std::string_view expected = "a list of rising numbers, at least one";
  std::vector<double> all = numbers(key, any_length, any_finite, "");
  const bool rises = std::adjacent_find(all.begin(), all.end(), std::greater_equal<>()) == all.end();
  if (all.empty() || !rises) throw_invalid(key, expected);
  return all;
}

std::vector<std::vector<double>> KeywordSource::rows(std::string_view key, std::size_t count,
                                                     std::size_t length) const {
  const std::string expected = count == any_length ? fmt::format("lists of {} numbers", length)
                                                   : fmt::format("{} lists of {} numbers", count, length);
  const Numbers value = array_at(key, expected);
  if (value.ndim() != 2 || value.shape(1) != static_cast<py::ssize_t>(length) ||
      (count != any_length && value.shape(0) != static_cast<py::ssize_t>(count)))
    throw_invalid(key, expected);
  std::vector<std::vector<double>> all;
  for (py::ssize_t i = 0; i < value.shape(0); ++i) all.emplace_back(value.data(i), value.data(i) + length);
  return all;
}

std::size_t KeywordSource::word(std::string_view key, std::span<const std::string_view> known) const {
  const std::string expected = fmt::format("one of {}", words_text(known));
  const py::object value = at(key, expected);
  if (!py::isinstance<py::str>(value)) throw_invalid(key, expected);
  const auto found = std::find(known.begin(), known.end(), utf8(value, key));
  if (found == known.end()) throw_invalid(key, expected);
  return static_cast<std::size_t>(found - known.begin());
}

}  // namespace sightline::python
