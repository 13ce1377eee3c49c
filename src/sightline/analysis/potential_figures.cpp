#include "sightline/analysis/potential_figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <utility>

#include "sightline/base.hpp"

namespace sightline {
namespace {

using Mark = Drawing::Mark;
using Curve = Drawing::Curve;
using Panel = Drawing::Panel;
using Grid = Drawing::Grid;

using std::numbers::pi;
constexpr double window = 3.0;                    // half the width of a figure [m]
constexpr double worth = 0.5;                     // level of the border in Figs. 14 and 16
constexpr int map_side = 268;                     // of two figures side by side [px]
constexpr int map_size = 120, surface_size = 32;  // points per side; even: none on an axis
/// Pose of the robot in the paper's figures in the global frame, Fig. 12.
constexpr Vec3<double> robot_place = {-1.0, -1.0, 0.0};
constexpr double robot_heading = pi / 4;

using Value = std::function<double(const Station&)>;

/// Maps a point of a figure's plane to a station.
using Plane = std::function<Station(double, double)>;

Grid grid_over(const Plane& plane, const Value& value, int across, Grid::View view, std::string label) {
  Grid grid{.view = view, .across = static_cast<std::size_t>(across), .label = std::move(label)};
  for (int j = 0; j < across; ++j) {
    for (int i = 0; i < across; ++i) {
      const double x = window * (2.0 * i / (across - 1) - 1), y = window * (2.0 * j / (across - 1) - 1);
      grid.x.push_back(x), grid.y.push_back(y), grid.z.push_back(value(plane(x, y)));
    }
  }
  return grid;
}

class Pictures {
 public:
  Pictures(const Potential& potential, const Verdict& verdict, const Potential* set)
      : potential_(potential), verdict_(verdict), set_(set), mount_(potential.mount()), field_(potential) {
    name_ = potential.name();
    if (const auto own = potential.kappa_A()) {
      sharpnesses_ = {0.5 * *own, *own, 5 * *own};
    }
  }

  std::vector<Drawing> all() {
    unit_step();
    limit_in_space();
    slope();
    if (!sharpnesses_.empty()) sigmoid_by_itself();
    sigmoid();
    global_frame();
    level_in_space();
    gradient();
    force();
    if (field_.sees_heading()) torque();
    return std::move(drawings_);
  }

 private:
  std::string frame() const { return mount_ != nullptr ? "S" : "V"; }
  std::string x_label() const { return fmt::format("x_{} [m]", frame()); }
  std::string y_label() const { return fmt::format("y_{} [m]", frame()); }
  std::string plane_words() const {
    return mount_ != nullptr ? "the xy-plane of the sensor frame S, the axis along x"
                             : "the xy-plane of the observer's frame V";
  }
  Plane sensor_plane() const {
    return [this](double x, double y) { return seen_at({x, y, 0}, mount_); };
  }
  static Value value_of(const Potential& p) {
    return [p](const Station& s) { return p(observer_of(s), target_of(s), 0.0); };
  }
  double broken(const Station& s) const {
    return potential_.violation(observer_of(s), target_of(s)) > 0 ? 1.0 : 0.0;
  }
  double sloped(const Station& s) const { return potential_.sloped(observer_of(s), target_of(s)); }
  Curve observer(double x = 0, double y = 0, double psi = 0) const {
    const double length = 0.5;
    return {"observer",
            Drawing::limit_colour,
            Mark::arrows,
            {x, x + length * std::cos(psi)},
            {y, y + length * std::sin(psi)}};
  }
  Panel map(std::string title, const Plane& plane, const Value& value, std::string label, int height) const {
    Panel panel{.x_label = x_label(), .y_label = y_label(), .curves = {observer()}, .height = height};
    panel.equal_scales = true;
    panel.title = std::move(title);
    panel.grid = grid_over(plane, value, map_size, Grid::View::map, std::move(label));
    return panel;
  }
  Panel surface(std::string title, const Plane& plane, const Value& value, std::string label) const {
    Panel panel{.x_label = x_label(), .y_label = y_label(), .curves = {}, .height = map_side};
    panel.title = std::move(title);
    panel.grid = grid_over(plane, value, surface_size, Grid::View::surface, std::move(label));
    return panel;
  }

