#include "sightline/io/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>
#include <numbers>
#include <set>
#include <span>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "sightline/io/event_words.hpp"
#include "sightline/io/graph_figure.hpp"
#include "sightline/io/page.hpp"
#include "sightline/io/safety_figure.hpp"
#include "sightline/io/summary.hpp"
#include "sightline/io/swarm_figure.hpp"
#include "sightline/io/text_file.hpp"

namespace sightline {
namespace {

using Mark = Drawing::Mark;
using Curve = Drawing::Curve;
using Panel = Drawing::Panel;
using Numbers = std::vector<double>;

constexpr double none = std::numeric_limits<double>::quiet_NaN();
constexpr double two_pi = 2 * std::numbers::pi;
constexpr double paper_update_ms = 2.5;      // of CMSCGMRES on the paper's machine, section 7.2
constexpr double apart = 1.67;               // between two simultaneous positions of Fig. 20 [s]
constexpr std::size_t rows_max = 2000;       // of a curve
constexpr std::size_t rows_of_all = 16'000;  // of a curve times the bodies: a large team's page stays small
constexpr std::size_t places_max = 600;      // that are joined by a line
constexpr std::size_t robots_a_figure = 4;   // with a panel each
constexpr std::size_t label_size_max = 18;   // characters of a name in a legend
constexpr std::size_t events_max = 50;       // in the page; the log has all

// A name short enough for a legend, cut between two characters.
std::string label(std::string_view name, std::size_t size = label_size_max) {
  std::size_t characters = 0;
  for (std::size_t i = 0; i < name.size(); ++i) {
    if ((static_cast<unsigned char>(name[i]) & 0xC0) == 0x80) continue;
    if (++characters > size) return std::string(name.substr(0, i)) + "…";
  }
  return std::string(name);
}

// Columns of a run as curves, thinned so that all extremes stay.
class Curves {
 public:
  explicit Curves(const Recording& recording)
      : recording_(recording),
        rows_(std::clamp<std::size_t>(rows_of_all / std::max<std::size_t>(1, recording.bodies.size()), 200,
                                      rows_max)) {}

  // y over x, thinned so that the extremes of both stay.
  Curve curve(std::string title, std::size_t colour, Mark mark, const Numbers& x, const Numbers& y) const {
    const std::size_t size = std::min(x.size(), y.size());
    const std::array columns = {std::span(y).first(size), std::span(x).first(size)};
    const bool rising = std::is_sorted(x.begin(), x.end());  // extremes of a rising x are its ends
    Curve result{std::move(title), colour, mark, {}, {}};
    for (const std::size_t i : rows_to_draw(std::span(columns).first(rising ? 1 : 2), rows_)) {
      result.x.push_back(x[i]);
      result.y.push_back(y[i]);
    }
    return result;
  }
  Curve over_time(std::string title, std::size_t colour, Mark mark, const Numbers& y) const {
    return curve(std::move(title), colour, mark, recording_.time, y);
  }
  // A constant over all of the run.
  Curve level(std::string title, std::size_t colour, double y) const {
    const auto& t = recording_.time;
    return {std::move(title),
            colour,
            Mark::dashed,
            {t.front(), std::max(t.back(), t.front() + recording_.period)},
            {y, y}};
  }

