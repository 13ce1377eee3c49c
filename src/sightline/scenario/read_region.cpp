#include "sightline/scenario/read_region.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>

namespace sightline {
namespace {

constexpr std::size_t parameters_max = 64;

/// The parameters of a region, each with its value in the file.
class RegionParameters {
 public:
  void read(const TomlTable& at) {
    for (const std::string& name : at.keys()) enter(name, at);
    if (values_.size() > parameters_max)
      at.throw_invalid(fmt::format("at most {} parameters", parameters_max));
  }

  /// Replaces the values of existing parameters.
  void replace(const TomlTable& at) {
    std::vector<std::string> names;
    for (const Parameter& p : list_) names.push_back(p.name);
    at.expect_only(std::vector<std::string_view>(names.begin(), names.end()));
    read(at);
  }

  const std::vector<Parameter>& list() const { return list_; }

  Vocabulary vocabulary() const {
    try {
      return Region::vocabulary(list_);
    } catch (const FormulaError& error) {
      const TomlValue& value = values_.at(error.definition());
      value.refuse_at(error.offset(), error.sentence());
    }
  }

 private:
  void enter(const std::string& name, const TomlTable& at) {
    constexpr std::string_view expected = "a number, a formula in quotes, or a table with value";
    const TomlValue value = at.value(name, expected);
    if (!value.is_table()) return put(Parameter(name, formula_text(value, expected)), value);
    const TomlTable table = value.table();
    table.expect_only({"value", "unit", "range"});
    const TomlValue inner = table.value("value", "a number or a formula in quotes");
    Parameter parameter(name, formula_text(inner, "a number or a formula in quotes"));
    std::string unit;
    if (table.has("unit")) {
      unit = table.text("unit", "a unit in quotes");
      if (!inner.is_number()) table.throw_invalid("unit", "no unit beside a formula, which has its own");
      check_unit(table.value("unit", "a unit in quotes"));
      parameter.text += " " + unit;
    }
    if (table.has("range")) {
      const TomlValue range = table.value("range", "two bounds");
      if (!range.is_array() || range.items().size() != 2) range.throw_invalid("two bounds, [least, most]");
      const auto bound = [&](std::size_t i) {
        const TomlValue item = range.items()[i];
        const std::string text = formula_text(item, "a number or a formula in quotes");
        if (item.is_text()) in_text(item, [&] { return parse_formula(text, {}); });
        return item.is_text() ? text : fmt::format("{}{}{}", text, unit.empty() ? "" : " ", unit);
      };
      parameter.low = bound(0);
      parameter.high = bound(1);
    }
    put(std::move(parameter), inner);
  }

  static void check_unit(const TomlValue& unit) {
    constexpr std::string_view one = "1 ";
    try {
      parse_formula(fmt::format("{}{}", one, unit.text()), {});
    } catch (const FormulaError& error) {
      unit.refuse_at(error.offset() - std::min(error.offset(), one.size()), error.sentence());
    }
  }

  /// A parameter with a new value keeps its range.
  void put(Parameter parameter, const TomlValue& value) {
    values_.insert_or_assign(parameter.name, value);
    for (Parameter& known : list_) {
      if (known.name != parameter.name) continue;
      if (parameter.low.empty()) parameter.low = known.low, parameter.high = known.high;
      known = std::move(parameter);
      return;
    }
    list_.push_back(std::move(parameter));
  }

