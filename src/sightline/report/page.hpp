/// The parts of a self-contained HTML page that reads on light and on dark.
#pragma once

#include <string>
#include <string_view>

#include "sightline/report/figures.hpp"

namespace sightline {

/// Text as it stands in a page; what XML knows no character for is a space.
std::string escaped(std::string_view text);

/// From the doctype to the heading, with the style; the page ends by `</body></html>`.
std::string page_head(std::string_view title);

/// A figure below its title.
std::string page_figure(const Figure& figure);

}  // namespace sightline
