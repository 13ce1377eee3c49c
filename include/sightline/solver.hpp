/// The interface of all solvers: measured state in, applicable input out, in bounded time, with a status.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/model.hpp"
#include "sightline/team.hpp"

namespace sightline {

// Report of which formulas of a solver are compiled, for messages. Formulas without a compiled
// function are interpreted: same bits, several times slower, with no other indication.

struct KernelUse {
  struct Formula {
    std::string name;  ///< "robot multirotor", "sensor_cone + keep_out"
    bool compiled;
  };
  std::vector<Formula> formulas{};  ///< unique names, in order of first use

  /// Adds a formula. A name counts as compiled only if all its formulas are.
  void add(const std::string& name, bool compiled);
  /// "2 of 5 formulas are interpreted, ...: robot rover, region"; empty if all are compiled.
  std::string sentence() const;
};

// Interface of all solvers: measured state in, applicable input out, in bounded time, with a
// status that reports how the update ended.

/// Inputs besides the states that an update considers; u spans hold all agents (nu).
struct AppliedInputs {
  std::span<const double> previous;  ///< in force until the update, including its `offset`
  std::span<const double> offset;    ///< added to the solver's inputs afterwards, such as wind compensation
  std::span<const Vec2<double>> lean{};  ///< tilt of each body that `offset` adds [-]; empty: none
  std::span<const double> u_ref{};       ///< u* in the costs of the agents; empty: the team's
};

/// Lateral standard deviation of the observed body's relative position.
struct ViewUncertainty {
  double sigma = 0.0;   ///< standard deviation now [m]
  double growth = 0.0;  ///< growth of sigma without measurements [m/s]

  double after(double time) const { return sigma + growth * time; }  ///< [m], after time [s]
};

/// How an update ended, from best to worst. `Solution::u` is always finite, within limits and
/// usable.
enum class Status : std::uint8_t {
  converged,        ///< residual <= tolerance
  stepped,          ///< residual > tolerance; the single step of a real-time update was taken in full
  iteration_limit,  ///< residual > tolerance after all steps of an iterating update, or after a
  ///< real-time step that was not full: damped, shortened, or with an unsettled active set
  deadline,       ///< the deadline passed; best result so far
  not_finite,     ///< the step was not finite: last good plan, shifted; the next update restarts
  invalid_state,  ///< the state was rejected (not finite, heading (0, 0)): last good plan, shifted
};
inline constexpr int status_count = 6;

std::string_view to_string(Status status);
/// Whether an update with this status made a plan from the given state.
constexpr bool gives_plan(Status status) { return status < Status::not_finite; }

/// Numbers of robot pairs in swarms.
struct Neighbours {
  int pairs = 0;     ///< pairs that approach each other along the plan and are kept apart
  int left_out = 0;  ///< pairs that approach each other but exceed the capacity
};

/// Predicted states of all bodies (N+1 x nx), stage by stage. Convertible to a span; a solver may
/// write the states lazily, at the first access.
class PredictedStates {
 public:
  /// Writes the states at the first access.
  class Writer {
   public:
    virtual std::span<const double> predicted_states() noexcept = 0;

   protected:
    ~Writer() = default;
  };

  PredictedStates() = default;
  PredictedStates(std::span<const double> written) : written_(written) {}
  PredictedStates(const std::vector<double>& written) : written_(written) {}
  PredictedStates(Writer& writer) : writer_(&writer) {}

  std::span<const double> span() const noexcept {
    return writer_ != nullptr ? writer_->predicted_states() : written_;
  }
  const double* data() const noexcept { return span().data(); }
  std::size_t size() const noexcept { return span().size(); }
  const double* begin() const noexcept { return data(); }
  const double* end() const noexcept { return data() + size(); }
  const double& operator[](std::size_t i) const noexcept { return data()[i]; }

 private:
  Writer* writer_ = nullptr;
  std::span<const double> written_;
};

/// Result of one update. The spans refer to the solver's memory and are valid until its next call.
struct Solution {
  std::span<const double> u;      ///< inputs to apply now, of all agents (nu)
  std::span<const double> raw_u;  ///< u before it was clamped to its limits (nu)
  /// The linearised trajectory, from the measured state under the inputs before the step; empty if
  /// there is none.
  PredictedStates x;
  Status status = Status::iteration_limit;
  /// Infinity norm of the optimality conditions at the linearisation point [1/s], each input
  /// divided by its scale, input_scales(); infinity: unknown.
  double residual = std::numeric_limits<double>::infinity();
  int iterations = 0;       ///< Krylov iterations
  Neighbours neighbours{};  ///< pairs of the team's swarms
  double elapsed = 0.0;     ///< wall time of the update [s]
};

class Connectivity;
class TeamPlanner;

/// Solver of one Ocp. `solve` does not throw, allocate, lock or print. Not thread-safe: one thread
/// at a time.
class Solver {
 public:
  virtual ~Solver() = default;

  virtual std::string_view name() const = 0;
  virtual const Ocp& ocp() const = 0;

  /// One update: maps the measured states of all bodies (nx) at `time` [s] to the inputs.
  virtual Solution solve(double time, std::span<const double> states) noexcept = 0;

  /// Sets the applied inputs for all later updates. Limits then hold for u + offset; rate_max and
  /// R_rate apply to the change from `previous`; tilts include `lean`; u* is u_ref over the whole
  /// horizon. Default: no offset and no rate limit. Solvers that ignore this rely on the loop,
  /// which enforces both limits.
  virtual void set_applied(const AppliedInputs& /*applied*/) noexcept {}

