#include "sightline/potential/potential.hpp"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

namespace sightline {

void require(bool holds, std::string_view potential, std::string_view field, double value,
             std::string_view expected) {
  if (holds && std::isfinite(value)) return;
  throw std::invalid_argument(fmt::format("{}.{} = {}, expected {}", potential, field, value, expected));
}

}  // namespace sightline
