#include "sightline/server/tuner.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <span>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "sightline/base.hpp"
#include "sightline/base/json_text.hpp"
#include "sightline/model/state_roles.hpp"
#include "sightline/registry.hpp"
#include "sightline/scenario/read_event.hpp"
#include "sightline/scenario/templates.hpp"

namespace sightline {
namespace {

using Json = Tuner::Json;

constexpr std::array<std::string_view, 5> tuned_keys = {"retune", "reference", "move", "wind", "fault"};
constexpr std::size_t keys_of_team = 2;  // the first ones; the others change a simulated world
constexpr double longest_ramp = 60.0;    // [s]

bool is_bare(std::string_view key) {
  return !key.empty() && std::all_of(key.begin(), key.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  });
}

std::string in_quotes(std::string_view text) { return json_text(Json(text)); }

Json json_of_node(const toml::node& node) {
  std::ostringstream text;
  text << toml::json_formatter(node);
  return Json::parse(text.str());
}

/// A section of a document as a JSON object, "agent"; empty if it is missing.
Json section_of(const TomlDocument& document, std::string_view key) {
  const toml::node* const node = document.root.get(key);
  return node != nullptr ? json_of_node(*node) : Json::object();
}

TomlDocument expanded(const Scenario& scenario) {
  TomlDocument document = parse_toml(scenario.text, scenario.file.native());
  document.registry = scenario.registry.get();
  expand(document);
  return document;
}

/// The only entry of an object that selects a part by name; null for any other value.
const Json::object_t::value_type* chosen(const Json& choice) {
  if (!choice.is_object() || choice.size() != 1) return nullptr;
  return &*choice.get_ref<const Json::object_t&>().begin();
}

/// Bounds in the text of a parameter's range: "0.05 to 10", "in (0, pi/2)", ">= 0"; null for an
/// absent bound.
std::pair<Json, Json> bounds_in(std::string_view words) {
  const auto number = [](std::string_view text) -> Json {
    while (!text.empty() && std::string_view(" ([>=in").find(text.front()) != std::string_view::npos)
      text.remove_prefix(1);
    if (text.starts_with("pi/2")) return std::numbers::pi / 2;
    if (text.starts_with("pi")) return std::numbers::pi;
    double value = 0.0;
    const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
    return fault == std::errc() && end != text.data() ? Json(value) : Json();
  };
  if (words.starts_with('>')) return {number(words), Json()};
  for (const std::string_view between : {" to ", ", "}) {
    const std::size_t at = words.find(between);
    if (at != std::string_view::npos && !number(words.substr(0, at)).is_null())
      return {number(words.substr(0, at)), number(words.substr(at + between.size()))};
  }
  return {};
}

Json parameters_of(const std::vector<ParameterText>& texts, const Json& given) {
  Json list = Json::array();
  for (const ParameterText& p : texts) {
    const auto found = given.is_object() ? given.find(std::string(p.key)) : given.end();
    Json value;
    if (given.is_object() && found != given.end()) {
      value = *found;
    } else {
      double number = 0.0;
      const auto [end, fault] = std::from_chars(p.value.data(), p.value.data() + p.value.size(), number);
      if (fault == std::errc() && end == p.value.data() + p.value.size()) value = number;
    }
    if (!value.is_number()) continue;
    const auto [low, high] = bounds_in(p.range);
    list.push_back({{"key", p.key},
                    {"value", value},
                    {"unit", p.unit},
                    {"low", low},
                    {"high", high},
                    {"range", p.range},
                    {"meaning", p.meaning}});
  }
  return list;
}

double usual_ramp_of(const Json& change) {
  return change.contains("retune") ? Tuner::usual_ramp : Tuner::usual_turn;
}

}  // namespace

