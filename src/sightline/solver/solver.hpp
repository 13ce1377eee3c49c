/// Interface of all solvers: measured state in, applicable input out, in bounded time, with a
/// status that reports how the update ended.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string_view>
#include <vector>

#include "sightline/ocp/ocp.hpp"
#include "sightline/solver/kernels/kernel_use.hpp"

namespace sightline {

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

  /// Projected KKT infinity norm of the current iterate at these states, without the solver's own
  /// relaxations; infinity if not a number. For acceptance figures, outside the timed part.
  virtual double kkt(double time, std::span<const double> states) noexcept = 0;

  /// Writes the inputs (nu) of the last good plan at `time` [s], for use if an update is late or
  /// lost. Before the plan begins: its first inputs; after it ends: its last; without a plan: zero.
  /// Input limits may have changed since then. Writes nothing if u has not nu entries.
  virtual void planned(double time, std::span<double> u) const noexcept = 0;

  /// Discards the iterate: the next update starts as the first did.
  virtual void restart() noexcept = 0;

  /// Capability to plan in a team that changes (team_planner.hpp); null: it plans for its own team
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

}  // namespace sightline
