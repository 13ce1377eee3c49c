/// Figures and report.html of a run.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/log.hpp"

namespace sightline {

// Colours of all figures: of pages and of other views of a flight.

inline constexpr std::size_t palette_robots = 6;  ///< used in turn, cyclically
inline constexpr std::array<std::string_view, palette_robots + 2> palette = {
    "#3b82d6", "#e07b1a", "#2a9d5c", "#a05cd0", "#d64a8b", "#1aa3b5", "#d8322f", "#8a8f98"};
inline constexpr std::string_view palette_green = palette[2], palette_red = palette[palette_robots],
                                  palette_grey = palette[palette_robots + 1];

// Curves, maps and surfaces as figures of a page: data that its script, viewer/src/figures.js,
// draws.

/// Content of a figure: panels in rows, one above the other.
struct Drawing {
  enum class Mark {
    line,
    dashed,
    thin,
    points,
    bars,    ///< from 0 to y, from each x to the next
    arrows,  ///< two rows each, tail and head
  };
  struct Curve {
    std::string title;     ///< empty: not in the legend
    std::size_t colour{};  ///< index below `colours`, or a named one
    Mark mark{};
    std::vector<double> x{}, y{};  ///< of equal length; a value that is not finite is a gap
  };
  /// z over points of a plane.
  struct Grid {
    enum class View {
      map,      ///< z as colour, below the curves
      surface,  ///< z as height, in perspective
      cloud,    ///< points in space, in perspective; the curves are in the plane z = 0
    };

    View view{};
    std::size_t across{};               ///< points per row of equal y; unused by a cloud
    std::vector<double> x{}, y{}, z{};  ///< of equal length, row by row; empty: no grid
    std::string label{};                ///< of z
  };
  /// Text at a position.
  struct Note {
    double x{}, y{};
    std::string text;
  };
  /// A vertical line across a panel, with a text at its upper end.
  struct TimeMark {
    double x{};
    std::string text{};
  };
  struct Panel {
    std::string x_label;  ///< empty: the panel shares the x axis of a panel below
    std::string y_label;
    std::vector<Curve> curves{};
    int height = 140;  ///< of the axes [px]
    bool log_x = false, log_y = false;
    bool equal_scales = false;  ///< equal lengths along x and y
    std::string title{};        ///< above the panel
    Grid grid{};
    std::optional<std::array<double, 2>> x_range{}, y_range{};  ///< low and high; none: the range
                                                                ///< of the curves
    std::vector<Note> labels{};
    std::vector<TimeMark> moments{};
    std::vector<std::string> y_names{};  ///< labels of y = 0, 1, ..., instead of the numbers
  };

  static constexpr std::size_t colours = palette_robots;  ///< distinct colours of curves
  static constexpr std::size_t limit_colour = 6, faint_colour = 7;

  std::string title, caption;  ///< plain text
  std::vector<Panel> panels{};
  int columns = 1;  ///< panels side by side
};

/// A picture that is drawn here. Text takes the page's colour, for light and dark pages.
struct Figure {
  std::string title, caption;  ///< plain text
  std::string svg;             ///< one <svg> element
};

/// Indices of the rows of a curve to draw, ascending, at most `most`: all rows; or the first, the
/// last, and each column's extremes in intervals of equal length. An interval without finite values
/// keeps a gap.
/// @param columns  of equal length
/// @param most  >= 2 + 2 columns
std::vector<std::size_t> rows_to_draw(std::span<const std::span<const double>> columns, std::size_t most);

/// Replaces values that an axis cannot show by gaps; removes curves, panels and drawings without a
/// point.
void prune(std::vector<Drawing>& drawings);

/// A pruned drawing as JSON, safe within an element of HTML: columns, and for each panel its axes,
/// curves, grid, notes and moments. A gap is null; a grid with rows has the x of one row and the y
/// of one column.
std::string to_json(const Drawing& drawing);

// report.html: one page about a run, from the run's files only.

/// Figures of a run, after Figs 4, 6, 19, 20 and 24 of the paper: distance and view angle of each
/// pair, least distances, paths from above and from the side, positions, headings, inputs, the
/// solver's record and the computation time. A curve has at most 2000 points.
std::vector<Drawing> drawings_of(const Recording& recording);

/// The page with all its figures; it loads no other file.
/// @param summary  text of summary.json; empty: missing, as for a run that was killed
/// @param partition  text of partition.json, of a partitioned team; ignored if it is of another run
/// @throws std::runtime_error with a sentence if the summary is invalid
std::string report_html(const Recording& recording, std::string_view summary,
                        std::string_view partition = {});

/// Writes report.html into a run's folder, from run.mcap, timing.csv and summary.json.
/// @throws std::runtime_error with a sentence for a file that cannot be read or written
void write_report(const std::filesystem::path& folder);

}  // namespace sightline
