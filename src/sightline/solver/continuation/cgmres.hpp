/// Single-shooting continuation/GMRES (Ohtsuka 2004): the unknowns are the inputs alone.
///
/// Each update rolls out states and costates from the measured state, so the dynamics hold exactly.
/// The defects that CMSCGMRES lets decay enter F directly. docs/equations.md, 7.5.
#pragma once

#include "sightline/solver/continuation/continuation.hpp"

namespace sightline {

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

}  // namespace sightline
