#include "sightline/record/safety_summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "sightline/base/no_value.hpp"
#include "sightline/scenario/read_safety.hpp"

namespace sightline {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t most_shown = 8;
constexpr std::array<const char*, 3> modes = {"off", "on", "report"};
constexpr std::array<const char*, 3> wall_names = {"floor", "ceiling", "world"};
constexpr double touched = 1e-6;  // [m] a wall that is passed by less is kept

using Bound = SafetySummary::Bound;

const char* name_of(Bound::Of of) { return wall_names[static_cast<std::size_t>(of)]; }

/// Whether a robot has a height to keep: what drives on the ground has none.
bool flies(const Model& model) {
  std::vector<double> x(static_cast<std::size_t>(model.nx())), u(static_cast<std::size_t>(model.nu()));
  for (double& input : u) {
    input = 1.0;
    model.at_rest({{0, 0, 1}, {1, 0}}, x.data());
    const double before = model.sight(x.data(), u.data()).p.z;
    for (int k = 0; k < 10; ++k) model.step(x.data(), u.data(), 0.05);
    if (model.sight(x.data(), u.data()).p.z != before) return true;
    input = 0.0;
  }
  return false;
}

double excess_of(const Bound& bound, const Vec3<double>& p) {
  switch (bound.of) {
    case Bound::Of::floor:
      return bound.limit - p.z;
    case Bound::Of::ceiling:
      return p.z - bound.limit;
    case Bound::Of::world:
      break;
  }
  return std::max(std::abs(p.x), std::abs(p.y)) - bound.limit;
}

}  // namespace

bool SafetySummary::Pair::kept() const { return least2 >= d_hard * d_hard; }

bool SafetySummary::Bound::kept() const { return !(excess > touched) && (within || !counts); }

double SafetySummary::Bound::worst() const {
  const double most = counts && !within ? std::max(excess, begun) : excess;
  return of == Of::floor ? limit - most : limit + most;
}

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
  if (scenario.safety) {
    mode_ = scenario.safety->barrier;
    const Walls& judged = scenario.safety->judged;
    const auto add_bound = [&](BodyId robot, Bound::Of of, double limit) {
      if (std::isfinite(limit))
        bounds_.push_back({robot, of, limit, -std::numeric_limits<double>::infinity(), 0.0});
    };
    for (int i = 0; i < team.bodies(); ++i) {
      const BodyId body{i};
      if (!team.is_agent(body)) continue;
      if (flies(team.model(body))) {
        add_bound(body, Bound::Of::floor, judged.floor);
        add_bound(body, Bound::Of::ceiling, judged.ceiling);
      }
      add_bound(body, Bound::Of::world, judged.world);
    }
  }
  if (mode_ != BarrierMode::off) robots_.resize(team.agents().size());
}

void SafetySummary::add(double time, std::span<const Sight<double>> sights,
                        std::span<const Presence> presence, std::span<const BarrierRecord> barriers,
                        std::span<const FallbackLevel> levels) {
  ++samples_;
  add_bounds(time, sights, presence, levels);
  const auto is_there = [&](BodyId body) { return presence[at(body)] != Presence::absent; };
  for (Pair& pair : pairs_) {
    if (!is_there(pair.a) || !is_there(pair.b)) continue;
    pair.in_force.count(time, period_);
    const Vec3<double> r = sights[at(pair.a)].p - sights[at(pair.b)].p;
    const double distance2 = dot(r, r);
    if (distance2 < pair.least2) pair.least2 = distance2, pair.time = time;
  }
  for (std::size_t i = 0; i < std::min(robots_.size(), barriers.size()); ++i) {
    robots_[i].active += barriers[i].active ? 1 : 0;
    robots_[i].conflicts += barriers[i].conflict ? 1 : 0;
  }
}

void SafetySummary::add_bounds(double time, std::span<const Sight<double>> sights,
                               std::span<const Presence> presence, std::span<const FallbackLevel> levels) {
  for (Bound& bound : bounds_) {
    const auto i = at(bound.robot);
    const bool lands =
        presence[i] == Presence::land || (i < levels.size() && levels[i] >= FallbackLevel::land);
    const bool counted = bound.counts;
    bound.counts = presence[i] != Presence::absent && !(lands && bound.of == Bound::Of::floor);
    if (!bound.counts) {
      bound.within = false;
      continue;
    }
    const double excess = excess_of(bound, sights[i].p);
    if (!counted) bound.begun = excess;
    bound.within = bound.within || excess <= touched;
    if (bound.within ? excess > bound.excess : !counted) {
      bound.time = time;
      if (bound.within) bound.excess = excess;
    }
  }
}

