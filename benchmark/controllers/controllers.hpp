/// The controllers of the benchmark as solvers that scenarios name: cbf_qp, visual_servo, pampc, cbf_mpc, process.
#pragma once

#include <string>

#include "sightline/registry.hpp"

namespace sightline::benchmark {

/// Adds them.
/// @param command  of the solver `process`, for a shell; empty: scenarios with that solver are refused
void add_controllers(Registry& registry, const std::string& command);

}  // namespace sightline::benchmark
