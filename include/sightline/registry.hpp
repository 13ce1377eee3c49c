/// The parts that a scenario may name: robots, potentials, limits, references, worlds, solvers; and links to real robots.
#pragma once

#include <algorithm>
#include <concepts>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/base.hpp"
#include "sightline/model.hpp"
#include "sightline/potential.hpp"
#include "sightline/solvers.hpp"
#include "sightline/vehicle.hpp"

namespace sightline {

// Registry of the parts that a scenario may name: robots, potentials, references, limits, worlds,
// solvers.
// The library and a user's program register parts by the same calls:
//
//   Registry registry;                          // the parts of the library
//   registry.robots.add<Boat>();
//   registry.potentials.add<Downwash>();
//   registry.worlds.add("basin", make_basin);
//   registry.solvers.add<PursuitOptions>("pursuit", {}, make_pursuit);
//   return command_line(argc, argv, registry);
//
// A part is a struct with `name`, a word. A scenario may set the parameters that its
// `parameters()` lists (base.hpp).

/// A struct that a scenario can refer to by its name.
template <class P>
concept NamedPart = std::default_initializable<P> && requires {
  { P::name } -> std::convertible_to<std::string_view>;
};

/// A part as text.
struct PartText {
  std::string name;
  std::vector<ParameterText> parameters;
  std::vector<std::string> presets{};
};

/// All parts of one kind by their names. `Made` is the type made from a part: Model, Potential,
/// Reference, Limit.
template <class Made>
class PartList {
 public:
  struct Part : PartText {
    /// @param beside  keys that the table may have beside the parameters
    std::function<Made(const ParameterSource&, std::span<const std::string_view> beside)> read;
  };

  /// @param kind   for error messages: "robot"
  /// @param taken  reserved words of this kind that are no parts
  explicit PartList(std::string_view kind, std::vector<std::string> taken = {})
      : kind_(kind), taken_(std::move(taken)) {}

  /// Adds a part.
  /// @throws std::invalid_argument for a name that is not a word or that another part has, and for
  /// defaults out of range
  template <NamedPart P>
  requires std::constructible_from<Made, P> PartList& add() {
    check_name(P::name);
    Part part{{std::string(P::name), parameter_texts(P{})},
              [](const ParameterSource& from, std::span<const std::string_view> beside) {
                const P read = read_part<P>(from, beside);
                try {
                  return made(read);
                } catch (const std::invalid_argument& error) {
                  from.throw_invalid(error.what());
                  throw;  // never: throw_invalid() has thrown
                }
              }};
    // Parts with mandatory parameters have no valid defaults.
    if (std::none_of(part.parameters.begin(), part.parameters.end(),
                     [](const ParameterText& p) { return p.must_be_given; }))
      (void)made(P{});
    if constexpr (requires { P::presets(); }) {
      for (const auto& preset : P::presets()) part.presets.emplace_back(preset.name);
    }
    parts_.push_back(std::make_shared<const Part>(std::move(part)));
    return *this;
  }

  std::string_view kind() const { return kind_; }
  /// In the order of adding.
  std::vector<std::string_view> names() const {
    std::vector<std::string_view> all;
    for (const auto& part : parts_) all.push_back(part->name);
    return all;
  }
  const std::vector<std::shared_ptr<const Part>>& all() const { return parts_; }
  /// The part of that name, or null.
  const Part* find(std::string_view name) const {
    for (const auto& part : parts_) {
      if (part->name == name) return part.get();
    }
    return nullptr;
  }

 private:
  template <class P>
  static Made made(const P& part) {
    const auto make = [](const auto& p) { return Made(p); };
    if constexpr (requires { part.reduced(make); }) {
      return part.reduced(make);
    } else {
      return make(part);
    }
  }
  void check_name(std::string_view name) const;

  std::string kind_;
  std::vector<std::string> taken_;
  std::vector<std::shared_ptr<const Part>> parts_;
};

/// @throws std::invalid_argument for a name that is not a word, or that is in `taken` or `names`
void check_part_name(std::string_view kind, std::string_view name, const std::vector<std::string>& taken,
                     const std::vector<std::string_view>& names);

template <class Made>
void PartList<Made>::check_name(std::string_view name) const {
  check_part_name(kind_, name, taken_, names());
}

struct Scenario;
struct ScenarioSpec;
class World;
class DetectionSource;
class Bridge;
class LinkReader;

/// Makes the source of a world's detections: it renders camera pictures and detects tags in them.
/// @throws std::invalid_argument if the requested pictures cannot be rendered or the requested tags
/// not be detected
using MakeRenderer = std::function<std::unique_ptr<DetectionSource>(const Scenario&)>;

/// Makes the world of a scenario.
/// @throws std::invalid_argument for a scenario that the world does not support
using MakeWorld = std::function<std::unique_ptr<World>(const Scenario&)>;

/// Checks a scenario for a world, without making the world.
/// @throws std::invalid_argument for a scenario that the world does not support
using CheckWorld = std::function<void(const ScenarioSpec&)>;

/// What moves the robots of a world: their models, or the vehicles of `[agent.NAME.vehicle]`.
enum class MovedBy { models, vehicles };

/// Makes the vehicle of a body in a model file, in the format that a world reads. Mass and inertia
/// are those of the body, all else is that of `vehicle`.
/// @throws std::invalid_argument for an unsuitable file or body; its sentence begins with "model =
/// " or "body = "
using VehicleOfModel = std::function<Vehicle(const Vehicle& vehicle, const ModelBody& model)>;

/// A world as a scenario may name it.
struct WorldPart {
  std::string name;
  MakeWorld make;
  MovedBy robots = MovedBy::models;
  /// Of a world that reads model files, which `[world] model` and `[agent.NAME.vehicle] model, body`
  /// name; empty: it reads none.
  VehicleOfModel of_model{};
  MakeRenderer renderer{};  ///< of pictures for cameras with `render = true`; empty: it has none
  CheckWorld check{};       ///< of a scenario while it is read, beyond that of its vehicles; empty: none

