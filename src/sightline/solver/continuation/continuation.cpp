#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>

#include "sightline/base.hpp"
#include "sightline/solvers.hpp"

namespace sightline {
namespace {

/// Rejects rate costs: the unknowns of one stage do not include the inputs of the previous stage.
Ocp without_rate_costs(Ocp ocp) {
  for (const Agent &agent : ocp.team().agents()) {
    if (agent.R_rate.empty()) continue;
    throw std::invalid_argument(fmt::format(
        "{} has a cost of its inputs' rates, R_rate, expected the solver newton_riccati, which plans with it",
        agent.name));
  }
  return ocp;
}

/// Rejects weights that change over time: the tracked root requires a fixed problem.
Ocp with_steady_weights(Ocp ocp) {
  const auto moves = [](const auto &term) { return term.ramp != Ramp{}; };
  const Team &team = ocp.team();
  if (std::any_of(team.couplings().begin(), team.couplings().end(), moves) ||
      std::any_of(team.constraints().begin(), team.constraints().end(), moves)) {
    throw std::invalid_argument(
        "a weight of the team moves over time, expected the solver newton_riccati, which can follow it");
  }
  return ocp;
}

/// Largest |v|; infinity if a value is not finite.
double largest(std::span<const double> values) noexcept {
  double m = 0.0, not_finite = 0.0;
  for (const double v : values) {
    m = std::max(m, std::fabs(v));
    not_finite += 0.0 * v;
  }
  return not_finite == 0.0 ? m : infinity;
}

}  // namespace

Continuation::Continuation(Ocp ocp, const ContinuationOptions &options)
    : ocp_(without_rate_costs(with_steady_weights(std::move(ocp)))),
      options_(check_parameters(options, "solver")),
      N_(ocp_.horizon().N),
      nx_(ocp_.nx()),
      nu_(ocp_.nu()),
      unknowns_(N_ * 3 * nu_),
      here_(ocp_),
      there_(ocp_),
      x_(at(1, nx_)),
      x_soon_(x_),
      rate_(x_),
      gmres_(unknowns_, options_.k_max),
      vectors_(7, gmres_.length()),
      U_(vectors_[0]),
      U_dot_(vectors_[1]),
      F_(vectors_[2]),
      F_there_(vectors_[3]),
      b_(vectors_[4]),
      U_trial_(vectors_[5]),
      F_soon_(vectors_[6]),
      X_(at(N_ + 1, nx_)),
      Lambda_(X_),
      X_trial_(X_),
      Lambda_trial_(X_),
      H_z_(at(1, nx_ + nu_)),
      u_(at(1, nu_)),
      raw_u_(u_),
      x_out_(X_),
      plan_(at(N_, nu_)) {
  for (const Agent &agent : ocp_.team().agents()) {
    const std::vector<double> scales = input_scales(agent);
    scales_.insert(scales_.end(), scales.begin(), scales.end());
  }
}

double Continuation::stage_length(double t) const noexcept {
  return ocp_.horizon().h() * (1.0 - exp(-options_.alpha * (t - started_at_)));
}

bool Continuation::accept(std::span<const double> states) noexcept {
  if (static_cast<int>(states.size()) != nx_) return false;
  std::copy(states.begin(), states.end(), x_.begin());
  const Team &team = ocp_.team();
  for (int i = 0; i < team.bodies(); ++i) {
    if (!team.model(BodyId{i}).normalise(&x_[at(team.state_offset(BodyId{i}), 1)])) return false;
  }
  return true;
}

/// The horizon is empty at the start: F = 0 is one scalar equation per input, monotonically
/// increasing in u between the limits.
void Continuation::start(double time) noexcept {
  started_at_ = last_time_ = time;
  here_.set_time(time, 0.0, x_.data());
  std::fill_n(U_, gmres_.length(), 0.0);
  std::fill_n(U_dot_, gmres_.length(), 0.0);
  for (int i = 0; i <= N_; ++i) std::copy(x_.begin(), x_.end(), &X_[at(i, nx_)]);
  for (int i = 0; i <= N_; ++i) here_.terminal_gradient(x_.data(), &Lambda_[at(i, nx_)]);
  for (int i = 0; i < N_; ++i) {
    for (int j = 0; j < nu_; ++j)
      U_[at(i, stride()) + at(j, 1)] = 0.5 * (here_.u_min(i)[j] + here_.u_max(i)[j]);
  }
  here_.linearise(X_.data(), U_, stride());
  const double k = options_.slack_weight;
  for (int i = 0; i < N_; ++i) {
    here_.gradient(i, Lambda_.data(), H_z_.data());
    int j = 0;
    for (const Agent &agent : ocp_.team().agents()) {
      for (const double R : agent.R) {
        const double r = 0.5 * (here_.u_max(i)[j] - here_.u_min(i)[j]);
        const double H_u = H_z_[at(nx_ + j, 1)];
        double low = -1.0, high = 1.0;  // y = (u - m) / r
        for (int bisection = 0; bisection < 60; ++bisection) {
          const double y = 0.5 * (low + high);
          const double slope = H_u + 2.0 * R * r * y + k / (std::sqrt(2.0) * r) * y / std::sqrt(1.0 - y * y);
          (slope < 0 ? low : high) = y;
        }
        const double y = 0.5 * (low + high), s = std::sqrt(0.5 * (1.0 - y * y));
        double *const unknown = U_ + at(i, stride()) + at(j, 1);
        unknown[0] += r * y;
        unknown[nu_] = k / (2.0 * s);
        unknown[2 * nu_] = s;
        ++j;
      }
    }
  }
  started_ = true;
}

void Continuation::restart() noexcept {
  started_ = false;
  std::fill(plan_.begin(), plan_.end(), 0.0);
  plan_time_ = plan_h_ = 0.0;
}

void Continuation::set_applied(const AppliedInputs &applied) noexcept {
  if (applied.offset.size() != u_.size()) return;
  here_.set_added(applied.offset);
  there_.set_added(applied.offset);
  if (applied.u_ref.size() != u_.size()) return;
  here_.set_u_ref(applied.u_ref);
  there_.set_u_ref(applied.u_ref);
}

void Continuation::limit_rows(const Hamiltonian &hamiltonian, const double *U, double *F) const noexcept {
  for (int i = 0; i < N_; ++i) {
    const double *const u = U + at(i, stride()), *const mu = u + nu_, *const s = mu + nu_;
    double *const F_u = F + at(i, stride()), *const F_mu = F_u + nu_, *const F_s = F_mu + nu_;
    const double *const low = hamiltonian.u_min(i), *const high = hamiltonian.u_max(i);
    for (int j = 0; j < nu_; ++j) {
      const double m = 0.5 * (low[j] + high[j]), r = 0.5 * (high[j] - low[j]), y = (u[j] - m) / r;
      F_u[j] += mu[j] * y / r;
      F_mu[j] = 0.5 * (y * y - 1.0) + s[j] * s[j];
      F_s[j] = 2.0 * mu[j] * s[j] - options_.slack_weight;
    }
  }
}

void Continuation::sweep(const double *U, const Defects &G, double scale) noexcept {
  const bool any = !G.x.empty();
  there_.roll_out(x_soon_.data(), U, stride(), any ? G.x.data() : nullptr, scale, X_trial_.data());
  there_.linearise(X_trial_.data(), U, stride());
  there_.costates(X_trial_.data(), any ? G.lambda.data() : nullptr, scale, Lambda_trial_.data(), F_there_,
                  stride());
  limit_rows(there_, U, F_there_);
}

void Continuation::product(const double *v, double *out) noexcept {
  here_.tangent(v, out, stride());
  for (int i = 0; i < N_; ++i) {
    const double *const u = U_ + at(i, stride()), *const mu = u + nu_, *const s = mu + nu_;
    const double *const du = v + at(i, stride()), *const dmu = du + nu_, *const ds = dmu + nu_;
    double *const d_u = out + at(i, stride()), *const d_mu = d_u + nu_, *const d_s = d_mu + nu_;
    const double *const low = here_.u_min(i), *const high = here_.u_max(i);
    for (int j = 0; j < nu_; ++j) {
      const double m = 0.5 * (low[j] + high[j]), r = 0.5 * (high[j] - low[j]);
      const double slope = (u[j] - m) / (r * r);
      d_u[j] += mu[j] / (r * r) * du[j] + slope * dmu[j];
      d_mu[j] = slope * du[j] + 2.0 * s[j] * ds[j];
      d_s[j] = 2.0 * (s[j] * dmu[j] + mu[j] * ds[j]);
    }
  }
}

/// The paper's product: (F(U + eps v, ...) - F(U, X, ...)) / eps, both one difference step later.
void Continuation::difference_product(const double *v, double *out) noexcept {
  const double eps = options_.difference_step;
  for (int i = 0; i < unknowns_; ++i) U_trial_[i] = U_[i] + eps * v[i];
  sweep(U_trial_, G_soon_, 1.0);
  for (int i = 0; i < unknowns_; ++i) out[i] = (F_there_[i] - F_soon_[i]) / eps;
}

void Continuation::move_unknowns(double step) noexcept {
  for (int i = 0; i < unknowns_; ++i) U_[i] += step * U_dot_[i];
}

/// Whether the iterate is near the solution curve: multipliers positive, inputs within one range of
/// their limits.
bool Continuation::limits_hold() const noexcept {
  for (int i = 0; i < N_; ++i) {
    const double *const u = U_ + at(i, stride()), *const mu = u + nu_;
    const double *const low = here_.u_min(i), *const high = here_.u_max(i);
    for (int j = 0; j < nu_; ++j) {
      const double range = high[j] - low[j];
      if (!(mu[j] > 0 && u[j] >= low[j] - range && u[j] <= high[j] + range)) return false;
    }
  }
  return true;
}

void Continuation::clamp_inputs(std::span<const double> u) noexcept {
  for (int j = 0; j < nu_; ++j) {
    raw_u_[at(j, 1)] = u[at(j, 1)];
    u_[at(j, 1)] = clamp(u[at(j, 1)], here_.u_min(0)[j], here_.u_max(0)[j]);
  }
}

void Continuation::keep_plan(double time) noexcept {
  for (int i = 0; i < N_; ++i) std::copy_n(U_ + at(i, stride()), nu_, &plan_[at(i, nu_)]);
  plan_time_ = time;
  plan_h_ = here_.h();
}

void Continuation::planned(double time, std::span<double> u) const noexcept {
  if (u.size() != u_.size()) return;
  const double stages = plan_h_ > 0 ? (time - plan_time_) / plan_h_ : 0.0;
  const int i = static_cast<int>(clamp(std::isfinite(stages) ? stages : 0.0, 0.0, N_ - 1.0));
  std::copy_n(&plan_[at(i, nu_)], nu_, u.begin());
}

/// Returns the last good plan's input at this time, clamped to the limits; zero without a plan.
Solution Continuation::fall_back(double time, Status status) noexcept {
  here_.set_time(std::isfinite(time) ? time : plan_time_, 0.0);
  planned(time, raw_u_);
  clamp_inputs(raw_u_);
  return {.u = u_, .raw_u = raw_u_, .x = {}, .status = status};
}

Solution Continuation::solve(double time, std::span<const double> states) noexcept {
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  const auto since_begin = [&] { return std::chrono::duration<double>(Clock::now() - begin).count(); };
  const FlushSubnormals guard;
  const auto failed = [&](Status status) {
    Solution s = fall_back(time, status);
    s.elapsed = since_begin();
    return s;
  };
  if (!std::isfinite(time) || !accept(states)) return failed(Status::invalid_state);

  // A step longer than 1/zeta would overshoot; a time that goes back requires a restart.
  const double wanted = started_ && time > last_time_ ? time - last_time_ : ocp_.horizon().dt;
  const double step = std::min(wanted, 1.0 / options_.zeta);
  if (!started_ || time < last_time_) start(time);
  last_time_ = time;

  const double eps = options_.difference_step, decay = 1.0 - options_.zeta * eps;
  here_.set_time(time, stage_length(time), x_.data());
  residuals(here_, x_, F_, G_);
  std::copy(X_.begin(), X_.end(), x_out_.begin());
  const double residual = std::max({largest({F_, at(unknowns_, 1)}), largest(G_.x), largest(G_.lambda)});

  // b from a difference step along x' = f(x, u_0).
  here_.flow(x_.data(), U_, rate_.data());
  for (int j = 0; j < nx_; ++j) x_soon_[at(j, 1)] = x_[at(j, 1)] + eps * rate_[at(j, 1)];
  there_.set_time(time + eps, stage_length(time + eps), x_soon_.data());
  sweep(U_, G_, decay);
  for (int i = 0; i < unknowns_; ++i) b_[i] = (decay * F_[i] - F_there_[i]) / eps;

  Gmres::Outcome outcome;
  if (options_.jacobian == JacobianProduct::exact) {
    here_.second_order(Lambda_.data());
    outcome = gmres_.solve([this](const double *v, double *out) { product(v, out); }, b_, U_dot_,
                           options_.gmres_tolerance);
  } else {
    residuals(there_, x_soon_, F_soon_, G_soon_);
    outcome = gmres_.solve([this](const double *v, double *out) { difference_product(v, out); }, b_, U_dot_,
                           options_.gmres_tolerance);
  }
  advance(step);
  if (!all_finite({U_, at(unknowns_, 1)}) || !all_finite(X_) || !all_finite(Lambda_)) {
    started_ = false;
    return failed(Status::not_finite);
  }

  clamp_inputs({U_, at(nu_, 1)});
  keep_plan(time);
  if (!limits_hold()) started_ = false;
  const Status status = residual <= options_.tolerance ? Status::converged
                        : started_ && step >= wanted   ? Status::stepped
                                                       : Status::iteration_limit;
  return {.u = u_,
          .raw_u = raw_u_,
          .x = x_out_,
          .status = status,
          .residual = residual,
          .iterations = outcome.iterations,
          .elapsed = since_begin()};
}

double Continuation::kkt(double time, std::span<const double> states) noexcept {
  if (!std::isfinite(time) || !accept(states)) return infinity;
  there_.set_time(time, stage_length(time), x_.data());
  there_.roll_out(x_.data(), U_, stride(), nullptr, 0.0, X_trial_.data());
  there_.linearise(X_trial_.data(), U_, stride());
  there_.costates(X_trial_.data(), nullptr, 0.0, Lambda_trial_.data(), F_there_, stride());
  double worst = 0.0, not_finite = 0.0;
  for (int i = 0; i < N_; ++i) {
    for (int j = 0; j < nu_; ++j) {
      const double u = U_[at(i, stride()) + at(j, 1)], H_u = F_there_[at(i, stride()) + at(j, 1)];
      const double s = scales_[at(j, 1)];
      const double gap = u - clamp(u - H_u * (s * s), there_.u_min(i)[j], there_.u_max(i)[j]);
      worst = std::max(worst, std::fabs(gap) / s);
      not_finite += 0.0 * H_u;
    }
  }
  return not_finite == 0.0 ? worst : infinity;
}

}  // namespace sightline