 private:
  const Recording& recording_;
  std::size_t rows_;
};

using Axis = double Vec3<double>::*;

Numbers along(const std::vector<Vec3<double>>& p, Axis axis) {
  Numbers result;
  for (const Vec3<double>& point : p) result.push_back(point.*axis);
  return result;
}

// "Positions", or with the names of the first and the last body where there are several such figures.
std::string group_title(std::string_view what, const std::vector<std::size_t>& group, const Recording& r,
                        std::size_t all) {
  if (group.size() == all) return std::string(what);
  return fmt::format("{}: {} to {}", what, r.bodies[group.front()].name, r.bodies[group.back()].name);
}

std::vector<std::vector<std::size_t>> groups_of(std::size_t size, const std::vector<std::size_t>& bodies) {
  std::vector<std::vector<std::size_t>> groups;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (i % size == 0) groups.emplace_back();
    groups.back().push_back(bodies[i]);
  }
  return groups;
}

void add_positions(const Recording& r, const Curves& curves, const std::vector<std::size_t>& group,
                   std::size_t all, std::vector<Drawing>& drawings) {
  Drawing drawing{group_title("Positions", group, r, all),
                  "In the global frame; dashed: what the robot is asked for.",
                  {}};
  for (const auto& [name, axis] :
       {std::pair{"x [m]", &Vec3<double>::x}, {"y [m]", &Vec3<double>::y}, {"z [m]", &Vec3<double>::z}}) {
    Panel panel{.x_label = axis == &Vec3<double>::z ? "t [s]" : "", .y_label = name};
    const bool first = axis == &Vec3<double>::x;
    for (std::size_t i = 0; i < group.size(); ++i) {
      const Recording::Body& body = r.bodies[group[i]];
      const auto title = [&](std::string_view of) { return first ? label(body.name) + std::string(of) : ""; };
      panel.curves.push_back(curves.over_time(title(""), i, Mark::line, along(body.p, axis)));
      panel.curves.push_back(curves.curve(title(" reference"), i, Mark::dashed, body.reference_time,
                                          along(body.reference_p, axis)));
    }
    drawing.panels.push_back(std::move(panel));
  }
  drawings.push_back(std::move(drawing));
}

void add_headings(const Recording& r, const Curves& curves, const std::vector<std::size_t>& group,
                  std::size_t all, std::vector<Drawing>& drawings) {
  Panel panel{.x_label = "t [s]", .y_label = "ψ [rad]", .height = 260};
  for (std::size_t i = 0; i < group.size(); ++i) {
    const Recording::Body& body = r.bodies[group[i]];
    panel.curves.push_back(curves.over_time(label(body.name), i, Mark::line, body.heading));
    // The same heading may be told by angles whole turns apart: the reference starts by the nearest.
    Numbers reference = body.reference_heading;
    if (!reference.empty() && !body.heading.empty()) {
      const double turns = std::round((body.heading.front() - reference.front()) / two_pi);
      for (double& psi : reference) psi += std::isfinite(turns) ? turns * two_pi : 0.0;
    }
    panel.curves.push_back(
        curves.curve(label(body.name) + " reference", i, Mark::dashed, body.reference_time, reference));
  }
  drawings.push_back(
      {group_title("Headings", group, r, all),
       "Angle of the heading, counted on over whole turns; dashed: what the robot is asked for.",
       {std::move(panel)}});
}

void add_inputs(const Recording& r, const Curves& curves, const std::vector<std::size_t>& group,
                std::size_t all, std::vector<Drawing>& drawings) {
  Drawing drawing{group_title("Inputs", group, r, all), "As applied; dashed: their limits at the start.", {}};
  for (const std::size_t robot : group) {
    const Recording::Body& body = r.bodies[robot];
    Panel panel{.x_label = robot == group.back() ? "t [s]" : "", .y_label = label(body.name, 10) + " u [-]"};
    for (std::size_t i = 0; i < body.u.size(); ++i) {
      panel.curves.push_back(
          curves.over_time(i < body.inputs.size() ? label(body.inputs[i]) : fmt::format("u_{}", i),
                           i % Drawing::colours, Mark::line, body.u[i]));
    }
    std::set<double> limits(body.u_min.begin(), body.u_min.end());
    limits.insert(body.u_max.begin(), body.u_max.end());
    bool first = true;
    for (const double limit : limits) {
      panel.curves.push_back(
          curves.level(std::exchange(first, false) ? "limits" : "", Drawing::limit_colour, limit));
    }
    drawing.panels.push_back(std::move(panel));
  }
  drawings.push_back(std::move(drawing));
}

void add_pair(const Recording& r, const Curves& curves, const Recording::Pair& pair,
              std::vector<Drawing>& drawings) {
  const Recording::Body &observer = r.bodies.at(pair.observer), &target = r.bodies.at(pair.target);
  Numbers distances, angles;
  for (std::size_t k = 0; k < std::min({observer.p.size(), observer.heading.size(), target.p.size()}); ++k) {
    const double psi = observer.heading[k];
    distances.push_back(norm(observer.p[k] - target.p[k]));
    angles.push_back(view_angle(pair.mount, {observer.p[k], {std::cos(psi), std::sin(psi)}}, target.p[k]));
  }
  Panel distance{.x_label = "", .y_label = "D [m]", .height = 160};
  distance.curves = {
      curves.over_time("distance D", 0, Mark::line, distances),
      curves.level(fmt::format("d_min = {:.4g} m", pair.d_min), Drawing::limit_colour, pair.d_min),
      curves.level(fmt::format("d_max = {:.4g} m", pair.d_max), Drawing::limit_colour, pair.d_max)};
  Panel angle{.x_label = "t [s]", .y_label = "α_t [rad]", .height = 160};
  angle.curves = {
      curves.over_time("view angle α_t", 0, Mark::line, angles),
      curves.level(fmt::format("limit α = {:.4g} rad", pair.alpha), Drawing::limit_colour, pair.alpha)};
  drawings.push_back({fmt::format("{} sees {}: distance and view angle", observer.name, target.name),
                      "The angle lies between the axis of the sensor and the target.",
                      {std::move(distance), std::move(angle)}});
}

// Paths from above; each 1.67 s a line from observer to target and the observer's heading, as Fig. 20.
void add_paths(const Recording& r, const Curves& curves, std::vector<Drawing>& drawings) {
  Panel panel{.x_label = "x [m]", .y_label = "y [m]", .height = 620, .equal_scales = true};
  double low = none, high = none;
  Curve starts{"start", Drawing::faint_colour, Mark::points, {}, {}};
  for (std::size_t i = 0; i < r.bodies.size(); ++i) {
    const Numbers x = along(r.bodies[i].p, &Vec3<double>::x), y = along(r.bodies[i].p, &Vec3<double>::y);
    if (x.empty()) continue;
    starts.x.push_back(x.front()), starts.y.push_back(y.front());
    for (const Numbers* p : {&x, &y}) {
      for (const double v : *p) low = std::fmin(low, v), high = std::fmax(high, v);
    }
    panel.curves.push_back(curves.curve(r.bodies.size() <= Drawing::colours ? label(r.bodies[i].name) : "",
                                        i % Drawing::colours, Mark::line, x, y));
  }
  const double arrow = std::max(0.05, 0.05 * (high - low));
  const std::size_t stride =
      std::max({std::size_t{1}, static_cast<std::size_t>(std::lround(apart / std::max(r.period, 1e-4))),
                r.time.size() / places_max});
  Curve joined{"at the same time", Drawing::faint_colour, Mark::thin, {}, {}};
  std::set<std::size_t> observers;
  for (const Recording::Pair& pair : r.pairs) {
    observers.insert(pair.observer);
    const auto &from = r.bodies.at(pair.observer).p, &to = r.bodies.at(pair.target).p;
    for (std::size_t k = 0; k < std::min(from.size(), to.size()); k += stride) {
      joined.x.insert(joined.x.end(), {from[k].x, to[k].x, none});
      joined.y.insert(joined.y.end(), {from[k].y, to[k].y, none});
    }
  }
  for (std::size_t i = 0; i < r.bodies.size() && r.pairs.empty(); ++i) {
    if (r.bodies[i].is_agent) observers.insert(i);
  }
  panel.curves.insert(panel.curves.begin(), std::move(joined));
  for (const std::size_t i : observers) {
    const Recording::Body& body = r.bodies[i];
    Curve headings{"", i % Drawing::colours, Mark::arrows, {}, {}};
    for (std::size_t k = 0; k < std::min(body.p.size(), body.heading.size()); k += stride) {
      headings.x.insert(headings.x.end(), {body.p[k].x, body.p[k].x + arrow * std::cos(body.heading[k])});
      headings.y.insert(headings.y.end(), {body.p[k].y, body.p[k].y + arrow * std::sin(body.heading[k])});
    }
    panel.curves.push_back(std::move(headings));
  }
  panel.curves.push_back(std::move(starts));
  drawings.push_back(
      {"Paths from above",
       fmt::format("Arrows: headings of {}, each {:.4g} s; grey: places at the same time.",
                   r.pairs.empty() ? "the robots" : "the observers", static_cast<double>(stride) * r.period),
       {std::move(panel)}});
}

void add_solver(const Recording& r, const Curves& curves, std::vector<Drawing>& drawings) {
  Panel cost{.x_label = "", .y_label = "l [-]"},
      residual{.x_label = "", .y_label = "residual [-]", .log_y = true},
      iterations{.x_label = "t [s]", .y_label = "iterations"};
  cost.curves = {curves.over_time("stage cost l", Drawing::faint_colour, Mark::line, r.cost)};
  for (std::size_t i = 0; i < std::min(r.controllers.size(), Drawing::colours); ++i) {
    const Recording::Controller& controller = r.controllers[i];
    const std::string name = r.controllers.size() > 1 ? label(controller.name) : "";
    residual.curves.push_back(curves.over_time(name, i, Mark::thin, controller.residual));
    iterations.curves.push_back(curves.over_time(
        "", i, Mark::thin, Numbers(controller.iterations.begin(), controller.iterations.end())));
  }
  drawings.push_back({"Cost and solver",
                      "Stage cost of the closed loop; residual and iterations of each update.",
                      {std::move(cost), std::move(residual), std::move(iterations)}});
}

Numbers in_ms(const Numbers& us) {
  Numbers ms;
  for (const double value : us) ms.push_back(std::isfinite(value) && value > 0 ? value / 1000 : none);
  return ms;
}

// Fig. 24 and how the times are spread, of all solvers that flew the scenario.
void add_times(const Recording& r, const Curves& curves, std::vector<Drawing>& drawings) {
  std::vector<std::pair<std::string_view, Numbers>> solvers = {{r.solver, in_ms(r.solve_us)}};
  for (const Recording::Comparison& other : r.comparisons)
    solvers.emplace_back(other.solver, in_ms(other.solve_us));
  double least = std::numeric_limits<double>::infinity(), greatest = 0.0;
  for (const auto& [name, ms] : solvers) {
    for (const double value : ms) {
      if (value > 0) least = std::min(least, value), greatest = std::max(greatest, value);
    }
  }
  if (!(least <= greatest)) return;

  // Bins of equal length in the logarithm, each from edge i to edge i + 1.
  constexpr std::size_t bins = 120;
  const double low = 0.98 * least, ratio = std::log(1.02 * greatest / low) / bins;
  const double period = 1000 * r.period;
  double most = 0.0;
  Panel time{.x_label = "t [s]", .y_label = "time to solve [ms]", .height = 220, .log_y = true};
  Panel spread{.x_label = "time to solve [ms]", .y_label = "updates", .height = 180, .log_x = true};
  for (std::size_t i = 0; i < std::min(solvers.size(), Drawing::colours); ++i) {
    const auto& [name, ms] = solvers[i];
    Numbers t;
    double sum = 0.0;
    std::size_t measured = 0;
    Curve bars{"", i, Mark::bars, Numbers(bins + 1), Numbers(bins + 1)};
    for (std::size_t edge = 0; edge <= bins; ++edge) {
      bars.x[edge] = low * std::exp(ratio * static_cast<double>(edge));
    }
    for (const double value : ms) {
      t.push_back(static_cast<double>(t.size()) * r.period);
      if (!(value > 0)) continue;
      sum += value, ++measured;
      bars.y[std::min(bins - 1, static_cast<std::size_t>(std::log(value / low) / ratio))] += 1;
    }
    const double mean = measured > 0 ? sum / static_cast<double>(measured) : none;
    time.curves.push_back(curves.curve(
        fmt::format("{}: mean {:.3g} ms{}", label(name), mean,
                    name == "cmscgmres" ? fmt::format(" (the paper reports {} ms)", paper_update_ms) : ""),
        i, Mark::thin, t, ms));
    most = std::max(most, *std::max_element(bars.y.begin(), bars.y.end()));
    spread.curves.push_back(std::move(bars));
  }
  time.curves.push_back(
      curves.level(fmt::format("control period {:.4g} ms", period), Drawing::limit_colour, period));
  spread.curves.push_back({"", Drawing::limit_colour, Mark::dashed, {period, period}, {0.0, most}});
  drawings.push_back(
      {"Computation time of an update",
       solvers.size() > 1
           ? "Measured; each solver flew the scenario by itself. Below, how the times are spread."
           : "Measured; below, how the times are spread.",
       {std::move(time), std::move(spread)}});
}

}  // namespace

