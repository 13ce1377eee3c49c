#include "sightline/potential.hpp"

#include <fmt/format.h>

#include <cmath>
#include <stdexcept>

namespace sightline {

void require(bool holds, std::string_view potential, std::string_view field, double value,
             std::string_view expected) {
  if (holds && std::isfinite(value)) return;
  throw std::invalid_argument(fmt::format("{}.{} = {}, expected {}", potential, field, value, expected));
}

void check_mount(std::string_view potential, const SensorMount& mount) {
  require(mount_pitches.hold(mount.pitch), potential, "mount.pitch", mount.pitch,
          mount_pitches.expected("rad"));
  require(std::isfinite(mount.offset), potential, "mount.offset", mount.offset, "a finite length, m");
  require(mount.sigmas >= 0, potential, "mount.sigmas", mount.sigmas, ">= 0");
}

}  // namespace sightline
