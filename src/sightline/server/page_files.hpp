/// Files of the page, as built from viewer/.
#pragma once

#include <span>
#include <string>
#include <string_view>

#include "sightline/server/page_server.hpp"

namespace sightline {

/// A file that the build produced from viewer/, embedded in the program.
struct BuiltFile {
  std::string_view path;  ///< "/", "/page.js"
  std::string_view type;
  std::string_view body;
};
/// Empty if the program was built without the page.
std::span<const BuiltFile> built_page();
/// Missing packages that prevented the build of the page, as text; empty if the program contains
/// it.
std::string_view page_lacks();

/// Files of the page by path, including "/". A program without the page serves a page that states
/// the reason.
PageFiles page_files();
/// The same for a program with the files `built`; if these are empty, `lacks` names the missing
/// packages.
PageFiles page_files(std::span<const BuiltFile> built, std::string_view lacks);
/// Whether the program contains the page.
bool has_page();
/// Why a program has no page, and how to build it: a clause without a full stop.
std::string without_page(std::string_view lacks);

}  // namespace sightline