  bool has_vehicles() const { return robots == MovedBy::vehicles; }
  bool renders() const { return static_cast<bool>(renderer); }
};

/// Worlds by their names in `[world] kind`.
class WorldList {
 public:
  /// @throws std::invalid_argument for a name that is not a word or that another world has, and for
  /// an empty function
  WorldList& add(std::string_view name, MakeWorld make, MovedBy robots = MovedBy::models,
                 VehicleOfModel of_model = {}, MakeRenderer renderer = {}, CheckWorld check = {});
  /// Those with an ability, or all; in the order of adding. The first of all is the default of a scenario.
  std::vector<std::string_view> names(bool (WorldPart::*can)() const = nullptr) const;
  /// The world of that name, or null.
  const WorldPart* find(std::string_view name) const;

 private:
  std::vector<WorldPart> worlds_;
};

/// What a solver supports beyond one team that never changes; flags of its entry in the list of
/// solvers.
struct SolverAbilities {
  bool changing_teams = false;   ///< plans for a team that changes in flight: team_planner()
  bool keep_apart = false;       ///< keeps_apart()
  bool uncertain_views = false;  ///< uses_uncertainty()
  bool input_rates = false;      ///< R_rate, a cost of the rates of inputs
};

/// A solver as a scenario may name it.
struct SolverPart {
  std::string name;
  SolverAbilities can{};
  /// Reads the options in [solver].
  /// @param beside  keys that the table may have beside the options
  std::function<SolverChoice(const ParameterSource& from, std::span<const std::string_view> beside,
                             const Horizon& horizon)>
      read;
};

/// Solvers by their names in `[solver] name`.
class SolverList {
 public:
  /// Adds a solver.
  /// @tparam Options  what [solver] may set, a struct as a part: its `parameters()` describe the keys
  /// @param make      makes one: (const Team&, const Horizon&, const Options&) to std::unique_ptr<Solver>;
  ///                  it may throw std::invalid_argument for a team that it does not support. Campaigns
  ///                  call it on several threads
  /// @throws std::invalid_argument for a name that is not a word or that another solver has
  template <class Options, class Make>
  requires std::is_invocable_r_v < std::unique_ptr<Solver>, Make,
  const Team&, const Horizon&,
      const Options& > SolverList& add(std::string_view name, const SolverAbilities& can, Make make) {
    return add({std::string(name), can,
                [called = std::string(name), make](const ParameterSource& from,
                                                   std::span<const std::string_view> beside, const Horizon&) {
                  return SolverChoice{called,
                                      MakeTeamSolver([make, options = read_part<Options>(from, beside)](
                                                         const Team& team, const Horizon& horizon) {
                                        return make(team, horizon, options);
                                      })};
                }});
  }
  SolverList& add(SolverPart part);
  /// In the order of adding. The first is the default of a scenario.
  std::vector<std::string_view> names() const;
  /// The solver of that name.
  /// @throws std::invalid_argument with the known names if there is none
  const SolverPart& named(std::string_view name) const;
  /// The names of the solvers with that ability, as text: "newton_riccati".
  std::string names_that(bool SolverAbilities::*can) const;

 private:
  std::vector<SolverPart> solvers_;
};

/// Every kind of part. A value: filled first, then passed to read_scenario().
struct Registry {
  /// Registers the parts of the library.
  Registry();

  PartList<Model> robots{"robot", {"text"}};
  PartList<Potential> potentials{"potential", {"region", "sensor", "weight"}};
  PartList<Reference> references{"reference", {"state"}};
  PartList<Limit> limits{"limit"};
  WorldList worlds;
  SolverList solvers;
  std::shared_ptr<const LinkReader> links{};  ///< for files with [fleet]; null: refuses them
  std::shared_ptr<const Bridge> bridge{};     ///< flies fleets; null: no fleet can fly
};

/// The parts of the library, made once.
const Registry& built_in_registry();

/// Parameters as a Markdown table: part, key, default, range, meaning; as in docs/reference.md.
/// @param kind  head of the first column
std::string parameters_table(std::string_view kind, std::span<const PartText> parts);
template <class Made>
std::string parameters_table(const PartList<Made>& list) {
  std::vector<PartText> parts;
  for (const auto& part : list.all()) parts.push_back(*part);
  return parameters_table(list.kind(), parts);
}

// Reading of scenarios with links to real robots. The flight itself needs a bridge, as sightline::dds.

/// The parts with a reader of [fleet] and of links, unless they have one.
Registry with_links(Registry parts = {});

}  // namespace sightline
