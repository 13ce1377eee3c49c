#include "sightline/analysis/potential_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "sightline/analysis/potential_figures.hpp"
#include "sightline/analysis/verdict_text.hpp"
#include "sightline/base/json_text.hpp"
#include "sightline/report/page.hpp"
#include "sightline/safety/view_cost.hpp"

namespace sightline {
namespace {

/// Start of a coupling's first body, if its potential depends on places in G.
std::optional<Vec3<double>> place_of(const Team& team, const Coupling& c, std::span<const double> x0) {
  if (x0.empty() || !sees_place(c.term.potential)) return {};
  return place_at(team, c.between.first, x0);
}

/// The set of a certified view, if the coupling is the sensor of that view; or nullptr.
const Potential* certified_set(const std::vector<Coupling>& couplings, const Coupling& sensor) {
  if (sensor.term.potential.mount() == nullptr) return nullptr;
  const auto found = std::find_if(couplings.begin(), couplings.end(), [&](const Coupling& other) {
    return other.term.potential.as<ViewCost>() != nullptr && other.between.first == sensor.between.first &&
           other.between.second == sensor.between.second;
  });
  return found != couplings.end() ? &found->term.potential : nullptr;
}

}  // namespace

std::vector<JudgedCoupling> judge_couplings(const Team& team, std::optional<std::size_t> only,
                                            const VerdictOptions& options, std::span<const double> x0) {
  std::vector<JudgedCoupling> judged;
  std::multimap<std::string, std::pair<Program, std::size_t>, std::less<>> known;
  const std::vector<Coupling> couplings = with_thirds_at(team, x0);
  for (std::size_t i = 0; i < couplings.size(); ++i) {
    if (only && *only != i) continue;
    const Potential& given = couplings[i].term.potential;
    const std::optional<Vec3<double>> around = place_of(team, couplings[i], x0);
    const Potential potential = around ? moved_to(*around, given) : given;
    Program program = formula_of(potential);
    JudgedCoupling one{i, {}, {}};
    const auto [begin, end] = known.equal_range(potential.name());
    for (auto k = begin; k != end && !one.same_as; ++k) {
      if (k->second.first == program) one.same_as = k->second.second;
    }
    if (!one.same_as) {
      one.verdict = judge(potential, options);
      one.verdict.around = around;
      describe(one.verdict);
      known.emplace(potential.name(), std::pair(std::move(program), i));
    }
    judged.push_back(std::move(one));
  }
  return judged;
}

std::string title_of(const Team& team, std::size_t coupling) {
  const Coupling& c = team.couplings()[coupling];
  std::string title = fmt::format("couple[{}] {} of {} and {}", coupling, c.term.potential.name(),
                                  team.name(c.between.first), team.name(c.between.second));
  if (c.has_third()) title += fmt::format(", past {}", team.name(c.third));
  return title;
}

std::string potential_html(const Scenario& scenario, const std::vector<JudgedCoupling>& judged) {
  std::string page = page_head(fmt::format("Potentials of {}", scenario.name));
  const std::vector<Coupling> couplings = with_thirds_at(scenario.team, scenario.x0);
  for (const JudgedCoupling& one : judged) {
    page += fmt::format("<h1 style=\"margin-top: 4rem\">{}</h1>\n",
                        escaped(title_of(scenario.team, one.coupling)));
    if (one.same_as) {
      page += fmt::format("<p>The same potential as couple[{}].</p>\n", *one.same_as);
      continue;
    }
    for (const std::string& sentence : one.verdict.warnings) {
      page += fmt::format("<p class=\"warning\">{}</p>\n", escaped(sentence));
    }
    page += "<details open><summary>Verdict</summary>\n<ul>\n";
    for (const std::string& sentence : one.verdict.words)
      page += fmt::format("<li>{}</li>\n", escaped(sentence));
    page += "</ul>\n</details>\n";
    const Potential& potential = couplings[one.coupling].term.potential;
    const auto& around = one.verdict.around;
    page += page_figures(drawings_of(around ? moved_to(*around, potential) : potential, one.verdict,
                                     certified_set(couplings, couplings[one.coupling])));
  }
  return page + page_end();
}

std::string verdict_json(const Scenario& scenario, const std::vector<JudgedCoupling>& judged) {
  using nlohmann::ordered_json;
  ordered_json couplings = ordered_json::array();
  for (const JudgedCoupling& one : judged) {
    const Coupling& c = scenario.team.couplings()[one.coupling];
    ordered_json entry = {
        {"couple", one.coupling},
        {"potential", c.term.potential.name()},
        {"between", {scenario.team.name(c.between.first), scenario.team.name(c.between.second)}},
        {"weight", c.term.weight}};
    if (one.same_as) {
      entry["same_as"] = *one.same_as;
    } else {
      entry["verdict"] = ordered_json::parse(to_json(one.verdict));
    }
    couplings.push_back(std::move(entry));
  }
  return json_text(ordered_json{{"scenario", scenario.name}, {"couplings", couplings}}, 2) + "\n";
}

}  // namespace sightline
