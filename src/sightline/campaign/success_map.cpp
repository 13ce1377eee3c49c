#include "sightline/campaign/success_map.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "sightline/report/page.hpp"

namespace sightline {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double map_radius = 150, map_centre = 175;  // radius and centre [px]

/// Colour scale from no to all runs recovered, distinguishable with colour vision deficiency.
std::string colour(double share) {
  struct Colour {
    double at, r, g, b;
  };
  constexpr std::array<Colour, 5> scale = {{{0.0, 127, 29, 29},
                                            {0.25, 194, 65, 12},
                                            {0.5, 234, 179, 8},
                                            {0.99, 132, 204, 160},
                                            {1.0, 15, 118, 110}}};
  std::size_t i = 0;
  while (i + 2 < scale.size() && share > scale[i + 1].at) ++i;
  const Colour &from = scale[i], &to = scale[i + 1];
  const double w = std::clamp((share - from.at) / (to.at - from.at), 0.0, 1.0);
  const auto mixed = [&](double a, double b) { return static_cast<int>(std::lround((1 - w) * a + w * b)); };
  return fmt::format("#{:02x}{:02x}{:02x}", mixed(from.r, to.r), mixed(from.g, to.g), mixed(from.b, to.b));
}

/// A point of the figure: bearing 0 is up, positive bearings are on the left.
std::string place(double distance, double bearing) {
  return fmt::format("{:.2f} {:.2f}", map_centre - distance * std::sin(bearing),
                     map_centre - distance * std::cos(bearing));
}

std::string describe(const SuccessMap::Cell& cell) {
  return fmt::format("{} of {} recovered", cell.recovered, cell.runs);
}

std::size_t cell_of(int ring, int sector) {
  return static_cast<std::size_t>(ring) * SuccessMap::sectors + static_cast<std::size_t>(sector);
}

double share(const SuccessMap::Cell& cell) {
  return static_cast<double>(cell.recovered) / static_cast<double>(cell.runs);
}

}  // namespace

void SuccessMap::add(double range, double bearing, Cell runs) {
  const auto count = [&](Cell& cell) {
    cell.runs += runs.runs;
    cell.recovered += runs.recovered;
  };
  if (std::abs(bearing) == pi) return count(behind);
  const double turn = std::remainder(bearing, 2 * pi) + pi;  // 0: straight behind, on the right
  const int ring = std::clamp(static_cast<int>(rings * range / range_max), 0, rings - 1);
  const int sector = std::clamp(static_cast<int>(sectors * turn / (2 * pi)), 0, sectors - 1);
  count(cells[cell_of(ring, sector)]);
}

std::string to_svg(const SuccessMap& map, const std::string& title) {
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" role=\"img\" "
      "aria-label=\"{2}\" font-family=\"system-ui, sans-serif\" font-size=\"12\" fill=\"currentColor\">\n"
      "<text x=\"{3}\" y=\"12\" text-anchor=\"middle\">{2}</text>\n",
      2 * map_centre, 2 * map_centre + 20, escaped(title), map_centre);
  for (int ring = 0; ring < map.rings; ++ring) {
    for (int sector = 0; sector < map.sectors; ++sector) {
      const SuccessMap::Cell& cell = map.cells[cell_of(ring, sector)];
      if (cell.runs == 0) continue;
      const double inner = map_radius * ring / map.rings, outer = map_radius * (ring + 1) / map.rings;
      const double from = 2 * pi * sector / map.sectors - pi, to = 2 * pi * (sector + 1) / map.sectors - pi;
      svg += fmt::format(
          "<path fill=\"{}\" d=\"M {} L {} A {} {} 0 0 0 {} L {} A {} {} 0 0 1 {} Z\">"
          "<title>{:.1f} to {:.1f} m, {:.0f} to {:.0f}°: {}</title></path>\n",
          colour(share(cell)), place(inner, from), place(outer, from), outer, outer, place(outer, to),
          place(inner, to), inner, inner, place(inner, from), map.range_max * ring / map.rings,
          map.range_max * (ring + 1) / map.rings, 180 * from / pi, 180 * to / pi, describe(cell));
    }
  }
  if (map.behind.runs > 0) {
    svg += fmt::format(
        "<path fill=\"none\" stroke=\"{}\" stroke-width=\"5\" d=\"M {} L {}\"><title>exactly behind: "
        "{}</title></path>\n",
        colour(share(map.behind)), place(0, pi), place(map_radius + 8, pi), describe(map.behind));
  }
  for (int ring = 2; ring <= map.rings; ring += 2) {
    svg += fmt::format(
        "<text x=\"{:.1f}\" y=\"{:.1f}\" fill=\"#fff\" stroke=\"#000\" stroke-width=\"2.5\" "
        "stroke-opacity=\"0.6\" paint-order=\"stroke\">{:.3g} m</text>\n",
        map_centre + 4, map_centre - map_radius * ring / map.rings + 13, map.range_max * ring / map.rings);
  }
  svg += fmt::format(
      "<path d=\"M {} L {} L {} Z\"><title>nose up</title></path>\n"
      "<text x=\"{}\" y=\"{}\" text-anchor=\"middle\">behind</text>\n</svg>",
      place(9, 0), place(7, 2.5), place(7, -2.5), map_centre, 2 * map_centre + 4);
  return svg;
}

}  // namespace sightline
