#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>
#include <string_view>
#include <utility>

#include "sightline/base.hpp"
#include "sightline/base/json_text.hpp"
#include "sightline/report.hpp"

namespace sightline {
namespace {

using Curve = Drawing::Curve;
using Panel = Drawing::Panel;
using Grid = Drawing::Grid;

// Whether differences and products of a value stay finite.
bool is_drawn(double value) { return std::abs(value) <= 1e100; }

bool has_a_number(const std::vector<double>& values) {
  return std::any_of(values.begin(), values.end(), is_drawn);
}

// Replaces values without a place on the axes.
void prune(Grid& grid) {
  for (double& z : grid.z)
    if (!is_drawn(z)) z = no_value;
  const bool placed = std::all_of(grid.x.begin(), grid.x.end(), is_drawn) &&
                      std::all_of(grid.y.begin(), grid.y.end(), is_drawn);
  if (!placed || !has_a_number(grid.z)) grid = {};
}
void prune_notes(Panel& panel) {
  std::erase_if(panel.labels,
                [](const Drawing::Note& note) { return !is_drawn(note.x) || !is_drawn(note.y); });
  std::erase_if(panel.moments, [](const Drawing::TimeMark& moment) { return !is_drawn(moment.x); });
  for (auto* range : {&panel.x_range, &panel.y_range})
    if (*range && !(is_drawn((**range)[0]) && is_drawn((**range)[1]))) range->reset();
}

constexpr std::array<std::string_view, 6> mark_names = {"line", "dashed", "thin", "points", "bars", "arrows"};
constexpr std::array<std::string_view, 3> view_names = {"map", "surface", "cloud"};

// Seven digits: more than a page can show, also after a zoom.
std::string json_of(double value) { return std::isfinite(value) ? fmt::format("{:.7g}", value) : "null"; }

// A "<" could end the element around the JSON.
std::string json_of(std::string_view text) {
  std::string json = json_text(nlohmann::json(text));
  for (std::size_t at = 0; (at = json.find('<', at)) != std::string::npos;) json.replace(at, 1, "\\u003c");
  return json;
}

template <class Range, class Item>
std::string json_list(const Range& range, Item&& item) {
  std::string json = "[";
  for (const auto& one : range) {
    if (json.size() > 1) json += ',';
    json += item(one);
  }
  return json + "]";
}

std::string json_of(std::span<const double> values) {
  return json_list(values, [](double value) { return json_of(value); });
}

std::string json_of(const Curve& curve) {
  return fmt::format(R"({{"label":{},"colour":"{}","mark":"{}","x":{},"y":{}}})", json_of(curve.title),
                     palette.at(curve.colour), mark_names.at(static_cast<std::size_t>(curve.mark)),
                     json_of(curve.x), json_of(curve.y));
}

std::string json_of(const Grid& grid) {
  if (grid.z.empty()) return "null";
  std::vector<double> x = grid.x, y = grid.y;
  if (grid.view != Grid::View::cloud) {
    x.resize(grid.across);
    for (std::size_t row = 0; row < y.size() / grid.across; ++row) y[row] = y[row * grid.across];
    y.resize(y.size() / grid.across);
  }
  return fmt::format(R"({{"view":"{}","across":{},"label":{},"x":{},"y":{},"z":{}}})",
                     view_names.at(static_cast<std::size_t>(grid.view)), grid.across, json_of(grid.label),
                     json_of(x), json_of(y), json_of(grid.z));
}

std::string json_of(const std::optional<std::array<double, 2>>& range) {
  return range ? json_of(std::span<const double>(*range)) : "null";
}

std::string json_of(const Panel& panel) {
  return fmt::format(
      R"({{"x":{},"y":{},"title":{},"height":{},"log":[{},{}],"equal":{},"xRange":{},"yRange":{},"names":{},)"
      R"("notes":{},"moments":{},"grid":{},"curves":{}}})",
      json_of(panel.x_label), json_of(panel.y_label), json_of(panel.title), panel.height, panel.log_x,
      panel.log_y, panel.equal_scales, json_of(panel.x_range), json_of(panel.y_range),
      json_list(panel.y_names, [](std::string_view name) { return json_of(name); }),
      json_list(panel.labels,
                [](const Drawing::Note& note) {
                  return fmt::format(R"({{"x":{},"y":{},"text":{}}})", json_of(note.x), json_of(note.y),
                                     json_of(note.text));
                }),
      json_list(panel.moments,
                [](const Drawing::TimeMark& moment) {
                  return fmt::format(R"({{"x":{},"text":{}}})", json_of(moment.x), json_of(moment.text));
                }),
      json_of(panel.grid), json_list(panel.curves, [](const Curve& curve) { return json_of(curve); }));
}

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

std::string to_json(const Drawing& drawing) {
  return fmt::format(R"({{"columns":{},"panels":{}}})", drawing.columns,
                     json_list(drawing.panels, [](const Panel& panel) { return json_of(panel); }));
}

}  // namespace sightline