  /// Fig. 8 and the left of Fig. 9.
  void unit_step() {
    const Value limit = [this](const Station& s) { return broken(s); };
    const Value step = [this](const Station& s) { return sloped(s) > 0 ? 1.0 : 0.0; };
    Drawing drawing{fmt::format("{}: unit step", name_),
                    fmt::format("0 where the limit holds, 1 where it is broken, (29), (30), in {}, by the "
                                "inequalities of the limit.",
                                plane_words()),
                    {map("limit holds: 0", sensor_plane(), limit, "ε [-]", map_side)},
                    2};
    if (std::isfinite(sloped(seen_at({0.3, 0.2, 0.1}, mount_)))) {
      drawing.panels.push_back(map("formula is 0", sensor_plane(), step, "ε [-]", map_side));
      drawing.caption += " On the right by the region of the formula, where its step is not 0.";
    }
    if (set_ != nullptr) {
      drawing.panels[0].curves.push_back(boundary_of_set());
      drawing.caption +=
          " Dots: the boundary of the set in which the view is certified, for a robot at rest.";
    }
    drawings_.push_back(std::move(drawing));
  }

  /// Where the limit `set_` changes along the lines of a grid in the plane of the sensor.
  Curve boundary_of_set() const {
    constexpr int lines = 80, steps = 240;
    Curve dots{"certified set", 1, Mark::points};
    for (int axis = 0; axis < 2; ++axis) {
      for (int i = 0; i < lines; ++i) {
        const double u = window * (2.0 * i / (lines - 1) - 1);
        bool before = false;
        for (int k = 0; k < steps; ++k) {
          const double w = window * (2.0 * k / (steps - 1) - 1), x = axis == 0 ? w : u, y = axis == 0 ? u : w;
          const Station s = seen_at({x, y, 0}, mount_);
          const bool in = set_->violation(observer_of(s), target_of(s)) <= 0;
          if (std::exchange(before, in) != in && k > 0) dots.x.push_back(x), dots.y.push_back(y);
        }
      }
    }
    return dots;
  }

  /// Points where `is_out` changes along the lines of a grid, in the frame of `place`.
  Grid border(const std::function<Station(const Vec3<double>&)>& place,
              const std::function<bool(const Station&)>& is_out, double reach) const {
    constexpr int lines = 26, steps = 60;
    Grid grid{.view = Grid::View::cloud, .label = "z [m]"};
    const auto at = [&](int i, int n) { return reach * (2.0 * i / (n - 1) - 1); };
    for (int axis = 0; axis < 3; ++axis) {
      for (int i = 0; i < lines * lines; ++i) {
        const double u = at(i / lines, lines), v = at(i % lines, lines);
        const auto point = [&](double w) {
          return axis == 0   ? Vec3<double>{w, u, v}
                 : axis == 1 ? Vec3<double>{u, w, v}
                             : Vec3<double>{u, v, w};
        };
        bool before = is_out(place(point(at(0, steps))));
        for (int k = 1; k < steps; ++k) {
          const bool now = is_out(place(point(at(k, steps))));
          if (now != before) {
            double low = at(k - 1, steps), high = at(k, steps);
            for (int n = 0; n < 12; ++n) {
              const double middle = 0.5 * (low + high);
              (is_out(place(point(middle))) == before ? low : high) = middle;
            }
            const Vec3<double> p = point(low);
            grid.x.push_back(p.x), grid.y.push_back(p.y), grid.z.push_back(p.z);
          }
          before = now;
        }
      }
    }
    return grid;
  }
  Panel cloud(std::string title, Grid grid, std::string frame_of, Curve arrow) const {
    Panel panel{.x_label = fmt::format("x{} [m]", frame_of),
                .y_label = fmt::format("y{} [m]", frame_of),
                .curves = {std::move(arrow)},
                .height = 400};
    grid.label = fmt::format("z{} [m]", frame_of);
    panel.title = std::move(title);
    panel.grid = std::move(grid);
    return panel;
  }

