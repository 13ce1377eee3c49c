/// Parts of a self-contained HTML page for light and dark modes, and for print.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sightline/report.hpp"

namespace sightline {

/// Text escaped for a page; characters that XML forbids become spaces.
std::string escaped(std::string_view text);

/// The script that draws the figures, built from viewer/; empty without esbuild.
std::string_view figures_script();

/// HTML from the doctype to the heading, with the style; states where the figures would be missing.
std::string page_head(std::string_view title);

/// A figure below its title.
std::string page_figure(const Figure& figure);
/// The figures of all drawings with content, as data for the script.
std::string page_figures(std::vector<Drawing> drawings);

/// The script, and the end of the page.
std::string page_end();

}  // namespace sightline
