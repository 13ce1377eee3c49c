/// What a scenario may call by name: robots, potentials, references, limits, worlds. Ours are registered by the calls that a
/// program of a user registers its own with:
///
///   Registry registry;                          // all of ours
///   registry.robots.add<Boat>();
///   registry.potentials.add<Downwash>();
///   registry.worlds.add("basin", make_basin);
///   return command_line(argc, argv, registry);
///
/// A part is a struct with `name`, a word; what it says by `parameters()` (base/parameter.hpp) is what a scenario may set.
#pragma once

#include <algorithm>
#include <concepts>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/base/parameter.hpp"
#include "sightline/model/model.hpp"
#include "sightline/potential/potential.hpp"
#include "sightline/potential/reference.hpp"
#include "sightline/potential/relaxed_barrier.hpp"
#include "sightline/world/vehicle.hpp"

namespace sightline {

/// A struct that a scenario can call by its name.
template <class P>
concept NamedPart = std::default_initializable<P> && requires {
  { P::name } -> std::convertible_to<std::string_view>;
};

/// All parts of one kind by their names. `Made` is what is made of a part: Model, Potential, Reference, Limit.
template <class Made>
class PartList {
 public:
  struct Part {
    std::string name;
    std::vector<ParameterText> parameters;
    std::vector<std::string> presets;
    /// @param beside  keys that may stand beside the parameters
    std::function<Made(const ParameterSource&, std::span<const std::string_view> beside)> read;
  };

  /// @param kind   what they are, for refusals: "robot"
  /// @param taken  words of this kind that are no parts
  explicit PartList(std::string_view kind, std::vector<std::string> taken = {})
      : kind_(kind), taken_(std::move(taken)) {}

  /// One more.
  /// @throws std::invalid_argument for a name that is no word, or that another part has, and for defaults out of range
  template <NamedPart P>
  requires std::constructible_from<Made, P> PartList& add() {
    check_name(P::name);
    Part part{.name = std::string(P::name),
              .parameters = parameter_texts(P{}),
              .presets = {},
              .read = [](const ParameterSource& from, std::span<const std::string_view> beside) {
                const P read = read_part<P>(from, beside);
                try {
                  return made(read);
                } catch (const std::invalid_argument& error) {
                  from.throw_invalid(error.what());
                  throw;  // never: that has thrown
                }
              }};
    // Where something must be given, the defaults alone are no part.
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
  /// In the order in which they were added.
  std::vector<std::string_view> names() const {
    std::vector<std::string_view> all;
    for (const auto& part : parts_) all.push_back(part->name);
    return all;
  }
  const std::vector<std::shared_ptr<const Part>>& all() const { return parts_; }
  /// The part of that name, or none.
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

/// @throws std::invalid_argument for a name that is no word or stands in `taken` or `names`
void check_part_name(std::string_view kind, std::string_view name, const std::vector<std::string>& taken,
                     const std::vector<std::string_view>& names);

template <class Made>
void PartList<Made>::check_name(std::string_view name) const {
  check_part_name(kind_, name, taken_, names());
}

struct Scenario;
class World;
class DetectionSource;
class Bridge;

/// Makes what renders the cameras' pictures of a world and searches them for tags.
/// @throws std::invalid_argument where pictures cannot be rendered, or tags not be found, as asked for
using MakeRenderer = std::function<std::unique_ptr<DetectionSource>(const Scenario&)>;

/// Makes the world that a scenario flies in.
/// @throws std::invalid_argument for a scenario that it cannot be the world of
using MakeWorld = std::function<std::unique_ptr<World>(const Scenario&)>;

/// What moves the robots of a world: their models, or vehicles, which `[agent.NAME.vehicle]` says.
enum class MovedBy { models, vehicles };

/// What a vehicle is by the body of a model file, in the form that a world reads: of the numbers of `vehicle`, mass and inertia are
/// those of the body.
/// @throws std::invalid_argument for a file or a body that cannot be it; a sentence that begins with "model = " or "body = "
using VehicleOfModel = std::function<Vehicle(const Vehicle& vehicle, const ModelBody& model)>;

/// Worlds by the names that `[world] kind` gives them.
class WorldList {
 public:
  /// @param of_model  where the world reads model files: then `[world] model` and `[agent.NAME.vehicle] model, body` name them
  /// @param renderer  where the world shows itself to cameras with `render = true`
  /// @throws std::invalid_argument for a name that is no word, or that another world has, and for no function
  WorldList& add(std::string_view name, MakeWorld make, MovedBy robots = MovedBy::models,
                 VehicleOfModel of_model = {}, MakeRenderer renderer = {});
  /// In the order in which they were added; the first is what a scenario flies in that names none.
  std::vector<std::string_view> names() const;
  /// The function of that name, or none.
  const MakeWorld* find(std::string_view name) const;
  /// Those whose robots are vehicles.
  std::vector<std::string_view> with_vehicles() const;
  /// How that world reads a vehicle of a model file; empty where it reads none.
  VehicleOfModel of_model(std::string_view name) const;
  /// What renders the pictures of that world; empty where nothing does.
  MakeRenderer renderer(std::string_view name) const;
  std::vector<std::string_view> with_renderers() const;

 private:
  struct Entry {
    std::string name;
    MakeWorld make;
    MovedBy robots;
    VehicleOfModel of_model;
    MakeRenderer renderer;
  };
  const Entry* entry(std::string_view name) const;

  std::vector<Entry> worlds_;
};

/// Every kind of part. A value: to be filled, then to be given to whoever reads a scenario.
struct Registry {
  /// Those of the library.
  Registry();

  PartList<Model> robots{"robot", {"text"}};
  PartList<Potential> potentials{"potential", {"region", "sensor", "weight"}};
  PartList<Reference> references{"reference", {"state"}};
  PartList<Limit> limits{"limit"};
  WorldList worlds;
  std::shared_ptr<const Bridge> bridge{};  ///< flies fleets (bridge.hpp); none: nothing does
};

/// Those of the library, made once.
const Registry& built_in_registry();

/// The parameters of all parts as a table of Markdown: `part`, `key`, default, range, meaning; as docs/reference.md has it.
template <class Made>
std::string parameters_table(const PartList<Made>& list);

extern template std::string parameters_table(const PartList<Model>&);
extern template std::string parameters_table(const PartList<Potential>&);
extern template std::string parameters_table(const PartList<Reference>&);
extern template std::string parameters_table(const PartList<Limit>&);

}  // namespace sightline
