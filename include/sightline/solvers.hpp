/// The solvers: Newton with Riccati factorisation, continuation/GMRES, and subteams that exchange predictions.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <variant>
#include <vector>

#include "sightline/base.hpp"
#include "sightline/formula.hpp"
#include "sightline/potentials.hpp"
#include "sightline/solver.hpp"
#include "sightline/team.hpp"

namespace sightline {

// State of the other parts from their messages: connectivity, losses, and clock offsets.
//
// Each message holds its send time by the sender's clock, and per other part the latest received
// message and its age. From an answer the receiver computes a round trip, and the clock offset (as
// NTP, RFC 5905, section 8):
//
//   offset = ((t_2 - t_1) + (t_3 - t_4)) / 2,   round trip = (t_4 - t_1) - (t_3 - t_2)
//
// with t_1, t_4 by the own clock and t_2, t_3 by the other clock. The offset with the smallest
// round trip of the last 10 s is used. Each offset is exact to half its round trip; two
// inconsistent offsets imply that a clock was reset, and only the later one is kept.

/// Which robots receive predictions of others, in a team that plans in parts. Reports the last
/// update, on the flight thread. Robots of one part always receive each other.
class Connectivity {
 public:
  /// Whether the plan of `robot` uses a recent prediction of `other`, and `other` also keeps its
  /// distance to `robot`.
  virtual bool receives_from(BodyId robot, BodyId other) const noexcept = 0;
  /// Whether every robot receives this body's predictions; true for a body that sends none.
  virtual bool is_received(BodyId body) const noexcept = 0;

 protected:
  ~Connectivity() = default;
};

/// Time of a computer's clock [ns].
using ClockTime = std::int64_t;

/// Acknowledgement of the last message of another part.
struct Echo {
  ClockTime stamp = 0;  ///< stamp of that message, by its sender's clock; 0: none received
  ClockTime held = 0;   ///< time since its arrival [ns]
};

/// Message of a part, once per period.
struct PartMessage {
  int part = -1;               ///< index in the partition
  std::uint64_t session = 0;   ///< id of the planning program; a restarted program has another
  std::uint64_t sequence = 0;  ///< increases by one per message
  ClockTime stamp = 0;         ///< time of the first Sight of each prediction, by the sender's clock
  bool steers = false;         ///< its robots follow their predictions and keep their distances
  std::uint8_t phase = 0;      ///< of its flight; not used here
  ClockTime begins = 0;        ///< start of its control of the robots, by the sender's clock; 0: unknown
  ClockTime arrived = 0;       ///< by another clock of the receiver, if any; not used here
  std::vector<Prediction> predictions{};  ///< of its robots; `who` refers to the whole team
  std::vector<Echo> echoes{};             ///< per part
};

/// Estimate of another clock's offset from the own clock.
class ClockOffsetByEcho {
 public:
  static constexpr ClockTime kept = 10'000'000'000;  // window of the offsets [ns]
  static constexpr ClockTime drift = 2'000'000;  // largest drift of two clocks in this window, 200 ppm [ns]

  /// Processes a message received at `now` (own clock), sent at `stamp` (other clock), that echoes
  /// a message of ours.
  void receive(ClockTime now, ClockTime stamp, const Echo& echo) noexcept;
  /// Other clock minus own clock [ns]; none before the first echo.
  std::optional<ClockTime> offset() const noexcept;
  void forget() noexcept { *this = {}; }

 private:
  // Best offset per time span, so that old ones can be discarded.
  struct Best {
    ClockTime since = 0, round_trip = std::numeric_limits<ClockTime>::max(), offset = 0;
  };
  static constexpr ClockTime span = kept / 5;
  std::array<Best, 5> best_{};
  std::size_t newest_ = 0;
};

/// Connection state of another part.
enum class PeerState : std::uint8_t {
  silent,      ///< no message yet, or none with an echo
  received,    ///< its newest message is recent
  stale,       ///< its newest message is older than stale_after
  other_time,  ///< its clock offset is too large
  idle,        ///< messages arrive, but it does not steer its robots and its announced start is not reached
};

/// Message state of all parts. Allocates only in the constructor.
class Peers {
 public:
  static constexpr ClockTime offset_max = 20'000'000;  ///< largest accepted clock offset [ns]

  /// @param stale_after  age beyond which a message is ignored [ns]
  Peers(int parts, int own, ClockTime stale_after);

  /// Processes a message received at `now` [ns, own clock]. @return whether it is the newest of its
  /// part; an older one is counted as late and dropped, one of an invalid part is dropped
  bool receive(const PartMessage& message, ClockTime now) noexcept;
  /// Connection state of a part at `now` [ns, own clock].
  PeerState state(int part, ClockTime now) const noexcept;
  bool receives_from(int part, ClockTime now) const noexcept {
    return state(part, now) == PeerState::received;
  }
  /// Other clock minus own clock [ns]; none if unknown.
  std::optional<ClockTime> offset(int part) const noexcept;
  std::uint8_t phase(int part) const noexcept { return peers_[static_cast<std::size_t>(part)].phase; }
  /// Start of its control, by its clock [ns]; 0: unknown.
  ClockTime begins(int part) const noexcept { return peers_[static_cast<std::size_t>(part)].begins; }
  /// Writes the echoes for the next message.
  void answer(ClockTime now, std::vector<Echo>& echoes) const noexcept;

