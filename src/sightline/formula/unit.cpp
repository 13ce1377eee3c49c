#include <fmt/format.h>

#include <array>
#include <cmath>
#include <numbers>

#include "sightline/formula.hpp"

namespace sightline {
namespace {

constexpr std::array named = {
    NamedUnit{"m", units::length, 1.0},   NamedUnit{"cm", units::length, 1e-2},
    NamedUnit{"mm", units::length, 1e-3}, NamedUnit{"km", units::length, 1e3},
    NamedUnit{"rad", units::none, 1.0},   NamedUnit{"deg", units::none, std::numbers::pi / 180},
    NamedUnit{"s", units::time, 1.0},     NamedUnit{"ms", units::time, 1e-3},
    NamedUnit{"Hz", Unit{0, -2}, 1.0},
};

std::string with_power(std::string_view name, int halves) {
  if (halves == 2) return std::string(name);
  return halves % 2 == 0 ? fmt::format("{}^{}", name, halves / 2) : fmt::format("{}^{}", name, halves / 2.0);
}

}  // namespace

std::optional<NamedUnit> unit_named(std::string_view name) {
  for (const NamedUnit& unit : named) {
    if (unit.name == name) return unit;
  }
  return {};
}

std::optional<Unit> to_power(Unit unit, double power) {
  const double metre = unit.metre * power, second = unit.second * power;
  if (!(std::fabs(power) <= 64) || metre != std::round(metre) || second != std::round(second)) return {};
  return Unit{static_cast<int>(metre), static_cast<int>(second)};
}

std::string to_string(Unit unit) {
  if (unit == units::none) return "a plain number or an angle";
  std::string above, below;
  for (const auto& [name, halves] : {std::pair{"m", unit.metre}, std::pair{"s", unit.second}}) {
    std::string& side = halves > 0 ? above : below;
    if (halves != 0) side += fmt::format("{}{}", side.empty() ? "" : " ", with_power(name, std::abs(halves)));
  }
  if (below.empty()) return above;
  return fmt::format("{}/{}", above.empty() ? "1" : above, below);
}

}  // namespace sightline
