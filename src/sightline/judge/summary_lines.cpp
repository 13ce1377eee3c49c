#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include "sightline/base/json_text.hpp"
#include "sightline/base/sentence.hpp"
#include "sightline/judge/summary.hpp"

namespace sightline {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t lines_max = 12;  // of one kind; summary.json has all

// Formats a number for people; "-" for null.
std::string describe(const Json& value, std::string_view unit) {
  if (!value.is_number()) return "-";
  const auto number = value.get<double>();
  const double size = std::abs(number);
  const int digits = size >= 100 ? 0 : size >= 10 ? 1 : size >= 1 ? 2 : 3;
  const std::string text = value.is_number_integer() ? fmt::format("{}", value.get<std::int64_t>())
                           : size > 0 && size < 1e-3 ? fmt::format("{:.1e}", number)
                                                     : fmt::format("{:.{}f}", number, digits);
  return unit.empty() ? text : fmt::format("{} {}", text, unit);
}

std::string percent(const Json& value) {
  return value.is_number() ? fmt::format("{:.1f} %", 100.0 * value.get<double>()) : "-";
}

/// "uav0 sees ball", or "uav0 left sees ball" by its camera left.
std::string pair_name(const Json& pair) {
  return fmt::format("{}{} sees {}", pair.at("observer").get<std::string>(),
                     pair.contains("sensor") ? " " + pair.at("sensor").get<std::string>() : "",
                     pair.at("target").get<std::string>());
}

std::string times_to_solve(const Json& s) {
  const Json& us = s.at("solve_us");
  return fmt::format("mean {}, median {}, 99 % within {}, longest {}", describe(us.at("mean"), "µs"),
                     describe(us.at("median"), "µs"), describe(us.at("p99"), "µs"),
                     describe(us.at("max"), "µs"));
}

// A missing or wrong entry is a fault of the summary.
template <class Read>
auto of_summary(Read&& read) {
  try {
    return read();
  } catch (const Json::exception& e) {
    throw std::runtime_error(fmt::format("summary.json is no summary of a run: {}", sentence_of(e)));
  }
}

// Reports all entries of a list, or only the lines_max entries with the highest scores. Then `more`
// receives the number of omitted entries.
template <class Score, class Print, class More>
void report_worst(const Json& list, Score&& score, Print&& print, More&& more) {
  std::vector<const Json*> entries;
  for (const Json& entry : list) entries.push_back(&entry);
  if (entries.size() > lines_max) {
    std::stable_sort(entries.begin(), entries.end(),
                     [&](const Json* a, const Json* b) { return score(*a) > score(*b); });
  }
  for (std::size_t i = 0; i < std::min(entries.size(), lines_max); ++i) print(*entries[i]);
  if (entries.size() > lines_max) more(entries.size() - lines_max);
}

double number(const Json& value, double otherwise) {
  return value.is_number() ? value.get<double>() : otherwise;
}

std::vector<SummaryLine> lines_of(const Json& s) {
  std::vector<SummaryLine> lines;
  const auto name = [](const Json& word) { return word.get<std::string>(); };
  const auto add = [&](std::string what, std::string value) {
    lines.push_back({std::move(what), std::move(value)});
  };

  // Time in which a criterion was in force; `all` if that is the whole run.
  const auto in_force = [](const Json& judged, std::string_view all) {
    return judged.contains("in_force") ? time_words(json_text(judged.at("in_force"))) : std::string(all);
  };

  std::string statuses;
  for (const auto& [status, count] : s.at("status").items()) {
    if (count != 0)
      statuses += fmt::format("{}{} {}", statuses.empty() ? "" : ", ", describe(count, ""), status);
  }
  add("updates", fmt::format("{} ({})", describe(s.at("updates"), ""), statuses));
  if (s.contains("without_plan")) {
    const std::string gap = describe_without_plan(json_text(s.at("without_plan")));
    if (!gap.empty()) add("without a plan", gap);
  }
  add("cost",
      fmt::format("{}, the stage cost l, which has no unit, summed over time", describe(s.at("cost"), "s")));
  add("time to solve", times_to_solve(s));
  add("allocations in an update", describe(s.at("allocations_per_update"), ""));
  add("largest input",
      fmt::format("{} before the clamp, {} beyond a limit", describe(s.at("max_abs_input"), ""),
                  describe(s.at("input_violations"), "")));
  if (s.contains("applied_violations") && s.at("applied_violations") != 0)
    add("APPLIED BEYOND A LIMIT", describe(s.at("applied_violations"), "inputs"));
  if (s.at("not_finite") != 0) add("not finite", describe(s.at("not_finite"), "updates"));
  add("least distance", describe(s.at("min_distance"), "m"));
  if (s.contains("pairs_active_max"))
    add("pairs kept apart", fmt::format("at most {} at one time", describe(s.at("pairs_active_max"), "")));
  if (s.contains("pairs_left_out_max") && s.at("pairs_left_out_max") != 0)
    add("NEAR PAIRS WITHOUT ROOM", fmt::format("up to {}, in an update: a larger pairs_max keeps them apart",
                                               describe(s.at("pairs_left_out_max"), "")));
  const auto and_more = [&](std::string_view of) {
    return [&add, of](std::size_t count) {
      add("...", fmt::format("{} more {}, none of them worse", count, of));
    };
  };
  const auto report_pair = [&](const Json& pair) {
    const Json &from = pair.at("in_view_from"), &distance = pair.at("distance");
    const std::string when = in_force(pair, "");
    const std::string at_the_end = from.is_null()
                                       ? when.empty() ? "not in view at the end" : "not in view at its end"
                                   : when.empty() ? "in view for good from " + describe(from, "s")
                                                  : "in view to its end from " + describe(from, "s");
    const std::string who = pair_name(pair);
    if (when.starts_with("0.0 s")) return add(who, "never in force");
    if (pair.at("in_view_fraction").is_null()) {
      return add(who, s.contains("settle") ? fmt::format("not judged: nothing after settle = {}",
                                                         describe(s.at("settle"), "s"))
                                           : "not judged");
    }
    std::string angle = "at most " + describe(pair.at("view_angle_max"), "rad");
    if (pair.contains("planned_view_angle")) {
      const Json& planned = pair.at("planned_view_angle");
      angle += fmt::format(" and {} in the mean (planned {} before within {} RMS)",
                           describe(pair.at("view_angle_mean"), "rad"), describe(planned.at("ahead"), "s"),
                           describe(planned.at("rms"), "rad"));
    }
    add(who, fmt::format("distance {} to {}, angle {}, {} of {}; {}", describe(distance.at("min"), ""),
                         describe(distance.at("max"), "m"), angle, percent(pair.at("in_view_fraction")),
                         when.empty() ? "the time" : when, at_the_end));
  };
  report_worst(
      s.at("pairs"), [](const Json& pair) { return -number(pair.at("in_view_fraction"), 2.0); }, report_pair,
      and_more("pairs"));
  if (s.contains("idle_observers")) {
    for (const Json& idle : s.at("idle_observers"))
      add(name(idle.at("observer")) + " observes no body", time_words(json_text(idle.at("in_force"))));
  }
  const auto report_agent = [&](const Json& agent) {
    const Json& error = agent.at("rms_position_error");
    const std::string steady =
        agent.contains("tilt_max") && agent.contains("position_offset")
            ? fmt::format(", {} of it steady", describe(agent.at("position_offset"), "m"))
            : "";
    add(name(agent.at("name")),
        (error.is_null() ? "" : fmt::format("position error {} (RMS{}), ", describe(error, "m"), steady)) +
            (agent.contains("rms_heading_error")
                 ? fmt::format("heading error {} (RMS), ", describe(agent.at("rms_heading_error"), "rad"))
                 : "") +
            fmt::format("input energy {}, u'Ru summed over time", describe(agent.at("energy"), "s")) +
            (agent.contains("tilt_max")
                 ? fmt::format(", tilt at most {}", describe(agent.at("tilt_max"), "rad"))
                 : "") +
            (agent.contains("input_rate_ratio")
                 ? fmt::format(", inputs at most {:.3g} times as fast as rate_max",
                               number(agent.at("input_rate_ratio"), 0.0))
                 : ""));
  };
  report_worst(
      s.at("agents"),
      [](const Json& agent) {
        return std::pair(number(agent.at("rms_position_error"), 0.0), number(agent.at("energy"), 0.0));
      },
      report_agent, and_more("robots"));
  const auto report_localization = [&](const Json& of) {
    add(name(of.at("agent")) + " localized by vision",
        of.at("known_from").is_null()
            ? "never"
            : fmt::format(
                  "from {}, error {} and {} (RMS), ANEES {} (4 is right), {} of {} detections refused, begun "
                  "anew {} times, at most {} without one",
                  describe(of.at("known_from"), "s"), describe(of.at("rmse"), "m"),
                  describe(of.at("heading_rmse"), "rad"), describe(of.at("anees"), ""),
                  describe(of.at("rejected"), ""), describe(of.at("detections"), ""),
                  describe(of.at("restarts"), ""), describe(of.at("longest_without_sight"), "s")));
  };
  report_worst(
      s.value("localization", Json::array()), [](const Json& of) { return number(of.at("rmse"), 1e9); },
      report_localization, and_more("robots that are localized by vision"));
  const auto report_limit = [&](const Json& limit) {
    const std::string when = in_force(limit, "");
    add("limit " + name(limit.at("name")),
        limit.at("fraction").is_null() ? "never in force"
        : limit.at("fraction") == 0.0
            ? "kept" + (when.empty() ? "" : " for " + when)
            : fmt::format("broken {} of {}, at most {} on end, by up to {}", percent(limit.at("fraction")),
                          when.empty() ? "the time" : when, describe(limit.at("longest"), "s"),
                          describe(limit.at("worst"), limit.value("unit", ""))));
  };
  report_worst(
      s.at("limits"),
      [](const Json& limit) {
        return std::pair(number(limit.at("fraction"), 0.0), number(limit.at("worst"), 0.0));
      },
      report_limit, and_more("limits"));
  const auto report_chatter = [&](const Json& c) {
    add(fmt::format("chatter of {}", name(c.at("agent"))),
        fmt::format("{} oscillates at the control period, by {} in the mean, {} of the time, first at {}; {} "
                    "damps it",
                    name(c.at("input")), describe(c.at("jump"), ""), percent(c.at("share")),
                    describe(c.at("from"), "s"),
                    c.at("region").get<bool>() ? "a larger smooth of the limit as text (0.01), or a larger R,"
                                               : "a larger R or a shorter period"));
  };
  report_worst(
      s.value("chatter", Json::array()), [](const Json& c) { return number(c.at("share"), 0.0); },
      report_chatter, and_more("inputs that chatter"));
  const auto report_drift = [&](const Json& d) {
    const Json& v = d.at("velocity");
    add(fmt::format("drift of {}", name(d.at("agent"))),
        fmt::format("moves away at {} until the end, (x, y, z) = ({:.3f}, {:.3f}, {:.3f}) m/s: {}",
                    describe(d.at("speed"), "m/s"), v.at(0).get<double>(), v.at(1).get<double>(),
                    v.at(2).get<double>(),
                    d.at("from_reference").get<bool>()
                        ? "its reference does not hold it"
                        : "it has no reference, and nothing that it feels holds it"));
  };
  report_worst(
      s.value("drift", Json()), [](const Json& d) { return number(d.at("speed"), 0.0); }, report_drift,
      and_more("robots that drift"));
  if (s.contains("safety")) {
    for (auto& [what, value] : safety_lines(json_text(s.at("safety"))))
      add(std::move(what), std::move(value));
  }
  if (!s.at("events").empty()) add("events", fmt::format("{}", s.at("events").size()));
  return lines;
}

}  // namespace

