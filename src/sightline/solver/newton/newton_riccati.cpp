#include "sightline/solver/newton/newton_riccati.hpp"

#include "sightline/solver/newton/newton_update.hpp"

namespace sightline {

NewtonRiccati::NewtonRiccati(Ocp ocp, const NewtonRiccatiOptions& options)
    : update_(std::make_unique<NewtonUpdate>(std::move(ocp), options)) {}
NewtonRiccati::NewtonRiccati(NewtonRiccati&& other) noexcept = default;
NewtonRiccati& NewtonRiccati::operator=(NewtonRiccati&& other) noexcept = default;
NewtonRiccati::~NewtonRiccati() = default;

const Ocp& NewtonRiccati::ocp() const { return update_->ocp(); }

Solution NewtonRiccati::solve(double time, std::span<const double> states) noexcept {
  return update_->solve(time, states);
}

double NewtonRiccati::kkt(double time, std::span<const double> states) noexcept {
  return update_->kkt(time, states);
}

void NewtonRiccati::planned(double time, std::span<double> u) const noexcept { update_->planned(time, u); }

KernelUse NewtonRiccati::kernels() const { return update_->kernels(); }

void NewtonRiccati::restart() noexcept { update_->restart(); }

void NewtonRiccati::set_applied(const AppliedInputs& applied) noexcept { update_->set_applied(applied); }
void NewtonRiccati::set_view_uncertainty(std::span<const ViewUncertainty> of_bodies) noexcept {
  update_->set_view_uncertainty(of_bodies);
}

void NewtonRiccati::plan(int k, std::span<double> u) const noexcept { update_->plan(k, u); }

void NewtonRiccati::set_plan(int k, std::span<const double> u) noexcept { update_->set_plan(k, u); }

void NewtonRiccati::set_prediction(const Prediction& prediction) noexcept {
  update_->set_prediction(prediction);
}

double NewtonRiccati::tolerance() const noexcept { return update_->tolerance(); }

}  // namespace sightline
