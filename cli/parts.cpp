#include "sightline/scenario/parts.hpp"

#include <nlohmann/json.hpp>

#include "cli/commands.hpp"
#include "cli/output.hpp"
#include "sightline/base/json_text.hpp"

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

}  // namespace

int list_parts(bool json, const Parts& parts) {
  if (json) {
    Json all = Json::object();
    add(all, parts.robots);
    add(all, parts.potentials);
    add(all, parts.references);
    add(all, parts.limits);
    print("{}\n", json_text(all, 2));
  } else {
    print("{}\n{}\n{}\n{}", parameters_table(parts.robots), parameters_table(parts.potentials),
          parameters_table(parts.references), parameters_table(parts.limits));
  }
  return 0;
}

}  // namespace sightline::cli
