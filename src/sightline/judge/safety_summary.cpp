#include "sightline/judge/safety_summary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <utility>

#include "sightline/base.hpp"
#include "sightline/base/json_text.hpp"
#include "sightline/judge/summary_keys.hpp"
#include "sightline/model/state_roles.hpp"
#include "sightline/safety/zone.hpp"
#include "sightline/scenario/read_safety.hpp"

namespace sightline {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t most_shown = 8;
constexpr std::array<const char*, 3> modes = {"off", "on", "report"};
constexpr std::array<const char*, 4> wall_names = {"floor", "ceiling", "world", "zone"};
constexpr double wall_tolerance = 1e-6;      // [m] tolerated excess over a wall
constexpr double distance_tolerance = 1e-9;  // [m] tolerated deficit below d_hard
constexpr double shown_time = 0.005;         // [s] shorter times are omitted from texts
constexpr double nothing = -std::numeric_limits<double>::infinity();

using Bound = SafetySummary::Bound;

const char* name_of(Bound::Of of) { return wall_names[static_cast<std::size_t>(of)]; }

/// Outward normals of a bound; a zone has none.
std::span<const Vec3<double>> sides(Bound::Of of) {
  static constexpr std::array<Vec3<double>, 4> level = {{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}}};
  static constexpr std::array<Vec3<double>, 2> upright = {{{0, 0, -1}, {0, 0, 1}}};
  if (of == Bound::Of::zone) return {};
  if (of == Bound::Of::world) return level;
  return std::span(upright).subspan(of == Bound::Of::floor ? 0 : 1, 1);
}

/// Limit along such a normal [m].
double limit_along(const Bound& bound) { return bound.of == Bound::Of::floor ? -bound.value : bound.value; }

double excess_of(const Bound& bound, const Vec3<double>& p) {
  double most = nothing;
  for (const Vec3<double>& n : sides(bound.of)) most = std::max(most, dot(n, p) - limit_along(bound));
  return most;
}

double part_of(std::int64_t updates, std::int64_t all) {
  return all > 0 ? static_cast<double>(updates) / static_cast<double>(all) : 0.0;
}

std::string for_how_long(double time) {
  return time >= shown_time ? fmt::format(", for {:.2f} s", time) : "";
}

}  // namespace

bool LimitRecord::raise(const Extreme& most) noexcept {
  if (most.value > worst_.value) worst_ = most;
  return most.value > tolerance_;
}

void LimitRecord::begin(double time, double excess, bool excused) noexcept {
  counts_ = true;
  excused_ = excused && excess > tolerance_;
  time_ = time, excess_ = excess;
  if (excused_)
    start_ = {excess, time};
  else
    (void)raise({excess, time});
}

void LimitRecord::cease() noexcept {
  if (excused_) {
    (void)raise(start_);
    broken_for_ += std::exchange(outside_for_, 0.0);
  }
  pause();
}

bool LimitRecord::move(double time, double excess, const Extreme& most) noexcept {
  // The excess is linear between two samples on opposite sides of the limit.
  const bool was = excess_ > tolerance_, is = excess > tolerance_;
  const double across = was != is ? std::abs((was ? excess_ : excess) / (excess - excess_)) : 1.0;
  const double beyond = was || is ? (time - time_) * across : 0.0;
  time_ = time, excess_ = excess;
  if (!excused_) {
    broken_for_ += beyond;
    return raise(most);
  }
  outside_for_ += beyond;
  if (is) {
    if (most.value > start_.value) start_ = most;
    return false;
  }
  excused_ = false;
  return raise({excess, time});
}

double SafetySummary::Bound::worst() const {
  return of == Of::floor || of == Of::zone ? value - limit.worst().value : value + limit.worst().value;
}

