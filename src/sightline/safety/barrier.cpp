#include "sightline/safety/barrier.hpp"

#include <algorithm>
#include <cmath>

namespace sightline {

std::string_view to_string(Wall wall) noexcept {
  constexpr std::array<std::string_view, 7> names = {"none",  "floor", "ceiling", "x_min",
                                                     "x_max", "y_min", "y_max"};
  return names[static_cast<std::size_t>(wall)];
}

Barrier::Barrier(const Model& model, std::span<const double>, std::span<const double>, double dt,
                 const BarrierOptions& options)
    : model_(model), options_(options), dt_(dt) {}

BarrierResult Barrier::filter(std::span<const double>, std::span<const Neighbour>,
                              std::span<const double> u_min, std::span<const double> u_max,
                              std::span<double> u) const noexcept {
  for (std::size_t i = 0; i < u.size(); ++i) u[i] = std::clamp(u[i], u_min[i], u_max[i]);
  return {};
}

double Barrier::reserve(std::span<const double>, const Neighbour& neighbour) const noexcept {
  return -neighbour.d_hard;
}

}  // namespace sightline
