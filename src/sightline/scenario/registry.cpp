#include "sightline/registry.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "sightline/base.hpp"
#include "sightline/model.hpp"
#include "sightline/potentials.hpp"
#include "sightline/robots.hpp"
#include "sightline/scenario.hpp"
#include "sightline/scenario/built_in_solvers.hpp"
#include "sightline/worlds.hpp"

namespace sightline {

Registry::Registry() {
  robots.add<Multirotor>();
  robots.add<AngleMultirotor>();
  robots.add<OmniRover>();
  robots.add<Unicycle>();
  robots.add<PointMass>();
  robots.add<VelocityMultirotor>();
  robots.add<HoverMultirotor>();

  potentials.add<SensorCone>();
  potentials.add<KeepOut>();
  potentials.add<Cohesion>();
  potentials.add<Bearing>();
  potentials.add<TooNear>();
  potentials.add<PassRight>();
  potentials.add<TooFar>();
  potentials.add<RelativeVelocity>();
  potentials.add<AltitudeBand>();
  potentials.add<Geofence>();

  references.add<Constant>();
  references.add<Circle>();
  references.add<Waypoints>();
  references.add<Steps>();

  limits.add<SpeedLimit>();
  limits.add<InputDisc>();

  worlds.add("model", [](const Scenario& scenario) -> std::unique_ptr<World> {
    return std::make_unique<ModelWorld>(scenario.team, scenario.x0, plant_options(scenario),
                                        sensor_options(scenario));
  });
  const auto rotors = [](const Scenario& scenario) -> std::unique_ptr<World> {
    return std::make_unique<RotorWorld>(scenario.team, scenario.x0, scenario.vehicles,
                                        plant_options(scenario), sensor_options(scenario));
  };
  worlds.add("rotors", rotors, MovedBy::vehicles);

  add_built_in(solvers);
}

WorldList& WorldList::add(std::string_view name, MakeWorld make, MovedBy robots, VehicleOfModel of_model,
                          MakeRenderer renderer, CheckWorld check) {
  check_part_name("world", name, {}, names());
  if (!make)
    throw_invalid("the world \"{}\" has no function, expected one that makes it of a scenario", name);
  worlds_.push_back({std::string(name), std::move(make), robots, std::move(of_model), std::move(renderer),
                     std::move(check)});
  return *this;
}

std::vector<std::string_view> WorldList::names(bool (WorldPart::*can)() const) const {
  std::vector<std::string_view> all;
  for (const WorldPart& world : worlds_)
    if (can == nullptr || (world.*can)()) all.push_back(world.name);
  return all;
}

const WorldPart* WorldList::find(std::string_view name) const {
  const auto found = std::find_if(worlds_.begin(), worlds_.end(),
                                  [&](const WorldPart& world) { return world.name == name; });
  return found != worlds_.end() ? &*found : nullptr;
}

const Registry& built_in_registry() {
  static const Registry parts;
  return parts;
}

void check_part_name(std::string_view kind, std::string_view name, const std::vector<std::string>& taken,
                     const std::vector<std::string_view>& names) {
  const auto lower = [](char c) { return c >= 'a' && c <= 'z'; };
  const bool is_word = !name.empty() && lower(name.front()) &&
                       std::all_of(name.begin(), name.end(),
                                   [&](char c) { return lower(c) || (c >= '0' && c <= '9') || c == '_'; });
  if (!is_word) {
    throw_invalid("a {} is called \"{}\", expected a word: a lower-case letter, then these, digits and _",
                  kind, name);
  }
  if (std::count(taken.begin(), taken.end(), name) + std::count(names.begin(), names.end(), name) > 0)
    throw_invalid("a {} is called \"{}\", expected a name of its own, another has this one", kind, name);
}

std::string parameters_table(std::string_view kind, std::span<const PartText> parts) {
  std::string text =
      fmt::format("| `{}` | parameter | default | range | meaning |\n|---|---|---|---|---|\n", kind);
  for (const PartText& part : parts) {
    if (!part.presets.empty()) {
      text += fmt::format("| `{}` | `preset` | {} | one of {} | the start for all others |\n", part.name,
                          part.presets.front(), fmt::join(part.presets, ", "));
    }
    for (const ParameterText& p : part.parameters) {
      const std::string_view missing = p.must_be_given ? "must be given" : "none";
      text += fmt::format("| `{}` | `{}` | {}{}{} | {} | {} |\n", part.name, p.key,
                          p.fallback.empty() ? missing : p.fallback,
                          p.fallback.empty() || p.unit.empty() ? "" : " ", p.fallback.empty() ? "" : p.unit,
                          p.range, p.meaning);
    }
  }
  return text;
}

}  // namespace sightline