  /// Fig. 8.
  void limit_in_space() {
    const auto place = [this](const Vec3<double>& p) { return seen_at(p, mount_); };
    drawings_.push_back(
        {fmt::format("{}: the limit in space", name_),
         fmt::format(
             "Points of the border between 0 and 1 of the unit step, in the frame {}; within {:.3g} m.",
             frame(), window),
         {cloud("",
                border(
                    place, [this](const Station& s) { return broken(s) > 0; }, window),
                "_" + frame(), observer())}});
  }

  /// The right of Fig. 9.
  void slope() {
    const Value value = [this](const Station& s) { return sloped(s); };
    if (!std::isfinite(value(seen_at({0.3, 0.2, 0.1}, mount_)))) return;
    drawings_.push_back(
        {fmt::format("{}: unit step with its slope", name_),
         fmt::format("(34): 0 where the formula's region is, rising away from it; in {}.", plane_words()),
         {map("from above", sensor_plane(), value, "l [-]", map_side),
          surface("in perspective", sensor_plane(), value, "l [-]")},
         2});
  }

  /// Fig. 10.
  void sigmoid_by_itself() {
    Panel value{.x_label = "c", .y_label = "sig(c) [-]", .curves = {}, .height = 240};
    Panel rate{.x_label = "c", .y_label = "dsig/dc", .curves = {}, .height = 240};
    const double reach = 4 / sharpnesses_.front();
    std::size_t colour = 0;
    for (const double kappa_A : sharpnesses_) {
      const std::string title = fmt::format("κ_A = {:.4g}", kappa_A);
      Curve s{title, colour, Mark::line}, d{title, colour, Mark::line};
      ++colour;
      for (int i = 0; i <= 400; ++i) {
        const double c = reach * (i / 200.0 - 1), sig = logistic(kappa_A * c);
        s.x.push_back(c), s.y.push_back(sig);
        d.x.push_back(c), d.y.push_back(kappa_A * sig * (1 - sig));
      }
      value.curves.push_back(std::move(s));
      rate.curves.push_back(std::move(d));
    }
    drawings_.push_back(
        {fmt::format("{}: the sigmoid and its derivative", name_),
         fmt::format("(35) and (36) over the limit's c, broken where c > 0; its own κ_A is {:.4g}.",
                     sharpnesses_[1]),
         {std::move(value), std::move(rate)},
         2});
  }

  /// Figs. 11, 13 and 15.
  void sigmoid() {
    Drawing drawing{
        fmt::format("{}: the potential", name_),
        fmt::format("(39) in {}, as the solver sees it; the unit step of (34) is the limit of a great κ_A.",
                    plane_words()),
        {},
        2};
    std::vector<double> kappas = sharpnesses_;
    if (kappas.empty()) kappas = {0.0};
    for (const double kappa_A : kappas) {
      const Potential p = sharpnesses_.empty() ? potential_ : potential_.sharpened(kappa_A);
      const std::string title = sharpnesses_.empty() ? "" : fmt::format("κ_A = {:.4g}", kappa_A);
      drawing.panels.push_back(map(title, sensor_plane(), value_of(p), "l [-]", map_side));
      drawing.panels.push_back(surface(title, sensor_plane(), value_of(p), "l [-]"));
    }
    drawings_.push_back(std::move(drawing));
  }

