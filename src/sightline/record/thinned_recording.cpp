#include "sightline/record/thinned_recording.hpp"

#include <algorithm>
#include <fstream>
#include <string>
#include <system_error>
#include <vector>

namespace sightline {
namespace {

/// Rows of timing.csv; 0 if it cannot be read.
std::size_t periods_timed(const std::filesystem::path& folder) {
  std::error_code ignored;
  const std::filesystem::path path = folder / "timing.csv";
  if (!std::filesystem::is_regular_file(path, ignored)) return 0;
  std::ifstream file(path, std::ios::binary);
  std::vector<char> piece(64 << 10);
  std::size_t lines = 0;
  while (file.read(piece.data(), static_cast<std::streamsize>(piece.size())) || file.gcount() > 0)
    lines += static_cast<std::size_t>(std::count(piece.begin(), piece.begin() + file.gcount(), '\n'));
  return lines - std::min<std::size_t>(lines, 1);  // header line
}

}  // namespace

Recording read_thinned_recording(const std::filesystem::path& folder, std::size_t rows_max) {
  const std::size_t periods = periods_timed(folder);
  if (periods <= rows_max) return read_recording(folder);
  const std::size_t rows = std::max<std::size_t>(1, rows_max / 5 * 4);
  return read_recording(folder, {}, (periods + rows - 1) / rows);
}

}  // namespace sightline