  struct Counts {
    std::int64_t received = 0, lost = 0, late = 0;  ///< late: older than the newest message
    std::int64_t sessions = 0;                      ///< number of programs that planned the part
  };
  const Counts& counts(int part) const noexcept { return peers_[static_cast<std::size_t>(part)].counts; }
  void forget() noexcept;

 private:
  struct Peer {
    std::uint64_t session = 0, sequence = 0;
    ClockTime stamp = 0, arrived = 0, begins = 0;
    bool steers = false;
    std::uint8_t phase = 0;
    ClockOffsetByEcho clock{};
    Counts counts{};
  };
  std::vector<Peer> peers_;  // per part, including the own one
  int own_;
  ClockTime stale_after_;
};

// GMRES (Saad and Schultz 1986) for a small real-time budget: preallocated memory, no restart,
// guarded termination.

/// Numbers that are summed in parallel in a fixed order, independent of the machine's lane width.
inline constexpr int dot_quantum = 32;

/// sum a_i b_i over n numbers, n a multiple of `dot_quantum`.
double dot(const double* a, const double* b, int n) noexcept;

class Gmres {
 public:
  /// @param n  unknowns; vectors passed to `solve` have `length()` >= n numbers, zero beyond n
  Gmres(int n, int k_max);

  int length() const { return length_; }

  struct Outcome {
    int iterations = 0;
    double residual = 0.0;  ///< ||b - A x||, from the rotations
  };

  /// Improves x towards A x = b, starting from the given x.
  /// @param product    called as product(v, out): out = A v; both of length(), out zero beyond n
  /// @param tolerance  stops when ||b - A x|| <= tolerance
  /// @param late       called as late() after each iteration; true ends the iterations
  template <class Product, class Late>
  Outcome solve(Product&& product, const double* b, double* x, double tolerance, Late&& late) noexcept;
  template <class Product>
  Outcome solve(Product&& product, const double* b, double* x, double tolerance) noexcept {
    return solve(product, b, x, tolerance, [] { return false; });
  }

 private:
  double& hessenberg(int i, int j) {
    return h_[static_cast<std::size_t>(j) * static_cast<std::size_t>(k_max_ + 1) +
              static_cast<std::size_t>(i)];
  }
  /// Orthogonalises v_{k+1} against the basis and normalises it. @return its length before
  /// normalisation
  double orthogonalise(int k) noexcept;
  /// Applies the rotations to column k and adds one that eliminates its last entry. @return false
  /// if singular
  bool rotate(int k) noexcept;
  /// x += V y, y from the triangular system of k columns.
  void advance(int k, double* x) noexcept;

  int length_, k_max_;
  Rows basis_;
  std::vector<double> h_, cos_, sin_, g_, y_;
};

template <class Product, class Late>
Gmres::Outcome Gmres::solve(Product&& product, const double* b, double* x, double tolerance,
                            Late&& late) noexcept {
  double* const v0 = basis_[0];
  product(static_cast<const double*>(x), v0);
  for (int i = 0; i < length_; ++i) v0[i] = b[i] - v0[i];
  const double beta = sqrt(dot(v0, v0, length_));
  // A zero residual leaves nothing to divide by; a non-finite one cannot be reduced.
  if (!(beta > tolerance) || !(beta < 1e300)) return {0, beta};
  for (int i = 0; i < length_; ++i) v0[i] /= beta;
  g_[0] = beta;
  double residual = beta;
  int k = 0;
  while (k < k_max_ && residual > tolerance) {
    product(static_cast<const double*>(basis_[k]), basis_[k + 1]);
    const double length = orthogonalise(k);
    if (!rotate(k)) break;
    residual = g_[static_cast<std::size_t>(k) + 1] < 0 ? -g_[static_cast<std::size_t>(k) + 1]
                                                       : g_[static_cast<std::size_t>(k) + 1];
    ++k;
    if (length == 0) break;  // happy breakdown: x is exact in the Krylov space
    if (late()) break;
  }
  advance(k, x);
  return {k, residual};
}

// Hamiltonian of an Ocp along its horizon: H = l + lambda' f at every stage, with its derivatives.
//
//   x_{i+1}  = x_i + h f(x_i, u_i)                                        `roll_out`
//   H_z      = l_z + f_z' lambda_{i+1},  z = (x, u)              `linearise`, then `gradient`
//   d H_z    along a tangent of u; x, lambda follow              `second_order`, then `tangent`
//
// All stages are evaluated at once, in lanes; only the recursions run stage by stage. Masked
// couplings are absent from the rows of agents they do not act on. The constructor allocates all
// memory.
//
// Trajectories are stage by stage: X (N+1 x nx), Lambda (N+1 x nx; stage 0 unused), u of stage i
// at u + i stride.

class Hamiltonian {
 public:
  /// @param ocp  must outlive the object
  explicit Hamiltonian(const Ocp& ocp);
  Hamiltonian(const Hamiltonian&) = delete;
  Hamiltonian& operator=(const Hamiltonian&) = delete;