SafetySummary::SafetySummary(const Scenario& scenario, double d_hard_otherwise, bool start_outside)
    : motion_(scenario.team, scenario.simulation.disturbances.input_delay, scenario.horizon.dt),
      period_(scenario.horizon.dt) {
  const Team& team = scenario.team;
  for (int i = 0; i < team.bodies(); ++i) names_.emplace_back(team.name(BodyId{i}));
  for (int i = 0; i < team.bodies(); ++i) {
    for (int j = i + 1; j < team.bodies(); ++j) {
      const BodyId a{i}, b{j};
      if (team.is_agent(a) || team.is_agent(b))
        pairs_.push_back({a, b, hard_distance(scenario, a, b).value_or(d_hard_otherwise),
                          LimitRecord(distance_tolerance)});
    }
  }
  if (scenario.safety) {
    mode_ = scenario.safety->barrier;
    start_outside_ = start_outside || scenario.safety->start_outside;
    const Walls& judged = scenario.safety->judged;
    const auto add_bound = [&](BodyId robot, Bound::Of of, double value) {
      if (std::isfinite(value)) bounds_.push_back({robot, of, value, LimitRecord(wall_tolerance)});
    };
    zones_ = scenario.safety->barrier_options.zones;
    zones_to_land_ = zones_to_land(zones_);
    for (int i = 0; i < team.bodies(); ++i) {
      const BodyId body{i};
      if (!team.is_agent(body)) continue;
      if (has_height(team.model(body))) {
        add_bound(body, Bound::Of::floor, judged.floor);
        add_bound(body, Bound::Of::ceiling, judged.ceiling);
      }
      add_bound(body, Bound::Of::world, judged.world);
      for (std::size_t k = 0; k < zones_.size(); ++k) {
        add_bound(body, Bound::Of::zone, 0.0);
        bounds_.back().zone = k;
      }
    }
  }
  if (mode_ != BarrierMode::off) robots_.resize(team.agents().size());
  for (const CertifiedView& view : scenario.certified_views)
    views_.push_back({view.observer, view.target, team.agent_index(view.observer), view.bounds.speed});
}

void SafetySummary::look_at_brakes(std::span<const Sight<double>> sights, std::span<const Presence> presence,
                                   double braking) noexcept {
  for (Pair& pair : pairs_) {
    if (pair.met || presence[at(pair.a)] == Presence::absent || presence[at(pair.b)] == Presence::absent)
      continue;
    pair.met = true;
    const Sight<double>&a = sights[at(pair.a)], &b = sights[at(pair.b)];
    const Vec3<double> r = a.p - b.p;
    const double distance = norm(r);
    const double closing = distance > 0 ? std::max(0.0, -dot(r, a.v - b.v) / distance) : 0.0;
    pair.could_brake = pair.d_hard == 0 || distance >= pair.d_hard + closing * closing / (2 * braking);
  }
}

void SafetySummary::add(const Sample& sample, std::span<const Sight<double>> sights) noexcept {
  motion_.follow(sample, sights);
  too_close_now_ = false;
  for (Pair& pair : pairs_) add_pair(pair, sample, sights);
  for (Bound& bound : bounds_) add_bound(bound, sample, sights);
  too_close_ = too_close_ || too_close_now_;
  for (int i = 0; i < sample.event_count; ++i) {
    const Event& event = sample.events[static_cast<std::size_t>(i)];
    if (event.kind == EventKind::missed_period && !sample.truth_known) unseen_ += std::llround(event.value);
    if (event.kind != EventKind::view_uncertified) continue;
    for (View& view : views_)
      if (view.observer.index == static_cast<int>(event.value) &&
          (view.is_in_force(sample) || (view.was_in_force && view.ends(sample))))
        ++view.uncertified;
  }
  if (sample.of != Sample::Of::update) return;
  ++samples_;
  for (std::size_t i = 0; i < std::min(robots_.size(), sample.barriers.size()); ++i) {
    robots_[i].active += sample.barriers[i].active ? 1 : 0;
    robots_[i].conflicts += sample.barriers[i].conflict ? 1 : 0;
  }
  for (View& view : views_) {
    view.was_in_force = view.is_in_force(sample);
    if (!view.was_in_force) continue;
    const ViewRecord& record = sample.views[view.robot];
    ++view.updates;
    view.active += record.active ? 1 : 0;
    view.certified += record.certified ? 1 : 0;
    if (record.certified) view.least = std::min(view.least, record.reserve);
  }
}

