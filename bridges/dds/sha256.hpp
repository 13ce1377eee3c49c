/// SHA-256, for the hashes by which ROS 2 knows a type.
#pragma once

#include <string>
#include <string_view>

namespace sightline::dds {

/// The hash of a text, 64 hexadecimal digits in lower case (FIPS 180-4).
std::string sha256(std::string_view text);

}  // namespace sightline::dds