  /// Sets the horizon from t [s] in steps of h [s]: references, limits, stage times.
  void set_time(double t, double h) noexcept;
  /// As above, with references limited to the heading error from x (nx)
  /// (HeadingErrorLimit).
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

// Base class of the continuation/GMRES solvers: they track the root of the optimality conditions
// over time, dF/dt = -zeta F, (5), instead of solving F = 0 anew. Full update: docs/equations.md,
// 7.
//
// Limits enter through one multiplier and one slack per input (7.4). The horizon grows from zero
// length, so that the start is a root. The derived class defines the states between the stages:
// unknowns with defects (`Cmscgmres`), or rolled out from the measured state (`Cgmres`).

/// How the product of the Jacobian with a vector is computed.
enum class JacobianProduct {
  exact,               ///< tangent of the sweeps, docs/equations.md, 8
  forward_difference,  ///< forward difference of the sweeps, as in the paper
};

struct ContinuationOptions {
  double zeta = 10.0;
  int k_max = 30;
  double alpha = 2.0, difference_step = 1e-8, slack_weight = 0.01;
  JacobianProduct jacobian = JacobianProduct::exact;
  double gmres_tolerance = 1e-8, tolerance = 1e-3;

  static constexpr auto parameters() {
    using O = ContinuationOptions;
    return Parameters{
        parameter("k_max", &O::k_max, "", {1, 1000, "1 to 1000"}, "GMRES iterations of an update, at most"),
        parameter("jacobian", &O::jacobian, std::array<std::string_view, 2>{"exact", "forward_difference"},
                  "product of the Jacobian and a vector"),
        parameter("zeta", &O::zeta, "1/s", above_zero,
                  "decay rate of the residual; stable for zeta dt < 2, smooth to 1"),
        parameter("alpha", &O::alpha, "1/s", above_zero, "growth rate of the horizon, T (1 - e^(-alpha t))"),
        parameter("difference_step", &O::difference_step, "s", {1e-15, 0.1, "1e-15 to 0.1"},
                  "eps of the finite differences in time"),
        parameter("slack_weight", &O::slack_weight, "", above_zero, "k of -k s in H: how early a limit acts"),
        parameter("gmres_tolerance", &O::gmres_tolerance, "", from_zero,
                  "GMRES stops at this norm of b - A U'"),
        parameter("tolerance", &O::tolerance, "", above_zero,
                  "the status is `converged` up to this residual")};
  }
};

class Continuation : public Solver {
 public:
  const Ocp& ocp() const override { return ocp_; }
  Solution solve(double time, std::span<const double> states) noexcept override;
  double kkt(double time, std::span<const double> states) noexcept override;
  void planned(double time, std::span<double> u) const noexcept override;
  void restart() noexcept override;
  /// Uses `offset` in the limits and `u_ref` in the costs; ignores the rest.
  void set_applied(const AppliedInputs& applied) noexcept override;

  /// Numbers that the solver keeps from update to update.
  virtual int unknowns() const { return unknowns_; }

 protected:
  /// @throws std::invalid_argument naming an option out of its range
  Continuation(Ocp ocp, const ContinuationOptions& options);

  /// Defects of X and Lambda, N+1 x nx each; empty if the trajectory has no defects.
  struct Defects {
    std::vector<double> x, lambda;
  };
  static std::size_t at(int i, int n) { return static_cast<std::size_t>(i) * static_cast<std::size_t>(n); }
  /// Unknowns of one stage: u, mu, s, each of all agents (nu).
  int stride() const { return 3 * nu_; }

  /// F and G at (U, x, t), with the Hamiltonian's t; linearises the Hamiltonian there and sets X_0
  /// = x.
  virtual void residuals(Hamiltonian& hamiltonian, const std::vector<double>& x, double* F,
                         Defects& G) noexcept = 0;
  /// U += step U', by `move_unknowns`; the trajectories follow; X_0 becomes the measured state.
  virtual void advance(double step) noexcept = 0;

  void move_unknowns(double step) noexcept;
  /// X, Lambda and F with the defects `scale` G at (U, x_soon, t + eps).
  void sweep(const double* U, const Defects& G, double scale) noexcept;
  /// Adds mu C_u to the rows of u; writes the rows of mu and s, C = ((u - m)/r)^2 / 2 - 1/2 + s^2.
  void limit_rows(const Hamiltonian& hamiltonian, const double* U, double* F) const noexcept;

