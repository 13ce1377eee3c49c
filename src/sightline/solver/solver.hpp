/// What every solver is: a measured state in, an input to apply out, in bounded time and with an honest
/// status.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string_view>
#include <vector>

#include "sightline/ocp/ocp.hpp"
#include "sightline/solver/kernels/kernel_use.hpp"

namespace sightline {

/// What an update reckons with besides the states, of all agents (nu each).
struct AppliedInputs {
  std::span<const double> previous;  ///< in force until the update, `offset` in it
  std::span<const double>
      offset;  ///< to the solver's inputs afterwards, such as what holds a robot against wind
  std::span<const Vec2<double>> lean{};  ///< of each body, that `added` gives it beside its own; empty: none
  std::span<const double> u_ref{};       ///< u* in the costs of the agents; empty: the team's
};

/// How sure a robot is of where what it looks at is to it, sideways.
struct ViewUncertainty {
  double sigma = 0.0;   ///< standard deviation now [m]
  double growth = 0.0;  ///< of it, while nothing is seen [m/s]

  double after(double time) const { return sigma + growth * time; }  ///< [m] after time [s]
};

/// How an update ended, the better first. In every case `Solution::u` is finite, within its limits and usable.
enum class Status : std::uint8_t {
  converged,  ///< residual <= tolerance
  stepped,    ///< residual > tolerance; the one step of a real-time update was taken whole
  iteration_limit,  ///< residual > tolerance after all the steps of an update that was asked to converge, or after a
  ///< real-time step that was not taken whole: damped, shortened, or at limits not yet known
  deadline,       ///< the time given was over; the best there was
  not_finite,     ///< the step was not finite: the last good plan, shifted; the next update starts anew
  invalid_state,  ///< the state was refused (not finite, heading (0, 0)): the last good plan, shifted
};
inline constexpr int status_count = 6;

std::string_view to_string(Status status);
/// Whether an update that ended so made a plan from the state it was given.
constexpr bool gives_plan(Status status) { return status < Status::not_finite; }

/// Pairs of swarms.
struct Neighbours {
  int pairs = 0;     ///< that come near each other along the plan and are kept apart
  int left_out = 0;  ///< that should be, but found no room
};

/// Predicted states of all bodies (N+1 x nx), stage by stage: read as a span, which a solver may write when it is first looked at.
class PredictedStates {
 public:
  /// Whoever writes them then.
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

/// The outcome of one update. The spans are the solver's own memory, valid until its next call.
struct Solution {
  std::span<const double> u;      ///< inputs to apply now, of all agents (nu)
  std::span<const double> raw_u;  ///< the same before they were clamped to their limits (nu)
  /// The trajectory that was linearised, from the measured state under the inputs before the step; empty where there is none.
  PredictedStates x;
  Status status = Status::iteration_limit;
  /// Infinity norm of the optimality conditions at the point that was linearised [per s], each input in its
  /// scale, input_scales(); infinity: not known.
  double residual = std::numeric_limits<double>::infinity();
  int iterations = 0;       ///< of the Krylov method
  Neighbours neighbours{};  ///< of the team's swarms
  double elapsed = 0.0;     ///< wall time of the update [s]
};

class Connectivity;
class TeamPlanner;

/// A solver of one Ocp. `solve` does not throw, allocate, lock or print. One thread at a time.
class Solver {
 public:
  virtual ~Solver() = default;

  virtual std::string_view name() const = 0;
  virtual const Ocp& ocp() const = 0;

  /// One update: from the measured states of all bodies (nx) at `time` [s] to the inputs.
  virtual Solution solve(double time, std::span<const double> states) noexcept = 0;

  /// For the updates that follow: limits of inputs then hold for u + added, rate_max and R_rate for their change from
  /// `before`, robots are seen to lean by `lean` more, and u* is u_ref over the whole horizon. Never told, nothing is added
  /// and inputs may jump. What a solver does not reckon with, it leaves to the loop, which keeps both limits.
  virtual void set_applied(const AppliedInputs& /*applied*/) noexcept {}

  /// For the updates that follow: Sight::doubt of each body along the horizon. Never told, all are sure. A solver that does not
  /// reckon with it, uses_uncertainty(), looks at where they take what they see to be.
  virtual void set_view_uncertainty(std::span<const ViewUncertainty> /*of_bodies*/) noexcept {}

  /// Projected KKT infinity norm of the present iterate at these states, without the solver's own
  /// relaxations; infinity where it is not a number. For acceptance figures, outside the timed part.
  virtual double kkt(double time, std::span<const double> states) noexcept = 0;

  /// Writes the inputs (nu) that the last good plan has for `time` [s], for use where an update is late or lost. Before
  /// the plan begins its first inputs, after it ends its last; zero where there is no plan yet. Input limits may have
  /// changed since. Writes nothing where u is shorter than nu.
  virtual void planned(double time, std::span<double> u) const noexcept = 0;

  /// Forgets the iterate: the next update starts as the first did.
  virtual void restart() noexcept = 0;

  /// Its capability to plan in a team that changes (team_planner.hpp); none: it plans for its own team alone.
  virtual TeamPlanner* team_planner() noexcept { return nullptr; }
  /// Which robots hear each other, where its team plans in parts that exchange messages; none: nobody needs to.
  virtual const Connectivity* connectivity() const noexcept { return nullptr; }
  /// Whether it plans for teams with swarms, Team::keep_apart().
  virtual bool keeps_apart() const noexcept { return false; }
  /// Whether its views shrink by what set_view_uncertainty() tells.
  virtual bool uses_uncertainty() const noexcept { return false; }
  /// Which of its formulas are compiled, for messages; nothing where none is ever looked for.
  virtual KernelUse kernels() const { return {}; }

  /// solve(), for a program that only wants the inputs.
  std::span<const double> step(double time, std::span<const double> states) noexcept {
    return solve(time, states).u;
  }
};

}  // namespace sightline