std::string toml_of(const nlohmann::ordered_json& value) {
  if (value.is_object()) {
    std::vector<std::string> entries;
    for (const auto& [key, inner] : value.items())
      entries.push_back(fmt::format("{} = {}", is_bare(key) ? key : in_quotes(key), toml_of(inner)));
    return entries.empty() ? "{}" : fmt::format("{{ {} }}", fmt::join(entries, ", "));
  }
  if (value.is_array()) {
    std::vector<std::string> items;
    for (const auto& item : value) items.push_back(toml_of(item));
    return fmt::format("[{}]", fmt::join(items, ", "));
  }
  if (value.is_null()) throw_invalid("null, expected a number, a text, true, false, an array or an object");
  if (!value.is_number_float()) return json_text(value);
  std::string number = fmt::format("{}", value.get<double>());
  if (number.find_first_of(".en") == std::string::npos) number += ".0";
  return number;
}

Tuner::Tuner(const Scenario& scenario) : scenario_(scenario), script_(scenario.script.events.size()) {
  const TomlDocument document = expanded(scenario_);
  const auto read_terms = [&](const std::string& kind, const auto& of_team) {
    const Json list = section_of(document, kind);
    for (std::size_t i = 0; i < list.size(); ++i) {
      const std::string place = fmt::format("{}[{}]", kind, i);
      const std::string name = list[i].value("name", place);
      const auto found =
          std::find_if(of_team.begin(), of_team.end(), [&](const auto& t) { return t.name == name; });
      if (found == of_team.end()) continue;  // a limit without a weight
      Term& term = now_.terms.emplace_back(Term{kind,
                                                name,
                                                place,
                                                {},
                                                found->term.weight,
                                                found->term.potential,
                                                list[i].value("potential", Json())});
      if constexpr (requires { found->between; }) {
        term.agents = {std::string(scenario_.team.name(found->between.first)),
                       std::string(scenario_.team.name(found->between.second))};
      } else {
        term.agents = {std::string(scenario_.team.name(found->agent))};
      }
    }
  };
  read_terms("couple", scenario_.team.couplings());
  read_terms("constrain", scenario_.team.constraints());
  const Json agents = section_of(document, "agent");
  for (const Agent& agent : scenario_.team.agents()) {
    const auto table = agents.find(agent.name);
    now_.references[agent.name] = table != agents.end() ? table->value("reference", Json()) : Json();
  }
  const Vec3<double>& wind = scenario_.simulation.disturbances.wind;
  now_.wind = {wind.x, wind.y, wind.z};
  try {  // no table can follow in a file with its events in one array
    (void)parse_toml(scenario_.text + "\n[[event]]\nat = 0.0\n", scenario_.file.native());
  } catch (const ScenarioError& error) {
    throw_invalid(
        "events cannot be added behind the scenario, expected [[event]] in place of event = [...]: {}",
        error.what());
  }
}

Tuner::Term& Tuner::Values::term(const std::string& kind, const std::string& name) {
  const auto found = std::find_if(terms.begin(), terms.end(),
                                  [&](const Term& t) { return t.kind == kind && t.name == name; });
  if (found == terms.end())
    throw_invalid("{} = {}, expected the name of a [[{}]]", kind, in_quotes(name), kind);
  return *found;
}

/// Keys of the event except `at`.
std::string Tuner::keys_of(const Json& change, double ramp) const {
  const auto keys = std::span(tuned_keys).first(changes_world() ? tuned_keys.size() : keys_of_team);
  if (!change.is_object() || change.empty())
    throw_invalid("event = {}, expected an object with one of {}", json_text(change), fmt::join(keys, ", "));
  std::string text;
  for (const auto& [key, value] : change.items()) {
    if (std::find(keys.begin(), keys.end(), key) == keys.end())
      throw_invalid("event.{}, expected one of {}", key, fmt::join(keys, ", "));
    for (const Json& one : value.is_array() ? value : Json::array({value})) {
      if (key == "retune" && one.is_object() && one.contains("agent"))
        throw_invalid(
            "event.retune.agent, expected couple or constrain: a robot's own weights and limits change at "
            "once");
    }
    text += fmt::format("{} = {}\n", key, toml_of(value));
  }
  if (std::isnan(ramp)) ramp = usual_ramp_of(change);
  if (!(ramp >= least_ramp && ramp <= longest_ramp))
    throw_invalid("ramp = {}, expected {} to {} s, so that no input steps", ramp, least_ramp, longest_ramp);
  return text + fmt::format("ramp = {}\n", toml_of(Json(ramp)));
}