void SafetySummary::add_pair(Pair& pair, const Sample& sample,
                             std::span<const Sight<double>> sights) noexcept {
  const bool was_there = std::exchange(pair.there, sample.presence[at(pair.a)] != Presence::absent &&
                                                       sample.presence[at(pair.b)] != Presence::absent);
  if (!pair.there) return pair.limit.cease();
  if (sample.of == Sample::Of::update) pair.in_force.count(sample.time, period_);
  const Vec3<double> r = sights[at(pair.a)].p - sights[at(pair.b)].p;
  const double distance2 = dot(r, r);
  // Skip pairs that could not reach their minimum distance so far or d_hard.
  const bool moved = motion_.moved(pair.a) && motion_.moved(pair.b);
  const double of_note =
      std::max(pair.least.value, pair.d_hard) + (moved ? motion_.reach(pair.a) + motion_.reach(pair.b) : 0.0);
  const bool is_near = !(distance2 > of_note * of_note);
  const double distance = is_near || !pair.limit.counts() ? std::sqrt(distance2) : of_note;
  Extreme nearest{distance, sample.time};
  if (is_near && moved) motion_.find_least_distance(pair.a, pair.b, nearest);
  if (nearest.value < pair.least.value) pair.least = nearest;
  if (pair.d_hard == 0) return;
  bool broken = false;
  if (was_there && pair.limit.counts()) {
    broken =
        pair.limit.move(sample.time, pair.d_hard - distance, {pair.d_hard - nearest.value, nearest.time});
  } else {
    pair.limit.begin(sample.time, pair.d_hard - distance, start_outside_);
    broken = !pair.limit.kept() && !pair.limit.never_within() && distance < pair.d_hard - distance_tolerance;
  }
  too_close_now_ = too_close_now_ || (broken && pair.could_brake);
}

void SafetySummary::add_bound(Bound& bound, const Sample& sample,
                              std::span<const Sight<double>> sights) noexcept {
  const auto i = at(bound.robot);
  const bool lands = sample.presence[i] == Presence::land ||
                     (i < sample.levels.size() && sample.levels[i] >= FallbackLevel::land);
  const bool there = sample.presence[i] != Presence::absent,
             was_there = std::exchange(bound.was_there, there);
  if (!there) return bound.limit.cease();
  if (lands && bound.of == Bound::Of::floor) return bound.limit.pause();
  const bool of_zone = bound.of == Bound::Of::zone;
  const Zone* const zone = of_zone ? &(lands ? zones_to_land_ : zones_)[bound.zone] : nullptr;
  const double excess = of_zone ? -zone_reserve(*zone, sights[i].p) : excess_of(bound, sights[i].p);
  // With the landing the floor of a room begins or ends.
  if (lands != std::exchange(bound.was_landing, lands) && of_zone &&
      zones_[bound.zone].from > zones_to_land_[bound.zone].from)
    bound.limit.pause();
  // A robot that stops landing climbs from below the floor, which is excused.
  if (!bound.limit.counts()) return bound.limit.begin(sample.time, excess, start_outside_ || was_there);
  Extreme most{excess, sample.time};
  if (motion_.moved(bound.robot) && excess + motion_.reach(bound.robot) > bound.limit.worst().value) {
    const std::span<const Knot> knots = motion_.knots(bound.robot);
    const double limit = of_zone ? 0.0 : limit_along(bound);
    Extreme along{most.value + limit, most.time};
    for (std::size_t k = 0; of_zone && k + 1 < knots.size(); ++k)
      find_greatest(knots[k], knots[k + 1], *zone, along);
    for (const Vec3<double>& n : sides(bound.of)) {
      for (std::size_t k = 0; k + 1 < knots.size(); ++k) find_greatest(knots[k], knots[k + 1], n, along);
    }
    most = {along.value - limit, along.time};
  }
  (void)bound.limit.move(sample.time, excess, most);
}

double SafetySummary::least_distance() const {
  double least = std::numeric_limits<double>::infinity();
  for (const Pair& pair : pairs_) least = std::min(least, pair.least.value);
  return least;
}

