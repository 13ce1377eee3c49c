/// Files of recordings, plain or packed by gzip or zstd.
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>

namespace sightline {

/// Upper bound on the unpacked bytes of one file.
inline constexpr std::size_t packed_file_max = std::size_t{1} << 30;

/// Reads a file; unpacks it if it is in the format of gzip or zstd.
/// @throws std::invalid_argument naming the file, if it is no regular file, cannot be read, or is
///   damaged or too long
std::string read_packed_file(const std::filesystem::path& file);

/// The beginning of a file, unpacked.
struct FileHead {
  std::string bytes;
  std::string_view packed_by{};  ///< "gzip", "zstd", or empty
};

/// Reads at most `size` bytes; what is damaged or cannot be read gives fewer.
FileHead read_head(const std::filesystem::path& file, std::size_t size);

/// The same as read_packed_file() for bytes of a file that may be packed by zstd.
/// @param file  name for messages
/// @throws std::invalid_argument if they are damaged, or unpacked too long
std::string unpacked(std::string bytes, const std::string& file);

}  // namespace sightline
