/// Changes of a running flight: the tunable values, and the events that change them.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sightline/scenario.hpp"

namespace sightline {

/// Converts requests into events, as a scenario would state them, and writes the scenario of a
/// tuned flight. For one thread.
///
/// A change is an object with the keys of an [[event]] that change something, as in TOML. Omitted
/// parameters of a potential keep their values:
///
///   {"retune": {"couple": "view", "weight": 0.4}}
///   {"retune": {"constrain": "constrain[0]", "potential": {"altitude_band": {"z_max": 2.0}}}}
///   {"reference": {"agent": "uav1",
///                  "reference": {"circle": {"centre": [0, 0, 1], "radius": 0.5, "rate": 0.3}}}}
///   {"move": {"obstacle": "post", "p": [1, 0, 1]}}
///   {"wind": {"acceleration": [0.3, 0, 0]}}
///   {"fault": {"kind": "dropout", "body": "uav1", "for": 0.5}}
///
/// A robot's own Q, R and limits are not tunable, because they change at once. Move, wind and fault
/// are refused in a flight over links.
class Tuner {
 public:
  using Json = nlohmann::ordered_json;
  static constexpr double usual_ramp = 0.5, usual_turn = 1.0;  ///< default: of weights, of
                                                               ///< references and bodies [s]
  static constexpr double least_ramp = 0.1;                    ///< [s]

  /// @param scenario  its `tuned` receives the events
  /// @throws std::invalid_argument if no event can be appended to the scenario's text
  explicit Tuner(const Scenario& scenario);

  /// Applies one change to the flight.
  /// @param change  as above
  /// @param ramp  time of the transition [s]; NaN: the default of the change
  /// @param now  time of the flight [s]
  /// @throws std::invalid_argument with the sentence that refuses a scenario with the same change
  /// @return the name of its event
  std::string change(const Json& change, double ramp, double now);

  /// The scenario with all changes so far, each event at its time: a flight of it gives the same
  /// commands. A comment at its end names each accepted change that is not in force yet.
  std::string flight_text() const;
  /// The scenario with the last tuned values, in force from the start.
  /// @throws std::invalid_argument if a value has no place in the scenario's text
  std::string final_text() const;
  /// The tunable values, with their present values:
  ///
  ///   {terms: [{kind, name, agents, weight, potential, alpha,
  ///             parameters: [{key, value, unit, low, high, range, meaning}]}],
  ///    references: [{agent, kind, value, goal, places, parameters}], bodies: [{kind, name}],
  ///    wind, faults: [kind], ramp, changes}
  ///
  /// `kind` of a term is "couple" or "constrain", the key of retune. `value` is the table of the
  /// reference, `goal` its position [m], `places` the indices of the position in a "state". low and
  /// high are null if there is no such bound. In a flight over links `bodies` and `faults` are
  /// empty, and `wind` is null.
  Json tunables() const;

 private:
  struct Term {
    std::string kind, name, place;  // place: of the table in the text, "couple[0]"; empty: none
    std::vector<std::string> agents;
    double weight;
    Potential potential;
    Json table;  // { NAME = {...} }
  };

  /// The present values, and their places in the scenario's text.
  struct Values {
    std::vector<Term> terms{};
    Json references{}, wind{};                                // references by the names of their robots
    std::vector<std::pair<std::string, std::string>> last{};  // last tuned values: place in the text, value

    Term& term(const std::string& kind, const std::string& name);
    /// Applies a change; if it throws, the values are invalid.
    void take(const Json& change, const TeamEvent& event);
  };

  bool changes_world() const { return scenario_.tuned->scope() == TunedScript::Scope::world; }
  std::string keys_of(const Json& change, double ramp) const;
  Json completed(const Json& change) const;
  Json reference_of(const std::string& agent) const;

  Scenario scenario_;
  std::size_t script_;  // number of its events
  Values now_;
};

/// A JSON value as TOML, on one line.
/// @throws std::invalid_argument for null
std::string toml_of(const nlohmann::ordered_json& value);

}  // namespace sightline