std::vector<Drawing> drawings_of(const Recording& recording) {
  if (recording.time.empty()) return {};
  const Curves curves(recording);
  std::vector<std::size_t> all, robots;
  for (std::size_t i = 0; i < recording.bodies.size(); ++i) {
    all.push_back(i);
    if (recording.bodies[i].is_agent) robots.push_back(i);
  }
  std::vector<Drawing> drawings;
  for (const Recording::Pair& pair : recording.pairs) add_pair(recording, curves, pair, drawings);
  if (auto safety = safety_drawing(recording)) drawings.push_back(std::move(*safety));
  if (auto swarm = swarm_drawing(recording)) drawings.push_back(std::move(*swarm));
  add_paths(recording, curves, drawings);
  for (const auto& group : groups_of(Drawing::colours, all)) {
    add_positions(recording, curves, group, all.size(), drawings);
  }
  for (const auto& group : groups_of(Drawing::colours, robots)) {
    add_headings(recording, curves, group, robots.size(), drawings);
  }
  for (const auto& group : groups_of(robots_a_figure, robots)) {
    add_inputs(recording, curves, group, robots.size(), drawings);
  }
  add_solver(recording, curves, drawings);
  add_times(recording, curves, drawings);
  return drawings;
}

namespace {

std::string row(std::string_view what, std::string_view value) {
  return fmt::format("<tr><th scope=\"row\">{}</th><td>{}</td></tr>\n", escaped(what), escaped(value));
}

std::string summary_table(std::string_view summary) {
  std::string table = "<h2>Summary</h2>\n<table>\n";
  for (const SummaryLine& line : summary_lines(summary)) table += row(line.what, line.value);
  return table + "</table>\n";
}

std::string comparison_table(const Recording& r, std::string_view summary) {
  if (r.comparisons.empty() || summary.empty()) return "";
  std::vector<std::string> summaries{std::string(summary)};
  for (const Recording::Comparison& other : r.comparisons) summaries.push_back(other.summary);
  std::string table = "<h2>Solvers side by side</h2>\n<table>\n";
  for (const SummaryLine& line : comparison_lines(summaries)) table += row(line.what, line.value);
  return table + "</table>\n";
}

std::string event_table(const Recording& r) {
  if (r.events.empty()) return "";
  std::string table = fmt::format("<details><summary>Events ({})</summary>\n<table>\n", r.events.size());
  for (std::size_t i = 0; i < std::min(r.events.size(), events_max); ++i) {
    const Recording::Event& event = r.events[i];
    const auto name = [&](int body) {
      const auto at = static_cast<std::size_t>(body);
      return at < r.bodies.size() ? r.bodies[at].name : fmt::format("body {}", body);
    };
    const auto script = [&](int index) {
      const auto at = static_cast<std::size_t>(index);
      return at < r.script.size() ? r.script[at] : fmt::format("event {}", index);
    };
    table += row(fmt::format("{:.2f} s", event.time), event_words(event.kind, event.value, {name, script}));
  }
  if (r.events.size() > events_max) table += row("…", "more in run.mcap");
  return table + "</table>\n</details>\n";
}

std::string read_file(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  if (!in.is_open() || in.bad()) {
    throw std::runtime_error(
        fmt::format("{} cannot be read: {}", file.string(), std::generic_category().message(errno)));
  }
  return text;
}

}  // namespace

