/// The Newton update and the functions of Solver and TeamPlanner, as free functions over the
/// workspace.
#pragma once

#include <memory>
#include <span>

#include "sightline/solver/newton/workspace.hpp"

namespace sightline::newton {

Solution update(Workspace& w, double time, std::span<const double> states) noexcept;
void warm_up(Workspace& w) noexcept;
double kkt(Workspace& w, double time, std::span<const double> states) noexcept;
void planned(const Workspace& w, double time, std::span<double> u) noexcept;
void plan(const Workspace& w, int k, std::span<double> u) noexcept;
void set_plan(Workspace& w, int k, std::span<const double> u) noexcept;
void set_prediction(Workspace& w, const Prediction& prediction) noexcept;
void set_view_uncertainty(Workspace& w, std::span<const ViewUncertainty> of_bodies) noexcept;
void set_applied(Workspace& w, const AppliedInputs& applied) noexcept;
KernelUse kernels(const Workspace& w);
void restart(Workspace& w) noexcept;

}  // namespace sightline::newton
