/// The solver of the paper, sec. 3: condensed multiple shooting continuation/GMRES (Shimizu,
/// Ohtsuka, Diehl 2009).
///
/// States and costates between the stages are unknowns too; their defects decay with F, dG/dt =
/// -zeta G, (5). Condensing eliminates them, so GMRES solves for the inputs alone. Full update:
/// docs/equations.md, 7.
#pragma once

#include "sightline/solver/continuation/continuation.hpp"

namespace sightline {

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

}  // namespace sightline
