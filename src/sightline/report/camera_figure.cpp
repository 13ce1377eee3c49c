#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "sightline/report/page.hpp"
#include "sightline/report/run_figures.hpp"
#include "sightline/scenario.hpp"

namespace sightline {
namespace {

constexpr std::size_t cameras_shown = 4, pictures_shown = 6, in_a_row = 3;
constexpr double width_on_page = 240.0, gap_between = 12.0, words_below = 18.0;  // in the page [px]
constexpr double code_in_tag = 6.0 / 8;  // of tag36h11: black frame, 1/8 wide per side

/// Projected corners of a plate, as the points of a polygon; empty if the camera does not see one.
std::string points_of(const Camera& camera, const Recording::Sighted& seen, const Tags& tags, int face,
                      double scale) {
  const Rotation R = rotation(seen.q);
  const double widest = camera.widest();
  std::string points;
  for (const Vec3<double>& corner : tags.corners(face, scale)) {
    const Vec3<double> p_S = seen.p + R.to_G(corner);
    if (!camera.sees(p_S, widest)) return "";
    const Vec2<double> at = camera.project(p_S);
    points += fmt::format("{:.1f},{:.1f} ", 0.5 * camera.width + at.x, 0.5 * camera.height + at.y);
  }
  return points;
}

std::string plates_of(const Camera& camera, const Recording::Sighted& seen, const Tags& tags) {
  std::string plates;
  const Rotation R = rotation(seen.q);
  for (int face = 0; face < tags.faces; ++face) {
    if (dot(R.to_G(tags.normal(face)), seen.p + R.to_G(tags.centre(face))) >= 0) continue;  // back
    for (const auto& [scale, fill] :
         {std::pair{Tags::border, "#fff"}, std::pair{1.0, "#000"}, std::pair{code_in_tag, "#777"}}) {
      const std::string points = points_of(camera, seen, tags, face, scale);
      if (!points.empty()) plates += fmt::format("<polygon points=\"{}\" fill=\"{}\"/>\n", points, fill);
    }
  }
  return plates;
}

/// Whether the picture shows any of it; what a further camera of the robot detects may lie beyond.
bool is_in_picture(const Recording& r, const Camera& camera, const Recording::Sighted& seen) {
  if (camera.sees(seen.p, camera.widest())) return true;
  const std::optional<Tags>& tags = r.bodies[seen.target].tags;
  return tags && seen.q != no_attitude && !plates_of(camera, seen, *tags).empty();
}

/// One figure in its own pixels, with its caption below.
std::string picture_of(const Recording& r, const Camera& camera, const Recording::Sighted& seen) {
  const Recording::Body& target = r.bodies[seen.target];
  const double scale = camera.width / width_on_page;
  std::string svg =
      fmt::format("<rect width=\"{}\" height=\"{}\" fill=\"#aaa\"/>\n", camera.width, camera.height);
  if (target.tags && seen.q != no_attitude) {
    svg += fmt::format("<svg width=\"{}\" height=\"{}\">\n{}</svg>\n", camera.width, camera.height,
                       plates_of(camera, seen, *target.tags));
  } else if (camera.sees(seen.p, camera.widest())) {
    const Vec2<double> at = camera.project(seen.p);
    svg += fmt::format("<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"{:.1f}\" fill=\"#000\"/>\n",
                       0.5 * camera.width + at.x, 0.5 * camera.height + at.y, 3 * scale);
  }
  return svg + fmt::format("<text x=\"0\" y=\"{:.1f}\" font-size=\"{:.1f}\">{:.2f} s: {}, {:.2f} m</text>\n",
                           camera.height + 14 * scale, 12 * scale, seen.stamp,
                           escaped(shortened(target.name, 16)), norm(seen.p));
}

/// @param detections  not empty
Figure pictures_of(const Recording& r, const Recording::Body& observer, const Camera& camera,
                   const std::vector<Recording::Sighted>& detections) {
  const std::size_t count = std::min(pictures_shown, detections.size());
  const double height = width_on_page * camera.height / camera.width;
  const std::size_t rows = (count + in_a_row - 1) / in_a_row;
  std::string svg = fmt::format(
      "<svg viewBox=\"0 0 {:.0f} {:.0f}\" role=\"img\" font-family=\"sans-serif\" fill=\"currentColor\">\n",
      in_a_row * (width_on_page + gap_between) - gap_between,
      static_cast<double>(rows) * (height + words_below + gap_between) - gap_between);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t last = detections.size() - 1;
    const Recording::Sighted& seen = detections[count > 1 ? i * last / (count - 1) : 0];
    svg += fmt::format("<g transform=\"translate({:.1f} {:.1f}) scale({:.5f})\">\n{}</g>\n",
                       static_cast<double>(i % in_a_row) * (width_on_page + gap_between),
                       static_cast<double>(i / in_a_row) * (height + words_below + gap_between),
                       width_on_page / camera.width, picture_of(r, camera, seen));
  }
  return {
      fmt::format("What the camera of {} saw", observer.name),
      fmt::format(
          "{} of its {} detections, each as it says that the tags were, without their code, in a picture of "
          "{} x {} pixels.",
          count, detections.size(), camera.width, camera.height),
      svg + "</svg>"};
}

}  // namespace

std::vector<Figure> camera_figures(const Recording& recording) {
  std::vector<Figure> figures;
  for (const Recording::Body& body : recording.bodies) {
    if (!body.camera || figures.size() == cameras_shown) continue;
    std::vector<Recording::Sighted> detections;
    for (const Recording::Sighted& one : body.sighted)
      if (is_in_picture(recording, *body.camera, one)) detections.push_back(one);
    if (!detections.empty()) figures.push_back(pictures_of(recording, body, *body.camera, detections));
  }
  return figures;
}

}  // namespace sightline
