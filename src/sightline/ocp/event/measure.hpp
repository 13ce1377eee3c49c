/// Measures that a condition evaluates, each a struct in the list `Measure`. Its functions and
/// constants:
///
///   keys       its keys in a scenario, within `when`; without keys only code makes it
///   value      its present value; NaN if a body is absent
///   scale      of a key: its threshold, and the further keys of its table
///   read       from the table of that key
///   bodies     that it refers to
///   describe   a text for the user
#pragma once

#include <fmt/format.h>

#include <array>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "sightline/base/range.hpp"
#include "sightline/ocp/event/moment.hpp"
#include "sightline/ocp/view_choice.hpp"

namespace sightline {

/// Range of a measure and of the threshold that a condition compares it with.
struct MeasureScale {
  std::optional<Range> threshold{};  ///< none: the measure is a limit, which holds below 0
  std::string_view unit{};
  /// The measure lies between 0 and this; none: unbounded.
  std::optional<double> largest{};
  std::vector<std::string_view> beside{};  ///< further keys that the table may have
};

inline constexpr double no_measure = std::numeric_limits<double>::quiet_NaN();

/// Distance of the positions of two bodies [m].
struct DistanceOf {
  static constexpr std::array<std::string_view, 1> keys = {"distance"};

  BodyId a, b;

  double value(const EventInstant& now) const noexcept {
    return now.is_there(a) && now.is_there(b) ? norm(now.sight(a).p - now.sight(b).p) : no_measure;
  }
  static MeasureScale scale(std::string_view /*key*/) {
    return {.threshold = positive("> 0 m"), .unit = "m", .largest = largest_number};
  }
  std::vector<BodyId> bodies() const { return {a, b}; }
  std::string describe(const Team& all) const {
    return fmt::format("the distance of {} and {}", all.name(a), all.name(b));
  }
  template <class Text>
  static DistanceOf read(const Text& when, std::string_view key) {
    const Between ends = when.two_bodies(key);
    return {ends.first, ends.second};
  }
};

/// The angle between the sensor's axis and the target, (71) [rad].
struct ViewAngleOf {
  static constexpr std::array<std::string_view, 1> keys = {"angle"};
  static constexpr Range range = {std::numeric_limits<double>::min(), std::numbers::pi*(1 - 1e-15),
                                  "in (0, pi) rad"};

  BodyId observer, target;
  SensorMount mount{};

  double value(const EventInstant& now) const noexcept {
    if (!now.is_there(observer) || !now.is_there(target)) return no_measure;
    return view_angle(mount, now.sight(observer), now.sight(target).p);
  }
  static MeasureScale scale(std::string_view /*key*/) {
    return {.threshold = range, .unit = "rad", .largest = std::numbers::pi};
  }
  std::vector<BodyId> bodies() const { return {observer, target}; }
  std::string describe(const Team& all) const {
    return fmt::format("the view angle of {} to {}", all.name(observer), all.name(target));
  }
  template <class Text>
  static ViewAngleOf read(const Text& when, std::string_view key) {
    const Between ends = when.two_bodies(key);
    return {ends.first, ends.second, when.sensor_of(ends.first, key)};
  }
};

/// Age of the last measurement of a body [s].
struct AgeOf {
  static constexpr std::array<std::string_view, 1> keys = {"age"};

  BodyId body;

  double value(const EventInstant& now) const noexcept {
    return now.is_there(body) ? now.age(body) : no_measure;
  }
  static MeasureScale scale(std::string_view /*key*/) {
    return {.threshold = positive("> 0 s"), .unit = "s", .largest = largest_number};
  }
  std::vector<BodyId> bodies() const { return {body}; }
  std::string describe(const Team& all) const {
    return fmt::format("the age of what is known of {}", all.name(body));
  }
  template <class Text>
  static AgeOf read(const Text& when, std::string_view key) {
    return {when.body(key, "the name of a body")};
  }
};

/// Violation of a limit, in its unit: > 0 outside.
struct ExcessOf {
  static constexpr std::array<std::string_view, 2> keys = {"region", "formula"};

  Potential potential;  ///< one that states a limit
  BodyId a, b;          ///< a potential of one robot has the same body twice

  double value(const EventInstant& now) const noexcept {
    if (!now.is_there(a) || !now.is_there(b)) return no_measure;
    return potential.violation(now.sight(a), now.sight(b), now.known.t);
  }
  static MeasureScale scale(std::string_view key) {
    MeasureScale scale{.beside = {"between", "agent", "parameters"}};
    if (key == "formula") scale.threshold = any_number();
    return scale;
  }
  std::vector<BodyId> bodies() const { return {a, b}; }
  std::string describe(const Team& all) const {
    return fmt::format("the excess of {} {}", potential.name(), whose(all, "of", "between"));
  }
  /// "is broken between uav0 and uav1".
  std::string limit_words(const Team& all, bool is_broken) const {
    return fmt::format("{} {} {}", potential.name(), is_broken ? "is broken" : "holds",
                       whose(all, "for", "between"));
  }
  template <class Text>
  static ExcessOf read(const Text& when, std::string_view key) {
    if (when.has("agent") == when.has("between")) when.throw_invalid("exactly one of between, agent");
    const std::string_view ends_key = when.has("agent") ? "agent" : "between";
    const Between ends = when.has("agent") ? when.one_robot(ends_key) : when.two_bodies(ends_key);
    return {when.limits(key, ends.first, ends_key), ends.first, ends.second};
  }

 private:
  std::string whose(const Team& all, std::string_view one, std::string_view two) const {
    if (a == b) return fmt::format("{} {}", one, all.name(a));
    return fmt::format("{} {} and {}", two, all.name(a), all.name(b));
  }
};

/// How much nearer the robot b is to a target than the robot a, which b would replace [m]. Infinite
/// if a is not steered, so that b replaces a robot that brakes or sinks; no measure if b is not
/// steered. Made by shapes only (shape.hpp).
struct NearerThan {
  BodyId a, b, target;

  double value(const EventInstant& now) const noexcept {
    if (!now.is_steered(b) || !now.is_there(target)) return no_measure;
    if (!now.is_steered(a)) return std::numeric_limits<double>::infinity();
    const Vec3<double> p = now.sight(target).p;
    return norm(now.sight(a).p - p) - norm(now.sight(b).p - p);
  }
  static MeasureScale scale(std::string_view /*key*/) { return {}; }
  std::vector<BodyId> bodies() const { return {a, b, target}; }
  std::string describe(const Team& all) const {
    return fmt::format("what {} is nearer to {} than {}", all.name(b), all.name(target), all.name(a));
  }
};

/// 1 in the period in which a choice turns an observer to this target, or to nobody; else 0. Made
/// by shapes only.
struct TurnedTo {
  std::size_t choice = 0;    ///< index in the script
  std::size_t observer = 0;  ///< index in the choice
  int target = ViewChoice::nobody;
  BodyId body{};  ///< the observer

  double value(const EventInstant& now) const noexcept {
    if (choice >= now.choosers.size()) return no_measure;
    const ViewChooser& chooser = now.choosers[choice];
    return chooser.changed(observer) && chooser.target(observer) == target ? 1.0 : 0.0;
  }
  static MeasureScale scale(std::string_view /*key*/) { return {}; }
  std::vector<BodyId> bodies() const { return {body}; }
  std::string describe(const Team& all) const { return fmt::format("the choice for {}", all.name(body)); }
};

using Measure = std::variant<DistanceOf, ViewAngleOf, AgeOf, ExcessOf, NearerThan, TurnedTo>;

}  // namespace sightline
