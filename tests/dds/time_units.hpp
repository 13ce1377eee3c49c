/// Units of times on a wire.
#pragma once

#include "bridges/dds/topics/conversion.hpp"

namespace sightline::dds {

constexpr Nanoseconds ms = 1'000'000, second = 1000 * ms;

}  // namespace sightline::dds
