/// The team of a run as it is at a sample: follows the events that the samples tell.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "sightline/potential/potential.hpp"
#include "sightline/run/sample.hpp"
#include "sightline/scenario/scenario.hpp"

namespace sightline {

/// An observer and what its sensor is to see, by the first coupling with a sensor cone or a region that is a
/// view.
struct Observation {
  BodyId observer, target;
  Potential potential;
  SensorMount mount;
  double alpha;         ///< limit of the view angle [rad]; not a number for a region
  double d_min, d_max;  ///< tightest of the couplings between the two [m]; not a number where none states it
  BodyId third{};       ///< that the potential looks past; index -1: none
};

/// Whether the target is in view at `time` [s]: the one judge of a view.
/// @param observer  its first_sight(), with the body that it looks past
bool is_in_view(const Observation& pair, const Sight<double>& observer, const Sight<double>& target,
                double time) noexcept;

/// All observations among couplings, in their order.
std::vector<Observation> observations(std::span<const Coupling> couplings);

/// All couplings that may be in force at some time of a run, those of the start first. Bodies are the scenario's.
std::vector<Coupling> all_couplings(const Scenario& scenario);

/// Of each body, whether its lean is judged and logged: vehicles, and robots from which a camera that is fixed to the body
/// looks at some time of a run.
std::vector<bool> leaning_bodies(const Scenario& scenario);

/// Ids are the scenario's throughout.
class PresentTeam {
 public:
  explicit PresentTeam(const Scenario& scenario);

  /// Takes in the events of the next sample. @return whether the team is another one now
  bool follow(const Sample& sample);

  /// Couplings and constraints that last, between bodies that are there.
  std::vector<Coupling> couplings() const;
  std::vector<Constraint> constraints() const;
  /// Robots that are steered and asked to observe, whether what they are to see is there or not.
  std::vector<BodyId> observers() const;
  /// In force for a robot, steered or not.
  const InputLimits& limits(BodyId robot) const { return active_team_.agent(AgentId{robot}).limits; }
  /// The robots that are steered, and what they feel; with ids of its own.
  const Team& team() const { return team_; }
  /// A robot that is steered now, as it is tuned; else none.
  const Agent* agent(BodyId robot) const;
  /// l of the team at the sample, masked or not.
  double cost(const Sample& sample);

 private:
  void compose(double t);

  Script script_;
  std::shared_ptr<const TunedScript> tuned_;
  ActiveTeam active_team_;
  Team team_;                  // of those that are steered and what they feel
  double settles_at_;          // when the weights come to rest that move now, and what faded is dropped [s]
  std::vector<BodyId> world_;  // of each of its bodies
  std::vector<double> x_, u_;  // its states and inputs
};

}  // namespace sightline
