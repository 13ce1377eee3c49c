/// Reads parts that a scenario names: potentials, references and limits, by their parameter lists
/// (registry.hpp), and solvers.
#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/registry.hpp"
#include "sightline/scenario.hpp"
#include "sightline/scenario/toml_table.hpp"

namespace sightline {

/// A table as a parameter source of parts. A view: the table must outlive it. Throws ScenarioError.
class TableSource : public ParameterSource {
 public:
  explicit TableSource(const TomlTable& at) : at_(at) {}

  bool has(std::string_view key) const override { return at_.has(key); }
  void expect_only(std::span<const std::string_view> keys) const override { at_.expect_only(keys); }
  double number(std::string_view key, const Bounds& bounds, std::string_view unit) const override;
  int integer(std::string_view key, const Bounds& bounds) const override;
  std::vector<double> numbers(std::string_view key, std::size_t length, const Bounds& bounds,
                              std::string_view unit) const override;
  std::vector<double> rising(std::string_view key) const override { return at_.rising(key); }
  std::vector<std::vector<double>> rows(std::string_view key, std::size_t count,
                                        std::size_t length) const override {
    return at_.rows(key, count, length);
  }
  std::size_t word(std::string_view key, std::span<const std::string_view> known) const override;
  [[noreturn]] void throw_invalid(std::string_view sentence) const override { at_.rethrow_at(sentence); }

 private:
  const TomlTable& at_;
};

/// Reads the described keys of several parts from one table, whose only other keys are `beside`.
template <class... Part>
void read_keys(const TomlTable& at, std::initializer_list<std::string_view> beside, Part&... parts) {
  std::vector<std::string_view> known(beside);
  const auto add = [&](const std::vector<std::string_view>& keys) {
    known.insert(known.end(), keys.begin(), keys.end());
  };
  (add(parameter_keys<Part>()), ...);
  at.expect_only(known);
  (read_parameters(TableSource(at), parts), ...);
}

/// The part of that name, with the parameters in the table; `beside` are further keys that the
/// table may have.
template <class Made>
Made read_named(const PartList<Made>& list, std::string_view name, const TomlTable& at,
                std::span<const std::string_view> beside = {}) {
  return list.find(name)->read(TableSource(at), beside);
}

/// A further sensor of a robot, [agent.NAME.sensors.SENSOR].
struct NamedSensor {
  std::string name;
  SensorMount mount;
};

/// An observing robot: the first of a coupling, or the constrained one.
struct Observer {
  std::string name;
  std::optional<SensorMount> mount;  ///< of the sensor that it looks through; [agent.NAME.sensor] if none is
                                     ///< chosen
  std::vector<NamedSensor> sensors{};
};

/// The observer, looking through its sensor that is named under `sensor`; unchanged without that key.
Observer read_looking(const TomlTable& at, Observer observer);

/// A selection of a team's bodies.
enum class Among { robots, bodies };

/// Names of these bodies, in the order of the team.
std::vector<std::string_view> body_names(const Team& team, Among among);

/// The name of one of them under `key`; `expected` describes them.
std::string read_name(const TomlTable& at, std::string_view key, const Team& team, Among among,
                      std::string_view expected);

/// A name under `key` that is not the name of a body: of an event, a stage, a coupling.
std::string read_label(const TomlTable& at, std::string_view key);

/// `potential = { NAME = {...} }` of [[couple]] or [[constrain]]; its `weight`.
Weighted read_potential(const TomlTable& at, const Observer& observer);

/// `{ NAME = {...}, weight = ... }`, an entry of a list of potentials.
Weighted read_weighted(const TomlTable& at, const Observer& observer);

/// `limit = { NAME = {...} }` of [[constrain]].
RelaxedBarrier read_limit(const TomlTable& at);

/// `reference = { NAME = ... }` of [agent.NAME].
Reference read_reference(const TomlTable& agent, const Model& model);

/// [solver].
SolverChoice read_solver(const TomlTable& solver, const Horizon& horizon);

}  // namespace sightline
