/// Where a command leaves its files.
#pragma once

#include <filesystem>

namespace sightline::cli {

/// Makes the folder given by -o.
/// @throws std::invalid_argument where that cannot be
void make_folder(const std::filesystem::path& folder);

}  // namespace sightline::cli
