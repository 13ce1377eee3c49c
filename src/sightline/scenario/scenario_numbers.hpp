/// The numbers in a scenario's text by their keys, and their replacement in place.
#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <utility>

namespace sightline {

struct TomlDocument;

/// A number and the bytes of the text that hold it.
struct NumberInText {
  std::size_t offset = 0, size = 0;
  double value = 0.0;
};

/// By key, as in error messages: "horizon.duration", "agent.uav0.start.p[2]", "couple[0].weight".
using ScenarioNumbers = std::map<std::string, NumberInText, std::less<>>;

ScenarioNumbers numbers_of(const TomlDocument& document);

/// The text with other numbers at some places, each at most once; all else stays, comments and
/// lines too. A written number is read back bit for bit.
std::string with_numbers(std::string_view text, std::span<const std::pair<NumberInText, double>> changes);

}  // namespace sightline
