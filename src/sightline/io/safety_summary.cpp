#include "sightline/io/safety_summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "sightline/io/safety_parts.hpp"

namespace sightline {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t pairs_shown = 8;
constexpr std::array<const char*, 3> modes = {"off", "on", "report"};

}  // namespace

bool SafetySummary::Pair::kept() const { return least2 >= d_hard * d_hard; }

SafetySummary::SafetySummary(const Scenario& scenario) : period_(scenario.horizon.dt) {
  const Team& team = scenario.team;
  for (int i = 0; i < team.bodies(); ++i) names_.emplace_back(team.name(BodyId{i}));
  for (int i = 0; i < team.bodies(); ++i) {
    for (int j = i + 1; j < team.bodies(); ++j) {
      const auto d_hard = hard_distance(scenario, BodyId{i}, BodyId{j});
      if (d_hard)
        pairs_.push_back({BodyId{i}, BodyId{j}, *d_hard, std::numeric_limits<double>::infinity(), 0.0});
    }
  }
  if (scenario.safety) mode_ = scenario.safety->barrier;
  if (mode_ != BarrierMode::off) robots_.resize(team.agents().size());
}

void SafetySummary::add(double time, std::span<const Sight<double>> sights,
                        std::span<const Presence> presence, std::span<const BarrierRecord> barriers) {
  ++samples_;
  const auto is_there = [&](BodyId body) {
    return presence[static_cast<std::size_t>(body.index)] != Presence::absent;
  };
  for (Pair& pair : pairs_) {
    if (!is_there(pair.a) || !is_there(pair.b)) continue;
    pair.in_force.count(time, period_);
    const Vec3<double> r =
        sights[static_cast<std::size_t>(pair.a.index)].p - sights[static_cast<std::size_t>(pair.b.index)].p;
    const double distance2 = dot(r, r);
    if (distance2 < pair.least2) pair.least2 = distance2, pair.time = time;
  }
  for (std::size_t i = 0; i < std::min(robots_.size(), barriers.size()); ++i) {
    robots_[i].active += barriers[i].active ? 1 : 0;
    robots_[i].conflicts += barriers[i].conflict ? 1 : 0;
  }
}

std::vector<SafetySummary::Pair> SafetySummary::by_margin() const {
  std::vector<Pair> sorted = pairs_;
  const auto margin = [](const Pair& pair) { return std::sqrt(pair.least2) - pair.d_hard; };
  std::stable_sort(sorted.begin(), sorted.end(),
                   [&](const Pair& a, const Pair& b) { return margin(a) < margin(b); });
  if (sorted.size() > pairs_shown) sorted.resize(pairs_shown);
  return sorted;
}

std::vector<std::string> SafetySummary::broken() const {
  std::vector<std::string> sentences;
  for (const Pair& pair : by_margin()) {
    if (pair.kept()) continue;
    sentences.push_back(fmt::format("{} came within {:.4g} m of {} at {:.2f} s, d_hard is {} m",
                                    names_[static_cast<std::size_t>(pair.a.index)], std::sqrt(pair.least2),
                                    names_[static_cast<std::size_t>(pair.b.index)], pair.time, pair.d_hard));
  }
  return sentences;
}

std::string SafetySummary::json() const {
  if (pairs_.empty() && mode_ == BarrierMode::off) return "";
  Json json;
  json["barrier"] = modes[static_cast<std::size_t>(mode_)];
  json["hard_distances"] = Json::array();
  for (const Pair& pair : by_margin()) {
    const double least = std::sqrt(pair.least2);
    json["hard_distances"].push_back({{"a", names_[static_cast<std::size_t>(pair.a.index)]},
                                      {"b", names_[static_cast<std::size_t>(pair.b.index)]},
                                      {"d_hard", pair.d_hard},
                                      {"least", std::isfinite(least) ? Json(least) : Json()},
                                      {"time", pair.time}});
    if (!pair.in_force.is_whole(static_cast<double>(samples_) * period_))
      json["hard_distances"].back()["in_force"] = pair.in_force.json();
  }
  json["agents"] = Json::array();
  const auto share = [&](std::int64_t part) {
    return samples_ > 0 ? static_cast<double>(part) / static_cast<double>(samples_) : 0.0;
  };
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    json["agents"].push_back({{"name", names_[i]},
                              {"barrier_active", share(robots_[i].active)},
                              {"barrier_conflict", share(robots_[i].conflicts)}});
  }
  return json.dump();
}

std::vector<std::pair<std::string, std::string>> safety_lines(std::string_view text) {
  const Json json = Json::parse(text);
  std::vector<std::pair<std::string, std::string>> lines;
  for (const Json& pair : json.at("hard_distances")) {
    const std::string who =
        fmt::format("{} and {}", pair.at("a").get<std::string>(), pair.at("b").get<std::string>());
    if (pair.at("least").is_null()) continue;
    const double least = pair.at("least").get<double>(), d_hard = pair.at("d_hard").get<double>();
    const std::string when = pair.contains("in_force") ? ", in " + time_words(pair.at("in_force")) : "";
    lines.emplace_back("hard distance", fmt::format("{}: {:.4g} m at least, {} {} m{}", who, least,
                                                    least < d_hard ? "BROKEN, to be" : "kept", d_hard, when));
  }
  for (const Json& agent : json.at("agents")) {
    const double active = agent.at("barrier_active").get<double>(),
                 conflict = agent.at("barrier_conflict").get<double>();
    lines.emplace_back(
        "barrier of " + agent.at("name").get<std::string>(),
        fmt::format("{} {:.1f} % of the time{}", json.at("barrier") == "on" ? "acted" : "would have acted",
                    100 * active, conflict > 0 ? fmt::format(", in conflict {:.1f} %", 100 * conflict) : ""));
  }
  return lines;
}

}  // namespace sightline
