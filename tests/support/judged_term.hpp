/// What a limit of a scenario says of two poses, by the documents' mathematics and none of the library's.
#pragma once

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/flight_log.hpp"
#include "tests/support/limit_text.hpp"

namespace sightline::test {

using Seen = FlightLog::Seen;

inline double distance(const Seen& a, const Seen& b) {
  return std::hypot(a.p[0] - b.p[0], a.p[1] - b.p[1], a.p[2] - b.p[2]);
}

/// A sensor on a robot: pitched down [rad], ahead of its place [m].
struct JudgedSensor {
  double pitch, offset;

  /// A body as the sensor has it: ahead along its axis, left, up.
  std::array<double, 3> operator()(const Seen& from, const Seen& to) const {
    const double x = to.p[0] - from.p[0], y = to.p[1] - from.p[1], up = to.p[2] - from.p[2];
    const double ahead = x * from.d[0] + y * from.d[1] - offset, left = y * from.d[0] - x * from.d[1];
    return {ahead * std::cos(pitch) - up * std::sin(pitch), left,
            ahead * std::sin(pitch) + up * std::cos(pitch)};
  }
  /// Off its axis [rad], (71).
  double angle(const Seen& from, const Seen& to) const {
    const auto [x, y, z] = (*this)(from, to);
    return std::atan2(std::hypot(y, z), x);
  }
};

/// A limit or another term, with the time in which nobody can doubt that it is in force.
struct JudgedTerm {
  std::string kind;
  const toml::table* keys = nullptr;
  std::string a, b;  // the same for one robot alone
  std::vector<std::string> felt_by;
  std::string name = {};
  double from = 0.0, until = std::numeric_limits<double>::infinity();  // [s]

  bool lasts() const { return std::isinf(until); }
  bool is_limit() const { return kind != "relative_velocity"; }
  bool is_region() const { return kind == "region" || kind == "sensor"; }
  bool joins(const std::string& x, const std::string& y) const {
    return (a == x && b == y) || (a == y && b == x);
  }
  /// As the summary names it.
  std::string label() const { return a == b ? kind + " " + a : fmt::format("{} {}-{}", kind, a, b); }

  /// Whether it looks through the sensor.
  bool is_view() const {
    return kind == "bearing" || kind == "sensor_cone" ||
           (is_region() && (says("bearing") || says("azimuth")));
  }
  /// What holds bodies apart stays where an observer turns to another target.
  bool keeps_apart() const {
    return kind == "too_near" || kind == "keep_out" || kind == "pass_right" ||
           (is_region() && (says("distance >") || says("hypot(r_x")));
  }

  /// How far the limit is broken at a time, in its unit; <= 0 where it is kept.
  double excess(const Seen& of_a, const Seen& of_b, const JudgedSensor& sensor, double t) const {
    const auto number = [&](std::string_view key, double missing) { return (*keys)[key].value_or(missing); };
    if (kind == "too_near" || kind == "keep_out") return number("d_min", 1.0) - distance(of_a, of_b);
    if (kind == "too_far" || kind == "cohesion") return distance(of_a, of_b) - number("d_max", 2.0);
    if (kind == "bearing" || kind == "sensor_cone") return sensor.angle(of_a, of_b) - number("alpha", 0.5);
    if (kind == "altitude_band")
      return std::max(number("z_min", 0.3) - of_a.p[2], of_a.p[2] - number("z_max", 3.0));
    if (kind == "pass_right") {
      // Each is pushed off from where it has the other a little to its left.
      const double half = 0.5 * number("delta", 0.2),
                   x = of_a.p[0] - of_b.p[0] + half * (of_a.d[1] - of_b.d[1]),
                   y = of_a.p[1] - of_b.p[1] - half * (of_a.d[0] - of_b.d[0]);
      return number("d_min", 1.0) - std::hypot(x, y, of_a.p[2] - of_b.p[2]);
    }
    double worst = -std::numeric_limits<double>::infinity();
    if (kind == "geofence") {
      for (std::size_t i = 0; i < 3; ++i) {
        worst = std::max({worst, of_a.p[i] - (*keys)["high"][i].value_or(0.0),
                          (*keys)["low"][i].value_or(0.0) - of_a.p[i]});
      }
    }
    if (!is_region()) return worst;
    const auto quantities = [&](std::string_view what) {
      return quantity(what, of_a, of_b, sensor(of_a, of_b), t);
    };
    return LimitText((*keys)["parameters"].as_table(), quantities).excess(*keys->get("inside"));
  }

 private:
  bool says(std::string_view word) const {
    std::ostringstream text;
    text << *keys;
    return text.str().find(word) != std::string::npos;
  }

  static std::optional<double> quantity(std::string_view name, const Seen& a, const Seen& b,
                                        const std::array<double, 3>& in_sensor, double t) {
    const auto [x, y, z] = in_sensor;
    const std::map<std::string_view, double> known = {{"x", x},
                                                      {"y", y},
                                                      {"z", z},
                                                      {"range", std::hypot(x, y, z)},
                                                      {"bearing", std::atan2(std::hypot(y, z), x)},
                                                      {"azimuth", std::atan2(y, x)},
                                                      {"elevation", std::atan2(z, std::hypot(x, y))},
                                                      {"r_x", b.p[0] - a.p[0]},
                                                      {"r_y", b.p[1] - a.p[1]},
                                                      {"r_z", b.p[2] - a.p[2]},
                                                      {"distance", distance(a, b)},
                                                      {"t", t}};
    if (const auto found = known.find(name); found != known.end()) return found->second;
    const std::size_t dot = name.find('.');
    if (dot == std::string_view::npos || name.size() != dot + 4) return std::nullopt;
    const Seen& of = name.starts_with("observer") ? a : b;
    const auto axis = static_cast<std::size_t>(name.back() - 'x');
    return name[dot + 1] == 'p' ? of.p.at(axis) : name[dot + 1] == 'v' ? of.v.at(axis) : of.d.at(axis);
  }
};

}  // namespace sightline::test
