/// Upper bounds of the probabilities that a flight of a campaign fails, by independent runs and by importance sampling.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sightline/analysis.hpp"
#include "sightline/campaign/page.hpp"
#include "sightline/campaign/rare_event.hpp"

namespace sightline {

/// An event and the bounds of its probability in a run.
struct CertifiedEvent {
  std::string name;       ///< "view lost for more than 0.5 s"
  std::int64_t runs = 0;  ///< independent runs, drawn by the campaign
  std::int64_t seen = 0;  ///< of these, runs with the event
  Interval bounds{};      ///< of 95 %, from these runs alone: clopper_pearson()
  std::optional<RareEvent>
      rare{};  ///< by importance sampling; none: nothing is drawn, or the event has no margin
};

struct Certificate {
  std::string scenario;
  double view_within = 0.0;  ///< time to see a target before it counts as lost [s]
  std::vector<CertifiedEvent> events;
  std::vector<std::string> premises;  ///< sentences
};

/// Bounds the probabilities that a view is lost for more than 0.5 s, that a hard distance is broken,
/// and that a robot lands that was to fly on. Events that no run could show are left out.
/// @param table       complete, of this scenario and plan
/// @param options     seed and threads
/// @param rare_runs   >= 200, further runs for each event with a margin, estimate_rare_event(); none
///   if nothing is drawn
Certificate certify(const Scenario& scenario, const CampaignPlan& plan, const CampaignTable& table,
                    const CampaignOptions& options, int rare_runs);

std::vector<CampaignLine> certificate_lines(const Certificate& certificate);
std::string certificate_json(const Certificate& certificate);
/// A section of the campaign's page.
std::string certificate_html(const Certificate& certificate);

}  // namespace sightline
