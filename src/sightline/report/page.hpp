/// Parts of a self-contained HTML page for light and dark modes.
#pragma once

#include <string>
#include <string_view>

#include "sightline/report/figures.hpp"

namespace sightline {

/// Text escaped for a page; characters that XML forbids become spaces.
std::string escaped(std::string_view text);

/// HTML from the doctype to the heading, with the style; `</body></html>` ends the page.
std::string page_head(std::string_view title);

/// A figure below its title.
std::string page_figure(const Figure& figure);

}  // namespace sightline
