#include "sightline/report/figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "sightline/base/no_value.hpp"
#include "sightline/report/gnuplot.hpp"

namespace sightline {
namespace {

using Mark = Drawing::Mark;
using Curve = Drawing::Curve;
using Panel = Drawing::Panel;
using GridView = Drawing::Grid::View;

constexpr int page_width = 900, axes_left = 102, axes_width = 780;  // [px]
constexpr std::string_view picture_head = "<?xml ";                 // of each figure of gnuplot

}  // namespace

std::vector<std::size_t> rows_to_draw(std::span<const std::span<const double>> columns, std::size_t most) {
  const std::size_t rows = columns.empty() ? 0 : columns.front().size();
  std::set<std::size_t> kept;
  if (rows <= most) {
    for (std::size_t i = 0; i < rows; ++i) kept.insert(kept.end(), i);
    return {kept.begin(), kept.end()};
  }
  const std::size_t stretches = (most - 2) / (2 * columns.size());
  for (std::size_t s = 0; s < stretches; ++s) {
    const std::size_t begin = s * rows / stretches, end = (s + 1) * rows / stretches;
    for (const auto& column : columns) {
      std::size_t low = begin, high = begin;
      for (std::size_t i = begin; i < end; ++i) {
        if (!std::isfinite(column[i])) continue;
        if (!(column[low] <= column[i])) low = i;
        if (!(column[high] >= column[i])) high = i;
      }
      kept.insert({low, high});
    }
  }
  kept.insert({0, rows - 1});
  return {kept.begin(), kept.end()};
}

namespace {

// Quotes a user's text in single quotes, where gnuplot expands nothing.
std::string literal(std::string_view text) {
  std::string result = "'";
  for (const char c : text) {
    if (c == '\'') result += '\'';
    result += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  }
  return result + "'";
}

// Whether gnuplot accepts a value as a number, also after differences and products.
bool is_drawn(double value) { return std::abs(value) <= 1e100; }

bool has_a_number(const std::vector<double>& values) {
  return std::any_of(values.begin(), values.end(), is_drawn);
}

// Replaces values without a place on the axes.
void prune(Drawing::Grid& grid) {
  for (double& z : grid.z)
    if (!is_drawn(z)) z = no_value;
  const auto has_place = [](const std::vector<double>& at) {
    return std::all_of(at.begin(), at.end(), is_drawn);
  };
  if (!has_a_number(grid.z) || !has_place(grid.x) || !has_place(grid.y)) grid = {};
}
void prune_notes(Panel& panel) {
  std::erase_if(panel.labels,
                [](const Drawing::Note& note) { return !is_drawn(note.x) || !is_drawn(note.y); });
  std::erase_if(panel.moments, [](const Drawing::TimeMark& moment) { return !is_drawn(moment.x); });
  for (auto* range : {&panel.x_range, &panel.y_range})
    if (*range && !(is_drawn((**range)[0]) && is_drawn((**range)[1]))) range->reset();
}

// Replaces values that an axis cannot show by gaps; removes curves, panels and drawings without a
// point.
void prune(std::vector<Drawing>& drawings) {
  for (Drawing& drawing : drawings) {
    for (Panel& panel : drawing.panels) {
      for (Curve& curve : panel.curves) {
        for (std::size_t i = 0; i < curve.x.size(); ++i) {
          const bool shown = is_drawn(curve.x[i]) && is_drawn(curve.y[i]) &&
                             (!panel.log_x || curve.x[i] > 0) && (!panel.log_y || curve.y[i] > 0);
          if (!shown) curve.y[i] = no_value;
        }
      }
      std::erase_if(panel.curves, [](const Curve& curve) { return !has_a_number(curve.y); });
      prune(panel.grid);
      prune_notes(panel);
    }
    const bool shared = !drawing.panels.empty() && drawing.panels.front().x_label.empty();
    const std::string x_label = shared ? drawing.panels.back().x_label : "";
    std::erase_if(drawing.panels,
                  [](const Panel& panel) { return panel.curves.empty() && panel.grid.z.empty(); });
    if (shared && !drawing.panels.empty()) drawing.panels.back().x_label = x_label;
  }
  std::erase_if(drawings, [](const Drawing& drawing) { return drawing.panels.empty(); });
}

std::string_view style(Mark mark) {
  switch (mark) {
    case Mark::line:
      return "with lines lw 1.6";
    case Mark::dashed:
      return "with lines lw 1.6 dt (8,5)";
    case Mark::thin:
      return "with lines lw 0.8";
    case Mark::points:
      return "with points pt 7 ps 0.7";
    case Mark::bars:
      return "with fillsteps fs solid 0.55 noborder";
    case Mark::arrows:
      break;
  }
  return "with vectors filled head size screen 0.011,18,60 lw 1.4";
}

std::size_t characters(std::string_view utf8) {
  return static_cast<std::size_t>(
      std::count_if(utf8.begin(), utf8.end(), [](char c) { return (c & 0xC0) != 0x80; }));
}

// Columns and rows of the legend above a panel.
struct Legend {
  std::size_t columns = 1, rows = 0;