  /// Fig. 12: with a level sensor in the plane of the robot, and as mounted in a plane that its
  /// axis meets.
  void global_frame() {
    const auto in_plane = [](double height) {
      return [height](double x, double y) {
        return Station{
            .observer = robot_place, .target = {x, y, robot_place.z + height}, .psi = robot_heading};
      };
    };
    const auto picture = [&](const Potential& p, double height, std::string title) {
      Panel panel = map(std::move(title), in_plane(height), value_of(p), "l [-]", map_side);
      panel.x_label = "x_G [m]", panel.y_label = "y_G [m]";
      panel.curves = {observer(robot_place.x, robot_place.y, robot_heading)};
      return panel;
    };
    Drawing drawing{
        fmt::format("{}: in the global frame", name_),
        "The robot is at (-1, -1, 0) m and heads 45 degrees from x to y; where the target may be.",
        {},
        2};
    if (mount_ == nullptr) {
      drawing.panels.push_back(picture(potential_, 0.0, "plane z = 0"));
    } else {
      // Where the axis meets the plane: 1.5 m ahead, or 1.5 m above or below if it is steeper.
      constexpr double reach = 1.5;
      const double slope = std::tan(mount_->pitch), ahead = reach / std::max(1.0, std::abs(slope)),
                   below = mount_->offset.z - std::clamp(reach * slope, -reach, reach);
      SensorMount level = *mount_;
      level.pitch = 0.0, level.frame = MountFrame::level;
      drawing.panels.push_back(
          picture(potential_.seen_from(level), level.offset.z,
                  fmt::format("plane z = {:.3g}, sensor level (β = 0)", level.offset.z)));
      drawing.panels.push_back(
          picture(potential_, below, fmt::format("plane z = {:.2f} m, β = {:.3g}", below, mount_->pitch)));
      drawing.caption += fmt::format(
          " Left with a sensor without pitch, as the paper has it. Right as it is mounted: the axis "
          "meets that plane {:.3g} m from the sensor, seen from above.",
          ahead);
    }
    drawings_.push_back(std::move(drawing));
  }

  /// Figs. 14 and 16.
  void level_in_space() {
    const auto place = [](const Vec3<double>& p) {
      return Station{.observer = robot_place, .target = p, .psi = robot_heading};
    };
    const auto above = [this](const Station& s) {
      return potential_(observer_of(s), target_of(s), 0.0) > worth;
    };
    drawings_.push_back(
        {fmt::format("{}: where it is worth {}", name_, worth),
         fmt::format("Points of the border of l > {} in the global frame; the robot is at (-1, -1, 0) m and "
                     "heads 45 degrees from x to y.",
                     worth),
         {cloud("", border(place, above, window), "_G",
                observer(robot_place.x, robot_place.y, robot_heading))}});
  }

  void gradient() {
    constexpr int across = 25;
    const double flat = verdict_.options.flat;
    Panel panel = map("", sensor_plane(), value_of(potential_), "l [-]", 688);
    Curve arrows{"force on the target, -dl/dp", 1, Mark::arrows};
    Curve dots{fmt::format("none: |gradient| < {:.3g} 1/m", flat), Drawing::faint_colour, Mark::points};
    const double pitch = 2 * window / (across + 1);
    double greatest = 0.0;
    std::vector<std::pair<Vec3<double>, Vec3<double>>> forces;
    for (int i = 0; i < across * across; ++i) {
      const int column = i % across, row = i / across;
      const Vec3<double> p = {-window + pitch * (1 + column), -window + pitch * (1 + row), 0.0};
      const FieldValue f = field_(seen_at(p, mount_));
      // Turns a force in V into S: the difference of two points in S that are `push` apart in V.
      const Vec3<double> push = {-f.first[0], -f.first[1], -f.first[2]};
      const Station s = seen_at(p, mount_);
      const Vec3<double> in_S = in_sensor_frame({.target = s.target + push}, mount_) - p;
      if (f.slope() < flat) {
        dots.x.push_back(p.x), dots.y.push_back(p.y);
      } else {
        forces.emplace_back(p, in_S);
        greatest = std::max(greatest, f.slope());
      }
    }
    for (const auto& [p, push] : forces) {
      const double size = norm(push);
      const double length =
          pitch * (0.25 + 0.75 * std::log(size / flat) / std::max(1e-9, std::log(greatest / flat)));
      arrows.x.insert(arrows.x.end(), {p.x, p.x + length * push.x / size});
      arrows.y.insert(arrows.y.end(), {p.y, p.y + length * push.y / size});
    }
    panel.curves = {arrows, dots, observer()};
    drawings_.push_back(
        {fmt::format("{}: its gradient", name_),
         fmt::format("Where it pushes the target, relative to the observer, in {}; arrows grow with the "
                     "logarithm of the force, from {:.3g} to {:.3g} 1/m. A dot: none.",
                     plane_words(), flat, greatest),
         {std::move(panel)}});
  }

