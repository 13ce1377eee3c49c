#include "sightline/solvers.hpp"

namespace sightline {

void Cgmres::residuals(Hamiltonian& hamiltonian, const std::vector<double>& x, double* F,
                       Defects& /*none*/) noexcept {
  hamiltonian.roll_out(x.data(), U_, stride(), nullptr, 0.0, X_.data());
  hamiltonian.linearise(X_.data(), U_, stride());
  hamiltonian.costates(X_.data(), nullptr, 0.0, Lambda_.data(), F, stride());
  limit_rows(hamiltonian, U_, F);
}

void Cgmres::advance(double step) noexcept {
  move_unknowns(step);
  here_.roll_out(x_.data(), U_, stride(), nullptr, 0.0, X_.data());
}

}  // namespace sightline
