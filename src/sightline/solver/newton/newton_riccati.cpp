#include "sightline/solver/newton/update.hpp"
#include "sightline/solvers.hpp"

namespace sightline {

NewtonRiccati::NewtonRiccati(Ocp ocp, const NewtonRiccatiOptions& options)
    : workspace_(std::make_unique<newton::Workspace>(std::move(ocp), options)) {}
NewtonRiccati::NewtonRiccati(NewtonRiccati&& other) noexcept = default;
NewtonRiccati& NewtonRiccati::operator=(NewtonRiccati&& other) noexcept = default;
NewtonRiccati::~NewtonRiccati() = default;

const Ocp& NewtonRiccati::ocp() const { return workspace_->ocp; }

Solution NewtonRiccati::solve(double time, std::span<const double> states) noexcept {
  return newton::update(*workspace_, time, states);
}

void NewtonRiccati::warm_up() noexcept { newton::warm_up(*workspace_); }

double NewtonRiccati::kkt(double time, std::span<const double> states) noexcept {
  return newton::kkt(*workspace_, time, states);
}

void NewtonRiccati::planned(double time, std::span<double> u) const noexcept {
  newton::planned(*workspace_, time, u);
}

KernelUse NewtonRiccati::kernels() const { return newton::kernels(*workspace_); }

void NewtonRiccati::restart() noexcept { newton::restart(*workspace_); }

void NewtonRiccati::set_applied(const AppliedInputs& applied) noexcept {
  newton::set_applied(*workspace_, applied);
}
void NewtonRiccati::set_view_uncertainty(std::span<const ViewUncertainty> of_bodies) noexcept {
  newton::set_view_uncertainty(*workspace_, of_bodies);
}

void NewtonRiccati::plan(int k, std::span<double> u) const noexcept { newton::plan(*workspace_, k, u); }

void NewtonRiccati::set_plan(int k, std::span<const double> u) noexcept {
  newton::set_plan(*workspace_, k, u);
}

void NewtonRiccati::set_prediction(const Prediction& prediction) noexcept {
  newton::set_prediction(*workspace_, prediction);
}

double NewtonRiccati::tolerance() const noexcept { return workspace_->options.tolerance; }

}  // namespace sightline