  void force() {
    Panel along{
        .x_label = fmt::format("x_{} [m]", frame()), .y_label = "-dl/dx [1/m]", .curves = {}, .height = 260};
    std::vector<double> kappas = sharpnesses_;
    if (kappas.empty()) kappas = {0.0};
    std::size_t colour = 0;
    for (const double kappa_A : kappas) {
      const Field field(sharpnesses_.empty() ? potential_ : potential_.sharpened(kappa_A));
      Curve curve{sharpnesses_.empty() ? "" : fmt::format("κ_A = {:.4g}", kappa_A), colour++, Mark::line};
      for (int i = 0; i <= 600; ++i) {
        const double x = verdict_.options.reach * (i / 300.0 - 1);
        const Station s = seen_at({x, 0, 0}, mount_);
        const FieldValue f = field(s);
        const Vec3<double> push = {-f.first[0], -f.first[1], -f.first[2]};
        curve.x.push_back(x);
        curve.y.push_back((in_sensor_frame({.target = s.target + push}, mount_) - Vec3<double>{x, 0, 0}).x);
      }
      along.curves.push_back(std::move(curve));
    }
    drawings_.push_back(
        {fmt::format("{}: the force along the axis", name_),
         fmt::format("On a target on the x axis of {}, y = z = 0; > 0 pushes it forward.", frame()),
         {std::move(along)}});
  }

  /// Yaw gradient of the observer against the angle between its heading and the target.
  void torque() {
    Panel size{.x_label = "angle by which the observer looks past the target [rad]",
               .y_label = "|dl/dψ| [1/rad]",
               .curves = {},
               .height = 260,
               .log_y = true};
    std::size_t colour = 0;
    const Vec3<double> axis =
        mount_ != nullptr ? mount_->attitude() * Vec3<double>{1, 0, 0} : Vec3<double>{1, 0, 0};
    for (const double distance : {0.5, 1.5, 3.0, 5.0}) {
      Curve curve{fmt::format("{:.3g} m away", distance), colour++, Mark::line};
      for (int i = 0; i <= 360; ++i) {
        const double psi = pi * (i / 180.0 - 1);
        curve.x.push_back(psi);
        curve.y.push_back(std::fabs(field_({.target = distance * axis, .psi = psi}).yaw()));
      }
      size.curves.push_back(std::move(curve));
    }
    size.curves.push_back({"threshold",
                           Drawing::limit_colour,
                           Mark::dashed,
                           {-pi, pi},
                           {verdict_.options.flat, verdict_.options.flat}});
    drawings_.push_back(
        {fmt::format("{}: what turns the observer", name_),
         "The gradient by the observer's heading, for targets in the direction of the axis; below "
         "the threshold nothing turns it.",
         {std::move(size)}});
  }

  Potential potential_;
  const Verdict& verdict_;
  const Potential* set_;  // a limit to be shown beside, or nullptr
  const SensorMount* mount_;
  Field field_;
  std::string name_;
  std::vector<double> sharpnesses_;  // the potential's own sharpness is in the middle
  std::vector<Drawing> drawings_;
};

}  // namespace

std::vector<Drawing> drawings_of(const Potential& potential, const Verdict& verdict, const Potential* set) {
  return Pictures(potential, verdict, set).all();
}

}  // namespace sightline
