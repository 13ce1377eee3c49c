#include "sightline/scenario/read_part.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sightline/scenario/csv_lists.hpp"
#include "sightline/scenario/read_region.hpp"

namespace sightline {
namespace {

/// The mount of the observer's sensor, which is mandatory.
SensorMount mount_of(const TomlTable& at, const Observer& observer) {
  if (!observer.mount) {
    at.throw_invalid(
        fmt::format("a robot with a sensor as observer, there is no [agent.{}.sensor]", observer.name));
  }
  return *observer.mount;
}

Potential read_text_potential(const TomlTable& at, const Observer& observer) {
  Region region = read_region(at);
  if (region.is_view()) (void)mount_of(at, observer);
  if (observer.mount) region = region.seen_from(*observer.mount);
  return at.checked([&] { return Potential(region); });
}

/// The names of all potentials; those given as text come last.
std::vector<std::string_view> potential_names(const Registry& registry) {
  std::vector<std::string_view> names = registry.potentials.names();
  names.insert(names.end(), {"region", "sensor"});
  return names;
}

/// The potential of that name in the table, for this observer.
Potential read_choice(const TomlTable& choice, std::string_view name, const Observer& observer) {
  const TomlTable at = choice.table(name);
  const PartList<Potential>& list = choice.registry().potentials;
  if (list.find(name) == nullptr) return read_text_potential(at, observer);
  Potential potential = read_named(list, name, at);
  if (potential.mount() == nullptr) return potential;
  const SensorMount mount = mount_of(at, observer);
  return at.checked([&] { return potential.seen_from(mount); });
}

double read_weight(const TomlTable& at) {
  return at.has("weight") ? at.number("weight", not_negative(">= 0")) : 1.0;
}

}  // namespace

double TableSource::number(std::string_view key, const Bounds& bounds, std::string_view unit) const {
  const std::string expected = bounds.expected(unit);
  const double low = bounds.or_zero ? 0.0 : std::max(bounds.low, -largest_number);
  const double v = at_.number(key, bounds.words == any_finite.words
                                       ? any_number()
                                       : Range{low, std::min(bounds.high, largest_number), expected});
  if (!bounds.hold(v)) at_.throw_invalid(key, expected);
  return v;
}

int TableSource::integer(std::string_view key, const Bounds& bounds) const {
  const auto bound = [](double v) {
    return static_cast<std::int64_t>(std::clamp(v, -largest_number, largest_number));
  };
  return static_cast<int>(at_.integer(key, bound(bounds.low), bound(bounds.high)));
}

std::vector<double> TableSource::numbers(std::string_view key, std::size_t length, const Bounds& bounds,
                                         std::string_view unit) const {
  std::vector<double> all = at_.numbers(key, length);
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (!bounds.hold(all[i])) at_.throw_invalid(key, i, bounds.expected(unit));
  }
  return all;
}

std::size_t TableSource::word(std::string_view key, std::span<const std::string_view> known) const {
  const std::string_view word = at_.word(key, known);
  return static_cast<std::size_t>(std::find(known.begin(), known.end(), word) - known.begin());
}

std::vector<std::string_view> body_names(const Team& team, Among among) {
  std::vector<std::string_view> known;
  for (int i = 0; i < team.bodies(); ++i) {
    if (among == Among::bodies || team.is_agent(BodyId{i})) known.push_back(team.name(BodyId{i}));
  }
  return known;
}

std::string read_name(const TomlTable& at, std::string_view key, const Team& team, Among among,
                      std::string_view expected) {
  return std::string(at.word(key, body_names(team, among), expected));
}

std::string read_label(const TomlTable& at, std::string_view key) {
  const std::string expected = fmt::format("a name of 1 to {} characters on one line", name_size_max);
  std::string label = at.text(key, expected);
  if (label.empty() || label.size() > name_size_max || one_line(label) != label)
    at.throw_invalid(key, expected);
  return label;
}

Observer read_looking(const TomlTable& at, Observer observer) {
  constexpr std::string_view key = "sensor";
  if (!at.has(key)) return observer;
  std::vector<std::string_view> known;
  for (const NamedSensor& one : observer.sensors) known.push_back(one.name);
  const std::string_view chosen =
      at.word(key, known, fmt::format("a sensor of [agent.{}.sensors]", observer.name));
  observer.mount =
      std::find_if(observer.sensors.begin(), observer.sensors.end(), [&](const NamedSensor& one) {
        return one.name == chosen;
      })->mount;
  return observer;
}

Weighted read_potential(const TomlTable& at, const Observer& observer) {
  const TomlTable choice = at.table("potential");
  const std::string_view name = choice.choice(potential_names(at.registry()));
  return {read_weight(at), read_choice(choice, name, observer)};
}

Weighted read_weighted(const TomlTable& at, const Observer& observer) {
  const std::string_view name = at.choice(potential_names(at.registry()), {"weight"});
  return {read_weight(at), read_choice(at, name, observer)};
}

RelaxedBarrier read_limit(const TomlTable& at) {
  const TomlTable choice = at.table("limit");
  const PartList<Limit>& list = at.registry().limits;
  const std::string_view name = choice.choice(list.names());
  const TomlTable limit = choice.table(name);
  RelaxedBarrier barrier{read_named(list, name, limit, parameter_keys<RelaxedBarrier>())};
  read_parameters(TableSource(limit), barrier);
  return limit.checked([&] {
    barrier.check();
    return barrier;
  });
}

Reference read_reference(const TomlTable& agent, const Model& model) {
  if (!agent.has("reference")) return {};
  constexpr std::string_view state = "state";
  const TomlTable choice = agent.table("reference");
  const PartList<Reference>& list = agent.registry().references;
  std::vector<std::string_view> known = list.names();
  known.push_back(state);
  const std::string_view name = choice.choice(known);
  if (name == state) return choice.numbers(state, static_cast<std::size_t>(model.nx()));
  const TomlTable at = choice.table(name);
  if (has_timed_lists(*list.find(name)))
    return list.find(name)->read(ListSource(at), parameter_keys<ListFile>());
  return read_named(list, name, at);
}

}  // namespace sightline
