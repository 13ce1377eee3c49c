/// Curves, maps and surfaces as pictures for a page, drawn by gnuplot.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sightline/report/palette.hpp"

namespace sightline {

/// What a picture shows, in its own words: panels in rows, one above the other.
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
  /// z over places in the plane.
  struct Grid {
    enum class View {
      map,      ///< z as a colour; curves lie on top
      surface,  ///< z as a height, in perspective
      cloud,    ///< points in space, in perspective; curves lie in the plane z = 0
    };

    View view{};
    std::size_t across{};               ///< points of a row, all of one y; of a cloud any
    std::vector<double> x{}, y{}, z{};  ///< of one length, row by row; none: no grid
    std::string label{};                ///< of z
  };
  /// Words at a place.
  struct Note {
    double x{}, y{};
    std::string text;
  };
  /// A vertical line across a panel, and what stands at its upper end.
  struct TimeMark {
    double x{};
    std::string text{};
  };
  struct Panel {
    std::string x_label;  ///< empty: the x axis is that of a panel below
    std::string y_label;
    std::vector<Curve> curves{};
    int height = 140;  ///< of the axes [px]
    bool log_x = false, log_y = false;
    bool equal_scales = false;  ///< a metre along x is as long as along y
    std::string title{};        ///< above the panel
    Grid grid{};
    std::optional<std::array<double, 2>> x_range{}, y_range{};  ///< low and high; none: as the curves ask for
    std::vector<Note> labels{};
    std::vector<TimeMark> moments{};
    std::vector<std::string> y_names{};  ///< of y = 0, 1, ..., in place of the numbers
  };

  static constexpr std::size_t colours = palette_robots;  ///< that tell curves apart
  static constexpr std::size_t limit_colour = 6, faint_colour = 7;

  std::string title, caption;  ///< plain text
  std::vector<Panel> panels{};
  int columns = 1;  ///< panels side by side
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
/// @param first  number of the first picture of its page, for the pictures of which ids differ
/// @throws std::runtime_error with a sentence where gnuplot is missing or fails
std::vector<Figure> draw(std::vector<Drawing> drawings, std::size_t first = 0);

}  // namespace sightline
