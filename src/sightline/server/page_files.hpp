/// The page itself, as it was built from viewer/.
#pragma once

#include <span>
#include <string>
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
/// The packages for want of which it was built without, as words; empty where the program carries the page.
std::string_view page_lacks();

/// Its files by their paths, "/" among them; where the program was built without them, a page that says so.
PageFiles page_files();
/// The same of a program that carries `built`, and lacks what `lacks` names where that is empty.
PageFiles page_files(std::span<const BuiltFile> built, std::string_view lacks);
/// Whether the program carries the page.
bool has_page();
/// Why a program has no page, and what brings one: a clause without a full stop.
std::string without_page(std::string_view lacks);

}  // namespace sightline
