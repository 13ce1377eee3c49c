#include "sightline/server/page_files.hpp"

namespace sightline {
namespace {

constexpr std::string_view no_page =
    "<!doctype html><html lang=\"en\"><meta charset=\"utf-8\"><title>sightline</title>"
    "<p>This sightline was built without its page. Run <code>npm ci --prefix viewer</code> and build again. "
    "The data are at <a href=\"scene.json\">scene.json</a>.</p></html>\n";

}  // namespace

bool has_page() { return !built_page().empty(); }

PageFiles page_files() {
  PageFiles files;
  if (!has_page()) files["/"] = {"text/html; charset=utf-8", std::string(no_page), true};
  for (const BuiltFile& file : built_page())
    files[std::string(file.path)] = {std::string(file.type), std::string(file.body), true};
  return files;
}

}  // namespace sightline
