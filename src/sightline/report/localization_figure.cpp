#include <fmt/format.h>

#include <algorithm>

#include "sightline/report/run_figures.hpp"

namespace sightline {
namespace {

constexpr std::size_t localized_shown = 4;

Drawing localization_drawing(const Recording& recording, const Recording::Body& body) {
  const Recording::Localization& of = body.localization;
  const Curves curves(recording);
  Drawing::Panel error{.x_label = "", .y_label = "error [m]"};
  std::vector<double> three_sigma = of.sigma;
  for (double& sigma : three_sigma) sigma *= 3;
  error.curves.push_back(curves.curve("of the estimate", 0, Drawing::Mark::line, of.time, of.error));
  error.curves.push_back(
      curves.curve("3 sigma", Drawing::limit_colour, Drawing::Mark::dashed, of.time, three_sigma));
  Drawing::Panel nees{.x_label = "", .y_label = "NEES", .log_y = true};
  nees.curves.push_back(curves.curve("", 0, Drawing::Mark::thin, of.time, of.nees));
  nees.curves.push_back(curves.level("4, the mean of one that is right", Drawing::limit_colour, 4.0));
  Drawing::Panel fits{.x_label = "t [s]", .y_label = "χ² of detections", .log_y = true};
  fits.curves.push_back(curves.curve("accepted", 0, Drawing::Mark::points, of.estimated_time, of.estimated));
  if (!of.refused.empty())
    fits.curves.push_back(curves.curve("refused", 1, Drawing::Mark::points, of.refused_time, of.refused));
  return {fmt::format("{} by what it sees", body.name),
          fmt::format("{} knows no position: the error of its estimate and what its filter estimates, the "
                      "squared error in units of the covariance, and how {} detections fitted.",
                      body.name, of.estimated.size() + of.refused.size()),
          {error, nees, fits}};
}

}  // namespace

std::vector<Drawing> localization_drawings(const Recording& recording) {
  std::vector<Drawing> drawings;
  if (recording.time.empty()) return drawings;
  for (const Recording::Body& body : recording.bodies) {
    if (body.localization.time.empty() || drawings.size() == localized_shown) continue;
    drawings.push_back(localization_drawing(recording, body));
  }
  return drawings;
}

}  // namespace sightline
