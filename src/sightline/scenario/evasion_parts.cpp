#include "sightline/scenario/evasion_parts.hpp"

#include "sightline/scenario/scenario_parts.hpp"

namespace sightline {
namespace {

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
  plan.agent = read_name(at, "agent", team, Among::robots, "a robot");
  plan.target = read_name(at, "target", team, Among::bodies, "another body");
  plan.obstacle = read_name(at, "obstacle", team, Among::bodies, "another body");
  if (at.has("published")) plan.published = read_columns(at.table("published"));
  return plan;
}

}  // namespace sightline
