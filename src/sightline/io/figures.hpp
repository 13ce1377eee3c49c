/// Curves as pictures for a page, drawn by gnuplot.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace sightline {

/// What a picture shows, in its own words: panels one above the other.
struct Drawing {
  enum class Mark {
    line,
    dashed,
    thin,
    points,
    bars,    ///< from 0 up to y, from each x to the next
    arrows,  ///< two rows for each, its tail and its head
  };
  struct Curve {
    std::string title;     ///< empty: not in the legend
    std::size_t colour{};  ///< below colours, or one of those with a name
    Mark mark{};
    std::vector<double> x{}, y{};  ///< of one length; what is not finite is a gap
  };
  struct Panel {
    std::string x_label;  ///< empty: the x axis is that of a panel below
    std::string y_label;
    std::vector<Curve> curves{};
    int height = 140;  ///< of the axes [px]
    bool log_x = false, log_y = false;
    bool equal_scales = false;  ///< a metre along x is as long as along y
  };

  static constexpr std::size_t colours = 6;  ///< that tell curves apart
  static constexpr std::size_t limit_colour = 6, faint_colour = 7;

  std::string title, caption;  ///< plain text
  std::vector<Panel> panels{};
};

/// A drawing to stand in a page; text and axes take the page's colour, so that it reads on light and on dark.
struct Figure {
  std::string title, caption;  ///< plain text
  std::string svg;             ///< one <svg> element
};

/// Rows to draw of a curve, rising, at most `most` of them: all, or else the first, the last and the extremes
/// of each column in stretches of equal length. A stretch without a finite number stays as a gap.
/// @param columns  of equal length
/// @param most     >= 2 + 2 columns
std::vector<std::size_t> rows_to_draw(std::span<const std::span<const double>> columns, std::size_t most);

/// The pictures of all drawings that have something to show; curves and panels without a point are left out.
/// @throws std::runtime_error with a sentence where gnuplot is missing or fails
std::vector<Figure> draw(std::vector<Drawing> drawings);

}  // namespace sightline