std::vector<SummaryLine> summary_lines(std::string_view json) {
  return of_summary([&] { return lines_of(Json::parse(json)); });
}

std::vector<std::array<std::string, 4>> planned_rows(std::string_view text) {
  return of_summary([&] {
    const Json s = Json::parse(text);
    std::vector<std::array<std::string, 4>> rows;
    for (const Json& pair : s.at("pairs")) {
      if (!pair.contains("planned_view_angle")) continue;
      const Json& planned = pair.at("planned_view_angle");
      rows.push_back({pair_name(pair) + ": view angle, mean", describe(planned.at("mean"), "rad"),
                      describe(pair.at("view_angle_mean"), "rad"), describe(planned.at("rms"), "rad")});
    }
    for (const Json& agent : s.at("agents")) {
      if (!agent.contains("planned_tilt")) continue;
      const Json& planned = agent.at("planned_tilt");
      const std::string who = agent.at("name").get<std::string>();
      rows.push_back({who + ": tilt, largest", describe(planned.at("max"), "rad"),
                      describe(agent.at("tilt_max"), "rad"), describe(planned.at("rms"), "rad")});
      if (!agent.contains("position_offset")) continue;
      rows.push_back({who + ": distance from its reference, steady", "",
                      describe(agent.at("position_offset"), "m"), ""});
      rows.push_back({who + ": the rest of it, RMS", "", describe(agent.at("tracking_error"), "m"), ""});
    }
    return rows;
  });
}

