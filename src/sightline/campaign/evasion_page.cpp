#include "sightline/campaign/evasion_page.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "sightline/analysis.hpp"
#include "sightline/report/page.hpp"
#include "sightline/scenario.hpp"

namespace sightline {
EvasionRuns evasion_runs(const Scenario& scenario, const CampaignPlan& plan, std::uint64_t seed, int runs) {
  const Variants variants(scenario, plan);
  EvasionRuns flown{scenario.name, {}};
  for (int i = 0; i < std::min(runs, evasion_runs_max); ++i) {
    const Scenario run = variants.of(draw_run(plan, seed, i));
    const auto solver = make_solver(run.solver, run.team, run.horizon);
    const Controllers controllers = {*solver};
    SimulatedClock clock;
    const auto world = make_world(run);
    EvasionTrace trace(run, *plan.evasion, sized_sample(*world, controllers));
    ClosedLoop loop(run, *world, controllers, clock, trace);
    static_cast<void>(loop.fly());
    flown.runs.push_back(std::move(trace));
  }
  return flown;
}

std::string evasion_text(const EvasionPlan& plan, std::span<const EvasionRuns> flown) {
  std::string text;
  const std::vector<std::vector<std::string>> table = evasion_table(plan, flown);
  std::size_t name = 0, source = 0;
  for (const auto& line : table) {
    name = std::max(name, line[0].size());
    source = std::max(source, line[1].size());
  }
  for (const auto& line : table) {
    text += fmt::format("{:{}}  {:{}}", line[0], name, line[1], source);
    for (std::size_t i = 2; i < line.size(); ++i) text += fmt::format("  {:>6}", line[i]);
    text += '\n';
  }
  return text;
}

std::string evasion_html(const EvasionPlan& plan, std::span<const EvasionRuns> flown) {
  std::string html = fmt::format(
      "<h2>How {} evades {} (Table 1)</h2>\n<div style=\"overflow-x: auto\"><table style=\"white-space: "
      "nowrap; font-size: 0.8rem\">\n",
      escaped(plan.agent), escaped(plan.obstacle));
  const std::vector<std::vector<std::string>> table = evasion_table(plan, flown);
  std::size_t columns = 0;
  for (const auto& line : table) columns = std::max(columns, line.size());
  html += "<tr><th style=\"width: auto\"></th><th style=\"width: auto\">run</th>";
  for (std::size_t i = 2; i < columns; ++i) html += fmt::format("<th style=\"width: auto\">{}</th>", i - 1);
  html += "</tr>\n";
  for (std::size_t k = 0; k < table.size(); ++k) {
    // Only the first source of a quantity has its name.
    const bool named = k > 0 && table[k][0] == table[k - 1][0];
    html += fmt::format("<tr><td>{}</td>", named ? "" : escaped(table[k][0]));
    for (const std::string& cell : std::span(table[k]).subspan(1))
      html += fmt::format("<td>{}</td>", escaped(cell));
    html += "</tr>\n";
  }
  html += fmt::format(
      "</table></div>\n<p class=\"soft\">Distances d_O to {} and d to {}, limits {:g} m and {:g} to {:g} m; "
      "d_O and the "
      "view angle, limit {:g} rad, count from {:g} s on.</p>\n",
      escaped(plan.obstacle), escaped(plan.target), plan.d_obstacle, plan.d_min, plan.d_max, plan.alpha,
      plan.from);
  for (const EvasionRuns& scenario : flown) html += page_figures(evasion_drawings(plan, scenario));
  return html;
}

}  // namespace sightline
