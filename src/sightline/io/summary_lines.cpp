#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include "sightline/io/summary.hpp"

namespace sightline {
namespace {

using Json = nlohmann::ordered_json;

// A number as a person reads it; "-" for null.
std::string words(const Json& value, std::string_view unit) {
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

std::string times_to_solve(const Json& s) {
  const Json& us = s.at("solve_us");
  const std::string_view beside = s.at("solver") == "cmscgmres" ? " (the paper: 2.5 ms)" : "";
  return fmt::format("mean {}{}, median {}, 99 % within {}, longest {}", words(us.at("mean"), "µs"), beside,
                     words(us.at("median"), "µs"), words(us.at("p99"), "µs"), words(us.at("max"), "µs"));
}

// What is not there, or of another kind, is a summary's fault.
template <class Read>
std::vector<SummaryLine> of_summary(Read&& read) {
  try {
    return read();
  } catch (const Json::exception& e) {
    throw std::runtime_error(fmt::format("summary.json is no summary of a run: {}", e.what()));
  }
}

std::vector<SummaryLine> lines_of(const Json& s) {
  std::vector<SummaryLine> lines;
  const auto name = [](const Json& word) { return word.get<std::string>(); };
  const auto add = [&](std::string what, std::string value) {
    lines.push_back({std::move(what), std::move(value)});
  };

  // Over what time something was judged; all of the run in the words given.
  const auto in_force = [](const Json& judged, std::string_view all) {
    return judged.contains("in_force") ? time_words(judged.at("in_force")) : std::string(all);
  };

  std::string statuses;
  for (const auto& [status, count] : s.at("status").items()) {
    if (count != 0)
      statuses += fmt::format("{}{} {}", statuses.empty() ? "" : ", ", words(count, ""), status);
  }
  add("updates", fmt::format("{} ({})", words(s.at("updates"), ""), statuses));
  if (s.contains("without_plan")) {
    const std::string gap = without_plan_in_words(s.at("without_plan").dump());
    if (!gap.empty()) add("without a plan", gap);
  }
  add("cost", words(s.at("cost"), "s"));
  add("time to solve", times_to_solve(s));
  add("allocations in an update", words(s.at("allocations_per_update"), ""));
  add("largest input", fmt::format("{} before the clamp, {} beyond a limit", words(s.at("max_abs_input"), ""),
                                   words(s.at("input_violations"), "")));
  if (s.contains("applied_violations") && s.at("applied_violations") != 0)
    add("APPLIED BEYOND A LIMIT", words(s.at("applied_violations"), "inputs"));
  if (s.at("not_finite") != 0) add("not finite", words(s.at("not_finite"), "updates"));
  add("least distance", words(s.at("min_distance"), "m"));
  if (s.contains("pairs_active_max"))
    add("pairs kept apart", fmt::format("at most {} at one time", words(s.at("pairs_active_max"), "")));
  for (const Json& pair : s.at("pairs")) {
    const Json &from = pair.at("in_view_from"), &distance = pair.at("distance");
    const std::string when = in_force(pair, "");
    const std::string at_the_end = from.is_null()
                                       ? when.empty() ? "not in view at the end" : "not in view at its end"
                                   : when.empty() ? "in view for good from " + words(from, "s")
                                                  : "in view to its end from " + words(from, "s");
    add(fmt::format("{} sees {}", name(pair.at("observer")), name(pair.at("target"))),
        when.starts_with("0.0 s")
            ? "never in force"
            : fmt::format("distance {} to {}, angle at most {}, {} of {}; {}", words(distance.at("min"), ""),
                          words(distance.at("max"), "m"), words(pair.at("view_angle_max"), "rad"),
                          percent(pair.at("in_view_fraction")), when.empty() ? "the time" : when,
                          at_the_end));
  }
  if (s.contains("idle_observers")) {
    for (const Json& idle : s.at("idle_observers"))
      add(name(idle.at("observer")) + " observes nobody", time_words(idle.at("in_force")));
  }
  for (const Json& agent : s.at("agents")) {
    const Json& error = agent.at("rms_position_error");
    add(name(agent.at("name")),
        (error.is_null() ? "" : fmt::format("position error {} (RMS), ", words(error, "m"))) +
            fmt::format("input energy {}", words(agent.at("energy"), "s")));
  }
  for (const Json& limit : s.at("limits")) {
    const std::string when = in_force(limit, "");
    add("limit " + name(limit.at("name")),
        limit.at("fraction").is_null() ? "never in force"
        : limit.at("fraction") == 0.0
            ? "kept" + (when.empty() ? "" : " for " + when)
            : fmt::format("broken {} of {}, at most {} on end, by up to {}", percent(limit.at("fraction")),
                          when.empty() ? "the time" : when, words(limit.at("longest"), "s"),
                          words(limit.at("worst"), "")));
  }
  if (s.contains("safety")) {
    for (auto& [what, value] : safety_lines(s.at("safety").dump())) add(std::move(what), std::move(value));
  }
  if (!s.at("events").empty()) add("events", fmt::format("{}", s.at("events").size()));
  return lines;
}

}  // namespace

std::vector<SummaryLine> summary_lines(std::string_view json) {
  return of_summary([&] { return lines_of(Json::parse(json)); });
}

std::vector<SummaryLine> comparison_lines(std::span<const std::string> summaries) {
  return of_summary([&] {
    std::vector<SummaryLine> lines;
    for (const std::string& text : summaries) {
      const Json s = Json::parse(text);
      lines.push_back(
          {s.at("solver"), fmt::format("{}; cost {}", times_to_solve(s), words(s.at("cost"), "s"))});
    }
    return lines;
  });
}

}  // namespace sightline
