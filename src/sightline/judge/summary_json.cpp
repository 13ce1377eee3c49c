#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "sightline/base/json_text.hpp"
#include "sightline/base/sentence.hpp"
#include "sightline/base/text_file.hpp"
#include "sightline/config.hpp"
#include "sightline/judge/summary.hpp"
#include "sightline/judge/summary_keys.hpp"

namespace sightline {
namespace {

using Json = nlohmann::ordered_json;

}  // namespace

std::string Summary::json() const {
  const SummaryValues v = values();
  const auto add_time = [&](Json& to, const TimeInForce& time) {
    if (!time.is_whole(end_)) to["in_force"_key] = Json::parse(time.json());
  };
  Json json;
  json["scenario"_key] = scenario_.name;
  json["seed"_key] = scenario_.simulation.seed;
  json["version"_key] = version;
  json["solver"_key] = scenario_.solver.name;
  json["settle"_key] = scenario_.simulation.settle;
  json["updates"_key] = v.updates;
  json["cost"_key] = v.cost;
  json["solve_us"_key] = {{"mean"_key, v.solve_us.mean},
                          {"median"_key, v.solve_us.median},
                          {"p99"_key, v.solve_us.p99},
                          {"max"_key, v.solve_us.max}};
  json["allocations_per_update"_key] = v.allocations_per_update;
  for (int i = 0; i < status_count; ++i) {
    json["status"_key][std::string(to_string(static_cast<Status>(i)))] =
        v.statuses[static_cast<std::size_t>(i)];
  }
  json["without_plan"_key] = Json::parse(plans_.json());
  json["not_finite"_key] = v.not_finite;
  json["input_violations"_key] = v.input_violations;
  json["applied_violations"_key] = v.applied_violations;
  json["max_abs_input"_key] = v.max_abs_input;
  json["min_distance"_key] = v.min_distance;
  if (!scenario_.team.swarms().empty()) {
    json["pairs_active_max"_key] = v.pairs_active_max;
    json["pairs_left_out_max"_key] = v.pairs_left_out_max;
  }
  for (const char* list : {"pairs", "agents", "limits", "chatter", "drift", "events"})
    json[list] = Json::array();
  for (const auto& pair : v.pairs) {
    json["pairs"_key].push_back(
        {{"observer"_key, pair.observer},
         {"target"_key, pair.target},
         {"distance"_key, {{"min"_key, pair.distance_min}, {"max"_key, pair.distance_max}}},
         {"view_angle_max"_key, pair.view_angle_max},
         {"in_view_from"_key, pair.in_view_from},
         {"in_view_fraction"_key, pair.in_view_fraction}});
    Json& seen = json["pairs"_key].back();
    if (!pair.sensor.empty()) seen["sensor"_key] = pair.sensor;
    if (pair.from_leaning) {
      seen["view_angle_mean"_key] = pair.view_angle_mean;
      seen["planned_view_angle"_key] = {{"ahead"_key, PlannedView::ahead},
                                        {"mean"_key, pair.planned_view_mean},
                                        {"rms"_key, pair.planned_view_rms}};
    }
    add_time(seen, pair.in_force);
  }
  for (const auto& idle : v.idle_observers) {
    json["idle_observers"_key].push_back(
        {{"observer"_key, idle.observer}, {"in_force"_key, Json::parse(idle.time.json())}});
  }
  for (const auto& robot : v.robots) {
    json["agents"_key].push_back({{"name"_key, robot.name},
                                  {"rms_position_error"_key, robot.rms_position_error},
                                  {"energy"_key, robot.energy}});
    if (!std::isnan(robot.rms_position_error)) {
      json["agents"_key].back()["position_offset"_key] = robot.position_offset;
      json["agents"_key].back()["tracking_error"_key] = robot.tracking_error;
    }
    if (!std::isnan(robot.rms_heading_error))
      json["agents"_key].back()["rms_heading_error"_key] = robot.rms_heading_error;
    if (!std::isnan(robot.tilt_max)) {
      json["agents"_key].back()["tilt_max"_key] = robot.tilt_max;
      json["agents"_key].back()["planned_tilt"_key] = {{"ahead"_key, PlannedTilt::ahead},
                                                       {"max"_key, robot.planned_tilt_max},
                                                       {"rms"_key, robot.planned_tilt_rms}};
    }
    if (!std::isnan(robot.input_rate_ratio))
      json["agents"_key].back()["input_rate_ratio"_key] = robot.input_rate_ratio;
  }
  for (const auto& limit : v.limits) {
    json["limits"_key].push_back({{"name"_key, limit.name},
                                  {"fraction"_key, limit.fraction},
                                  {"longest"_key, limit.longest},
                                  {"worst"_key, limit.worst},
                                  {"unit"_key, limit.unit}});
    add_time(json["limits"_key].back(), limit.in_force);
  }
  for (const auto& c : v.chatter) {
    json["chatter"_key].push_back({{"agent"_key, c.agent},
                                   {"input"_key, c.input},
                                   {"from"_key, c.from},
                                   {"share"_key, c.share},
                                   {"jump"_key, c.jump},
                                   {"region"_key, c.region}});
  }
  if (!v.drift) {
    json["drift"_key] = nullptr;
  } else {
    for (const auto& d : *v.drift) {
      json["drift"_key].push_back({{"agent"_key, d.agent},
                                   {"speed"_key, norm(d.v)},
                                   {"velocity"_key, {d.v.x, d.v.y, d.v.z}},
                                   {"from_reference"_key, d.from_reference}});
    }
  }
  for (const auto& event : v.events)
    json["events"_key].push_back({{"time"_key, event.time}, {"name"_key, event.name}});
  if (const std::string localization = localization_.json(); !localization.empty())
    json["localization"_key] = Json::parse(localization);
  if (const std::string safety = safety_.json(); !safety.empty()) json["safety"_key] = Json::parse(safety);
  return json_text(json, 2) + "\n";
}

std::string write_summary(const std::filesystem::path& folder, std::string_view json) {
  try {
    write_text(folder / "summary.json", json);
    return {};
  } catch (const std::runtime_error& error) {
    return sentence_of(error);
  }
}

}  // namespace sightline