  Ocp ocp_;
  ContinuationOptions options_;
  int N_, nx_, nu_, unknowns_;
  Hamiltonian here_;                       // at the measured state
  Hamiltonian there_;                      // one difference step later
  std::vector<double> x_, x_soon_, rate_;  // measured state, normalised; predicted; its rate

 private:
  Gmres gmres_;
  Rows vectors_;  // vectors of all unknowns: U_ to F_soon_ below

 protected:
  double *U_, *U_dot_, *F_, *F_there_, *b_, *U_trial_, *F_soon_;
  std::vector<double> X_, Lambda_, X_trial_, Lambda_trial_;  // N+1 x nx
  Defects G_, G_soon_;
  std::vector<double> H_z_;

 private:
  double stage_length(double t) const noexcept;
  bool accept(std::span<const double> states) noexcept;
  void start(double time) noexcept;
  void product(const double* v, double* out) noexcept;
  void difference_product(const double* v, double* out) noexcept;
  [[nodiscard]] bool limits_hold() const noexcept;
  void clamp_inputs(std::span<const double> u) noexcept;
  void keep_plan(double time) noexcept;
  Solution fall_back(double time, Status status) noexcept;

  bool started_ = false;
  double started_at_ = 0.0, last_time_ = 0.0;
  std::vector<double> u_, raw_u_, x_out_;
  std::vector<double> scales_;  // of the inputs (nu)

  std::vector<double> plan_;  // inputs of the last good update, N x nu
  double plan_time_ = 0.0, plan_h_ = 0.0;
};

// Single-shooting continuation/GMRES (Ohtsuka 2004): the unknowns are the inputs alone.
//
// Each update rolls out states and costates from the measured state, so the dynamics hold exactly.
// The defects that CMSCGMRES lets decay enter F directly. docs/equations.md, 7.5.

using CgmresOptions = ContinuationOptions;

class Cgmres final : public Continuation {
 public:
  /// @throws std::invalid_argument naming an option out of its range
  explicit Cgmres(Ocp ocp, const CgmresOptions& options = {}) : Continuation(std::move(ocp), options) {}
  Cgmres(const Team& team, const Horizon& horizon, const CgmresOptions& options = {})
      : Cgmres(Ocp(team, horizon), options) {}

  std::string_view name() const override { return "cgmres"; }

 private:
  void residuals(Hamiltonian& hamiltonian, const std::vector<double>& x, double* F,
                 Defects& none) noexcept override;
  void advance(double step) noexcept override;
};

// The solver of the paper, sec. 3: condensed multiple shooting continuation/GMRES (Shimizu,
// Ohtsuka, Diehl 2009).
//
// States and costates between the stages are unknowns too; their defects decay with F, dG/dt =
// -zeta G, (5). Condensing eliminates them, so GMRES solves for the inputs alone. Full update:
// docs/equations.md, 7.

using CmscgmresOptions = ContinuationOptions;

class Cmscgmres final : public Continuation {
 public:
  /// @throws std::invalid_argument naming an option out of its range
  explicit Cmscgmres(Ocp ocp, const CmscgmresOptions& options = {});
  Cmscgmres(const Team& team, const Horizon& horizon, const CmscgmresOptions& options = {})
      : Cmscgmres(Ocp(team, horizon), options) {}

  std::string_view name() const override { return "cmscgmres"; }
  int unknowns() const override { return unknowns_ + 2 * N_ * nx_; }

 private:
  void residuals(Hamiltonian& hamiltonian, const std::vector<double>& x, double* F,
                 Defects& G) noexcept override;
  void advance(double step) noexcept override;
};

// Simulated network between the parts of a team: messages arrive late, reordered, or not at all.
//
// Delay and loss are drawn from the seed, the two parts and the message number, so that a flight
// is reproducible.

/// Transport of messages in a flight whose parts run in separate programs.
enum class MessagesBy : std::uint8_t {
  network,
  simulation,  ///< the network plus the simulated delay and loss, for tests
};

/// Options of the exchange of predictions between parts.
struct ExchangeOptions {
  static constexpr std::string_view name = "exchange";

  double stale_after = 0.2;
  double speed_max = 1.5;
  // Simulated network.
  double delay = 0.01, jitter = 0.0, loss = 0.0, offset = 0.0;
  MessagesBy flown_by = MessagesBy::network;
  std::uint64_t seed = 1;  ///< of loss and jitter

