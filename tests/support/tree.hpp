/// Where the tree is whose files tests read.
#pragma once

#include <filesystem>

namespace sightline::test {

inline const std::filesystem::path tree = SIGHTLINE_SOURCE_DIR;

}  // namespace sightline::test
