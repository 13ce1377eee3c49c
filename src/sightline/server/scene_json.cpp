#include "sightline/server/scene_json.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <iterator>
#include <list>
#include <nlohmann/json.hpp>
#include <span>

#include "sightline/base.hpp"
#include "sightline/base/json_text.hpp"
#include "sightline/potential/protection.hpp"
#include "sightline/potentials.hpp"
#include "sightline/report/scene.hpp"
#include "sightline/safety/zone.hpp"
#include "sightline/scenario/read_safety.hpp"
#include "sightline/server/limit_surface.hpp"
#include "sightline/world.hpp"

namespace sightline {
namespace {

using SceneValue = nlohmann::ordered_json;

/// Writer of a growing list or object, with the few digits that a page needs.
class JsonText {
 public:
  void number(double value, int digits) {
    if (!std::isfinite(value)) {
      text_ += "null";
    } else {
      fmt::format_to(std::back_inserter(text_), "{:.{}f}", value, digits);
    }
  }
  void significant(double value) {
    if (!std::isfinite(value)) {
      text_ += "null";
    } else {
      fmt::format_to(std::back_inserter(text_), "{:.4g}", value);
    }
  }
  void quoted(std::string_view words) { text_ += json_text(SceneValue(words)); }
  /// Adds a comma unless it is the first entry.
  void next() {
    if (text_.back() != '[' && text_.back() != '{') text_ += ',';
  }
  void key(std::string_view name) {
    next();
    fmt::format_to(std::back_inserter(text_), "\"{}\":", name);
  }
  void raw(std::string_view words) { text_ += words; }
  /// Writes a list with a function that writes one entry.
  template <class List, class Write>
  void list(const List& all, Write&& write) {
    text_ += '[';
    for (const auto& one : all) {
      next();
      write(one);
    }
    text_ += ']';
  }
  std::string take() { return std::move(text_); }

 private:
  std::string text_;
};

SceneValue or_null(double value) { return std::isfinite(value) ? SceneValue(value) : SceneValue(); }

bool is_known(const Sight<double>& s) {
  return std::isfinite(s.p.x + s.p.y + s.p.z + s.d.x + s.d.y + s.lean.x + s.lean.y);
}

SceneValue rounded(const LimitSurface& surface) {
  SceneValue corners = SceneValue::array(), triangles = SceneValue::array();
  for (const Vec3<double>& p : surface.corners)
    for (const double value : {p.x, p.y, p.z}) corners.push_back(std::round(value * 1e5) / 1e5);
  for (const auto& triangle : surface.triangles)
    for (const int corner : triangle) triangles.push_back(corner);
  return {{"reach", surface.reach},
          {"scales", surface.scales},
          {"open", surface.open},
          {"corners", std::move(corners)},
          {"triangles", std::move(triangles)}};
}

SceneValue mounted(const SensorMount& mount) {
  const Quaternion q = quaternion(rotation_from(mount.attitude()));
  return {{"offset", {mount.offset.x, mount.offset.y, mount.offset.z}},
          {"turned", {q.x, q.y, q.z, q.w}},
          {"on_body", mount.frame == MountFrame::body}};
}

/// Surfaces of a scene's limits, each once.
class SceneSurfaces {
 public:
  explicit SceneSurfaces(const Team& team) : team_(team) {}

  /// @return its index in `all`; null if there is none
  SceneValue of_pair(const Observation& pair) {
    Known& known = find(pair.potential, pair.mount, LimitSurface::Goes::with_sensor);
    const bool goes = known.surface.goes == LimitSurface::Goes::with_sensor;
    return number(known, goes, pair.potential, between(pair.observer, pair.target));
  }
  /// Adds the region of a text potential that is no view: around the second body, or in front of
  /// the first one's sensor.
  void add_zone(const Coupling& c) {
    const Potential& potential = c.term.potential;
    if (potential.as<Region>() == nullptr || observes(potential)) return;
    const auto& [first, second] = c.between;
    const SensorMount mount = potential.mount() != nullptr ? *potential.mount() : SensorMount{};
    Known& known = find(potential, mount, LimitSurface::Goes::with_target);
    const SceneValue surface = number(known, true, potential, between(first, second));
    if (surface.is_null()) return;
    const bool seen = known.surface.goes == LimitSurface::Goes::with_sensor;
    SceneValue zone = {
        {"body", seen ? first.index : second.index}, {"surface", surface}, {"name", potential.name()}};
    zone["mount"] = seen ? mounted(mount) : SceneValue();
    if (std::find(zones.begin(), zones.end(), zone) == zones.end()) zones.push_back(std::move(zone));
  }

