/// The page itself, as it was built from viewer/.
#pragma once

#include <span>
#include <string_view>

#include "sightline/server/page_server.hpp"

namespace sightline {

/// A file that the build made of viewer/, as bytes of the program.
struct BuiltFile {
  std::string_view path;  ///< "/", "/page.js"
  std::string_view type;
  std::string_view body;
};
/// Empty where it was built without.
std::span<const BuiltFile> built_page();

/// Its files by their paths, "/" among them; where the program was built without them, a page that says so.
PageFiles page_files();
/// Whether the program carries the page.
bool has_page();

}  // namespace sightline
