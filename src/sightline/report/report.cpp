#include "sightline/report.hpp"

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

#include "sightline/base.hpp"
#include "sightline/base/reason.hpp"
#include "sightline/base/text_file.hpp"
#include "sightline/judge/event_description.hpp"
#include "sightline/judge/planned_view.hpp"
#include "sightline/judge/summary.hpp"
#include "sightline/record/thinned_recording.hpp"
#include "sightline/report/curves.hpp"
#include "sightline/report/flown_figure.hpp"
#include "sightline/report/graph_figure.hpp"
#include "sightline/report/page.hpp"
#include "sightline/report/run_figures.hpp"

namespace sightline {
namespace {

using Mark = Drawing::Mark;
using Curve = Drawing::Curve;
using Panel = Drawing::Panel;
using Numbers = std::vector<double>;

constexpr double two_pi = 2 * std::numbers::pi;
constexpr double paper_update_ms = 2.5;     // CMSCGMRES on the paper's machine, section 7.2
constexpr std::size_t robots_a_figure = 4;  // a panel each
constexpr std::size_t events_max = 50;      // in the page; the log has all
constexpr std::size_t moments_max = 12;     // marked in the curves
constexpr std::size_t robots_max = 24;      // with curves of their own; of more, half as many with
                                            // the least distances
constexpr std::size_t pairs_max = 12;       // with figures of their own; of more, those with the
                                            // least time in view

// "Positions", with the names of the bodies if there are several such figures.
std::string group_title(std::string_view what, const std::vector<std::size_t>& group, const Recording& r,
                        std::size_t all) {
  if (group.size() == all) return std::string(what);
  std::string names;
  for (const std::size_t i : group)
    names += fmt::format("{}{}", names.empty() ? "" : ", ", label(r.bodies[i].name, 12));
  return fmt::format("{}: {}", what, names);
}

std::vector<std::vector<std::size_t>> groups_of(std::size_t size, const std::vector<std::size_t>& bodies) {
  std::vector<std::vector<std::size_t>> groups;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (i % size == 0) groups.emplace_back();
    groups.back().push_back(bodies[i]);
  }
  return groups;
}

// Adds the floor, and the ceiling if a body came near it.
bool add_bounds(const Recording& r, const Curves& curves, Panel& panel) {
  if (!std::isfinite(r.floor)) return false;
  double highest = no_value;
  for (const Curve& curve : panel.curves) {
    for (const double z : curve.y) highest = std::fmax(highest, z);
  }
  panel.curves.push_back(curves.level("", Drawing::limit_colour, r.floor));
  if (highest > 0.5 * (r.floor + r.ceiling))
    panel.curves.push_back(curves.level("", Drawing::limit_colour, r.ceiling));
  return true;
}

void add_positions(const Recording& r, const Curves& curves, const std::vector<std::size_t>& group,
                   std::size_t all, std::vector<Drawing>& drawings) {
  Drawing drawing{group_title("Positions", group, r, all), "In the global frame", {}};
  bool requested = false, bounded = false;
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
      requested = requested || !body.reference_p.empty();
    }
    if (axis == &Vec3<double>::z) bounded = add_bounds(r, curves, panel);
    drawing.panels.push_back(std::move(panel));
  }
  if (requested) drawing.caption += "; dashed: its reference";
  if (bounded) drawing.caption += "; red: floor and ceiling of [safety]";
  drawing.caption += ".";
  drawings.push_back(std::move(drawing));
}