  SceneValue all = SceneValue::array(), zones = SceneValue::array(), undrawn = SceneValue::array();

 private:
  static constexpr std::size_t most = 64;
  struct Known {
    SensorMount mount;
    LimitSurface::Goes rather;
    std::vector<double> looks;  // values of the limit at sample poses
    LimitSurface surface;
    int number = -1;  // index in `all`
  };

  std::string between(BodyId a, BodyId b) const {
    return fmt::format("{} › {}", team_.name(a), team_.name(b));
  }

  SceneValue number(Known& known, bool goes, const Potential& potential, const std::string& where) {
    const LimitSurface& surface = known.surface;
    const bool there = goes && !surface.triangles.empty();
    std::string lacks = surface.lacks;
    if (lacks.empty() && !there) lacks = "its limit does not go with the sensor";
    if (there && known.number < 0 && all.size() >= most) {
      undrawn.push_back(
          fmt::format("{} of {}: not drawn, more than {} surfaces", potential.name(), where, most));
      return {};
    }
    if (!lacks.empty())
      undrawn.push_back(
          fmt::format("{} of {}: {}drawn: {}", potential.name(), where, there ? "partly " : "not ", lacks));
    if (!there) return {};
    if (known.number < 0) {
      known.number = static_cast<int>(all.size());
      all.push_back(rounded(surface));
    }
    return known.number;
  }

  /// Computes equal limits once.
  Known& find(const Potential& potential, const SensorMount& mount, LimitSurface::Goes rather) {
    std::vector<double> looks;
    for (int i = 0; i < 40; ++i) {
      Sight<double> a{}, b{};
      a.d = b.d = {1, 0};
      b.p = {0.3 * i * std::cos(1.3 * i), 0.2 * i * std::sin(1.7 * i), 0.1 * (i - 20)};
      a.p.z = i % 3, a.v.x = i % 5, b.v.y = i % 7;
      const double limit = potential.violation(a, b, 0.1 * i);
      looks.push_back(std::isnan(limit) ? 0.1234 : limit);
    }
    for (Known& one : known_)
      if (one.looks == looks && one.mount == mount && one.rather == rather) return one;
    known_.push_back({mount, rather, std::move(looks), limit_surface(potential, mount, rather)});
    return known_.back();
  }

