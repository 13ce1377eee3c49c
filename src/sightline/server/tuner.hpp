/// What may be tuned of a flight, and the events that tune it.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sightline/scenario/scenario.hpp"

namespace sightline {

/// Makes events of what somebody asks for, as a scenario would say them, and writes the scenario that a tuned flight comes to. One thread.
///
/// A change is an object with the keys of an [[event]] that change something, as TOML has them:
///
///   {"retune": {"couple": "view", "weight": 0.4}}
///   {"retune": {"constrain": "constrain[0]", "potential": {"altitude_band": {"z_max": 2.0}}}}   parameters that are left out stay
///   {"reference": {"agent": "uav1", "reference": {"circle": {"centre": [0, 0, 1], "radius": 0.5, "rate": 0.3}}}}
///   {"move": {"obstacle": "post", "p": [1, 0, 1]}}
///   {"wind": {"acceleration": [0.3, 0, 0]}}
///   {"fault": {"kind": "dropout", "body": "uav1", "for": 0.5}}
///
/// A robot's own Q, R and limits are not among them, since they change at once.
class Tuner {
 public:
  using Json = nlohmann::ordered_json;
  static constexpr double usual_ramp = 0.5, usual_turn = 1.0;  ///< of weights, of references and bodies [s]
  static constexpr double least_ramp = 0.1;                    ///< [s]

  /// @param scenario  whose `tuned` takes the events
  /// @throws std::invalid_argument where no event can stand behind the scenario's text
  explicit Tuner(const Scenario& scenario);

  /// Hands one change to the flight.
  /// @param change  as above
  /// @param ramp    over which it is blended [s]; not a number: as is usual for it
  /// @param now     time of the flight [s]
  /// @throws std::invalid_argument with the sentence of a scenario that says the same and is refused
  /// @return the name of its event
  std::string change(const Json& change, double ramp, double now);

  /// The scenario with all that was tuned so far, each event at its time: flown again it gives the same commands. A comment at its end
  /// names each change that is accepted and not flown yet.
  std::string flight_text() const;
  /// The scenario with the values that were tuned last, from the start.
  /// @throws std::invalid_argument where a value has no place in the scenario's text
  std::string final_text() const;
  /// What may be tuned, with the values that it has now:
  ///
  ///   {terms: [{kind, name, agents, weight, potential, parameters: [{key, value, unit, low, high, range, meaning}]}],
  ///    references: [{agent, kind, value, goal, places, parameters}], bodies: [{kind, name}], wind, faults: [kind], ramp}
  ///
  /// `kind` is "couple" or "constrain", the key of retune; `value` the table of the reference, `goal` where its robot is to be [m],
  /// `places` of p in the numbers of a "state". low and high are null where there is no such bound.
  Json tunables() const;

 private:
  struct Term {
    std::string kind, name, place;  // place: of the table in the text, "couple[0]"; empty: none
    std::vector<std::string> agents;
    double weight;
    Potential potential;
    Json table;  // { NAME = {...} }
  };

  /// What holds, and where the scenario's text would say it.
  struct Values {
    std::vector<Term> terms{};
    Json references{}, wind{};  // references by the names of their robots
    std::vector<std::pair<std::string, std::string>>
        last{};  // what was tuned last: places in the text, values

    Term& term(const std::string& kind, const std::string& name);
    /// After a change; where it throws, they are spoilt.
    void take(const Json& change, const TeamEvent& event);
  };

  std::string keys_of(const Json& change, double ramp) const;
  Json completed(const Json& change) const;
  Json reference_of(const std::string& agent) const;

  Scenario scenario_;
  std::size_t script_;  // events of it
  Values now_;
};

/// A JSON value as TOML, on one line.
/// @throws std::invalid_argument for null
std::string toml_of(const nlohmann::ordered_json& value);

}  // namespace sightline