/// Adds the present values of the parameters that a potential's change omits.
Json Tuner::completed(const Json& change) const {
  Json whole = change;
  if (!whole.is_object() || !whole.contains("retune") || !whole["retune"].is_object()) return whole;
  Json& retune = whole["retune"];
  const auto* const requested = retune.contains("potential") ? chosen(retune["potential"]) : nullptr;
  if (requested == nullptr || !requested->second.is_object()) return whole;
  for (const Term& term : now_.terms) {
    if (!retune.contains(term.kind) || retune[term.kind] != Json(term.name)) continue;
    const auto* const now = chosen(term.table);
    if (now == nullptr || now->first != requested->first || !now->second.is_object()) continue;
    Json table = now->second;
    table.update(requested->second);
    retune["potential"] = Json{{now->first, table}};
    break;
  }
  return whole;
}

std::string Tuner::change(const Json& change, double ramp, double now) {
  TunedScript& tuned = *scenario_.tuned;
  if (tuned.is_full())
    throw_invalid("{} changes of one flight, expected no more: write it, and fly that", TunedScript::room);
  const Json whole = completed(change);
  std::string keys = keys_of(whole, ramp);
  // As text of the scenario, behind the earlier changes.
  std::string text = scenario_.text;
  double at = std::max(0.0, now);
  for (std::size_t i = 0; i < tuned.size(); ++i) {
    if (tuned.is_ignored(i)) continue;
    const double occurred = tuned.at(i);
    at = std::isnan(occurred) ? at + scenario_.horizon.dt : std::max(at, occurred);
    text += tuned.text(i, std::isnan(occurred) ? at : occurred);
  }
  text += fmt::format("\n[[event]]\nat = {}\n{}", at + scenario_.horizon.dt, keys);
  TeamEvent event;
  try {
    event = parse_spec(std::move(text), scenario_.file, *scenario_.registry, {.files = scenario_.files})
                .script.events.back();
  } catch (const std::runtime_error& error) {
    throw std::invalid_argument(error.what());
  }
  const std::string words = describe(event.actions.front(), scenario_.team);
  event.name =
      shortened(one_line(fmt::format("tune {}: {}", script_ + tuned.size(), words)), name_size_max - 4);
  keys += fmt::format("name = {}\n", in_quotes(event.name));
  Values next = now_;
  next.take(whole, event);
  std::string name = event.name;
  tuned.add(std::move(event), std::move(keys));
  now_ = std::move(next);  // only now: the values must agree with the events
  return name;
}

void Tuner::Values::take(const Json& change, const TeamEvent& event) {
  const auto set = [&](const std::string& place, const Json& value) {
    std::erase_if(last, [&](const auto& entry) { return entry.first == place; });
    last.emplace_back(place, toml_of(value));
  };
  const auto each = [](const Json& value, const auto& act) {
    for (const Json& one : value.is_array() ? value : Json::array({value})) act(one);
  };
  for (const auto& [key, value] : change.items()) {
    each(value, [&, &key = key](const Json& one) {
      if (key == "retune") {
        const std::string kind = one.contains("couple") ? "couple" : "constrain";
        Term& of = term(kind, one.at(kind));
        if (one.contains("weight")) set(of.place + ".weight", of.weight = one["weight"]);
        if (one.contains("potential")) set(of.place + ".potential", of.table = one["potential"]);
        for (const Action& action : event.actions) {
          const auto* const retuned = std::get_if<RetuneTerm>(&action);
          if (retuned != nullptr && retuned->name == of.name && retuned->potential)
            of.potential = *retuned->potential;
        }
      } else if (key == "reference") {
        const std::string agent = one.at("agent");
        set(fmt::format("agent.{}.reference", agent), references[agent] = one.at("reference"));
      } else if (key == "move") {
        const std::string kind = one.contains("target") ? "target" : "obstacle", body = one.at(kind);
        set(fmt::format("{}.{}.p", kind, body), one.at("p"));
      } else if (key == "wind") {
        set("simulation.disturbance.wind", wind = one.at("acceleration"));
      }
    });
  }
}