  static constexpr auto parameters() {
    using E = ExchangeOptions;
    return Parameters{
        parameter("stale_after", &E::stale_after, "s", {0.02, 10, "0.02 to 10"},
                  "age of a message from which its robots count as uncooperative"),
        parameter("speed_max", &E::speed_max, "m/s", from_zero,
                  "at most, of a robot of another part without messages"),
        parameter("delay", &E::delay, "s", {0, 1, "0 to 1"}, "simulated: from the update to the receiver"),
        parameter("jitter", &E::jitter, "s", {0, 1, "0 to 1"}, "simulated: at most, added to the delay"),
        parameter("loss", &E::loss, "", {0, 1, "0 to 1"}, "simulated: share of the messages that never come"),
        parameter("offset", &E::offset, "s", {-1, 1, "-1 to 1"},
                  "simulated: by which the clock of the last part is ahead of the first one's; those between "
                  "lie between"),
        parameter("flown_by", &E::flown_by, std::array<std::string_view, 2>{"network", "simulation"},
                  "of flights: what is simulated happens to the network's messages as well, to try it")};
  }
};

/// Message that a part received since its last update.
struct ReceivedMessage {
  const PartMessage* message = nullptr;  ///< the newest usable one; null: none arrived
  double time = 0.0;                     ///< time of its first Sights, by the receiver's clock [s]
  bool ended = false;                    ///< the earlier prediction is now too old
};

/// Uniform random number in [0, 1), a function of its arguments: decides a message from one part to
/// another.
enum class MessageChance : std::uint8_t { loss = 1, jitter };
double chance_of(MessageChance what, std::uint64_t seed, int to, int from, std::uint64_t sequence) noexcept;

/// Messages of all parts. Allocates only in the constructor. Different parts may receive in
/// parallel, and send in parallel.
class SimulatedMessages {
 public:
  /// @param predictions  those of each part, in their final sizes
  SimulatedMessages(const ExchangeOptions& options, const Horizon& horizon,
                    std::span<const std::vector<Prediction>> predictions);

  /// Sends a part's predictions from t [s] on.
  void send(int part, double t, std::span<const Prediction> predictions) noexcept;
  /// Delivers to a part the messages that have arrived by t [s].
  void receive(int to, double t) noexcept;
  /// Result of the last receive().
  ReceivedMessage news(int to, int from) const noexcept { return links_[place(to, from)].news; }
  bool receives_from(int to, int from) const noexcept { return links_[place(to, from)].received; }

  /// Whether any message was sent.
  bool begun() const noexcept { return numbers_.front() > 0; }
  /// Periods after which two parts know each other's clock offset, unless no message arrives.
  int talk_periods() const noexcept { return talk_periods_; }
  void restart() noexcept;

 private:
  struct Link {
    std::uint64_t seen = 0;  // number of the newest received message
    bool received = false, used = false;
    ReceivedMessage news{};
  };
  std::size_t place(int to, int from) const noexcept {
    return static_cast<std::size_t>(to) * parts_ + static_cast<std::size_t>(from);
  }
  ClockTime clock(int part, double t) const noexcept;

  ExchangeOptions options_;
  std::size_t parts_, kept_;
  int talk_periods_;
  std::vector<std::vector<PartMessage>> sent_;  // latest messages of each part, by number
  std::vector<std::vector<double>> sent_at_;    // send times [s]
  std::vector<std::uint64_t> numbers_;          // messages sent, per part
  std::vector<Peers> peers_;
  std::vector<Link> links_;
};

// The default solver: one exact Newton step per update on the coupled optimality conditions, with
// a Riccati factorisation per robot and Krylov iterations for the couplings.
//
// Single shooting: the trajectory is rolled out from the measured state, so the dynamics hold
// exactly and the unknowns are the inputs. Each update warm-starts from the previous plan,
// extrapolated in time. Limits are exact, by an active set that is relinearised when it changes.
// An unreliable step is damped, shortened or, at worst, rejected. docs/equations.md, 11.

class ThreadPool;
enum class KernelChoice;

struct NewtonRiccatiOptions {
  int max_newton_steps = 1;
  double tolerance = 1e-6;
  int max_krylov = 4;
  double krylov_stop = 1e-3, step_cap = 0.5, deadline = 0.0;
  int start_steps = 10;
  KernelChoice kernels{};  ///< compiled if available, see KernelTable
  /// Thread pool for teams of at least `shared_from` robots; null: the calling thread alone. The
  /// result is the same.
  std::shared_ptr<ThreadPool> pool{};
  static constexpr int shared_from = 128;