double SafetySummary::distance_margin() const {
  double margin = infinity;
  for (const Pair& pair : pairs_)
    if (pair.d_hard > 0 && pair.could_brake) margin = std::min(margin, pair.least.value - pair.d_hard);
  if (!std::isfinite(margin)) return no_value;
  return too_close_ ? std::min(margin, -distance_tolerance) : std::max(margin, 0.0);
}

bool SafetySummary::could_brake() const {
  return std::all_of(pairs_.begin(), pairs_.end(), [](const Pair& pair) { return pair.could_brake; });
}

/// Worst first, at most most_shown of each kind.
std::vector<SafetySummary::Bound> SafetySummary::by_excess() const {
  std::vector<Bound> sorted = bounds_;
  std::erase_if(sorted, [](const Bound& bound) { return bound.limit.empty(); });
  std::stable_sort(sorted.begin(), sorted.end(), [](const Bound& a, const Bound& b) {
    return std::pair(!a.limit.kept(), a.limit.worst().value) >
           std::pair(!b.limit.kept(), b.limit.worst().value);
  });
  std::array<std::size_t, wall_names.size()> shown{};
  std::erase_if(
      sorted, [&](const Bound& bound) { return shown[static_cast<std::size_t>(bound.of)]++ >= most_shown; });
  return sorted;
}

std::vector<SafetySummary::Pair> SafetySummary::by_margin() const {
  std::vector<Pair> sorted = pairs_;
  std::erase_if(sorted, [](const Pair& pair) { return pair.d_hard == 0; });
  std::stable_sort(sorted.begin(), sorted.end(), [](const Pair& a, const Pair& b) {
    return std::pair(!a.limit.kept(), a.limit.worst().value) >
           std::pair(!b.limit.kept(), b.limit.worst().value);
  });
  if (sorted.size() > most_shown) sorted.erase(sorted.begin() + most_shown, sorted.end());
  return sorted;
}

std::vector<std::string> SafetySummary::broken() const {
  std::vector<std::string> sentences;
  for (const Pair& pair : by_margin()) {
    if (pair.limit.kept()) continue;
    const Extreme& worst = pair.limit.worst();
    sentences.push_back(
        fmt::format("{} {} {:.4g} m of {} at {:.2f} s{}, d_hard is {} m{}", names_[at(pair.a)],
                    pair.limit.never_within() ? "began within" : "came within", pair.d_hard - worst.value,
                    names_[at(pair.b)], worst.time, pair.limit.never_within() ? " and they never parted" : "",
                    pair.d_hard, for_how_long(pair.limit.broken_for())));
  }
  for (std::string& sentence : broken_walls()) sentences.push_back(std::move(sentence));
  return sentences;
}

std::vector<std::string> SafetySummary::broken_walls() const {
  std::vector<std::string> sentences;
  for (const Bound& bound : by_excess()) {
    if (bound.limit.kept()) continue;
    if (bound.of == Bound::Of::zone) {
      sentences.push_back(broken_zone(bound));
      continue;
    }
    const bool never = bound.limit.never_within();
    sentences.push_back(fmt::format(
        "{} {} {} {:.4g} m at {:.2f} s{}, the {} is {} m{}", names_[at(bound.robot)],
        never ? "began at" : "came to", bound.of == Bound::Of::world ? "|p_x| or |p_y| of" : "a height of",
        bound.worst(), bound.limit.worst().time, never ? " and never came within" : "", name_of(bound.of),
        bound.value, for_how_long(bound.limit.broken_for())));
  }
  return sentences;
}

std::string SafetySummary::broken_zone(const Bound& bound) const {
  const Zone::Keep keep = zones_[bound.zone].keep,
                   other = keep == Zone::Keep::inside ? Zone::Keep::outside : Zone::Keep::inside;
  const bool never = bound.limit.never_within();
  return fmt::format("{} {} {:.4g} m {} zone {} at {:.2f} s{}, to be {}{}", names_[at(bound.robot)],
                     never ? "began" : "came", -bound.worst(), to_string(other), bound.zone,
                     bound.limit.worst().time, never ? " and never changed sides" : "", to_string(keep),
                     for_how_long(bound.limit.broken_for()));
}