  std::vector<Parameter> list_;
  std::map<std::string, TomlValue> values_;
};

Limits read_limits(const TomlValue& value, const Vocabulary& names, int depth = 0) {
  constexpr std::string_view expected =
      "a comparison in quotes, or a table with limit, all_of, any_of or not";
  if (depth > region_depth_max)
    value.throw_invalid(fmt::format("at most {} within each other", region_depth_max));
  if (value.is_text()) {
    in_text(value, [&] { return parse_limits(value.text(), names); });
    return value.text();
  }
  if (!value.is_table()) value.throw_invalid(expected);
  const TomlTable table = value.table();
  if (table.has("limit")) {
    table.expect_only({"limit", "grows_with"});
    const TomlValue limit = table.value("limit", "a comparison in quotes");
    if (!limit.is_text()) limit.throw_invalid("a comparison in quotes");
    in_text(limit, [&] { return parse_limits(limit.text(), names); });
    if (!table.has("grows_with")) return limit.text();
    const TomlValue grows = table.value("grows_with", "a formula in quotes");
    if (!grows.is_text()) grows.throw_invalid("a formula in quotes");
    in_text(grows, [&] { return parse_formula(grows.text(), names); });
    return {limit.text(), grows.text()};
  }
  constexpr std::array<std::string_view, 4> kinds = {"all_of", "any_of", "not", "limit"};
  const std::string kind(table.choice(kinds));
  const TomlValue inner = table.value(kind, expected);
  if (kind == "not") return !read_limits(inner, names, depth + 1);
  if (!inner.is_array() || inner.items().empty()) inner.throw_invalid("an array of one or more limits");
  std::vector<Limits> parts;
  for (const TomlValue& item : inner.items()) parts.push_back(read_limits(item, names, depth + 1));
  return kind == "all_of" ? all_of(std::move(parts)) : any_of(std::move(parts));
}

Slope read_slope(const TomlTable& choice, const Vocabulary& names) {
  constexpr std::array<std::string_view, 3> slopes = {"none", "quadratic", "softplus"};
  const std::string kind(choice.choice(slopes));
  const TomlTable at = choice.table(kind);
  if (kind == "none") {
    at.expect_only({});
    return NoSlope{};
  }
  if (kind == "softplus") {
    Softplus slope;
    at.read(
        {{"kappa_G", &slope.kappa_G, positive("> 0")}, {"kappa_H", &slope.kappa_H, not_negative(">= 0")}});
    return slope;
  }
  Quadratic slope;
  at.read({{"kappa_G", &slope.kappa_G, not_negative(">= 0")}, {"kappa_H", &slope.kappa_H, positive("> 0")}},
          {"grows_with"});
  if (at.has("grows_with")) {
    const TomlValue grows = at.value("grows_with", "a formula in quotes");
    if (!grows.is_text()) grows.throw_invalid("a formula in quotes");
    in_text(grows, [&] { return parse_formula(grows.text(), names); });
    slope.grows_with = grows.text();
  }
  return slope;
}

/// Sets the potential's options once its limits are known; `here` overrides `there`.
Region finished(Region region, const Vocabulary& names, const TomlTable& here, const TomlTable* there) {
  const auto from = [&](std::string_view key) -> const TomlTable* {
    if (here.has(key)) return &here;
    return there != nullptr && there->has(key) ? there : nullptr;
  };
  double kappa_A = region.kappa_A(), width = region.width();
  if (const TomlTable* at = from("kappa_A")) kappa_A = at->number("kappa_A", positive("> 0"));
  if (const TomlTable* at = from("smooth")) width = at->number("smooth", {1e-9, 1.0, "1e-9 to 1"});
  region = region.sigmoid(kappa_A).smoothed_over(width);
  if (const TomlTable* at = from("slope")) region = region.slope(read_slope(at->table("slope"), names));
  return region;
}

/// The region of a file, with the overrides in `at`; named after the file.
Region read_file(const TomlTable& at) {
  at.expect_only({"file", "parameters", "slope", "kappa_A", "smooth"});
  const std::string name = at.text("file", "the file of a region, relative to this one");
  const std::filesystem::path file = std::filesystem::path(at.file()).parent_path() / name;
  std::string text;
  try {
    text = at.file_text(name);
  } catch (const ScenarioError& error) {
    at.throw_invalid("file", fmt::format("the file of a region, relative to this one ({})", error.what()));
  }
  const TomlDocument document = parse_toml(text, file.native());
  const TomlTable there(document);
  there.expect_only({"inside", "parameters", "slope", "kappa_A", "smooth"});
  RegionParameters parameters;
  parameters.read(there.table_or_empty("parameters"));
  parameters.replace(at.table_or_empty("parameters"));
  const Vocabulary names = parameters.vocabulary();
  const Limits inside = read_limits(there.value("inside", "the limits of the region"), names);
  return at.checked([&] { return finished(Region(inside, parameters.list()), names, at, &there); })
      .named(file.stem().string());
}

}  // namespace

Region read_inside(const TomlTable& at, std::string_view key) {
  const TomlValue value = at.value(key, "the limits of a region");
  if (value.is_table() && value.table().has("file")) return read_file(value.table());
  RegionParameters parameters;
  parameters.read(at.table_or_empty("parameters"));
  const Limits inside = read_limits(value, parameters.vocabulary());
  return at.checked([&] { return Region(inside, parameters.list()); });
}

Region read_formula(const TomlTable& at, std::string_view key) {
  const TomlValue value = at.value(key, "a formula in quotes");
  if (!value.is_text()) value.throw_invalid("a formula in quotes");
  RegionParameters parameters;
  parameters.read(at.table_or_empty("parameters"));
  in_text(value, [&] { return parse_formula(value.text(), parameters.vocabulary()); });
  return at.checked([&] { return Region(fmt::format("({}) < 0", value.text()), parameters.list()); });
}

std::string formula_text(const TomlValue& value, std::string_view expected) {
  if (value.is_text()) return value.text();
  if (!value.is_number()) value.throw_invalid(expected);
  return fmt::format("{}", value.number());
}

Region read_region(const TomlTable& at) {
  if (at.has("file")) return read_file(at);
  at.expect_only({"file", "inside", "parameters", "slope", "kappa_A", "smooth"});
  RegionParameters parameters;
  parameters.read(at.table_or_empty("parameters"));
  const Vocabulary names = parameters.vocabulary();
  const Limits inside = read_limits(at.value("inside", "the limits of the region"), names);
  return at.checked([&] { return finished(Region(inside, parameters.list()), names, at, nullptr); });
}

}  // namespace sightline
