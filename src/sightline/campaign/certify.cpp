#include "sightline/campaign/certify.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "sightline/base.hpp"
#include "sightline/base/json_text.hpp"
#include "sightline/campaign/runs.hpp"
#include "sightline/report/page.hpp"

namespace sightline {
namespace {

constexpr double kept = 1e-12;  // below a severity of 0, for a margin of exactly 0

/// An event of a run.
struct RunEvent {
  std::string_view name;
  std::string_view known, seen;            ///< conditions of SQL
  double (*margin)(const RunResult& run);  ///< < 0: it occurred; null: it occurs or not
};

constexpr std::array<RunEvent, 3> run_events = {
    RunEvent{"view lost for more than 0.5 s", "view_margin IS NOT NULL", "view_margin < 0",
             [](const RunResult& run) { return run.view_margin; }},
    RunEvent{"distance below d_hard", "distance_margin IS NOT NULL", "distance_margin < 0",
             [](const RunResult& run) { return run.distance_margin; }},
    RunEvent{"landed without being asked", "1", "landed = 1", nullptr}};

double severity(double margin) {
  if (std::isnan(margin)) return -infinity;
  return margin < 0 ? -margin : -margin - kept;
}

RareEvent sample(const Scenario& scenario, const CampaignPlan& plan, const RunEvent& event, int dimensions,
                 const CampaignOptions& options, int runs, int stream) {
  const std::uint64_t seed = RandomStream(options.seed, StreamId::draw, stream).bits();
  return estimate_rare_event(dimensions, runs, seed, [&](const std::vector<Trial>& trials) {
    std::vector<double> severities(trials.size());
    CampaignOptions level = options;
    level.runs = static_cast<int>(trials.size());
    level.first = 0;
    level.shard = {};
    level.draw = [&](int index) {
      const Trial& trial = trials[static_cast<std::size_t>(index)];
      return run_at(plan, trial.point, trial.seed, index);
    };
    fly_campaign(scenario, plan, level, [&](const RunDraw& run, const RunResult& result) {
      severities[static_cast<std::size_t>(run.index)] = severity(event.margin(result));
    });
    return severities;
  });
}

/// The probability of an event as a sentence without an end.
std::string describe(const CertifiedEvent& event) {
  std::string text = fmt::format("probability at most {:.2g} by {} independent runs, {} with it",
                                 event.bounds.high, event.runs, event.seen);
  if (!event.rare) return text;
  if (event.rare->seen == 0)
    return text + fmt::format("; not seen in {} runs of importance sampling", event.rare->trials);
  return text + fmt::format("; {:.2g}, at most {:.2g}, by {} runs of importance sampling",
                            event.rare->probability, event.rare->bounds.high, event.rare->trials);
}

}  // namespace

Certificate certify(const Scenario& scenario, const CampaignPlan& plan, const CampaignTable& table,
                    const CampaignOptions& options, int rare_runs) {
  const int dimensions = static_cast<int>(drawn_names(plan).size());
  const bool samples = dimensions > 0;
  Certificate certificate;
  certificate.scenario = scenario.name;
  certificate.view_within = plan.view_within;
  certificate.premises = {
      "in simulation: the world, the noise and the draws of the scenario are those of reality",
      "independent runs bound the probability exactly (Clopper and Pearson), at 95 %, each event by itself"};
  certificate.premises.emplace_back(
      samples ? "importance sampling: the search has found each region of the drawn numbers that matters"
              : "no importance sampling: [campaign] draws no number that it could vary");
  Runs runs(table);
  for (std::size_t i = 0; i < run_events.size(); ++i) {
    const RunEvent& event = run_events[i];
    CertifiedEvent one{.name = std::string(event.name),
                       .runs = runs.count(std::string(event.known)),
                       .seen = runs.count(std::string(event.seen))};
    if (one.runs == 0) continue;
    one.bounds = clopper_pearson(one.seen, one.runs);
    if (samples && event.margin != nullptr)
      one.rare = sample(scenario, plan, event, dimensions, options, rare_runs, static_cast<int>(i));
    certificate.events.push_back(std::move(one));
  }
  return certificate;
}

std::vector<CampaignLine> certificate_lines(const Certificate& certificate) {
  std::vector<CampaignLine> lines;
  for (const CertifiedEvent& event : certificate.events) lines.push_back({event.name, describe(event)});
  for (const std::string& premise : certificate.premises) lines.push_back({"premise", premise});
  return lines;
}

std::string certificate_json(const Certificate& certificate) {
  nlohmann::ordered_json json = {{"scenario", certificate.scenario},
                                 {"confidence", 0.95},
                                 {"view_within", certificate.view_within},
                                 {"premises", certificate.premises}};
  for (const CertifiedEvent& event : certificate.events) {
    nlohmann::ordered_json one = {{"event", event.name},
                                  {"independent",
                                   {{"runs", event.runs},
                                    {"seen", event.seen},
                                    {"low", event.bounds.low},
                                    {"high", event.bounds.high}}}};
    if (const auto& rare = event.rare)
      one["importance_sampling"] = {
          {"runs", rare->trials},         {"levels", rare->levels},           {"seen", rare->seen},
          {"effective", rare->effective}, {"probability", rare->probability}, {"low", rare->bounds.low},
          {"high", rare->bounds.high}};
    json["events"].push_back(std::move(one));
  }
  return json_text(json, 2) + "\n";
}

std::string certificate_html(const Certificate& certificate) {
  std::string html = "<h2>Bounds of probabilities</h2>\n<table>\n";
  for (const CampaignLine& line : certificate_lines(certificate))
    html += fmt::format("<tr><th>{}</th><td>{}</td></tr>\n", escaped(line.what), escaped(line.value));
  return html + "</table>\n";
}

}  // namespace sightline