std::string report_html(const Recording& recording, std::string_view summary) {
  const Recording& r = recording;
  const double end = r.time.empty() ? 0.0 : r.time.back() + r.period;
  std::string page = fmt::format(
      "{}<p class=\"soft\">{:.6g} s in periods of {:.4g} ms, solver {}, seed {}. sightline {}, {}.</p>\n",
      page_head(r.name), end, 1000 * r.period, escaped(r.solver), r.seed, escaped(r.version),
      escaped(r.compiler));
  if (!r.complete || summary.empty()) {
    page +=
        fmt::format("<p class=\"warning\">The run did not end by itself: its log stops at {:.6g} s{}.</p>\n",
                    end, summary.empty() ? ", and there is no summary.json" : "");
  }
  if (!summary.empty()) page += summary_table(summary);
  page += comparison_table(r, summary);
  for (const Figure& figure : graph_figures(r)) page += page_figure(figure);
  for (const Figure& figure : draw(drawings_of(r))) page += page_figure(figure);
  page += event_table(r);
  page += fmt::format("<details><summary>Scenario</summary>\n<pre>{}</pre>\n</details>\n</body>\n</html>\n",
                      escaped(r.scenario));
  return page;
}

void write_report(const std::filesystem::path& folder) {
  const Recording recording = read_recording(folder);
  const auto summary = folder / "summary.json";
  write_text(folder / "report.html",
             report_html(recording, std::filesystem::exists(summary) ? read_file(summary) : std::string()));
}

}  // namespace sightline