std::string Tuner::flight_text() const {
  std::string text = scenario_.text;
  const TunedScript& tuned = *scenario_.tuned;
  std::string to_come;
  for (std::size_t i = 0; i < tuned.size(); ++i) {
    const double at = tuned.at(i);
    if (tuned.is_ignored(i)) continue;
    if (std::isnan(at))
      to_come += fmt::format("\n# not in this text, since it is accepted and not flown yet: {}\n",
                             one_line(tuned.event(i).name));
    else
      text += tuned.text(i, at);
  }
  return text + to_come;
}

std::string Tuner::final_text() const {
  if (now_.last.empty()) return scenario_.text;
  std::vector<std::string> set;
  for (const auto& [place, value] : now_.last) set.push_back(fmt::format("{}={}", place, value));
  try {
    return parse_spec(printed(expanded(scenario_)), scenario_.file, *scenario_.registry,
                      {.files = scenario_.files, .set = set})
        .text;
  } catch (const std::runtime_error& error) {
    throw std::invalid_argument(error.what());
  }
}

Json Tuner::reference_of(const std::string& agent) const {
  const BodyId body = scenario_.team.find(agent);
  Json places = Json::array();
  for (const int state : roles_of(scenario_.team.model(body)).position)
    if (state >= 0) places.push_back(state);
  Json reported = {{"agent", agent},  {"kind", nullptr},  {"value", nullptr},
                   {"goal", nullptr}, {"places", places}, {"parameters", Json::array()}};
  const auto* const now = chosen(now_.references.at(agent));
  if (now == nullptr) return reported;
  reported["kind"] = now->first;
  reported["value"] = now->second;
  if (now->first == "constant") reported["goal"] = now->second.value("p", Json());
  if (now->first == "circle") reported["goal"] = now->second.value("centre", Json());
  if (now->first == "state" && places.size() == 3)
    for (const Json& place : places) reported["goal"].push_back(now->second.at(place.get<std::size_t>()));
  if (const auto* const part = scenario_.registry->references.find(now->first); part != nullptr)
    reported["parameters"] = parameters_of(part->parameters, now->second);
  return reported;
}

Json Tuner::tunables() const {
  Json terms = Json::array(), references = Json::array(), bodies = Json::array();
  for (const Term& term : now_.terms) {
    const auto* const potential = chosen(term.table);
    terms.push_back(
        {{"kind", term.kind},
         {"name", term.name},
         {"agents", term.agents},
         {"weight", term.weight},
         {"potential", potential != nullptr ? Json(potential->first) : Json()},
         {"alpha", term.potential.alpha() ? Json(*term.potential.alpha()) : Json()},
         {"parameters", potential != nullptr ? parameters_of(term.potential.parameters(), potential->second)
                                             : Json::array()}});
  }
  for (const Agent& agent : scenario_.team.agents()) references.push_back(reference_of(agent.name));
  const bool all = changes_world();
  const auto add_bodies = [&](std::string_view kind, const std::vector<BodyId>& of_kind) {
    for (const BodyId body : of_kind)
      if (all) bodies.push_back({{"kind", kind}, {"name", scenario_.team.name(body)}});
  };
  add_bodies("target", scenario_.targets);
  add_bodies("obstacle", scenario_.obstacles);
  return {{"terms", terms},
          {"references", references},
          {"bodies", bodies},
          {"wind", all ? now_.wind : Json()},
          {"faults", all ? Json(fault_words) : Json::array()},
          {"ramp", usual_ramp},
          {"changes", scenario_.tuned->size()}};
}

}  // namespace sightline
