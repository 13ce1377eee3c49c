#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "sightline/analysis.hpp"
#include "sightline/analysis/observation.hpp"
#include "sightline/analysis/view_band.hpp"
#include "sightline/scenario.hpp"
#include "sightline/scenario/guarantee.hpp"
#include "sightline/scenario/read_view.hpp"

namespace sightline {
namespace {

std::string limit_name(const Team& team, std::size_t coupling) {
  return fmt::format("couple[{}] {}", coupling, team.couplings()[coupling].term.potential.name());
}

std::string band(const DistanceBand& b) {
  if (std::isinf(b.high)) return b.low > 0 ? fmt::format("from {:.2f} m", b.low) : "at any distance";
  return b.low > 0 ? fmt::format("from {:.2f} to {:.2f} m", b.low, b.high)
                   : fmt::format("up to {:.2f} m", b.high);
}

std::string bands(const std::vector<DistanceBand>& all) {
  std::string text;
  for (const DistanceBand& b : all) text += (text.empty() ? "" : ", ") + band(b);
  return text;
}

/// Verb for a drift: "climb", "sink" or "wander".
std::string_view way(const Vec3<double>& drift) {
  if (std::fabs(drift.z) < norm(drift.x, drift.y)) return "wander";
  return drift.z > 0 ? "climb" : "sink";
}

std::string_view what_it_does(LimitKind kind) {
  switch (kind) {
    case LimitKind::apart:
      return "keeps them apart";
    case LimitKind::together:
      return "keeps them together";
    case LimitKind::view:
      return "looks where the other is";
    case LimitKind::none:
      break;
  }
  return "states no limit";
}

std::string_view when_broken(LimitKind kind) {
  switch (kind) {
    case LimitKind::apart:
      return "being hit";
    case LimitKind::together:
      return "being too far";
    case LimitKind::view:
      return "losing sight";
    case LimitKind::none:
      break;
  }
  return "it";
}

std::string feeling(const Team& team, std::size_t coupling) {
  std::string names;
  for (const AgentId agent : team.couplings()[coupling].felt_by) {
    names += fmt::format("{}{}", names.empty() ? "" : ", ", team.name(agent));
  }
  return names;
}

std::string pair_words(const PairAdvice& pair, const Team& team) {
  std::string text = fmt::format("{} and {}\n", team.name(pair.first), team.name(pair.second));
  for (const LimitWorth& l : pair.limits) {
    text += fmt::format("  {} {}, {}; {} costs at most {:.2f}, felt by {}\n", limit_name(team, l.coupling),
                        what_it_does(l.kind),
                        l.holds.empty() ? "can hold at no distance" : "can hold " + bands(l.holds),
                        when_broken(l.kind), l.worst, feeling(team, l.coupling));
    if (l.in_world) {
      text += fmt::format("    it depends on where in G they are: looked at around the starts of {} and {}\n",
                          team.name(pair.first), team.name(pair.second));
    }
  }
  for (const auto& [i, j] : pair.contradictions) {
    text += fmt::format("  contradiction: {} and {} cannot hold at once\n", limit_name(team, i),
                        limit_name(team, j));
  }
  if (!pair.holds.empty()) {
    text += fmt::format("  all limits can hold at once {}\n", bands(pair.holds));
  } else if (pair.contradictions.empty()) {
    text += "  contradiction: its limits cannot hold at once\n";
  }
  if (!pair.rest && pair.drift) {
    return text +
           fmt::format(
               "  no rest: {} and {} do not feel the same, and by what each feels they {} together for "
               "ever\n",
               team.name(pair.first), team.name(pair.second), way(*pair.drift));
  }
  if (!pair.rest) {
    text += fmt::format("  no equilibrium within {:.3g} m: nothing keeps them at a distance\n",
                        1.5 * explain_reach);
    return text;
  }
  const PairRest& rest = *pair.rest;
  text += fmt::format(
      "  they rest at D = {:.3f} m ({:.3f} m across, {} {:.3f} m {}), where it costs {:.2f}; at most {} "
      "more from {:.2f} to {:.2f} m\n",
      rest.distance, rest.across, team.name(pair.first), std::fabs(rest.height),
      rest.height < 0 ? "below" : "above", rest.cost, explain_margin, rest.within.low, rest.within.high);
  for (const std::size_t coupling : rest.broken) {
    text += fmt::format("  there {} is broken: raise its weight, or move its limit\n",
                        limit_name(team, coupling));
  }
  return text;
}

/// Whether no other limit that keeps the robot apart costs less; among equal costs, the first.
bool is_weakest(const HitCost& h, const Explanation& e) {
  return std::none_of(e.hits.begin(), e.hits.end(), [&](const HitCost& other) {
    return other.agent == h.agent && std::pair(other.hit, other.coupling) < std::pair(h.hit, h.coupling);
  });
}

std::string hit_words(const HitCost& h, const Team& team) {
  if (h.others == 0) {
    return fmt::format("{}: being hit costs {:.2f}, evading costs nothing: it evades\n", team.name(h.agent),
                       h.hit);
  }
  const std::string costs =
      fmt::format("{}: being hit costs {:.2f}, all else that it would lose by evading {:.2f}",
                  team.name(h.agent), h.hit, h.others);
  if (!h.weight) return costs + ": it evades\n";
  return fmt::format("{}: raise the weight of {} from {:.3g} to {:.2g}\n", costs,
                     limit_name(team, h.coupling), team.couplings()[h.coupling].term.weight, *h.weight);
}

}  // namespace

std::string to_string(const Explanation& e, const Team& team) {
  std::string text = fmt::format("Costs are at worst within {:.3g} m, weights applied.\n", explain_reach);
  for (const PairAdvice& pair : e.pairs) {
    if (!pair.same_as) {
      text += pair_words(pair, team);
      continue;
    }
    const PairAdvice& other = e.pairs[*pair.same_as];
    text += fmt::format("{} and {}: as {} and {}\n", team.name(pair.first), team.name(pair.second),
                        team.name(other.first), team.name(other.second));
  }
  for (const HitCost& h : e.hits) {
    if (h.weight || is_weakest(h, e)) text += hit_words(h, team);
  }
  if (e.pairs.empty()) text += "no couplings: each robot flies by its own cost\n";
  return text;
}

std::string explain_text(const Scenario& scenario) {
  const Team& team = scenario.team;
  std::string text = to_string(explain(team, scenario.x0), team);
  for (const ObservationCycle& cycle : observation_cycles(scenario)) text += to_string(cycle, team) + "\n";
  const std::vector<ViewBand> views = view_bands(scenario);
  for (const ViewBand& view : views) {
    if (!view.same_as) {
      text += to_string(view, team);
      continue;
    }
    const ViewBand& other = views[*view.same_as];
    text += fmt::format("{} sees the tags of {}: as {} those of {}\n", view.camera, team.name(view.target),
                        other.camera, team.name(other.target));
  }
  for (const CertifiedView& view : scenario.certified_views) text += describe(view, team);
  for (const std::string& sentence : unobservable_robots(scenario)) text += sentence + "\n";
  return text + describe(distance_guarantees(scenario), team, std::numeric_limits<std::size_t>::max());
}

}  // namespace sightline
