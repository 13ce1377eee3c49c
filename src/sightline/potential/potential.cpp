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
  require(mount_turns.hold(mount.yaw), potential, "mount.yaw", mount.yaw, mount_turns.expected("rad"));
  require(mount_turns.hold(mount.roll), potential, "mount.roll", mount.roll, mount_turns.expected("rad"));
  for (const double d : {mount.offset.x, mount.offset.y, mount.offset.z})
    require(mount_offsets.hold(d), potential, "mount.offset", d, mount_offsets.expected("m"));
  require(mount.sigmas >= 0, potential, "mount.sigmas", mount.sigmas, ">= 0");
}

}  // namespace sightline
