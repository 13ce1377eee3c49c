/// Units of measurement for positions and motions.
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace sightline {

/// Powers of metre and second, counted in halves, so that the root of a unit is a unit. Angles and
/// plain numbers have power 0.
struct Unit {
  int metre = 0, second = 0;

  bool operator==(const Unit&) const = default;
  friend Unit operator*(Unit a, Unit b) { return {a.metre + b.metre, a.second + b.second}; }
  friend Unit operator/(Unit a, Unit b) { return {a.metre - b.metre, a.second - b.second}; }
};

namespace units {
inline constexpr Unit none{}, length{2, 0}, time{0, 2}, velocity{2, -2};
}

/// A unit with its name and its size in SI units.
struct NamedUnit {
  std::string_view name;
  Unit unit;
  double factor;
};

/// Finds m, cm, mm, km, rad, deg, s, ms or Hz; none for another name.
std::optional<NamedUnit> unit_named(std::string_view name);

/// `unit` to a power of at most 64; none if the result has powers other than whole halves.
std::optional<Unit> to_power(Unit unit, double power);

/// Text of a unit: "m^2", "m/s", "1/s"; "a plain number or an angle".
std::string to_string(Unit unit);

}  // namespace sightline
