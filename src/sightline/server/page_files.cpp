#include "sightline/server/page_files.hpp"

#include <fmt/format.h>

namespace sightline {

bool has_page() { return !built_page().empty(); }

std::string without_page(std::string_view lacks) {
  return fmt::format("built without its page, for want of {}; scripts/deps.sh demo installs what it needs",
                     lacks);
}

PageFiles page_files() { return page_files(built_page(), page_lacks()); }

PageFiles page_files(std::span<const BuiltFile> built, std::string_view lacks) {
  PageFiles files;
  if (built.empty())
    files["/"] = {
        "text/html; charset=utf-8",
        fmt::format("<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><title>sightline</title>"
                    "<p>This sightline was {}. Then build again. "
                    "The data are at <a href=\"scene.json\">scene.json</a>.</p></html>\n",
                    without_page(lacks)),
        true};
  for (const BuiltFile& file : built)
    files[std::string(file.path)] = {std::string(file.type), std::string(file.body), true};
  return files;
}

}  // namespace sightline
