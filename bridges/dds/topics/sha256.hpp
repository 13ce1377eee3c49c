/// SHA-256, for ROS 2 type hashes.
#pragma once

#include <string>
#include <string_view>

namespace sightline::dds {

/// Hash of a text: 64 lower-case hexadecimal digits (FIPS 180-4).
std::string sha256(std::string_view text);

}  // namespace sightline::dds
