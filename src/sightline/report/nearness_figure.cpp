#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "sightline/report/run_figures.hpp"

namespace sightline {
namespace {

constexpr double looks_max = 3e7;  // most evaluated distances

}  // namespace

std::vector<Nearness> nearest_pairs(const Recording& recording, std::size_t most) {
  const auto& bodies = recording.bodies;
  const double all = static_cast<double>(bodies.size()) * static_cast<double>(bodies.size()) / 2;
  const auto stride = static_cast<std::size_t>(
      std::max(1.0, std::ceil(static_cast<double>(recording.time.size()) * all / looks_max)));
  std::vector<Nearness> pairs;  // `least` holds squares until the end
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    for (std::size_t j = i + 1; j < bodies.size(); ++j) {
      if (bodies[i].is_agent || bodies[j].is_agent)
        pairs.push_back({i, j, std::numeric_limits<double>::infinity()});
    }
  }
  std::vector<Vec3<double>> p(bodies.size());
  for (std::size_t k = 0; k < recording.time.size(); k += stride) {
    for (std::size_t i = 0; i < bodies.size(); ++i)
      p[i] = k < bodies[i].p.size() ? bodies[i].p[k] : Vec3<double>{std::nan(""), 0.0, 0.0};
    for (Nearness& pair : pairs) {
      const Vec3<double> r = p[pair.first] - p[pair.second];
      if (dot(r, r) < pair.least) pair.least = dot(r, r);
    }
  }
  std::erase_if(pairs, [](const Nearness& pair) { return !std::isfinite(pair.least); });
  for (Nearness& pair : pairs) pair.least = std::sqrt(pair.least);
  const auto end = pairs.begin() + static_cast<std::ptrdiff_t>(std::min(most, pairs.size()));
  std::partial_sort(pairs.begin(), end, pairs.end(), [](const Nearness& a, const Nearness& b) {
    return std::tie(a.least, a.first, a.second) < std::tie(b.least, b.first, b.second);
  });
  pairs.erase(end, pairs.end());
  return pairs;
}

std::optional<Drawing> nearness_drawing(const Recording& recording, const Curves& curves) {
  const auto& bodies = recording.bodies;
  if (bodies.size() == 2 && recording.d_hard.empty() && !recording.pairs.empty()) return std::nullopt;
  const std::vector<Nearness> pairs = nearest_pairs(recording, Drawing::colours + 1);
  if (pairs.empty()) return std::nullopt;
  Drawing::Panel panel{.x_label = "t [s]", .y_label = "D [m]", .height = 200};
  double greatest = 0.0;
  for (std::size_t n = 0; n < std::min(pairs.size(), Drawing::colours); ++n) {
    const auto &first = bodies[pairs[n].first], &second = bodies[pairs[n].second];
    std::vector<double> distance;
    for (std::size_t k = 0; k < std::min(first.p.size(), second.p.size()); ++k)
      distance.push_back(norm(first.p[k] - second.p[k]));
    panel.curves.push_back(curves.over_time(fmt::format("{} and {}", label(first.name), label(second.name)),
                                            n, Drawing::Mark::line, distance));
    for (const double d : panel.curves.back().y) greatest = std::fmax(greatest, d);
  }
  for (const double d_hard : recording.d_hard)
    panel.curves.push_back(
        curves.level(fmt::format("d_hard = {:.4g} m", d_hard), Drawing::limit_colour, d_hard));
  panel.y_range = {{0.0, 1.05 * greatest}};
  return Drawing{
      "Nearest to each other",
      fmt::format("Distances of centres{}{}.",
                  pairs.size() > Drawing::colours ? "; the six pairs that came nearest" : "",
                  recording.d_hard.empty() ? "" : "; dashed: the hard distance, never to be fallen short of"),
      {std::move(panel)}};
}

}  // namespace sightline