  static constexpr auto parameters() {
    using O = NewtonRiccatiOptions;
    constexpr Bounds steps = {1, 1000, "1 to 1000"};
    return Parameters{
        parameter("max_newton_steps", &O::max_newton_steps, "", steps, "of an update"),
        parameter("start_steps", &O::start_steps, "", steps, "Newton steps of the first update, at most"),
        parameter("max_krylov", &O::max_krylov, "", {0, 1000, "0 to 1000"},
                  "Krylov iterations, or substitution passes, of a step"),
        parameter("tolerance", &O::tolerance, "", above_zero,
                  "the status is `converged` up to this residual"),
        parameter("krylov_stop", &O::krylov_stop, "", from_zero,
                  "stop at this correction, in the norm of the Hessian"),
        parameter("step_cap", &O::step_cap, "", above_zero,
                  "a larger step of an input in its scale, or residual, starts a line search"),
        parameter("deadline", &O::deadline, "",
                  {0.0, std::numeric_limits<double>::max(), ">= 0 s, 0 for none"},
                  "an update ends then, after the step in progress, at least one")};
  }
};

namespace newton {
struct Workspace;
}

class NewtonRiccati final : public Solver, public TeamPlanner {
 public:
  /// @throws std::invalid_argument naming an option out of its range
  explicit NewtonRiccati(Ocp ocp, const NewtonRiccatiOptions& options = {});
  NewtonRiccati(const Team& team, const Horizon& horizon, const NewtonRiccatiOptions& options = {})
      : NewtonRiccati(Ocp(team, horizon), options) {}
  NewtonRiccati(NewtonRiccati&& other) noexcept;
  NewtonRiccati& operator=(NewtonRiccati&& other) noexcept;
  ~NewtonRiccati() override;

  std::string_view name() const override { return "newton_riccati"; }
  const Ocp& ocp() const override;
  Solution solve(double time, std::span<const double> states) noexcept override;
  void set_applied(const AppliedInputs& applied) noexcept override;
  void set_view_uncertainty(std::span<const ViewUncertainty> of_bodies) noexcept override;
  bool uses_uncertainty() const noexcept override { return true; }
  void warm_up() noexcept override;
  double kkt(double time, std::span<const double> states) noexcept override;
  void planned(double time, std::span<double> u) const noexcept override;
  void restart() noexcept override;
  TeamPlanner* team_planner() noexcept override { return this; }
  bool keeps_apart() const noexcept override { return true; }
  KernelUse kernels() const override;

  void plan(int k, std::span<double> u) const noexcept override;
  void set_plan(int k, std::span<const double> u) noexcept override;
  void set_prediction(const Prediction& prediction) noexcept override;
  double tolerance() const noexcept override;

 private:
  friend class InputGradient;
  std::unique_ptr<newton::Workspace> workspace_;
};

// Derivatives of the applied input with respect to all that an update depends on: adjoint of the
// Newton step.
//
// At the optimum H_u(u, theta) = 0 for inputs that are free; inputs on their limits do not move. So
// du/dtheta = -M^-1 dH_u/dtheta with M the matrix of the Newton step, and for any numbers g
//
//   d(g' u_0)/dtheta = -v' dH_u/dtheta,   M' v = (g, 0, ..., 0)
//
// One v gives the derivatives by all theta. M' is solved with the factorisation of the last update;
// docs/equations.md, 15.

/// Derivatives of g' u of a NewtonRiccati solver. Neither throws, allocates nor locks after its
/// construction. Not included: weights of swarms, numbers of barriers, the motion of a controlled
/// third body, limits that move with the previous input.
class InputGradient {
 public:
  /// A number that the inputs depend on: "uav0.Q[3]", "couple[0].weight", "couple[0].d_min",
  /// "constrain[1].weight" in the order of Team. "uav0.x_ref[2]" is a shift of the whole reference.
  struct Parameter {
    std::string name;
    double value = 0.0;
  };

  /// @param solver  must outlive the object
  /// @throws std::bad_alloc
  explicit InputGradient(NewtonRiccati& solver);
  InputGradient(InputGradient&& other) noexcept;
  InputGradient& operator=(InputGradient&& other) noexcept;
  ~InputGradient();

  /// Differentiates g' u, u the inputs of the last update (nu), at the point that it linearised.
  /// Call it before the solver's next function. @return false, with derivatives of zero, unless the
  /// update ended with a full step that was not damped and no reference was turned
  /// (HeadingErrorLimit)
  bool differentiate(std::span<const double> g) noexcept;

  /// By the measured states of all bodies, with normalised headings  (nx).
  std::span<const double> states() const noexcept;
  /// By the inputs in force before the update  (nu); nonzero only for robots with R_rate.
  std::span<const double> previous() const noexcept;
  /// By each of parameters().
  std::span<const double> by_parameters() const noexcept;
  const std::vector<Parameter>& parameters() const noexcept;
  /// Relative change of v by the last refinement: the error of the derivatives is smaller.
  double error() const noexcept;

 private:
  struct Work;
  std::unique_ptr<Work> work_;
};

// A subteam: robots of a team that plan separately; coupled bodies outside follow their
// predictions.
//
//   min over u_S   sum over i in S of l_i + sum of the couplings that act on a robot of S
//
// with the Sights of the other bodies given. A coupling that acts on robots of two subteams
// belongs to both, one end each. Given the other trajectories, its derivative by the own inputs is
// that of the whole team. A plan that no subteam can improve is thus a stationary point of the
// whole. Subteams share no memory; they exchange `Prediction`s. docs/partition.md

/// Which bodies outside are part of a subteam's problem.
enum class Others : std::uint8_t { felt, all };

/// Team of the robots in `own` with all couplings that act on them. Bodies outside, the coupled
/// ones or all, become obstacles with the same names. Robots come first, both in the order of the
/// whole team.
/// @throws std::invalid_argument for an empty list, a body that is no robot, or a swarm with robots
///   outside
Team subteam_of(const Team& whole, std::span<const AgentId> own, Others others = Others::felt);

class Subteam {
 public:
  /// @throws std::invalid_argument as subteam_of does, and if the solver is no TeamPlanner; and
  ///   what making the solver throws
  Subteam(const Team& whole, std::span<const AgentId> own, const MakeSolver& make,
          Others others = Others::felt);

