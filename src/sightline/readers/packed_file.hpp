/// Files of recordings, plain or packed by gzip or zstd.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

namespace sightline {

/// Upper bound on the unpacked bytes of one file.
inline constexpr std::size_t packed_file_max = std::size_t{1} << 30;

/// Reads a file; unpacks it if it is in the format of gzip or zstd.
/// @throws std::invalid_argument naming the file, if it is no regular file, cannot be read, or is
///   damaged or too long
std::string read_packed_file(const std::filesystem::path& file);

/// The same for bytes of a file that may be packed by zstd.
/// @param file  name for messages
/// @throws std::invalid_argument if they are damaged, or unpacked too long
std::string unpacked(std::string bytes, const std::string& file);

}  // namespace sightline