double SafetySummary::conflict_share() const {
  if (mode_ == BarrierMode::off || samples_ == 0) return no_value;
  std::int64_t most = 0;
  for (const Robot& robot : robots_) most = std::max(most, robot.conflicts);
  return part_of(most, samples_);
}

std::string SafetySummary::json() const {
  const std::vector<Pair> pairs = by_margin();
  const std::vector<Bound> bounds = by_excess();
  if (pairs.empty() && bounds_.empty() && mode_ == BarrierMode::off && views_.empty()) return "";
  Json json;
  json["barrier"_key] = modes[static_cast<std::size_t>(mode_)];
  if (unseen_ > 0) json["unseen_periods"_key] = unseen_;
  const auto add_times = [](Json& to, const LimitRecord& limit) {
    to["broken_for"_key] = limit.kept() ? 0.0 : limit.broken_for();
    if (limit.outside_at_start() > 0) to["outside_at_start"_key] = limit.outside_at_start();
  };
  json["hard_distances"_key] = Json::array();
  for (const Pair& pair : pairs) {
    const LimitRecord& limit = pair.limit;
    Json& one = json["hard_distances"_key].emplace_back(
        Json{{"a"_key, names_[at(pair.a)]},
             {"b"_key, names_[at(pair.b)]},
             {"d_hard"_key, pair.d_hard},
             {"least"_key, limit.empty() ? Json() : Json(pair.d_hard - limit.worst().value)},
             {"time"_key, limit.worst().time},
             {"kept"_key, limit.kept()}});
    add_times(one, limit);
    if (!pair.in_force.is_whole(static_cast<double>(samples_) * period_))
      one["in_force"_key] = Json::parse(pair.in_force.json());
  }
  json["walls"_key] = Json::array();
  for (const Bound& bound : bounds) {
    if (bound.of == Bound::Of::zone) {
      Json& one = json["zones"_key].emplace_back(Json{{"name"_key, names_[at(bound.robot)]},
                                                      {"zone"_key, bound.zone},
                                                      {"keep"_key, to_string(zones_[bound.zone].keep)},
                                                      {"least"_key, bound.worst()},
                                                      {"time"_key, bound.limit.worst().time},
                                                      {"kept"_key, bound.limit.kept()}});
      add_times(one, bound.limit);
      continue;
    }
    Json& one = json["walls"_key].emplace_back(Json{{"name"_key, names_[at(bound.robot)]},
                                                    {"wall"_key, name_of(bound.of)},
                                                    {"limit"_key, bound.value},
                                                    {"worst"_key, bound.worst()},
                                                    {"time"_key, bound.limit.worst().time},
                                                    {"kept"_key, bound.limit.kept()}});
    add_times(one, bound.limit);
  }
  json["agents"_key] = Json::array();
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    json["agents"_key].push_back({{"name"_key, names_[i]},
                                  {"barrier_active"_key, part_of(robots_[i].active, samples_)},
                                  {"barrier_conflict"_key, part_of(robots_[i].conflicts, samples_)}});
  }
  for (const View& view : views_) {
    json["views"_key].push_back({{"observer"_key, names_[at(view.observer)]},
                                 {"target"_key, names_[at(view.target)]},
                                 {"speed_max"_key, view.speed},
                                 {"in_force"_key, part_of(view.updates, samples_)},
                                 {"certified"_key, part_of(view.certified, view.updates)},
                                 {"uncertified"_key, view.uncertified},
                                 {"active"_key, part_of(view.active, view.updates)},
                                 {"reserve"_key, std::isfinite(view.least) ? Json(view.least) : Json()}});
  }
  return json_text(json);
}

std::vector<RobotView> SafetySummary::views() const {
  std::vector<RobotView> all;
  for (const View& view : views_)
    all.push_back({.observer = names_[at(view.observer)],
                   .target = names_[at(view.target)],
                   .certified = view.updates > 0 ? part_of(view.certified, view.updates) : no_value,
                   .active = view.updates > 0 ? part_of(view.active, view.updates) : no_value,
                   .uncertified = view.uncertified});
  return all;
}