/// The worst first, at most as many of each kind as are shown.
std::vector<SafetySummary::Bound> SafetySummary::by_excess() const {
  std::vector<Bound> sorted = bounds_;
  const auto beyond = [](const Bound& bound) {
    return std::abs(bound.worst() - bound.limit) * (bound.kept() ? -1 : 1);
  };
  std::stable_sort(sorted.begin(), sorted.end(),
                   [&](const Bound& a, const Bound& b) { return beyond(a) > beyond(b); });
  std::array<std::size_t, wall_names.size()> shown{};
  std::erase_if(sorted, [&](const Bound& bound) {
    return !std::isfinite(bound.worst()) || shown[static_cast<std::size_t>(bound.of)]++ >= most_shown;
  });
  return sorted;
}

std::vector<SafetySummary::Pair> SafetySummary::by_margin() const {
  std::vector<Pair> sorted = pairs_;
  const auto margin = [](const Pair& pair) { return std::sqrt(pair.least2) - pair.d_hard; };
  std::stable_sort(sorted.begin(), sorted.end(),
                   [&](const Pair& a, const Pair& b) { return margin(a) < margin(b); });
  if (sorted.size() > most_shown) sorted.resize(most_shown);
  return sorted;
}

std::vector<std::string> SafetySummary::broken() const {
  std::vector<std::string> sentences;
  for (const Pair& pair : by_margin()) {
    if (pair.kept()) continue;
    sentences.push_back(fmt::format("{} came within {:.4g} m of {} at {:.2f} s, d_hard is {} m",
                                    names_[at(pair.a)], std::sqrt(pair.least2), names_[at(pair.b)], pair.time,
                                    pair.d_hard));
  }
  for (std::string& sentence : broken_walls()) sentences.push_back(std::move(sentence));
  return sentences;
}

std::vector<std::string> SafetySummary::broken_walls() const {
  std::vector<std::string> sentences;
  for (const Bound& bound : by_excess()) {
    if (bound.kept()) continue;
    const std::string& who = names_[at(bound.robot)];
    const std::string limit = fmt::format("the {} is {} m", name_of(bound.of), bound.limit);
    const char* where = bound.of == Bound::Of::world ? "|p_x| or |p_y| of" : "a height of";
    sentences.push_back(bound.within || !bound.counts
                            ? fmt::format("{} came to {} {:.4g} m at {:.2f} s, {}", who, where, bound.worst(),
                                          bound.time, limit)
                            : fmt::format("{} began at {} {:.4g} m at {:.2f} s and never came within, {}",
                                          who, where, bound.worst(), bound.time, limit));
  }
  return sentences;
}

double SafetySummary::conflict_share() const {
  if (mode_ == BarrierMode::off || samples_ == 0) return no_value;
  std::int64_t most = 0;
  for (const Robot& robot : robots_) most = std::max(most, robot.conflicts);
  return static_cast<double>(most) / static_cast<double>(samples_);
}

std::string SafetySummary::json() const {
  if (pairs_.empty() && bounds_.empty() && mode_ == BarrierMode::off) return "";
  Json json;
  json["barrier"] = modes[static_cast<std::size_t>(mode_)];
  json["hard_distances"] = Json::array();
  for (const Pair& pair : by_margin()) {
    const double least = std::sqrt(pair.least2);
    json["hard_distances"].push_back({{"a", names_[at(pair.a)]},
                                      {"b", names_[at(pair.b)]},
                                      {"d_hard", pair.d_hard},
                                      {"least", std::isfinite(least) ? Json(least) : Json()},
                                      {"time", pair.time}});
    if (!pair.in_force.is_whole(static_cast<double>(samples_) * period_))
      json["hard_distances"].back()["in_force"] = Json::parse(pair.in_force.json());
  }
  json["walls"] = Json::array();
  for (const Bound& bound : by_excess()) {
    json["walls"].push_back({{"name", names_[at(bound.robot)]},
                             {"wall", name_of(bound.of)},
                             {"limit", bound.limit},
                             {"worst", bound.worst()},
                             {"time", bound.time},
                             {"kept", bound.kept()}});
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
    const std::string when =
        pair.contains("in_force") ? ", in " + time_words(pair.at("in_force").dump()) : "";
    lines.emplace_back("hard distance", fmt::format("{}: {:.4g} m at least, {} {} m{}", who, least,
                                                    least < d_hard ? "BROKEN, to be" : "kept", d_hard, when));
  }
  // Each that is broken, or else the one that was nearest to it.
  const auto told_of = [&](const Json& wall) {
    return std::any_of(lines.begin(), lines.end(),
                       [&](const auto& line) { return line.first == wall.get<std::string>(); });
  };
  for (const Json& bound : json.value("walls", Json::array())) {
    const Json& wall = bound.at("wall");
    if (bound.at("kept") == true && told_of(wall)) continue;
    lines.emplace_back(
        wall.get<std::string>(),
        fmt::format("{}: {:.4g} m at {}, {} {} m", bound.at("name").get<std::string>(),
                    bound.at("worst").get<double>(), wall == "floor" ? "least" : "most",
                    bound.at("kept") == true ? "kept" : "BROKEN, to be", bound.at("limit").get<double>()));
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
