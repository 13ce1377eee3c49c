#include <algorithm>

#include "sightline/solvers.hpp"

namespace sightline {

Cmscgmres::Cmscgmres(Ocp ocp, const CmscgmresOptions& options) : Continuation(std::move(ocp), options) {
  G_ = G_soon_ = {X_, X_};
}

void Cmscgmres::residuals(Hamiltonian& hamiltonian, const std::vector<double>& x, double* F,
                          Defects& G) noexcept {
  std::copy(x.begin(), x.end(), X_.begin());
  hamiltonian.linearise(X_.data(), U_, stride());
  const double h = hamiltonian.h();
  double* const G_end = &G.lambda[at(N_, nx_)];
  hamiltonian.terminal_gradient(&X_[at(N_, nx_)], G_end);
  for (int j = 0; j < nx_; ++j) G_end[j] = Lambda_[at(N_, nx_) + at(j, 1)] - G_end[j];
  for (int i = 0; i < N_; ++i) {
    const double *const x_i = &X_[at(i, nx_)], *const lambda = &Lambda_[at(i, nx_)];
    hamiltonian.flow(x_i, U_ + at(i, stride()), rate_.data());
    double* const G_x = &G.x[at(i + 1, nx_)];
    for (int j = 0; j < nx_; ++j) G_x[j] = x_i[nx_ + j] - x_i[j] - h * rate_[at(j, 1)];
    hamiltonian.gradient(i, lambda + nx_, H_z_.data());
    std::copy_n(&H_z_[at(nx_, 1)], nu_, F + at(i, stride()));
    if (i == 0) continue;
    double* const G_lambda = &G.lambda[at(i, nx_)];
    for (int j = 0; j < nx_; ++j) G_lambda[j] = lambda[j] - lambda[nx_ + j] - h * H_z_[at(j, 1)];
  }
  limit_rows(hamiltonian, U_, F);
}

void Cmscgmres::advance(double step) noexcept {
  const double eps = options_.difference_step;
  for (int i = 0; i < unknowns_; ++i) U_trial_[i] = U_[i] + eps * U_dot_[i];
  sweep(U_trial_, G_, 1.0 - options_.zeta * eps);
  move_unknowns(step);
  const double ratio = step / eps;
  for (std::size_t i = at(1, nx_); i < X_.size(); ++i) {
    X_[i] += ratio * (X_trial_[i] - X_[i]);
    Lambda_[i] += ratio * (Lambda_trial_[i] - Lambda_[i]);
  }
  std::copy(x_.begin(), x_.end(), X_.begin());
}

}  // namespace sightline