void add_headings(const Recording& r, const Curves& curves, const std::vector<std::size_t>& group,
                  std::size_t all, std::vector<Drawing>& drawings) {
  Panel panel{.x_label = "t [s]", .y_label = "ψ [rad]", .height = 260};
  for (std::size_t i = 0; i < group.size(); ++i) {
    const Recording::Body& body = r.bodies[group[i]];
    panel.curves.push_back(curves.over_time(label(body.name), i, Mark::line, body.heading));
    // Headings may differ by whole turns: the reference starts at the nearest equivalent one.
    Numbers reference = body.reference_heading;
    if (!reference.empty() && !body.heading.empty()) {
      const double turns = std::round((body.heading.front() - reference.front()) / two_pi);
      for (double& psi : reference) psi += std::isfinite(turns) ? turns * two_pi : 0.0;
    }
    panel.curves.push_back(
        curves.curve(label(body.name) + " reference", i, Mark::dashed, body.reference_time, reference));
  }
  const bool requested = std::any_of(group.begin(), group.end(),
                                     [&](std::size_t i) { return !r.bodies[i].reference_heading.empty(); });
  drawings.push_back({group_title("Headings", group, r, all),
                      fmt::format("Angle of the heading, counted on over whole turns{}.",
                                  requested ? "; dashed: its reference" : ""),
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

/// Sight of a body in a period.
Sight<double> seen(const Recording::Body& body, std::size_t k) {
  const double psi = body.heading[k];
  return {
      {body.p[k], {std::cos(psi), std::sin(psi)}}, {}, k < body.lean.size() ? body.lean[k] : Vec2<double>{}};
}

void add_pair(const Recording& r, const Curves& curves, const Recording::Pair& pair,
              std::vector<Drawing>& drawings) {
  const Recording::Body &observer = r.bodies.at(pair.observer), &target = r.bodies.at(pair.target);
  Numbers distances, angles;
  for (std::size_t k = 0; k < std::min({observer.p.size(), observer.heading.size(), target.p.size()}); ++k) {
    distances.push_back(norm(observer.p[k] - target.p[k]));
    angles.push_back(view_angle(pair.mount, seen(observer, k), target.p[k]));
  }
  Panel distance{.x_label = "", .y_label = "D [m]", .height = 160};
  distance.curves = {
      curves.over_time("distance D", 0, Mark::line, distances),
      curves.level(fmt::format("d_min = {:.4g} m", pair.d_min), Drawing::limit_colour, pair.d_min),
      curves.level(fmt::format("d_max = {:.4g} m", pair.d_max), Drawing::limit_colour, pair.d_max)};
  Panel angle{.x_label = "t [s]", .y_label = "α_t [rad]", .height = 160};
  const PlannedAngles planned = planned_angles(r, pair);
  angle.curves = {
      curves.over_time("view angle α_t", 0, Mark::line, angles),
      curves.curve(fmt::format("planned {} s before", PlannedAhead::ahead), 1, Mark::dashed, planned.time,
                   planned.angle),
      curves.level(fmt::format("limit α = {:.4g} rad", pair.alpha), Drawing::limit_colour, pair.alpha)};
  drawings.push_back(
      {fmt::format("{} sees {}: distance and view angle", observer.name, target.name),
       fmt::format("The angle lies between the axis of the sensor and the target{}.",
                   std::isfinite(pair.alpha + pair.d_min + pair.d_max) ? "; dashed: the limits" : ""),
       {std::move(distance), std::move(angle)}});
}

// Events of the page, without the solver's status changes, which another figure shows.
std::vector<Recording::Event> events_of(const Recording& r) {
  std::vector<Recording::Event> events;
  std::copy_if(r.events.begin(), r.events.end(), std::back_inserter(events),
               [](const Recording::Event& event) { return event.kind != "solver_status"; });
  return events;
}

// Events to mark in the curves, by their numbers in the list; nearly simultaneous events share a
// mark.
std::vector<Drawing::TimeMark> moments_of(const Recording& r) {
  std::vector<Drawing::TimeMark> moments;
  const double together = 0.02 * (r.time.back() - r.time.front());
  const std::vector<Recording::Event> events = events_of(r);
  for (std::size_t i = 0; i < std::min(events.size(), events_max); ++i) {
    const Recording::Event& event = events[i];
    if (moments.empty() || event.time - moments.back().x > together) {
      if (moments.size() == moments_max) break;
      moments.push_back({event.time, fmt::format("{}", i + 1)});
    } else if (!moments.back().text.ends_with("…")) {
      moments.back().text += "…";
    }
  }
  return moments;
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
  for (const double value : us) ms.push_back(std::isfinite(value) && value > 0 ? value / 1000 : no_value);
  return ms;
}

// Fig. 24 and the distribution of the computation times, of all solvers of the scenario.
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

  // Bins of equal logarithmic width, each from edge i to edge i + 1.
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
      t.push_back(static_cast<double>(t.size()) * r.row_time());
      if (!(value > 0)) continue;
      sum += value, ++measured;
      bars.y[std::min(bins - 1, static_cast<std::size_t>(std::log(value / low) / ratio))] += 1;
    }
    const double mean = measured > 0 ? sum / static_cast<double>(measured) : no_value;
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

namespace {

// Pairs with figures; of many, those with the greatest share of time out of the cone.
std::vector<Recording::Pair> pairs_to_draw(const Recording& r) {
  std::vector<Recording::Pair> pairs = r.pairs;
  if (pairs.size() <= pairs_max) return pairs;
  std::vector<std::pair<double, std::size_t>> blind;
  for (std::size_t n = 0; n < pairs.size(); ++n) {
    const Recording::Body &observer = r.bodies.at(pairs[n].observer), &target = r.bodies.at(pairs[n].target);
    const std::size_t rows = std::min({observer.p.size(), observer.heading.size(), target.p.size()});
    double out = 0.0;
    for (std::size_t k = 0; k < rows; k += 1 + rows / 256) {
      if (view_angle(pairs[n].mount, seen(observer, k), target.p[k]) > pairs[n].alpha) out += 1.0;
    }
    blind.emplace_back(-out, n);
  }
  std::sort(blind.begin(), blind.end());
  std::vector<Recording::Pair> worst;
  for (std::size_t n = 0; n < pairs_max; ++n) worst.push_back(pairs[blind[n].second]);
  return worst;
}

// Robots with curves of their own; of many, those with the least distances, in the order of the
// team.
std::vector<std::size_t> robots_to_draw(const Recording& r, const std::vector<std::size_t>& robots) {
  if (robots.size() <= robots_max) return robots;
  std::set<std::size_t> nearest;
  for (const Nearness& pair : nearest_pairs(r, robots_max)) {
    for (const std::size_t body : {pair.first, pair.second}) {
      if (r.bodies[body].is_agent && nearest.size() < robots_max / 2) nearest.insert(body);
    }
  }
  return {nearest.begin(), nearest.end()};
}

// All panels over time span the run and show its events.
void share_time(const Recording& r, const Curves& curves, std::vector<Drawing>& drawings) {
  const std::vector<Drawing::TimeMark> moments = moments_of(r);
  for (Drawing& drawing : drawings) {
    bool first = true;
    for (Panel& panel : drawing.panels) {
      if ((panel.x_label.empty() ? drawing.panels.back() : panel).x_label != "t [s]") continue;
      panel.x_range = {{r.time.front(), curves.end()}};
      panel.moments = moments;
      if (std::exchange(first, false)) continue;
      for (Drawing::TimeMark& moment : panel.moments) moment.text.clear();
    }
  }
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
  const std::vector<std::size_t> shown = robots_to_draw(recording, robots);
  if (shown.size() < robots.size()) all = shown;
  std::vector<Drawing> drawings;
  for (const Recording::Pair& pair : pairs_to_draw(recording)) add_pair(recording, curves, pair, drawings);
  if (auto nearness = nearness_drawing(recording, curves)) drawings.push_back(std::move(*nearness));
  if (auto safety = safety_drawing(recording)) drawings.push_back(std::move(*safety));
  for (Drawing& localized : localization_drawings(recording)) drawings.push_back(std::move(localized));
  if (auto swarm = swarm_drawing(recording)) drawings.push_back(std::move(*swarm));
  drawings.push_back(paths_drawing(recording, curves));
  for (const auto& group : groups_of(Drawing::colours, all)) {
    add_positions(recording, curves, group, all.size(), drawings);
  }
  for (const auto& group : groups_of(Drawing::colours, shown)) {
    add_headings(recording, curves, group, shown.size(), drawings);
  }
  for (const auto& group : groups_of(robots_a_figure, shown)) {
    if (auto flown = flown_drawing(recording, curves, group)) {
      flown->title = group_title(flown->title, group, recording, shown.size());
      drawings.push_back(std::move(*flown));
    }
  }
  for (const auto& group : groups_of(robots_a_figure, shown)) {
    add_inputs(recording, curves, group, shown.size(), drawings);
  }
  add_solver(recording, curves, drawings);
  add_times(recording, curves, drawings);
  share_time(recording, curves, drawings);
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

std::string partition_table(std::string_view summary, std::string_view partition) {
  if (summary.empty() || partition.empty()) return "";
  std::string table;
  for (const SummaryLine& line : partition_lines(summary, partition)) table += row(line.what, line.value);
  return table.empty() ? table : "<h2>The team in parts</h2>\n<table>\n" + table + "</table>\n";
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
  const std::vector<Recording::Event> events = events_of(r);
  if (events.empty()) return "";
  std::string table = fmt::format("<details><summary>Events ({})</summary>\n<table>\n", events.size());
  for (std::size_t i = 0; i < std::min(events.size(), events_max); ++i) {
    const Recording::Event& event = events[i];
    const auto name = [&](int body) {
      const auto at = static_cast<std::size_t>(body);
      return at < r.bodies.size() ? r.bodies[at].name : fmt::format("body {}", body);
    };
    const auto script = [&](int index) {
      const auto at = static_cast<std::size_t>(index);
      return at < r.script.size() ? r.script[at] : fmt::format("event {}", index);
    };
    table += row(fmt::format("{}: {:.2f} s", i + 1, event.time),
                 event_words(event.kind, event.value, {name, script}));
  }
  if (events.size() > events_max) table += row("…", "more in run.mcap");
  return table + "</table>\n</details>\n";
}

// Notes on all figures below.
std::string notes_of(const Recording& r) {
  std::string notes;
  if (!r.time.empty() && !moments_of(r).empty())
    notes += "Dotted vertical lines are events, by their numbers in the list at the end of the page. ";
  const auto robots = static_cast<std::size_t>(std::count_if(
      r.bodies.begin(), r.bodies.end(), [](const Recording::Body& body) { return body.is_agent; }));
  if (robots > robots_max) {
    notes += fmt::format(
        "Of the {} robots those have curves of their own that came nearest to another body. ", robots);
  }
  if (r.pairs.size() > pairs_max)
    notes += fmt::format("Of the {} observers the {} that saw least are drawn. ", r.pairs.size(), pairs_max);
  if (r.stride > 1)
    notes += fmt::format("One period of {} is drawn; of times to solve, the longest of them. ", r.stride);
  return notes.empty() ? notes : fmt::format("<p class=\"soft\">{}</p>\n", escaped(notes));
}

std::string read_file(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string text{std::istreambuf_iterator<char>(in), {}};
  if (!in.is_open() || in.bad()) {
    throw std::runtime_error(fmt::format("{} cannot be read: {}", file.string(), reason(errno)));
  }
  return text;
}

}  // namespace

std::string report_html(const Recording& recording, std::string_view summary, std::string_view partition) {
  const Recording& r = recording;
  const double end = r.end();
  std::string page = fmt::format(
      "{}<p class=\"soft\">{:.6g} s in periods of {:.4g} ms, solver {}, seed {}. sightline {}, {}.</p>\n",
      page_head(r.name), end, 1000 * r.period, escaped(r.solver), r.seed, escaped(r.version),
      escaped(r.compiler));
  if (!r.complete || summary.empty()) {
    page +=
        fmt::format("<p class=\"warning\">The run did not end by itself: its log stops at {:.6g} s{}.</p>\n",
                    end, summary.empty() ? ", and there is no summary.json" : "");
  }
  if (r.lost_after)
    page += fmt::format("<p class=\"warning\">Samples are missing after {:.6g} s.</p>\n", *r.lost_after);
  if (!summary.empty()) page += summary_table(summary) + flown_table(summary);
  page += comparison_table(r, summary);
  page += partition_table(summary, partition);
  for (const Figure& figure : graph_figures(r)) page += page_figure(figure);
  for (const Figure& figure : camera_figures(r)) page += page_figure(figure);
  page += notes_of(r);
  page += page_figures(drawings_of(r)) + event_table(r);
  return page + fmt::format("<details><summary>Scenario</summary>\n<pre>{}</pre>\n</details>\n{}",
                            escaped(r.scenario), page_end());
}

void write_report(const std::filesystem::path& folder) {
  const Recording recording = read_thinned_recording(folder);
  const auto text_of = [&](const char* file) {
    return std::filesystem::exists(folder / file) ? read_file(folder / file) : std::string();
  };
  write_text(folder / "report.html",
             report_html(recording, text_of("summary.json"), text_of("partition.json")));
}

}  // namespace sightline
