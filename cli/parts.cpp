#include <nlohmann/json.hpp>

#include "cli/arguments.hpp"
#include "cli/output.hpp"
#include "sightline/base/json_text.hpp"
#include "sightline/registry.hpp"

namespace sightline::cli {
namespace {

using Json = nlohmann::ordered_json;

template <class Made>
void add(Json& json, const PartList<Made>& list) {
  Json& kind = json[std::string(list.kind())] = Json::object();
  for (const auto& part : list.all()) {
    Json& parameters = kind[part->name] = Json::array();
    if (!part->presets.empty()) parameters.push_back({{"key", "preset"}, {"one_of", part->presets}});
    for (const ParameterText& p : part->parameters) {
      Json& one = parameters.emplace_back(Json{{"key", p.key}, {"unit", p.unit}, {"range", p.range}});
      one["default"] = p.fallback.empty() ? Json() : Json(p.fallback);
      one["must_be_given"] = p.must_be_given;
      one["meaning"] = p.meaning;
    }
  }
}

int list_parts(bool json, const Registry& registry) {
  if (json) {
    Json all = Json::object();
    add(all, registry.robots);
    add(all, registry.potentials);
    add(all, registry.references);
    add(all, registry.limits);
    print("{}\n", json_text(all, 2));
  } else {
    print("{}\n{}\n{}\n{}", parameters_table(registry.robots), parameters_table(registry.potentials),
          parameters_table(registry.references), parameters_table(registry.limits));
  }
  return 0;
}

}  // namespace

Execute describe_parts(CLI::App& app) {
  const auto json = std::make_shared<bool>(false);
  app.description("List the robots, potentials, references and limits that a scenario may use");
  app.add_flag("--json", *json, "JSON instead of tables");
  return [json](const Registry& registry, char**) { return list_parts(*json, registry); };
}

}  // namespace sightline::cli