  const Ocp& ocp() const { return solver_->ocp(); }
  const Solver& solver() const { return *solver_; }
  /// Id in the whole team of a body of the subteam. @throws std::out_of_range
  BodyId in_whole(BodyId body) const { return in_whole_.at(at(body)); }

  /// One update; `states` are those of all bodies of the whole team, of which the subteam uses its
  /// own bodies. The solution is in the order of the subteam. Neither throws nor allocates.
  Solution solve(double time, std::span<const double> states) noexcept;

  /// As Solver::set_applied(), in the order of the subteam.
  void set_applied(const AppliedInputs& applied) noexcept { solver_->set_applied(applied); }

  /// Predictions of the own robots under the present plan; `who` refers to the whole team.
  std::span<const Prediction> predictions() const { return predictions_; }
  /// Stores a message; ignores it if the body is unknown here, planned here, or the values are not
  /// finite.
  void receive(const Prediction& prediction) noexcept { receive(prediction, prediction.time); }
  /// As above, with the time of its first Sight by the own clock.
  void receive(const Prediction& prediction, double time) noexcept;
  /// Removes the prediction of a body of the whole team.
  void forget(BodyId who) noexcept;
  /// As receive(prediction), but an empty prediction with h > 0 removes the previous one.
  void set_prediction(const Prediction& prediction) noexcept;

  /// KKT norm of the own robots at the present plan, given the received predictions.
  double kkt(double time, std::span<const double> states) noexcept;
  void planned(double time, std::span<double> u) const noexcept { solver_->planned(time, u); }
  void plan(int k, std::span<double> u) const noexcept { planner_->plan(k, u); }
  void set_plan(int k, std::span<const double> u) noexcept {
    planned_ = true;
    planner_->set_plan(k, u);
  }
  /// Predicts from these states under the present plan, without an update.
  void predict(double time, std::span<const double> states) noexcept;
  void restart() noexcept;

 private:
  int place_of(BodyId who) const noexcept;
  void put(const Prediction& prediction, double time) noexcept;
  void gather(std::span<const double> states) noexcept;
  void roll_out(double time) noexcept;

  const Team whole_;
  std::vector<BodyId> in_whole_;  // per body
  std::vector<int> in_subteam_;   // per body of the whole team; -1: not part of the subteam
  std::unique_ptr<Solver> solver_;
  TeamPlanner* planner_ = nullptr;  // planner of solver_
  bool planned_ = false;
  std::vector<double> x_, u_, rate_, path_, no_input_;
  std::vector<Prediction> predictions_;
  Prediction received_;  // with the subteam's id
};

// Solver of a team in subteams that plan separately and exchange predictions: one solver outside,
// several inside.
//
// An update consists of one or more exchanges. In each, every subteam solves once with the latest
// received trajectories, and sends its own. Jacobi order: all send after all have solved, so they
// can run in parallel. Gauss-Seidel order: each sends immediately, so later subteams use it.
// Trajectories of the last update are extrapolated to the present. With simulated messages each
// subteam sends once per update, and the network delays or drops the message. docs/partition.md

enum class ExchangeOrder : std::uint8_t { jacobi, gauss_seidel };

std::string_view to_string(ExchangeOrder order);
/// @throws std::invalid_argument for an unknown word
ExchangeOrder exchange_order(std::string_view word);

/// Partition: every robot of a team in exactly one subteam.
using Partition = std::vector<std::vector<AgentId>>;

/// A subteam in text form.
struct PartSpec {
  std::string name;  ///< empty: no name
  std::vector<std::string> robots;
};
/// Splits "front: a,b | c,d"; does not check that the robots exist.
/// @throws std::invalid_argument for a repeated name
std::vector<PartSpec> parse_parts(std::string_view text);

/// Reads "a,b | c,d": robots by name, subteams in solving order; a subteam may have a name, "front:
/// a,b".
/// @throws std::invalid_argument naming an unknown robot, a robot named twice or in no subteam, or
///   a subteam without robots
Partition read_partition(std::string_view text, const Team& team);

struct PartitionOptions {
  ExchangeOrder order = ExchangeOrder::gauss_seidel;
  int exchanges = 1;  ///< per update, 1..1000
  /// Messages with delay and loss, as between computers; then one exchange per update, in Jacobi
  /// order. None: predictions arrive immediately.
  std::optional<ExchangeOptions> messages{};
  /// Threads that solve subteams in parallel in Jacobi order, 1..ThreadPool::most; the plan is
  /// independent of their number.
  int threads = 1;
};

/// @throws std::invalid_argument for an option out of its range, or an invalid combination of
///   options
void check_options(const PartitionOptions& options);

class PartitionedSolver : public Solver, public TeamPlanner, public Connectivity {
 public:
  /// @param make  makes the solver of each subteam, and that of the whole team, which evaluates the
  ///   whole plan
  /// @throws std::invalid_argument for an option out of its range, if a robot is not in exactly one
  ///   subteam, or if a solver is no TeamPlanner; and what making a solver throws
  PartitionedSolver(const Team& team, const Partition& partition, const MakeSolver& make,
                    const PartitionOptions& options = {});

