#include "cli/output.hpp"

#include <fmt/format.h>

#include <stdexcept>
#include <system_error>

namespace sightline::cli {

void make_folder(const std::filesystem::path& folder) {
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder)) {
    throw std::invalid_argument(fmt::format("-o {}: {}, expected a folder that can be made", folder.native(),
                                            error ? error.message() : "not a folder"));
  }
}

}  // namespace sightline::cli
