#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "sightline/base/json_text.hpp"
#include "sightline/base/sentence.hpp"
#include "sightline/base/text_file.hpp"
#include "sightline/config.hpp"
#include "sightline/judge/summary.hpp"

namespace sightline {
namespace {

using Json = nlohmann::ordered_json;

}  // namespace

std::string Summary::json() const {
  const SummaryValues v = values();
  const auto add_time = [&](Json& to, const TimeInForce& time) {
    if (!time.is_whole(end_)) to["in_force"] = Json::parse(time.json());
  };
  Json json;
  json["scenario"] = scenario_.name;
  json["seed"] = scenario_.simulation.seed;
  json["version"] = version;
  json["solver"] = scenario_.solver.name;
  json["settle"] = scenario_.simulation.settle;
  json["updates"] = v.updates;
  json["cost"] = v.cost;
  json["solve_us"] = {{"mean", v.solve_us.mean},
                      {"median", v.solve_us.median},
                      {"p99", v.solve_us.p99},
                      {"max", v.solve_us.max}};
  json["allocations_per_update"] = v.allocations_per_update;
  for (int i = 0; i < status_count; ++i) {
    json["status"][std::string(to_string(static_cast<Status>(i)))] = v.statuses[static_cast<std::size_t>(i)];
  }
  json["without_plan"] = Json::parse(plans_.json());
  json["not_finite"] = v.not_finite;
  json["input_violations"] = v.input_violations;
  json["applied_violations"] = v.applied_violations;
  json["max_abs_input"] = v.max_abs_input;
  json["min_distance"] = v.min_distance;
  if (!scenario_.team.swarms().empty()) {
    json["pairs_active_max"] = v.pairs_active_max;
    json["pairs_left_out_max"] = v.pairs_left_out_max;
  }
  for (const char* list : {"pairs", "agents", "limits", "chatter", "drift", "events"})
    json[list] = Json::array();
  for (const auto& pair : v.pairs) {
    json["pairs"].push_back({{"observer", pair.observer},
                             {"target", pair.target},
                             {"distance", {{"min", pair.distance_min}, {"max", pair.distance_max}}},
                             {"view_angle_max", pair.view_angle_max},
                             {"in_view_from", pair.in_view_from},
                             {"in_view_fraction", pair.in_view_fraction}});
    if (pair.from_leaning) {
      Json& seen = json["pairs"].back();
      seen["view_angle_mean"] = pair.view_angle_mean;
      seen["planned_view_angle"] = {
          {"ahead", PlannedView::ahead}, {"mean", pair.planned_view_mean}, {"rms", pair.planned_view_rms}};
    }
    add_time(json["pairs"].back(), pair.in_force);
  }
  for (const auto& idle : v.idle_observers) {
    json["idle_observers"].push_back(
        {{"observer", idle.observer}, {"in_force", Json::parse(idle.time.json())}});
  }
  for (const auto& robot : v.robots) {
    json["agents"].push_back(
        {{"name", robot.name}, {"rms_position_error", robot.rms_position_error}, {"energy", robot.energy}});
    if (!std::isnan(robot.rms_position_error)) {
      json["agents"].back()["position_offset"] = robot.position_offset;
      json["agents"].back()["tracking_error"] = robot.tracking_error;
    }
    if (!std::isnan(robot.rms_heading_error))
      json["agents"].back()["rms_heading_error"] = robot.rms_heading_error;
    if (!std::isnan(robot.tilt_max)) {
      json["agents"].back()["tilt_max"] = robot.tilt_max;
      json["agents"].back()["planned_tilt"] = {
          {"ahead", PlannedTilt::ahead}, {"max", robot.planned_tilt_max}, {"rms", robot.planned_tilt_rms}};
    }
    if (!std::isnan(robot.input_rate_ratio))
      json["agents"].back()["input_rate_ratio"] = robot.input_rate_ratio;
  }
  for (const auto& limit : v.limits) {
    json["limits"].push_back({{"name", limit.name},
                              {"fraction", limit.fraction},
                              {"longest", limit.longest},
                              {"worst", limit.worst},
                              {"unit", limit.unit}});
    add_time(json["limits"].back(), limit.in_force);
  }
  for (const auto& c : v.chatter) {
    json["chatter"].push_back({{"agent", c.agent},
                               {"input", c.input},
                               {"from", c.from},
                               {"share", c.share},
                               {"jump", c.jump},
                               {"region", c.region}});
  }
  if (!v.drift) {
    json["drift"] = nullptr;
  } else {
    for (const auto& d : *v.drift) {
      json["drift"].push_back({{"agent", d.agent},
                               {"speed", norm(d.v)},
                               {"velocity", {d.v.x, d.v.y, d.v.z}},
                               {"from_reference", d.from_reference}});
    }
  }
  for (const auto& event : v.events) json["events"].push_back({{"time", event.time}, {"name", event.name}});
  if (const std::string localization = localization_.json(); !localization.empty())
    json["localization"] = Json::parse(localization);
  if (const std::string safety = safety_.json(); !safety.empty()) json["safety"] = Json::parse(safety);
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