  std::string_view name() const override { return "partitioned"; }
  const Ocp& ocp() const override { return whole_->ocp(); }
  /// The residual is that of the whole team's conditions at the new plan. It is computed after the
  /// subteams have finished; `elapsed`, the wall time of all subteams, excludes it.
  Solution solve(double time, std::span<const double> states) noexcept override;
  void set_applied(const AppliedInputs& applied) noexcept override;
  double kkt(double time, std::span<const double> states) noexcept override;
  void planned(double time, std::span<double> u) const noexcept override;
  void restart() noexcept override;
  TeamPlanner* team_planner() noexcept override { return this; }
  const Connectivity* connectivity() const noexcept override { return messages_ ? this : nullptr; }
  bool keeps_apart() const noexcept override { return whole_->keeps_apart(); }

  void plan(int k, std::span<double> u) const noexcept override;
  /// Predictions that subteams received stay in force until the next ones arrive.
  void set_plan(int k, std::span<const double> u) noexcept override;
  void set_prediction(const Prediction& prediction) noexcept override;
  double tolerance() const noexcept override { return whole_planner_->tolerance(); }
  /// Makes every subteam send the prediction of its plan from these states.
  void send_all(double time, std::span<const double> states) noexcept;

  bool receives_from(BodyId robot, BodyId other) const noexcept override;
  bool is_received(BodyId body) const noexcept override;

  int subteams() const { return static_cast<int>(members_.size()); }
  /// Processor time of the slowest subteam in the last update, all exchanges [s]: the update time
  /// with one computer per subteam.
  double slowest() const noexcept;
  /// Processor time of one subteam [s].
  double elapsed(int subteam) const noexcept { return members_[static_cast<std::size_t>(subteam)].elapsed; }

 private:
  struct Member {
    std::unique_ptr<Subteam> subteam;
    mutable std::vector<double> u;      // scratch, in the subteam's order
    std::vector<double> before, u_ref;  // the same
    std::vector<Vec2<double>> lean;     // the same, of each body
    double elapsed = 0.0;               // processor time of the last update [s]
    Solution solution = {};             // of the last exchange
  };

  /// Index of a robot's part; -1: none.
  int part_of(BodyId body) const noexcept { return part_of_[static_cast<std::size_t>(body.index)]; }
  void talk_before(double time, std::span<const double> states) noexcept;
  void receive(int to, double time) noexcept;
  bool accepts(double time, std::span<const double> states) noexcept;
  void exchange(double time, std::span<const double> states) noexcept;
  void send(const Member& sender) noexcept;
  /// Calls of(subteam) for each subteam, in parallel on the thread pool.
  template <class Of>
  void for_each(Of&& of) noexcept;
  /// Calls of(subteam) and measures its processor time.
  template <class Of>
  void timed(int subteam, Of&& of) noexcept;
  void gather(const Subteam& subteam, std::span<const double> of_whole,
              std::span<double> of_subteam) const noexcept;
  void scatter(const Subteam& subteam, std::span<const double> of_subteam,
               std::span<double> of_whole) const noexcept;
  void write_states(std::span<const double> states) noexcept;

  std::unique_ptr<Solver> whole_;  // evaluates the whole plan
  TeamPlanner* whole_planner_;     // planner of whole_
  bool has_plan_ = false;
  PartitionOptions options_;
  std::vector<Member> members_;
  std::vector<int> part_of_;                   // per body
  std::optional<SimulatedMessages> messages_;  // none: predictions arrive immediately
  std::vector<double> x_now_, u_, raw_u_, u_stage_, x_;
  ThreadPool pool_;
};

// The solver that a scenario names.

/// Makes a solver of a team, with options that were read before.
using MakeTeamSolver = std::function<std::unique_ptr<Solver>(const Team&, const Horizon&)>;

/// Name and options of a solver; of one that a program adds, the function that makes it.
struct SolverChoice {
  std::string name = "newton_riccati";
  std::variant<NewtonRiccatiOptions, ContinuationOptions, MakeTeamSolver> options{};
};

}  // namespace sightline
