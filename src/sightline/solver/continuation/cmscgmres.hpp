/// The paper's solver: condensed multiple shooting continuation/GMRES (Shimizu, Ohtsuka, Diehl 2009),
/// section 3.
///
/// The states and costates between the stages are unknowns too, whose defects decay with F, dG/dt = -zeta G,
/// (5); they are condensed, so GMRES sees the inputs alone. docs/equations.md, 7 has the update in full.
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