std::vector<SummaryLine> comparison_lines(std::span<const std::string> summaries) {
  return of_summary([&] {
    std::vector<SummaryLine> lines;
    for (const std::string& text : summaries) {
      const Json s = Json::parse(text);
      lines.push_back(
          {s.at("solver"), fmt::format("{}; cost {}", times_to_solve(s), describe(s.at("cost"), "s"))});
    }
    return lines;
  });
}

std::vector<SummaryLine> partition_lines(std::string_view summary, std::string_view partition) {
  return of_summary([&] {
    const Json s = Json::parse(summary), p = Json::parse(partition);
    std::vector<SummaryLine> lines;
    if (p.at("cost") != s.at("cost")) return lines;
    std::string parts;
    for (const Json& part : p.at("parts")) {
      std::string names;
      for (const Json& name : part)
        names += fmt::format("{}{}", names.empty() ? "" : " ", name.get<std::string>());
      parts += fmt::format("{}{}", parts.empty() ? "" : ", ", names);
    }
    lines.push_back(
        {"parts", fmt::format("{}; {} order, exchanges an update: {}", parts,
                              p.at("order").get<std::string>(), describe(p.at("exchanges"), ""))});
    lines.push_back(
        {"cost ∫ l dt",
         fmt::format("{}, by one solver for the whole team {}: {:+.4f} %", describe(p.at("cost"), "s"),
                     describe(p.at("whole_cost"), "s"), 100 * p.at("cost_excess").get<double>())});
    lines.push_back(
        {"slowest part", fmt::format("{} an update, in the median", describe(p.at("part_us"), "µs"))});
    for (const Json& sweep : p.at("sweeps")) {
      lines.push_back(
          {fmt::format("after exchange {}", describe(sweep.at("sweep"), "")),
           fmt::format("|u - u*| {}, |J - J*| / J* {}, residual {} (medians at {} moments)",
                       describe(sweep.at("input").at("median"), ""),
                       describe(sweep.at("cost").at("median"), ""),
                       describe(sweep.at("kkt").at("median"), "1/s"), describe(p.at("moments"), ""))});
    }
    return lines;
  });
}

}  // namespace sightline
