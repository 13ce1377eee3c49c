/// What was probably meant by a name that is none.
#pragma once

#include <span>
#include <string_view>

namespace sightline {

/// The name of `known`, not empty, with the least edit distance.
std::string_view nearest(std::string_view name, std::span<const std::string_view> known);

}  // namespace sightline