  const Team& team_;
  std::list<Known> known_;
};

}  // namespace

SceneJson::SceneJson(const Scenario& scenario)
    : name_(scenario.name),
      solver_(scenario.solver.name),
      period_(scenario.horizon.dt),
      duration_(scenario.simulation.duration),
      floor_(no_value),
      ceiling_(no_value),
      wind_(scenario.simulation.disturbances.wind),
      gust_(scenario.simulation.disturbances.gust_sigma),
      faults_(scenario.simulation.faults),
      late_plans_(scenario.simulation.late_plans),
      team_(scenario.team),
      couplings_(all_couplings(scenario)),
      pairs_(observations(couplings_)),
      hard_(size(team_.bodies())) {
  if (scenario.safety) {
    floor_ = scenario.safety->barrier_options.floor;
    ceiling_ = scenario.safety->barrier_options.ceiling;
    prisms_ = scenario.safety->barrier_options.zones;
    has_barrier_ = scenario.safety->barrier != BarrierMode::off;
  }
  localized_.resize(size(team_.bodies()));
  for (const LocalizedRobot& one : scenario.localization.robots) localized_[size(one.robot.index)] = true;
  for (int i = 0; i < team_.bodies(); ++i)
    if (team_.is_agent(BodyId{i})) robots_.push_back(BodyId{i});
  for (int i = 0; i < team_.bodies(); ++i)
    hard_[size(i)] = hard_distance(scenario, BodyId{i == 0 ? 1 : 0}, BodyId{i}).value_or(0.0);
  script_ = scenario.script;
  tuned_ = scenario.tuned;
}

std::string SceneJson::scene(std::string_view session, bool live) const {
  SceneValue json = {{"name", name_},
                     {"session", session},
                     {"live", live},
                     {"period", period_},
                     {"duration", duration_},
                     {"solver", solver_},
                     {"floor", or_null(floor_)},
                     {"ceiling", or_null(ceiling_)},
                     {"barrier", has_barrier_},
                     {"wind", {{"v", {wind_.x, wind_.y, wind_.z}}, {"gust", gust_}}},
                     {"faults", SceneValue::array()},
                     {"bodies", SceneValue::array()},
                     {"pairs", SceneValue::array()}};
  for (int i = 0; i < team_.bodies(); ++i) {
    const BodyId body{i};
    SceneValue entry = {{"name", team_.name(body)},
                        {"robot", team_.model(body).name()},
                        {"agent", team_.is_agent(body)},
                        {"localized", bool{localized_[size(i)]}},
                        {"hard", hard_[size(i)]}};
    if (team_.is_agent(body)) {
      const auto inputs = team_.model(body).inputs();
      const InputLimits& limits = team_.agent(body).limits;
      entry["inputs"] = std::vector<std::string>(inputs.begin(), inputs.end());
      entry["u_min"] = limits.u_min().front();
      entry["u_max"] = limits.u_max().front();
    }
    json["bodies"].push_back(std::move(entry));
  }
  for (const Fault& fault : faults_)
    json["faults"].push_back({{"name", fmt::format("{} of {}", to_string(fault.kind),
                                                   fault.body.index < 0 ? "all" : team_.name(fault.body))},
                              {"from", fault.from},
                              {"until", or_null(fault.until)}});
  for (const LatePlan& late : late_plans_)
    json["faults"].push_back({{"name", "late plans"}, {"from", late.from}, {"until", or_null(late.until)}});
  SceneSurfaces surfaces(team_);
  for (const Observation& pair : pairs_)
    json["pairs"].push_back({{"observer", pair.observer.index},
                             {"target", pair.target.index},
                             {"alpha", or_null(pair.alpha)},
                             {"d_min", or_null(pair.d_min)},
                             {"d_max", or_null(pair.d_max)},
                             {"mount", mounted(pair.mount)},
                             {"surface", surfaces.of_pair(pair)}});
  for (const Coupling& c : couplings_) surfaces.add_zone(c);
  json["surfaces"] = std::move(surfaces.all);
  json["zones"] = std::move(surfaces.zones);
  json["prisms"] = SceneValue::array();
  for (const Zone& zone : prisms_) {
    const auto [low, high] = drawn_heights(zone);
    SceneValue polygon = SceneValue::array();
    for (const Vec2<double>& corner : zone.polygon) polygon.push_back(corner.x), polygon.push_back(corner.y);
    json["prisms"].push_back(
        {{"polygon", std::move(polygon)}, {"low", low}, {"high", high}, {"keep", to_string(zone.keep)}});
  }
  json["undrawn"] = std::move(surfaces.undrawn);
  return json_text(json);
}

std::string SceneJson::moment(const ShownState& state, const std::vector<TriggeredEvent>& events) const {
  constexpr int millimetres = 3, turns = 4;
  JsonText text;
  const auto point = [&](const Vec3<double>& p) {
    for (const double value : {p.x, p.y, p.z}) text.next(), text.number(value, millimetres);
  };
  text.raw("{\"t\":");
  text.number(state.time, millimetres);
  const auto there = [&](BodyId body) {
    const auto& seen = state.seen[size(body.index)];
    return seen && is_known(*seen);
  };
  text.key("b");
  text.list(state.seen, [&](const std::optional<Sight<double>>& seen) {
    if (!seen || !is_known(*seen)) return text.raw("null");
    const Quaternion q = leaning(seen->d, seen->lean);
    text.raw("[");
    point(seen->p);
    for (const double value : {q.x, q.y, q.z, q.w}) text.next(), text.number(value, turns);
    text.raw("]");
  });
  text.key("p");
  std::size_t number = 0;
  text.list(pairs_, [&](const Observation& pair) {
    const bool requested = state.requested.empty() || state.requested[number] != 0;
    ++number;
    if (!requested || !there(pair.observer) || !there(pair.target)) return text.raw("null");
    const auto sight = [&](BodyId body) { return state.seen[size(body.index)].value_or(Sight<double>{}); };
    const Sight<double> a = first_sight(sight, pair.observer, pair.third), b = sight(pair.target);
    text.raw(is_in_view(pair, a, b, state.time) ? "[1," : "[0,");
    text.number(norm(a.p - b.p), millimetres);
    text.next();
    text.number(view_angle(pair.mount, a, b.p), turns);
    text.raw("]");
  });
  text.key("u");
  text.list(robots_, [&](BodyId robot) {
    const std::span all(state.u);
    const std::size_t from = size(team_.input_offset(robot)), count = team_.model(robot).inputs().size();
    if (from + count > all.size()) return text.raw("[]");
    text.list(all.subspan(from, count), [&](double value) { text.significant(value); });
  });
  text.key("status");
  text.quoted(state.status);
  text.key("residual");
  text.significant(state.residual);
  text.key("us");
  text.significant(state.solve_us);
  text.key("it");
  text.raw(fmt::format("{}", state.iterations));
  if (!state.levels.empty()) {
    text.key("levels");
    text.list(state.levels, [&](std::string_view level) { text.quoted(level); });
  }
  if (!state.barrier.empty()) {
    text.key("barrier");
    text.list(state.barrier, [&](char acts) { text.raw(acts != 0 ? "1" : "0"); });
  }
  if (!state.reserve.empty()) {
    text.key("reserve");
    text.list(state.reserve, [&](double value) { text.significant(value); });
  }
  const auto is_known_one = [](const PoseEstimate& e) { return e.known; };
  if (std::any_of(state.estimates.begin(), state.estimates.end(), is_known_one)) {
    text.key("e");
    std::size_t of = 0;
    text.list(state.estimates, [&](const PoseEstimate& e) {
      const BodyId robot = robots_[of++];
      if (!e.known) return text.raw("null");
      text.raw("[");
      point(e.p);
      for (int i = 0; i < 3; ++i)
        for (int j = i; j < 3; ++j) text.next(), text.significant(e.P(i, j));
      const bool reported = state.truth_known && there(robot);
      text.next(), text.significant(reported ? norm(e.p - state.seen[size(robot.index)]->p) : no_value);
      text.next(), text.significant(e.position_sigma());
      text.raw("]");
    });
  }
  if (!state.paths.empty()) {
    text.key("paths");
    text.list(state.paths, [&](const std::vector<Vec3<double>>& path) {
      text.raw("[");
      for (const Vec3<double>& p : path) point(p);
      text.raw("]");
    });
  }
  if (!events.empty()) {
    text.key("events");
    text.list(events, [&](const TriggeredEvent& event) {
      text.raw(fmt::format("[{},", event.number));
      text.number(event.time, millimetres);
      text.next();
      text.quoted(event.words);
      text.raw("]");
    });
  }
  text.raw("}");
  return text.take();
}

std::vector<char> SceneJson::requested(const PresentTeam& present) const {
  const std::vector<Observation> now = observations(present.couplings());
  std::vector<char> mask;
  for (const Observation& pair : pairs_)
    mask.push_back(
        std::any_of(now.begin(), now.end(), [&](const Observation& one) { return is_same_view(one, pair); }));
  return mask;
}

std::string SceneJson::describe(std::string_view kind, double value) const {
  const EventNames names = {
      .of_body =
          [&](int body) { return std::string(body < team_.bodies() ? team_.name(BodyId{body}) : "?"); },
      .of_event =
          [&](int number) {
            const TeamEvent* const of = flown_event(script_, tuned_.get(), size(number));
            return of != nullptr ? of->name : std::string("?");
          }};
  if (kind == to_string(EventKind::missed_period)) return fmt::format("{} periods missed", value);
  if (kind == to_string(EventKind::solver_status) && value >= 0 && value < status_count)
    return fmt::format("solver: {}", to_string(static_cast<Status>(std::lround(value))));
  return event_words(kind, value, names);
}

}  // namespace sightline
