#include <algorithm>
#include <cmath>
#include <limits>

#include "sightline/report/run_figures.hpp"

namespace sightline {
std::optional<Drawing> swarm_drawing(const Recording& recording) {
  if (recording.time.empty() || recording.controllers.empty() || recording.controllers[0].pairs.empty())
    return std::nullopt;
  std::vector<const Recording::Body*> robots;
  for (const Recording::Body& body : recording.bodies) {
    if (body.is_agent) robots.push_back(&body);
  }
  std::vector<double> least, mean, farthest;
  for (std::size_t k = 0; k < recording.time.size(); ++k) {
    double nearest2 = std::numeric_limits<double>::infinity(), sum = 0.0, most = std::nan("");
    int bound = 0;
    for (std::size_t i = 0; i < robots.size(); ++i) {
      if (k >= robots[i]->p.size()) continue;
      for (std::size_t j = 0; j < i; ++j) {
        if (k >= robots[j]->p.size()) continue;
        const Vec3<double> r = robots[i]->p[k] - robots[j]->p[k];
        if (dot(r, r) < nearest2) nearest2 = dot(r, r);
      }
      if (robots[i]->reference_p.empty()) continue;
      const double to_go = norm(robots[i]->p[k] - robots[i]->reference_p.back());
      if (!std::isfinite(to_go)) continue;
      sum += to_go;
      most = std::fmax(most, to_go);
      ++bound;
    }
    least.push_back(std::isfinite(nearest2) ? std::sqrt(nearest2) : std::nan(""));
    mean.push_back(sum / bound);
    farthest.push_back(most);
  }
  Drawing::Panel distance{.x_label = "", .y_label = "D [m]", .height = 160},
      pairs{.x_label = "", .y_label = "pairs", .height = 160},
      way{.x_label = "t [s]", .y_label = "to go [m]", .height = 160};
  const auto over_time = [&](const char* title, std::size_t colour, const std::vector<double>& y) {
    return thinned(title, colour, Drawing::Mark::line, recording.time, y);
  };
  distance.curves = {over_time("of the two that are nearest", 0, least)};
  pairs.curves = {over_time("kept apart", 1, recording.controllers[0].pairs)};
  way.curves = {over_time("mean", 2, mean), over_time("farthest", 3, farthest)};
  return Drawing{
      "Swarm",
      "Least distance of two robots; pairs that come near each other along their plans; how far the robots "
      "are from their references at the end.",
      {std::move(distance), std::move(pairs), std::move(way)}};
}

}  // namespace sightline