  Legend(const Panel& panel, int axes) {
    std::size_t entries = 0, longest = 0;
    for (const Curve& curve : panel.curves) {
      if (curve.title.empty()) continue;
      ++entries;
      longest = std::max(longest, characters(curve.title));
    }
    columns = std::clamp<std::size_t>(static_cast<std::size_t>(axes) / (70 + 9 * longest), 1,
                                      std::max<std::size_t>(1, entries));
    rows = (entries + columns - 1) / columns;
  }
};

struct AxisRange {
  double low = std::numeric_limits<double>::infinity(), high = -low;

  double length() const { return high - low; }
  double middle() const { return low + 0.5 * length(); }
};

AxisRange range_of(const Panel& panel, std::vector<double> Curve::*axis) {
  AxisRange range;
  const std::vector<double>& grid = axis == &Curve::x ? panel.grid.x : panel.grid.y;
  if (!grid.empty()) {
    const auto [low, high] = std::minmax_element(grid.begin(), grid.end());
    range = {*low, *high};
    if (panel.grid.view != GridView::cloud) return range;
  }
  for (const Curve& curve : panel.curves) {
    for (std::size_t i = 0; i < curve.y.size(); ++i) {
      if (!std::isfinite(curve.y[i])) continue;
      range.low = std::min(range.low, (curve.*axis)[i]), range.high = std::max(range.high, (curve.*axis)[i]);
    }
  }
  return range;
}

AxisRange height_of(const Drawing::Grid& grid) {
  if (grid.z.empty()) return {0.0, 0.0};
  AxisRange range;
  for (const double z : grid.z)
    if (std::isfinite(z)) range = {std::min(range.low, z), std::max(range.high, z)};
  return range;
}

struct Space {
  AxisRange x, y, z;
};

// The box of a cloud; no side is too short for its tics.
Space space_of(const Panel& panel) {
  Space space{range_of(panel, &Curve::x), range_of(panel, &Curve::y), height_of(panel.grid)};
  if (!panel.curves.empty()) space.z = {std::min(space.z.low, 0.0), std::max(space.z.high, 0.0)};
  const double least =
      std::max({1e-3, 0.5 * space.x.length(), 0.5 * space.y.length(), 0.5 * space.z.length()});
  for (AxisRange* side : {&space.x, &space.y, &space.z}) {
    const double middle = side->middle(), half = 0.5 * std::max(side->length(), least);
    *side = {middle - half, middle + half};
  }
  return space;
}

// Range of the data with a margin; of a logarithmic y at most the upper six decades.
std::string ranges(const Panel& panel, int axes) {
  const AxisRange x = range_of(panel, &Curve::x), y = range_of(panel, &Curve::y);
  const auto text = [](double x_low, double x_high, double y_low, double y_high) {
    return fmt::format("set xrange [{}:{}]\nset yrange [{}:{}]\n", x_low, x_high, y_low, y_high);
  };
  if (!panel.grid.z.empty()) {
    const Space space = panel.grid.view == GridView::cloud ? space_of(panel) : Space{x, y, {}};
    return text(space.x.low, space.x.high, space.y.low, space.y.high);
  }
  if (panel.equal_scales) {
    const double metres = 0.54 * std::max({x.length() / axes, y.length() / panel.height,
                                           1e-6 * (1 + std::abs(x.middle()) + std::abs(y.middle()))});
    const double across = metres * axes, up = metres * panel.height;
    return text(x.middle() - across, x.middle() + across, y.middle() - up, y.middle() + up);
  }
  const double size = std::max(std::abs(y.low), std::abs(y.high));
  const double air =
      y.length() > 0 ? std::max({0.07 * y.length(), 1e-6 * size, 1e-9}) : std::max(1e-3, 0.07 * size);
  const double y_low = panel.log_y ? std::max(y.low, 1e-6 * y.high) / 1.3 : panel.log_x ? 0.0 : y.low - air;
  const double y_high = panel.log_y ? 1.6 * y.high : y.high + air;
  if (panel.log_x) return text(x.low / 1.05, x.high * 1.05, y_low, y_high);
  const double x_low = panel.x_range ? (*panel.x_range)[0] : x.low,
               x_high = panel.x_range ? (*panel.x_range)[1] : x.high;
  const double x_air =
      x_high > x_low ? 0.003 * (x_high - x_low) : std::max(1e-3, 1e-3 * std::abs(x_low));  // shows last tic
  return panel.y_range ? text(x_low, x_high + x_air, (*panel.y_range)[0], (*panel.y_range)[1])
                       : text(x_low, x_high + x_air, y_low, y_high);
}

// Labels, vertical lines and names of values.
std::string notes(const Panel& panel) {
  std::string script = "unset arrow\n";
  for (const Drawing::Note& note : panel.labels) {
    script += fmt::format("set label {} at {},{} left offset 0.4,0.3 font ',10'\n", literal(note.text),
                          note.x, note.y);
  }
  for (const Drawing::TimeMark& moment : panel.moments) {
    script += fmt::format("set arrow from {0},graph 0 to {0},graph 1 nohead lc rgb '{1}' lw 1 dt (2,4)\n",
                          moment.x, palette[Drawing::faint_colour]);
    if (!moment.text.empty()) {
      script += fmt::format("set label {} at {},graph 1 left offset 0.2,-0.6 font ',10'\n",
                            literal(moment.text), moment.x);
    }
  }
  if (panel.y_names.empty()) return script + "set ytics autofreq\n";
  script += "set ytics (";
  for (std::size_t i = 0; i < panel.y_names.size(); ++i)
    script += fmt::format("{}{} {}", i > 0 ? ", " : "", literal(panel.y_names[i]), i);
  return script + ")\n";
}

void write_curve(std::ostream& script, const Curve& curve, std::string_view name) {
  script << name << " << EOD\n";
  if (curve.mark == Mark::arrows) {
    for (std::size_t i = 0; i + 1 < curve.x.size(); i += 2) {
      const double dx = curve.x[i + 1] - curve.x[i], dy = curve.y[i + 1] - curve.y[i];
      if (!std::isfinite(dx + dy)) continue;
      script << fmt::format("{:.8g} {:.8g} {:.5g} {:.5g}\n", curve.x[i], curve.y[i], dx, dy);
    }
  } else {
    for (std::size_t i = 0; i < curve.x.size(); ++i) {
      if (std::isfinite(curve.y[i])) script << fmt::format("{:.8g} {:.8g}", curve.x[i], curve.y[i]);
      script << '\n';  // an empty row is a gap
    }
  }
  script << "EOD\n";
}

bool in_space(const Panel& panel) { return !panel.grid.z.empty() && panel.grid.view != GridView::map; }

// The panel's field, plotted first, below its curves.
std::string write_grid(std::ostream& script, const Drawing::Grid& grid, const Space& space) {
  if (grid.z.empty()) return "plot ";
  script << "$grid << EOD\n";
  for (std::size_t i = 0; i < grid.z.size(); ++i) {
    if (i > 0 && grid.across > 0 && i % grid.across == 0) script << '\n';
    script << fmt::format("{:.6g} {:.6g} {:.5g}\n", grid.x[i], grid.y[i], grid.z[i]);
  }
  script << "EOD\n";
  const std::string label = literal(grid.label);
  switch (grid.view) {
    case GridView::map:
      return "set cblabel " + label + " offset 1,0\nplot $grid using 1:2:3 with image notitle";
    case GridView::surface:
      return "unset colorbox\nset ztics autofreq\nset zlabel " + label +
             " rotate by 90 offset 1,0\nset view 58,35,1,1\nsplot $grid using 1:2:3 with pm3d notitle";
    case GridView::cloud:
      break;
  }
  const AxisRange z = height_of(grid);
  // As large as possible: the height of the box is to the scale of its sides.
  const double scale = 1.25 * std::min(1.0, std::max(space.x.length(), space.y.length()) / space.z.length());
  // The middle of the colour scale is legible on light and dark pages.
  return fmt::format("set cbrange [{}:{}]\nset zrange [{}:{}]\n", z.low - 0.9 * z.length() - 1e-9,
                     z.high + 0.5 * z.length() + 1e-9, space.z.low, space.z.high) +
         "unset colorbox\nset zlabel " + label + " rotate by 90 offset 1,0\n" +
         fmt::format("set view 58,35,{},1\nset view equal xyz\n", scale) +
         "splot $grid using 1:2:3:3 with points pt 7 ps 0.25 lc palette notitle";
}

void write_panel(std::ostream& script, const Panel& panel, int axes) {
  for (std::size_t i = 0; i < panel.curves.size(); ++i) {
    write_curve(script, panel.curves[i], fmt::format("$c{}", i));
  }
  script << "unset logscale\nset colorbox\nset cbrange [*:*]\nset zrange [*:*]\nset view noequal\n"
         << (panel.log_x ? "set logscale x\n" : "") << (panel.log_y ? "set logscale y\n" : "")
         << ranges(panel, axes) << notes(panel) << "set xlabel " << literal(panel.x_label)
         << " offset 0,0.4\nset ylabel " << literal(panel.y_label)
         << (in_space(panel) ? " offset -0.5,0" : " offset 0.5,0") << "\nset format x "
         << (panel.x_label.empty() ? "''" : "'%g'") << "\nset format y '%g'\n"
         << write_grid(script, panel.grid, space_of(panel));
  for (std::size_t i = 0; i < panel.curves.size(); ++i) {
    const Curve& curve = panel.curves[i];
    const std::string_view columns = !in_space(panel)             ? ""
                                     : curve.mark == Mark::arrows ? "using 1:2:(0):3:4:(0)"
                                                                  : "using 1:2:(0)";
    script << (i > 0 || !panel.grid.z.empty() ? ", " : "")
           << fmt::format("$c{} {} {} lc rgb '{}' {}", i, columns, style(curve.mark),
                          palette.at(curve.colour),
                          curve.title.empty() ? "notitle" : "title " + literal(curve.title));
  }
  script << '\n';
}

// Axes of a panel, from the figure's upper left corner [px].
struct PanelPlace {
  int x, width, title_y, legend_y, y;
};

void write_drawing(std::ostream& script, const Drawing& drawing) {
  constexpr int row = 20, gap = 10, axis = 46, colour_box = 92;
  const int columns = std::max(1, drawing.columns), share = page_width / columns;
  std::vector<PanelPlace> places;
  int height = gap;
  for (std::size_t first = 0; first < drawing.panels.size(); first += static_cast<std::size_t>(columns)) {
    const std::size_t end = std::min(first + static_cast<std::size_t>(columns), drawing.panels.size());
    int head = 0, tallest = 0;
    for (std::size_t i = first; i < end; ++i) {
      const Panel& panel = drawing.panels[i];
      const int column = static_cast<int>(i - first);
      const int from = columns == 1 ? axes_left : column * share + 72;
      const bool map = !panel.grid.z.empty() && panel.grid.view == GridView::map;
      const int axes = (columns == 1 ? axes_width : share - 90) - (map ? colour_box : 0);
      const int title = panel.title.empty() ? 0 : row;
      head = std::max(head, title + static_cast<int>(Legend(panel, axes).rows) * row);
      places.push_back({from, axes, height, height + title, 0});
    }
    for (std::size_t i = first; i < end; ++i) {
      places[i].y = height + head;
      const Panel& panel = drawing.panels[i];
      tallest = std::max(tallest, panel.height + gap + (panel.x_label.empty() ? 0 : axis));
    }
    height += head + tallest;
  }
  const auto across = [](int x) { return x / static_cast<double>(page_width); };
  const auto up = [&](int y) { return 1 - y / static_cast<double>(height); };
  script << fmt::format("set terminal svg size {},{} font 'sans-serif,13' noenhanced\nset multiplot\n",
                        page_width, height);
  for (std::size_t i = 0; i < drawing.panels.size(); ++i) {
    const Panel& panel = drawing.panels[i];
    const PanelPlace& at = places[i];
    const Legend legend(panel, at.width);
    script << fmt::format(
        "set lmargin at screen {}\nset rmargin at screen {}\nset key at screen {},{} left top maxcols {} "
        "maxrows {}\n"
        "unset label\n",
        across(at.x), across(at.x + at.width), across(at.x), up(at.legend_y - gap / 2), legend.columns,
        std::max<std::size_t>(1, legend.rows));
    if (!panel.title.empty()) {
      script << fmt::format("set label {} at screen {},{} left\n", literal(panel.title), across(at.x),
                            up(at.title_y + row / 2 - 2));
    }
    if (in_space(panel)) {  // a box in perspective needs more room than its axes
      script << fmt::format("set margins -1,-1,-1,-1\nset origin {},{}\nset size {},{}\n", across(at.x - 60),
                            up(at.y + panel.height + axis), across(at.width + 75),
                            (panel.height + axis) / static_cast<double>(height));
    } else {
      script << fmt::format(
          "set origin 0,0\nset size 1,1\nset tmargin at screen {}\nset bmargin at screen {}\n", up(at.y),
          up(at.y + panel.height));
    }
    write_panel(script, panel, at.width);
  }
  script << "unset multiplot\n";
}

void replace_all(std::string& text, std::string_view from, std::string_view to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
  }
}

// gnuplot's figure as an element of a page: without head and pop-up titles, with unique ids, black
// replaced by the page's colour.
std::string inlined(std::string svg, std::size_t number) {
  const std::size_t begin = svg.find("<svg");
  if (begin == std::string::npos) throw std::runtime_error("gnuplot drew no picture");
  svg.erase(0, begin);
  for (const std::string_view mark : {" id='", " id=\"", "href='#", "url(#"}) {
    replace_all(svg, mark, fmt::format("{}f{}_", mark, number));
  }
  for (std::size_t at = svg.find("<title>"); at != std::string::npos; at = svg.find("<title>", at)) {
    svg.erase(at, svg.find("</title>", at) + std::string_view("</title>").size() - at);
  }
  replace_all(svg, "\"black\"", "\"currentColor\"");
  replace_all(svg, "'black'", "'currentColor'");
  return svg;
}

}  // namespace

