/// The team of a run at a sample, updated by the events in the samples.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "sightline/loop.hpp"
#include "sightline/potential.hpp"
#include "sightline/scenario.hpp"

namespace sightline {

/// An observer and the target of a sensor of it, from the first coupling with a sensor cone or a
/// region that is a view.
struct Observation {
  BodyId observer, target;
  Potential potential;
  SensorMount mount;
  double alpha;         ///< limit of the view angle [rad]; NaN for a region
  double d_min, d_max;  ///< tightest of the couplings between the two [m]; NaN if none sets it
  BodyId third{};       ///< third body of the potential; index -1: none
};

/// True if the target is in view at `time` [s]; the only judge of a view.
/// @param observer  first_sight() of the observer, with the third body
bool is_in_view(const Observation& pair, const Sight<double>& observer, const Sight<double>& target,
                double time) noexcept;

/// Whether two observations are of one view: the same pair, through the same sensor if both have one.
bool is_same_view(const Observation& one, const Observation& other) noexcept;

/// All observations among couplings, in their order.
std::vector<Observation> observations(std::span<const Coupling> couplings);

/// All couplings that may be in force during a run, those at the start first. Body ids are the
/// scenario's.
std::vector<Coupling> all_couplings(const Scenario& scenario);

/// For each body, true if its tilt is judged and logged: vehicles, and observers whose camera is
/// body-fixed at some time of the run.
std::vector<bool> leaning_bodies(const Scenario& scenario);

/// The team of a run, with the scenario's ids.
class PresentTeam {
 public:
  explicit PresentTeam(const Scenario& scenario);

  /// Applies the events of the next sample. @return true if the team has changed
  bool follow(const Sample& sample);

  /// Couplings and constraints that stay in force, between present bodies.
  std::vector<Coupling> couplings() const;
  std::vector<Constraint> constraints() const;
  /// Steered robots with a coupling that requests an observation, whether the target is present or
  /// not.
  std::vector<BodyId> observers() const;
  /// Limits in force of a robot, steered or not.
  const InputLimits& limits(BodyId robot) const { return active_team_.agent(AgentId{robot}).limits; }
  /// The steered robots and the bodies that affect them; with its own ids.
  const Team& team() const { return team_; }
  /// The robot with its present tuning; null if the robot is not steered.
  const Agent* agent(BodyId robot) const;
  /// Stage cost l of the team at the sample, masked or not.
  double cost(const Sample& sample);

 private:
  void compose(double t);

  Script script_;
  std::shared_ptr<const TunedScript> tuned_;
  ActiveTeam active_team_;
  Team team_;                  // steered robots and the bodies that affect them
  double settles_at_;          // when moving weights settle and faded terms are removed [s]
  std::vector<BodyId> world_;  // scenario id of each body of team_
  std::vector<double> x_, u_;  // states and inputs of team_
};

}  // namespace sightline
