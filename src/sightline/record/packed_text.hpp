/// Text files of measurement tables, plain or packed by gzip.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

namespace sightline {

/// Upper bound on the unpacked text of one file [bytes].
inline constexpr std::size_t packed_text_max = std::size_t{256} << 20;

/// Reads a file; unpacks it if it is in gzip's format.
/// @throws std::invalid_argument naming the file, if it is no regular file, cannot be read, or is
///   damaged or too long
std::string read_packed_text(const std::filesystem::path& file);

}  // namespace sightline
