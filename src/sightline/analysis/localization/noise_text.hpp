/// Numbers of a noise as TOML and as JSON.
#pragma once

#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <type_traits>

#include "sightline/base.hpp"

namespace sightline {

/// Angles of texts are in degrees.
inline constexpr double degrees_of_radian = 180 / std::numbers::pi;

/// A number with 4 digits that TOML takes for a float.
inline std::string float_text(double value) {
  std::string text = fmt::format("{:.4g}", value);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

/// The table [localize] with all numbers.
template <class Noise>
std::string noise_text(const Noise& noise) {
  std::string text = "[localize]\n";
  const auto add = [&](const auto& p) {
    const auto value = noise.*p.member;
    if constexpr (std::is_same_v<std::remove_cvref_t<decltype(value)>, int>) {
      text += fmt::format("{} = {}\n", p.key, value);
    } else {
      text += fmt::format("{} = {}{}\n", p.key, float_text(value),
                          p.unit.empty() ? "" : fmt::format("  # {}", p.unit));
    }
  };
  each_parameter<Noise>(add);
  return text;
}

template <class Noise>
nlohmann::ordered_json noise_json(const Noise& noise) {
  nlohmann::ordered_json numbers;
  each_parameter<Noise>([&](const auto& p) { numbers[std::string(p.key)] = noise.*p.member; });
  return numbers;
}

}  // namespace sightline