  /// Sets Sight::uncertainty of each body along the horizon for all later updates. Default: 0.
  /// Solvers whose uses_uncertainty() is false use the mean.
  virtual void set_view_uncertainty(std::span<const ViewUncertainty> /*of_bodies*/) noexcept {}

  /// Reads and writes what the next update will, so that its code and data are in the caches; no
  /// later result changes, but predicted states and derivatives of the last update are lost.
  /// Default: nothing.
  virtual void warm_up() noexcept {}

  /// Projected KKT infinity norm of the current iterate at these states, without the solver's own
  /// relaxations; infinity if not a number. For acceptance figures, outside the timed part.
  virtual double kkt(double time, std::span<const double> states) noexcept = 0;

  /// Writes the inputs (nu) of the last good plan at `time` [s], for use if an update is late or
  /// lost. Before the plan begins: its first inputs; after it ends: its last; without a plan: zero.
  /// Input limits may have changed since then. Writes nothing if u has not nu entries.
  virtual void planned(double time, std::span<double> u) const noexcept = 0;

  /// Discards the iterate: the next update starts as the first did.
  virtual void restart() noexcept = 0;

  /// Capability to plan in a team that changes (TeamPlanner); null: it plans for its own team
  /// alone.
  virtual TeamPlanner* team_planner() noexcept { return nullptr; }
  /// Which robots receive each other's predictions if subteams exchange messages; null: no
  /// exchange.
  virtual const Connectivity* connectivity() const noexcept { return nullptr; }
  /// Whether it plans for teams with swarms, Team::keep_apart().
  virtual bool keeps_apart() const noexcept { return false; }
  /// Whether its plans use the values of set_view_uncertainty().
  virtual bool uses_uncertainty() const noexcept { return false; }
  /// Which formulas are compiled, for messages; empty if the solver uses no compiled formulas.
  virtual KernelUse kernels() const { return {}; }

  /// Calls solve() and returns the inputs only.
  std::span<const double> step(double time, std::span<const double> states) noexcept {
    return solve(time, states).u;
  }
};

// Predicted motion of one body along the horizon: the only data that subteams exchange.

/// Prediction message: the body, the time of the first sample, the step and the predicted Sights.
struct Prediction {
  BodyId who;
  double time = 0.0;                       ///< time of the first Sight [s]
  double h = 0.0;                          ///< step between two Sights [s], > 0
  std::vector<Sight<double>> sights = {};  ///< N + 1 Sights; empty: no prediction

  /// Whether the prediction is usable at time t [s] for a body at p [m]: |t - time| is less than
  /// its length, and it deviates from p by at most `astray` [m].
  bool holds(double t, const Vec3<double>& p) const noexcept;
  static constexpr double astray = 1.0;
  /// Predicted Sight at time t + k h [s], stage k >= 0. Interpolates linearly between two Sights;
  /// before the first and after the last Sight the velocity is constant.
  Sight<double> at(double t, int k) const noexcept;
  /// Whether the time and all numbers of all Sights are finite.
  bool is_finite() const noexcept;
};

// Interface for planning in a team that changes in flight, or that plans in several subteams.

/// A plan that can be read, set and taken over from the solver of another team, and that uses
/// predictions of uncontrolled bodies. Obtained from Solver::team_planner().
class TeamPlanner {
 public:
  virtual const Ocp& ocp() const = 0;

  /// Reads the planned inputs at stage k of all agents (nu): the start of the next update. In
  /// plan() and set_plan() an invalid stage or length has no effect. Neither allocates, locks nor
  /// blocks.
  virtual void plan(int k, std::span<double> u) const noexcept = 0;
  /// Replaces the plan at stage k; the next update clamps it to the limits. All stages must be set.
  virtual void set_plan(int k, std::span<const double> u) noexcept = 0;

  /// Sets the predicted trajectory of an uncontrolled body, at most N + 1 Sights; without it the
  /// body keeps its velocity. Updates within one horizon of its time use it, until the next
  /// prediction is set; an empty one removes it. Ignores a prediction that is too long or of a
  /// robot planned here.
  virtual void set_prediction(const Prediction& prediction) noexcept = 0;

  /// Residual up to which an update is `converged` [1/s].
  virtual double tolerance() const noexcept = 0;

  /// Planned inputs at all stages  (N x nu).
  std::vector<double> whole_plan() const;
  /// Continues the plan of another team's solver: agents of both teams, matched by name, take their
  /// inputs from that plan; the others keep theirs. Allocates. No effect if the plan has other
  /// stages.
  /// @param plan  inputs of the agents of `before`  (N x nu of that team)
  void take_over(const Team& before, std::span<const double> plan);

 protected:
  ~TeamPlanner() = default;
};

/// The TeamPlanner of a solver.
/// @param need  the feature that requires it, such as "a team that changes in flight"
/// @throws std::invalid_argument naming the solver and the need if it is no TeamPlanner
TeamPlanner& team_planner_of(Solver& solver, std::string_view need);

/// Makes the solver of a team, with a fixed horizon and fixed options. May throw what the
/// constructor of the solver throws.
using MakeSolver = std::function<std::unique_ptr<Solver>(Team)>;

}  // namespace sightline
