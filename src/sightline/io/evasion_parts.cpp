#include "sightline/io/evasion_parts.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace sightline {
namespace {

enum class Kind { robot, other };

std::string name_of(const TomlTable& at, std::string_view key, const Team& team, Kind kind) {
  const std::string_view expected = kind == Kind::robot ? "a robot" : "another body";
  std::string name = at.text(key, expected);
  std::vector<std::string_view> known;
  for (int i = 0; i < team.bodies(); ++i) {
    if (kind == Kind::other || team.is_agent(BodyId{i})) known.push_back(team.name(BodyId{i}));
  }
  if (std::find(known.begin(), known.end(), name) == known.end()) {
    constexpr std::size_t shown_size = 60;
    at.refuse(
        key, fmt::format("{}, the nearest is \"{}\"", expected, nearest(shortened(name, shown_size), known)));
  }
  return name;
}

EvasionColumns read_columns(const TomlTable& at) {
  EvasionColumns columns;
  at.expect_only({"min_obstacle", "min_target", "max_target", "max_angle"});
  columns.min_obstacle = at.numbers("min_obstacle", TomlTable::any_length);
  const std::size_t runs = columns.min_obstacle.size();
  columns.min_target = at.numbers("min_target", runs);
  columns.max_target = at.numbers("max_target", runs);
  columns.max_angle = at.numbers("max_angle", runs);
  return columns;
}

}  // namespace

EvasionPlan read_evasion(const TomlTable& at, const Team& team) {
  EvasionPlan plan;
  constexpr Range length = positive("> 0 m");
  at.read({{"from", &plan.from, not_negative(">= 0 s")},
           {"d_obstacle", &plan.d_obstacle, length},
           {"d_min", &plan.d_min, length},
           {"d_max", &plan.d_max, length},
           {"alpha", &plan.alpha, positive("> 0 rad")}},
          {"agent", "target", "obstacle", "published"});
  plan.agent = name_of(at, "agent", team, Kind::robot);
  plan.target = name_of(at, "target", team, Kind::other);
  plan.obstacle = name_of(at, "obstacle", team, Kind::other);
  if (at.has("published")) plan.published = read_columns(at.table("published"));
  return plan;
}

}  // namespace sightline
