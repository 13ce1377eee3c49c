#include "sightline/scenario/read_shape.hpp"

#include <fmt/format.h>

#include "sightline/ocp/shape.hpp"

namespace sightline {
namespace {

constexpr std::string_view observer_word = "observer", both_word = "both", all_word = "all";

/// The bodies of a shape, each named once.
std::vector<BodyId> read_members(const TomlTable& at, std::string_view key, std::size_t least,
                                 const Team& team) {
  std::vector<BodyId> bodies = bodies_named(at, key, TomlTable::any_length, team);
  for (auto body = bodies.begin(); body != bodies.end(); ++body) {
    if (std::find(bodies.begin(), body, *body) == body) continue;
    at.refuse(key, static_cast<std::size_t>(body - bodies.begin()), "each body once");
  }
  if (bodies.size() < least) at.refuse(key, fmt::format("an array of {} names or more", least));
  return bodies;
}

std::vector<Between> read_chain(const TomlTable& at, const Team& team) {
  return chain(read_members(at, "chain", 2, team));
}

std::vector<Between> read_ring(const TomlTable& at, const Team& team) {
  return ring(read_members(at, "ring", 2, team));
}

std::vector<Between> read_star(const TomlTable& shape, const Team& team) {
  const TomlTable at = shape.table("star", "a table with centre and observers");
  at.expect_only({"centre", "observers"});
  const BodyId centre =
      team.find(read_name(at, "centre", team, Among::bodies, "a robot, target or obstacle"));
  const std::vector<BodyId> observers = read_members(at, "observers", 1, team);
  const auto found = std::find(observers.begin(), observers.end(), centre);
  if (found != observers.end()) {
    at.refuse("observers", static_cast<std::size_t>(found - observers.begin()), "another body than centre");
  }
  return star(centre, observers);
}

std::vector<Between> read_all_pairs(const TomlTable& at, const Team& team) {
  constexpr std::string_view key = "all_pairs", expected = "an array of names, or \"all\" for all robots";
  const TomlValue value = at.value(key, expected);
  if (!value.is_text()) {
    if (!value.is_array()) value.refuse(expected);
    return all_pairs(read_members(at, key, 2, team));
  }
  if (value.text() != all_word) value.refuse(expected);
  std::vector<BodyId> robots;
  for (int i = 0; i < team.bodies(); ++i) {
    if (team.is_agent(BodyId{i})) robots.push_back(BodyId{i});
  }
  if (robots.size() < 2) value.refuse("an array of names, the team has a single robot");
  return all_pairs(robots);
}

using ReadPairs = std::vector<Between> (*)(const TomlTable& shape, const Team& team);
constexpr std::array shapes = {
    Named<ReadPairs>{"chain", read_chain},
    Named<ReadPairs>{"star", read_star},
    Named<ReadPairs>{"ring", read_ring},
    Named<ReadPairs>{"all_pairs", read_all_pairs},
};

/// Who feels a shape; a body that is no robot feels nothing as an observer.
FeltBy read_felt_by(const TomlTable& at, const std::vector<Between>& pairs, const Team& team) {
  constexpr std::array words = {observer_word, both_word};
  if (!at.has("felt_by") || at.word("felt_by", words) == both_word) return FeltBy::both;
  for (const Between& pair : pairs) {
    if (team.is_agent(pair.first)) continue;
    at.refuse("felt_by", fmt::format("robots as observers, \"{}\" is none", team.name(pair.first)));
  }
  return FeltBy::observer;
}

/// `nearest = { target, observers, margin, dwell, ramp }`, and `name`: whoever is nearest observes.
void read_relay(const TomlTable& shape, const TermsOf& terms_of, Team& team, Script& script) {
  const TomlTable at = shape.table("nearest", "a table with target and observers");
  RelayOptions options{.name = shape.has("name") ? read_label(shape, "name") : "nearest"};
  at.read({{"margin", &options.margin, not_negative(">= 0 m")},
           {"dwell", &options.dwell, positive("> 0 s")},
           {"ramp", &options.ramp, time_range}},
          {"target", "observers"});
  const BodyId target =
      team.find(read_name(at, "target", team, Among::bodies, "a robot, target or obstacle"));
  std::vector<AgentId> observers;
  for (const BodyId body : read_members(at, "observers", 2, team)) {
    if (!team.is_agent(body) || body == target) {
      at.refuse("observers", observers.size(), "a robot other than the target");
    }
    observers.push_back(AgentId{body});
  }
  if (std::any_of(script.begins.begin(), script.begins.end(),
                  [&](const std::string& stage) { return region_of(stage) == options.name; })) {
    shape.refuse("name", "a name of its own, another shape has this one");
  }
  shape.checked([&] { relay(team, script, terms_of, observers, target, options); });
}

}  // namespace

void read_shape(const TomlTable& at, const Observers& observers, Team& team, Script& script) {
  constexpr std::string_view nearest_word = "nearest";
  const bool is_relay = at.has(nearest_word);
  std::vector<Between> pairs;
  FeltBy felt_by = FeltBy::observer;
  std::string_view name = nearest_word;
  if (is_relay) {
    at.expect_only({"name", nearest_word, "potential", "weight", "potentials"});
  } else {
    name = at.choice(names(shapes), {"potential", "weight", "potentials", "felt_by"});
    pairs = find(shapes, name)(at, team);
    felt_by = read_felt_by(at, pairs, team);
  }

  // One potential as in [[couple]], or a list of them, each with its weight.
  std::vector<TomlTable> list;
  if (at.has("potentials")) {
    for (const std::string_view key : {"potential", "weight"}) {
      if (at.has(key)) at.refuse(key, "no such key beside potentials, which have their own");
    }
    list = at.tables("potentials");
    if (list.empty()) at.refuse("potentials", "one potential or more");
  } else if (!at.has("potential")) {
    at.refuse("potentials", "an array of potentials, or potential and weight");
  }
  if (pairs.size() * std::max<std::size_t>(list.size(), 1) > shape_couplings_max) {
    at.refuse(name, fmt::format("at most {} couplings", shape_couplings_max));
  }
  const TermsOf terms_of = [&](Between pair) {
    const Observer observer = observer_of(team, observers, pair.first);
    if (list.empty()) return std::vector<Weighted>{read_potential(at, observer)};
    std::vector<Weighted> terms;
    for (const TomlTable& entry : list) terms.push_back(read_weighted(entry, observer));
    return terms;
  };
  if (is_relay) return read_relay(at, terms_of, team, script);
  at.checked([&] { couple(team, terms_of, pairs, felt_by); });
}

}  // namespace sightline