std::vector<std::pair<std::string, std::string>> safety_lines(std::string_view text) {
  const Json json = Json::parse(text);
  std::vector<std::pair<std::string, std::string>> lines;
  // Texts for the time outside at an excused start, and for the time of a violation.
  const auto times = [](const Json& of) {
    const double broken_for = of.value("broken_for", 0.0), outside = of.value("outside_at_start", 0.0);
    if (of.value("kept", true) && outside > 0)
      return fmt::format(", outside at the start for {:.2f} s, then kept", outside);
    return for_how_long(broken_for);
  };
  for (const Json& pair : json.at("hard_distances")) {
    const std::string who =
        fmt::format("{} and {}", pair.at("a").get<std::string>(), pair.at("b").get<std::string>());
    if (pair.at("least").is_null()) continue;
    const double least = pair.at("least").get<double>(), d_hard = pair.at("d_hard").get<double>();
    const std::string when =
        pair.contains("in_force") ? ", in " + time_words(json_text(pair.at("in_force"))) : "";
    const bool kept = pair.value("kept", least >= d_hard);
    lines.emplace_back("hard distance",
                       fmt::format("{}: {:.4g} m at least, {} {} m{}{}", who, least,
                                   kept ? "kept" : "BROKEN, to be", d_hard, times(pair), when));
  }
  // One line for each wall that is broken or was exceeded at the start, otherwise for the one with
  // the least margin.
  const auto has_line = [&](const std::string& wall) {
    return std::any_of(lines.begin(), lines.end(), [&](const auto& line) { return line.first == wall; });
  };
  for (const Json& bound : json.value("walls", Json::array())) {
    const std::string wall = bound.at("wall").get<std::string>();
    const bool kept = bound.at("kept").get<bool>();
    if (kept && !bound.contains("outside_at_start") && has_line(wall)) continue;
    lines.emplace_back(
        wall, fmt::format("{}: {:.4g} m at {}, {} {} m{}", bound.at("name").get<std::string>(),
                          bound.at("worst").get<double>(), wall == "floor" ? "least" : "most",
                          kept ? "kept" : "BROKEN, to be", bound.at("limit").get<double>(), times(bound)));
  }
  for (const Json& zone : json.value("zones", Json::array())) {
    const std::string what = fmt::format("zone {}", zone.at("zone").get<std::size_t>());
    const bool kept = zone.at("kept").get<bool>();
    if (kept && !zone.contains("outside_at_start") && has_line(what)) continue;
    lines.emplace_back(
        what, fmt::format("{}: {:.4g} m from its boundary at least, {} {}{}",
                          zone.at("name").get<std::string>(), zone.at("least").get<double>(),
                          kept ? "kept" : "BROKEN, to be", zone.at("keep").get<std::string>(), times(zone)));
  }
  if (json.contains("unseen_periods"))
    lines.emplace_back("missed periods",
                       fmt::format("{} were not seen, only the measurements around them are judged",
                                   json.at("unseen_periods").get<std::int64_t>()));
  for (const Json& agent : json.at("agents")) {
    const double active = agent.at("barrier_active").get<double>(),
                 conflict = agent.at("barrier_conflict").get<double>();
    lines.emplace_back(
        "barrier of " + agent.at("name").get<std::string>(),
        fmt::format("{} {:.1f} % of the time{}", json.at("barrier") == "on" ? "acted" : "would have acted",
                    100 * active, conflict > 0 ? fmt::format(", in conflict {:.1f} %", 100 * conflict) : ""));
  }
  for (const Json& view : json.value("views", Json::array())) {
    const auto ended = view.value("uncertified", std::int64_t{0});
    const double in_force = view.value("in_force", 1.0);
    lines.emplace_back(
        "view of " + view.at("target").get<std::string>(),
        fmt::format("by {}{}: certified {:.1f} % of the time for {} m/s, its filter acted {:.1f} %{}",
                    view.at("observer").get<std::string>(),
                    in_force < 1 ? fmt::format(", in force {:.1f} % of the run", 100 * in_force) : "",
                    100 * view.at("certified").get<double>(), view.at("speed_max").get<double>(),
                    100 * view.at("active").get<double>(),
                    ended > 0 ? fmt::format(", uncertified {} times", ended) : ""));
  }
  return lines;
}

}  // namespace sightline
