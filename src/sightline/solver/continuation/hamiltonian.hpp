/// Hamiltonian of an Ocp along its horizon: H = l + lambda' f at every stage, with its derivatives.
///
///   x_{i+1}  = x_i + h f(x_i, u_i)                                        `roll_out`
///   H_z      = l_z + f_z' lambda_{i+1},  z = (x, u)              `linearise`, then `gradient`
///   d H_z    along a tangent of u; x, lambda follow              `second_order`, then `tangent`
///
/// All stages are evaluated at once, in lanes; only the recursions run stage by stage. Masked
/// couplings are absent from the rows of agents they do not act on. The constructor allocates all
/// memory.
///
/// Trajectories are stage by stage: X (N+1 x nx), Lambda (N+1 x nx; stage 0 unused), u of stage i
/// at u + i stride.
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "sightline/formula/interpret.hpp"
#include "sightline/ocp/ocp.hpp"
#include "sightline/potential/heading_error_limit.hpp"

namespace sightline {

class Hamiltonian {
 public:
  /// @param ocp  must outlive the object
  explicit Hamiltonian(const Ocp& ocp);
  Hamiltonian(const Hamiltonian&) = delete;
  Hamiltonian& operator=(const Hamiltonian&) = delete;

  /// Sets the horizon from t [s] in steps of h [s]: references, limits, stage times.
  void set_time(double t, double h) noexcept;
  /// As above, with references limited to the heading error from x (nx)
  /// (potential/heading_error_limit.hpp).
  void set_time(double t, double h, const double* x) noexcept;
  double h() const { return h_; }
  /// Sets the offset added to the inputs of all agents (nu): from the next set_time() on limits
  /// hold for the sum.
  void set_added(std::span<const double> added) noexcept {
    std::copy(added.begin(), added.end(), added_.begin());
  }

  /// Sets u* of all agents (nu) at all stages.
  void set_u_ref(std::span<const double> u_ref) noexcept;

  /// Limits of stage i, all agents (nu).
  const double* u_min(int i) const { return &u_min_[at(i, nu_)]; }
  const double* u_max(int i) const { return &u_max_[at(i, nu_)]; }

  /// rate = f(x, u) of all bodies at one stage.
  void flow(const double* x, const double* u, double* rate) const noexcept;
  /// X from X_0 = x: X_{i+1} = X_i + h f + scale Z_{i+1}; Z (N+1 x nx) may be null.
  void roll_out(const double* x, const double* u, int stride, const double* Z, double scale,
                double* X) noexcept;

  /// Evaluates l_z and f_z at all stages 0 .. N-1.
  void linearise(const double* X, const double* u, int stride) noexcept;
  /// H_z = (H_x, H_u) of stage i (nx + nu) with the given lambda_{i+1}; after `linearise`.
  void gradient(int i, const double* lambda_next, double* H_z) const noexcept;
  /// phi_x at X_N (nx).
  void terminal_gradient(const double* x, double* phi_x) const noexcept;
  /// Lambda from Lambda_N = phi_x + scale Z_N: Lambda_i = Lambda_{i+1} + h H_x + scale Z_i, and H_u
  /// of all stages into F + i stride; after `linearise`. Z may be null.
  void costates(const double* X, const double* Z, double scale, double* Lambda, double* F,
                int stride) noexcept;

  /// Evaluates the second derivatives at the point of the last `linearise`, with these costates.
  void second_order(const double* Lambda) noexcept;
  /// d F along du, defects held: the sweep forward in dx, backward in dlambda (docs/equations.md,
  /// 8); after `second_order`. du of stage i at du + i stride, dF likewise.
  void tangent(const double* du, double* dF, int stride) noexcept;

 private:
  /// Destination of one structural nonzero: column `slot` of an operator, element `row`.
  struct Contribution {
    const double* values;  // one per stage
    int slot, row;
    bool first;   // assigns instead of adding
    bool scaled;  // by h
  };
  /// dest += sum_c column_c source[c], for one agent at each stage; columns are padded to whole
  /// packs.
  struct StageOperator {
    int rows = 0;              // padded
    std::vector<int> sources;  // index in a stage's tangent vector
    std::vector<Contribution> contributions;
    Rows columns;  // [stage]: sources.size() x rows

    void add(int source, int row, const double* values, bool scaled);
    void assemble(int stages, double h) noexcept;
    /// Adds the sum of column_c source_c to `dest`, in packs.
    void apply(int stage, const double* source, double* dest) const noexcept;
  };
  /// Offsets of one agent in the padded tangent vector of a stage, [dx | du | dlambda_next], and
  /// its operators.
  struct AgentTangent {
    int nx, nu, x_at, u_at;        // in the stacked x and u
    int dx_at, du_at, dlambda_at;  // in the tangent vector
    StageOperator forward, backward, input;
  };

  static std::size_t at(int i, int n) { return static_cast<std::size_t>(i) * static_cast<std::size_t>(n); }
  void bind();
  void lay_out_tangents();

  const Ocp& ocp_;
  const Formulas& formulas_;
  int N_, nx_, nu_;
  double h_ = 0.0;
  std::vector<int> x_at_, u_at_;  // of each body
  // One value per stage; x_ref_ also holds the value at t + N h:
  Rows x_, u_, lambda_, x_ref_, u_ref_, Q_, R_, t_;
  Rows g_;  // l_z: nx + nu rows
  std::vector<Rows> agent_first_, agent_second_, pair_first_, pair_second_;
  std::vector<Evaluation> agent_first_run_, agent_second_run_, pair_first_run_, pair_second_run_;
  std::vector<double> u_min_, u_max_, added_, stage_x_, stage_u_, stage_rate_, H_z_;
  std::vector<HeadingErrorLimit> heading_limits_;  // of each agent
  std::vector<AgentTangent> tangents_;
  Rows tangent_;  // [stage 0..N]: padded [dx | du | dlambda_next]
  Rows d_input_;  // one agent's rows of dF
};

}  // namespace sightline