std::vector<Figure> draw(std::vector<Drawing> drawings, std::size_t first) {
  prune(drawings);
  if (drawings.empty()) return {};
  std::ostringstream script;
  script << "set encoding utf8\nset border lw 0.8\nset tics nomirror scale 0.6\n"
            "set grid lw 0.5 lc rgb '#8a8f98'\n"
            "set key horizontal Left reverse samplen 2\n"
            "set palette defined (0 '#f3f7fc', 1 '#c6dcef', 2 '#84b8da', 3 '#3787c0', 4 '#0b3c7d')\n"
            "set pm3d border lc rgb '#8a8f98' lw 0.3\nset xyplane relative 0\n";
  for (const Drawing& drawing : drawings) write_drawing(script, drawing);
  const std::string pictures = run_gnuplot(script.str());
  std::vector<Figure> figures;
  std::size_t begin = pictures.find(picture_head);
  for (std::size_t i = 0; i < drawings.size(); ++i) {
    const std::size_t end = begin == std::string::npos ? begin : pictures.find(picture_head, begin + 1);
    figures.push_back({drawings[i].title, drawings[i].caption,
                       inlined(pictures.substr(std::min(begin, pictures.size()), end - begin), first + i)});
    begin = end;
  }
  return figures;
}

}  // namespace sightline
