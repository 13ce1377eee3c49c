#include "sightline/campaign/page.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <tuple>

#include "sightline/campaign/confidence.hpp"
#include "sightline/campaign/database.hpp"
#include "sightline/campaign/paired.hpp"
#include "sightline/campaign/runs.hpp"
#include "sightline/campaign/success_map.hpp"
#include "sightline/campaign/table.hpp"
#include "sightline/judge.hpp"
#include "sightline/report/page.hpp"

namespace sightline {
namespace {

constexpr int worst_runs = 12;
constexpr int reasons_max = 3;         // in the summary; the table has all
constexpr std::size_t robots_max = 8;  // robots with own lines for energies and errors

std::string percent(double share) { return fmt::format("{:.2f} %", 100 * share); }

/// "9990 of 10000, 99.90 % (95 %: 99.82 % to 99.95 %)".
std::string share_words(std::int64_t good, std::int64_t runs) {
  if (runs == 0) return "of none";
  const Interval bounds = wilson(good, runs);
  return fmt::format("{} of {}, {} (95 %: {} to {})", good, runs,
                     percent(static_cast<double>(good) / static_cast<double>(runs)), percent(bounds.low),
                     percent(bounds.high));
}

std::string in(double value, std::string_view unit) {
  return std::isnan(value) ? "-" : fmt::format("{:.3g}{}{}", value, unit.empty() ? "" : " ", unit);
}

std::vector<CampaignLine> lines_of(Runs& runs) {
  const std::int64_t all = runs.count();
  std::vector<CampaignLine> lines;
  for (int i = 0; i < outcome_count; ++i) {
    const auto outcome = static_cast<Outcome>(i);
    const std::int64_t these = runs.count(outcome);
    if (these > 0 || i == 0) lines.push_back({std::string(to_string(outcome)), share_words(these, all)});
  }
  for (const auto& [index, reason] : runs.reasons(reasons_max))
    lines.push_back({fmt::format("run {} failed", index), reason});
  const auto quantile = [&](std::string_view column, double share, std::string_view unit) {
    return in(runs.quantile(column, share), unit);
  };
  const auto median = [&](std::string_view column, std::string_view unit) -> std::string {
    std::vector<double> values = runs.values(column);
    if (values.empty()) return "-";
    const MedianBounds bounds = bootstrap_median(std::move(values));
    return fmt::format("{} (95 %: {:.3g} to {})", in(bounds.median, unit), bounds.low, in(bounds.high, unit));
  };
  lines.push_back(
      {"time to first view",
       fmt::format("median {}, 95 % within {}, last {}; never in {} runs", median("time_to_first_view", "s"),
                   quantile("time_to_first_view", 0.95, "s"), quantile("time_to_first_view", 1.0, "s"),
                   runs.count("time_to_first_view IS NULL"))});
  lines.push_back({"fraction in view", fmt::format("median {}, least {}", median("fraction_in_view", ""),
                                                   quantile("fraction_in_view", 0.0, ""))});
  lines.push_back(
      {"least distance", fmt::format("median {}, of all {}; where it could brake at the start {}",
                                     median("min_distance", "m"), quantile("min_distance", 0.0, "m"),
                                     quantile("iif(could_brake, min_distance, NULL)", 0.0, "m"))});
  std::vector<std::string> columns = runs.energies();
  if (columns.size() > robots_max) columns.clear();
  columns.insert(columns.begin(), "energy");
  for (const std::string& column : columns) {
    const std::string quoted = sql_name(column);
    lines.push_back(
        {column, fmt::format("u'Ru summed over time: median {}, 90 % within {} to {}", median(quoted, "s"),
                             quantile(quoted, 0.05, "s"), quantile(quoted, 0.95, "s"))});
  }
  // For robots with a reference.
  std::vector<CampaignLine> tracking;
  for (const std::string& column : runs.ending_in(robot_endings[1])) {
    const std::string robot = column.substr(0, column.size() - robot_endings[1].size()),
                      heading = robot + std::string(robot_endings[2]);
    std::vector<std::string> errors;
    for (const auto& [what, of, unit] :
         {std::tuple("position", column, "m"), std::tuple("heading", heading, "rad")}) {
      const std::string quoted = sql_name(of);
      if (runs.count(fmt::format("{} IS NOT NULL", quoted)) > 0)
        errors.push_back(fmt::format("{} error (RMS) median {}, 95 % within {}", what, median(quoted, unit),
                                     quantile(quoted, 0.95, unit)));
    }
    if (!errors.empty())
      tracking.push_back({robot + " tracks its reference", fmt::format("{}", fmt::join(errors, "; "))});
  }
  if (tracking.size() <= robots_max) lines.insert(lines.end(), tracking.begin(), tracking.end());
  for (const std::string& column : runs.ending_in(localization_endings[0])) {
    const std::string robot = column.substr(0, column.size() - localization_endings[0].size());
    const std::string rmse = sql_name(column), anees = sql_name(robot + std::string(localization_endings[1])),
                      unseen = sql_name(robot + std::string(localization_endings[2]));
    lines.push_back(
        {robot + " localized by vision",
         fmt::format(
             "error (RMS) median {}, 95 % within {}, most {}, of all runs {}; ANEES {} (4 is right), of one "
             "run at most {}; at most {} without a sighting; never in {} runs",
             quantile(rmse, 0.5, "m"), quantile(rmse, 0.95, "m"), quantile(rmse, 1.0, "m"),
             quantile(fmt::format("(SELECT sqrt(avg({0} * {0})) FROM runs)", rmse), 0.0, "m"),
             quantile(fmt::format("(SELECT avg({}) FROM runs)", anees), 0.0, ""), quantile(anees, 1.0, ""),
             quantile(unseen, 1.0, "s"), runs.count(fmt::format("{} IS NULL", rmse)))});
  }
  for (const std::string& column : runs.ending_in(view_endings[0])) {
    const std::string observer = column.substr(0, column.size() - view_endings[0].size());
    const std::string certified = sql_name(column),
                      active = sql_name(observer + std::string(view_endings[1])),
                      ended = sql_name(observer + std::string(view_endings[2]));
    lines.push_back(
        {observer + " certifies its view",
         fmt::format(
             "share of the time: median {}, least {}; the filter acts: median {}, at most {}; {} times "
             "uncertified, in {} runs",
             quantile(certified, 0.5, ""), quantile(certified, 0.0, ""), quantile(active, 0.5, ""),
             quantile(active, 1.0, ""), quantile(fmt::format("(SELECT sum({}) FROM runs)", ended), 0.0, ""),
             runs.count(fmt::format("{} > 0", ended)))});
  }
  const auto restless = [&](const char* column, std::string_view unit, std::string_view what) {
    const std::int64_t these = runs.count(fmt::format("{} > 0", column));
    lines.push_back({column, these == 0 ? "none"
                                        : fmt::format("in {} of {} runs {}, at most {}", these, all, what,
                                                      quantile(column, 1.0, unit))});
  };
  restless("chatter", "of the time", "an input jumps to and fro each period");
  restless("drift", "m/s", "a robot leaves its reference until the end");
  restless("longest_out_of_view", "s", "an observer loses its target for a time");
  restless("longest_without_plan", "s", "a solver gives no plan for a time");
  if (runs.count("barrier_conflict IS NOT NULL") > 0)
    restless("barrier_conflict", "of the time", "no command keeps all that the barrier is to keep");
  lines.push_back({"periods with a violation", quantile("(SELECT sum(violations) FROM runs)", 0.0, "")});
  return lines;
}

std::string table_of(const std::vector<CampaignLine>& lines) {
  std::string html = "<table>\n";
  for (const CampaignLine& line : lines)
    html += fmt::format("<tr><th>{}</th><td>{}</td></tr>\n", escaped(line.what), escaped(line.value));
  return html + "</table>\n";
}

/// Runs over a column, a curve for each table.
Drawing distribution(std::vector<Runs>& tables, std::string_view column, const std::string& title,
                     const std::string& label, const std::string& caption) {
  constexpr int bins = 50;
  Drawing drawing{.title = title, .caption = caption};
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (Runs& runs : tables) {
    low = std::fmin(low, runs.quantile(column, 0.0));
    high = std::fmax(high, runs.quantile(column, 1.0));
  }
  if (!(low <= high)) return drawing;
  if (high - low < 1e-9) high = low + 1e-3;
  Drawing::Panel panel{.x_label = label, .y_label = "runs [%]"};
  for (std::size_t i = 0; i < tables.size(); ++i) {
    const double all = static_cast<double>(std::max<std::int64_t>(1, tables[i].count()));
    Drawing::Curve curve{tables.size() > 1 ? tables[i].name : "", i, Drawing::Mark::bars};
    const std::vector<double> counts = tables[i].histogram(column, low, high, bins);
    for (int bin = 0; bin <= bins; ++bin) {
      curve.x.push_back(low + (high - low) * bin / bins);
      curve.y.push_back(bin < bins ? 100 * counts[static_cast<std::size_t>(bin)] / all : 0.0);
    }
    panel.curves.push_back(std::move(curve));
  }
  drawing.panels.push_back(std::move(panel));
  return drawing;
}

/// Upper end of a distribution.
double largest(const Distribution& d) {
  const double most = d.kind == Distribution::Kind::normal
                          ? d.values[0] + 3 * d.values[1]
                          : *std::max_element(d.values.begin(), d.values.end());
  return d.fraction > 0 ? std::max(most, d.constant) : most;
}

std::string maps(std::vector<Runs>& tables, const CampaignPlan& plan) {
  std::string html;
  for (const StartDraw& start : plan.starts) {
    html += fmt::format(
        "<h2>Recovered, by where {0} starts</h2>\n<figure aria-label=\"map of starts\">\n"
        "<div style=\"display: flex; flex-wrap: wrap; gap: 1rem\">\n",
        escaped(start.agent));
    for (Runs& runs : tables) {
      html += fmt::format("<div style=\"flex: 0 1 430px\">{}</div>\n",
                          to_svg(runs.map_of(start.agent, std::max(largest(start.range), 1e-9)), runs.name));
    }
    html += fmt::format(
        "</div>\n<figcaption>Where {0} has {1} at the start, by horizontal distance and by bearing off its "
        "nose, "
        "which points up: green, all are recovered; yellow, half; dark red, none. The spoke is a bearing of "
        "exactly 180°. Hover over a cell for its numbers.</figcaption>\n</figure>\n",
        escaped(start.agent), escaped(start.around));
  }
  return html;
}

/// Table of the outcomes for each value of a discrete choice.
std::string choices(std::vector<Runs>& tables, const CampaignPlan& plan) {
  std::string rows;
  for (const NumberDraw& draw : plan.draws) {
    if (draw.distribution.kind != Distribution::Kind::choice || draw.distribution.values.size() < 2) continue;
    for (const double value : draw.distribution.values) {
      const std::string where = fmt::format("{} = {}", sql_name(draw.key), value);
      rows += fmt::format("<tr><th>{} = {}</th>", escaped(draw.key), value);
      for (Runs& runs : tables) {
        rows += fmt::format(
            "<td>{}</td>",
            escaped(share_words(runs.count(where + " AND outcome = 'recovered'"), runs.count(where))));
      }
      rows += "</tr>\n";
    }
  }
  if (rows.empty()) return rows;
  std::string head = "<tr><th></th>";
  for (const Runs& runs : tables) head += fmt::format("<th>{}</th>", escaped(runs.name));
  return fmt::format("<h2>Recovered, by what was chosen</h2>\n<table>\n{}</tr>\n{}</table>\n", head, rows);
}

std::string worst(Runs& runs, const std::string& command, const std::filesystem::path& folder) {
  Database::Statement query(
      runs.database(),
      fmt::format(
          "SELECT \"index\", outcome, min_distance, time_to_first_view, fraction_in_view, barrier_conflict, "
          "coalesce(reason, '') FROM runs ORDER BY "
          "CASE outcome WHEN 'failed' THEN 0 WHEN 'too_close' THEN 1 WHEN 'lost' THEN 2 ELSE 3 END, "
          "CASE outcome WHEN 'too_close' THEN min_distance ELSE -coalesce(time_to_first_view, 1e9) END, "
          "\"index\" LIMIT {}",
          worst_runs));
  std::string html =
      "<h2>Worst runs</h2>\n<table>\n<tr class=\"soft\"><td>run</td><td>outcome</td><td>least distance</td>"
      "<td>first view</td><td>in view</td><td>barrier in conflict</td><td>failed by</td></tr>\n";
  std::string lines;
  while (query.step()) {
    const std::int64_t index = query.integer(0);
    const auto value = [&](int column) { return query.number(column).value_or(std::nan("")); };
    html += fmt::format(
        "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n", index,
        escaped(query.text(1)), in(value(2), "m"), in(value(3), "s"), in(100 * value(4), "%"),
        in(100 * value(5), "%"), escaped(query.text(6)));
    lines += fmt::format("{} --only {} -o {}\n", command, index,
                         shell_word((folder / fmt::format("run_{}", index)).native()));
  }
  return html + fmt::format(
                    "</table>\n<p class=\"soft\">A dash: it never came. Each flies again, with its log and "
                    "report, by</p>\n<pre>{}</pre>\n",
                    escaped(lines));
}

}  // namespace

std::string shell_word(std::string_view text) {
  constexpr std::string_view plain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=:,./@%";
  if (!text.empty() && text.find_first_not_of(plain) == std::string_view::npos) return std::string(text);
  std::string word = "'";
  for (const char c : text) word += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return word + "'";
}

std::vector<CampaignLine> campaign_lines(const CampaignTable& table) {
  Runs runs(table);
  return lines_of(runs);
}

std::string campaign_html(const std::vector<CampaignTable>& tables, const CampaignPlan& plan,
                          const std::string& command, const std::filesystem::path& folder,
                          const std::string& more) {
  std::vector<Runs> all;
  all.reserve(tables.size());
  for (const CampaignTable& table : tables) all.emplace_back(table);
  Runs& first = all.front();

  std::string page = page_head(fmt::format("Campaign of {}", first.name));
  page += fmt::format(
      "<p class=\"soft\">{} closed loops of {:g} s. Recovered: in view within {:g} s and at the end, no two "
      "nearer "
      "than their hard distance where {:g} m/s² could brake for it at the start.</p>\n",
      first.count(), plan.duration, plan.view_within, plan.braking);
  const std::int64_t bad = first.count("outcome <> 'recovered'");
  if (bad > 0) page += fmt::format("<p class=\"warning\">{} runs were not recovered.</p>\n", bad);
  for (Runs& runs : all) page += fmt::format("<h2>{}</h2>\n", escaped(runs.name)) + table_of(lines_of(runs));
  for (std::size_t i = 1; i < tables.size(); ++i) {
    page += fmt::format("<h2>Energy of {}, compared with {}</h2>\n", escaped(tables[i].name),
                        escaped(first.name)) +
            table_of(energy_lines(tables[0], tables[i]));
  }
  page += maps(all, plan) + choices(all, plan);
  std::vector<Drawing> drawings = {
      distribution(all, "time_to_first_view", "Time to first view", "time [s]",
                   "Until every observer had seen its target once; runs that never did are not there."),
      distribution(all, "min_distance", "Least distance", "distance [m]",
                   "Of a robot to any other body, all of the run, its start too."),
      distribution(all, "fraction_in_view", "Fraction of the time in view", "fraction [-]",
                   "From the start on, all observers at once."),
      distribution(all, "energy", "Energy of the inputs", "u'Ru dt [s]", "Of all robots.")};
  return page + page_figures(std::move(drawings)) + more + worst(first, command, folder) + page_end();
}

}  // namespace sightline
