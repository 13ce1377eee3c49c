#include "sightline/scenario/read_view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>
#include <variant>

#include "sightline/model/state_roles.hpp"
#include "sightline/ocp/apply_action.hpp"
#include "sightline/potential/protection.hpp"
#include "sightline/run/team_barrier.hpp"
#include "sightline/run/team_view.hpp"
#include "sightline/safety/view_cost.hpp"
#include "sightline/safety/view_filter.hpp"
#include "sightline/scenario/reach.hpp"
#include "sightline/scenario/read_estimate.hpp"
#include "sightline/scenario/read_part.hpp"
#include "sightline/scenario/read_safety.hpp"

namespace sightline {
namespace {

/// The limits of a pair that say where the target must be: sensors and distances.
struct ViewLimits {
  std::vector<Potential> all;
  double weight = 0.0;  // the greatest of those that act on the observer
};
ViewLimits limits_of(const std::vector<Coupling>& couplings, BodyId observer, BodyId target) {
  ViewLimits limits;
  for (const Coupling& coupling : couplings) {
    const Potential& potential = coupling.term.potential;
    const auto is_between = [&](BodyId first, BodyId second) {
      return coupling.between.first == first && coupling.between.second == second;
    };
    const bool is_symmetric = potential.mount() == nullptr;
    if (!is_between(observer, target) && !(is_symmetric && is_between(target, observer))) continue;
    if (!observes(potential) && !keeps_apart(potential) && !potential.d_min() && !potential.d_max()) continue;
    limits.all.push_back(potential);
    const auto& felt_by = coupling.felt_by;
    if (std::find(felt_by.begin(), felt_by.end(), observer) != felt_by.end())
      limits.weight = std::max(limits.weight, coupling.term.weight);
  }
  return limits;
}

bool is_observed(std::span<const Coupling> couplings, BodyId observer, BodyId target) {
  return std::any_of(couplings.begin(), couplings.end(), [&](const Coupling& c) {
    return is_view_of(c, {observer, target});
  });
}

/// The couplings of the start, or after the first event by which the observer observes the target: the
/// event alone, or with those before it.
std::vector<Coupling> couplings_of_view(const ScenarioSpec& scenario, const CertifiedView& view) {
  const std::vector<Coupling>& at_start = scenario.team.couplings();
  if (is_observed(at_start, view.observer, view.target)) return at_start;
  ActiveTeam together(scenario.team, scenario.presence);
  for (const TeamEvent& event : scenario.script.events) {
    ActiveTeam alone(scenario.team, scenario.presence);
    for (ActiveTeam* const after : {&alone, &together}) {
      for (const Action& action : event.actions) (void)after->apply(action, 0.0, 0.0);
      std::vector<Coupling> couplings = after->couplings();
      std::erase_if(couplings, [](const Coupling& c) { return !c.ramp.lasts(); });
      if (is_observed(couplings, view.observer, view.target)) return couplings;
    }
  }
  return {};
}

/// Whether an action turns the observer to the target.
bool turns_to(const Action& action, const CertifiedView& view) {
  const auto* observe = std::get_if<Observe>(&action);
  return observe != nullptr && observe->observer == view.observer && observe->target == view.target;
}

/// Whether an event of the scenario does.
bool turns_to(const Script& script, const CertifiedView& view) {
  return std::any_of(script.events.begin(), script.events.end(), [&](const TeamEvent& event) {
    return std::any_of(event.actions.begin(), event.actions.end(),
                       [&](const Action& action) { return turns_to(action, view); });
  });
}

/// The couplings that an action adds or gives another potential. Those of the observer that may have moved
/// to the target by then are also among them as couplings with the target.
std::vector<Coupling> made_by(const Action& action, const ScenarioSpec& scenario, const CertifiedView& view) {
  if (const auto* add = std::get_if<AddCoupling>(&action)) return {add->coupling};
  if (const auto* hand_over = std::get_if<HandOver>(&action)) return hand_over->couplings;
  const auto* retune = std::get_if<RetuneTerm>(&action);
  std::vector<Coupling> made;
  if (retune == nullptr || !retune->potential) return made;
  for (Coupling& c : stated_couplings(scenario)) {
    if (c.name != retune->name) continue;
    c.term.potential = *retune->potential;
    made.push_back(c);
    const bool moves = c.term.potential.mount() != nullptr || c.term.potential.d_max();
    if (c.between.first != view.observer || c.between.second == view.target || !moves ||
        !turns_to(scenario.script, view))
      continue;
    c.between.second = view.target;
    made.push_back(std::move(c));
  }
  return made;
}

/// The limits of the pair when the view begins, and all that events give it: the set keeps them at any time.
ViewLimits all_limits_of(const ScenarioSpec& scenario, const CertifiedView& view) {
  ViewLimits limits = limits_of(couplings_of_view(scenario, view), view.observer, view.target);
  for (const TeamEvent& event : scenario.script.events) {
    for (const Action& action : event.actions) {
      for (Potential& one : limits_of(made_by(action, scenario, view), view.observer, view.target).all) {
        const auto is_same = [&](const Potential& known) {  // the one by which the view begins
          return one.mount() != nullptr && known.mount() == one.mount();
        };
        if (std::none_of(limits.all.begin(), limits.all.end(), is_same)) limits.all.push_back(std::move(one));
      }
    }
  }
  return limits;
}

/// Whether the observer may observe the target by this action, which it did not before.
bool begins_view(const Action& action, const ScenarioSpec& scenario, const CertifiedView& view) {
  return turns_to(action, view) || is_observed(made_by(action, scenario, view), view.observer, view.target);
}

/// Whether the observer observes the target through two sensors in the scenario; at one time or not.
bool has_two_sensors(const ScenarioSpec& scenario, const CertifiedView& view) {
  const SensorMount* first = nullptr;
  const auto is_another = [&](const SensorMount* mount) {
    if (first == nullptr) first = mount;
    return mount != nullptr && *mount != *first;
  };
  const auto have_another = [&](std::span<const Coupling> couplings) {
    return std::any_of(couplings.begin(), couplings.end(), [&](const Coupling& c) {
      return is_view_of(c, {view.observer, view.target}) && is_another(c.term.potential.mount());
    });
  };
  if (have_another(scenario.team.couplings())) return true;
  for (const TeamEvent& event : scenario.script.events) {
    for (const Action& action : event.actions) {
      if (have_another(made_by(action, scenario, view))) return true;
      if (!turns_to(action, view)) continue;
      const auto& through = std::get<Observe>(action).through;
      if (through && is_another(&*through)) return true;
    }
  }
  return false;
}

/// Adds the sets of the views to the costs: at the start, and at the end of the events that begin a
/// view. A set leaves by itself with the last coupling that observes its pair (apply_action()).
/// @param sets  of each view; of weight 0: none
void couple_sets(ScenarioSpec& scenario, const std::vector<CertifiedView>& views, std::vector<Coupling> sets,
                 const std::vector<std::string>& places) {
  for (TeamEvent& event : scenario.script.events) {
    std::vector<Action>& actions = event.actions;
    for (std::size_t k = 0; k < views.size(); ++k) {
      const bool begins = std::any_of(actions.begin(), actions.end(), [&](const Action& action) {
        return begins_view(action, scenario, views[k]);
      });
      if (begins && sets[k].term.weight > 0)
        actions.push_back(HandOver{AgentId{views[k].observer}, {sets[k].name}, {sets[k]}});
    }
  }
  for (std::size_t k = 0; k < views.size(); ++k) {
    const bool at_start = is_observed(scenario.team.couplings(), views[k].observer, views[k].target);
    if (!at_start || sets[k].term.weight == 0) continue;
    scenario.team.couple(std::move(sets[k]));
    scenario.coupling_places.push_back(places[k]);
  }
}

/// What is assumed of the motion that an observer localized by vision estimates; 0 of another one.
ViewOdometry read_odometry(const TomlTable& at, const ScenarioSpec& scenario, const CertifiedView& view) {
  const LocalizedRobot* found = localized_robot(scenario, view.observer);
  for (const char* key : {"velocity_error", "turn_error"}) {
    if (found == nullptr && at.has(key))
      at.throw_invalid(key, "no such key for an observer whose own state is measured");
  }
  if (found == nullptr) return {};
  if (found->filter.filter != FilterKind::attitude)
    at.throw_invalid("observer",
                     "a robot with localization = \"global\", or with estimate.filter = \"attitude\", which "
                     "estimates its velocity");
  if (scenario.links) at.throw_invalid("observer", "a robot with localization = \"global\" beside a [fleet]");
  if (view.is_on_request())
    at.throw_invalid("speed_unrequested", "no such key for an observer that is localized by vision");
  if (view.bounds.error == 0)
    at.throw_invalid("error", "above 0 for an observer that is localized by vision");
  ViewOdometry odometry;
  for (const RobotCompensation& of : scenario.compensations)
    if (of.robot == view.observer) odometry.delay = of.command_delay;
  if (view.bounds.age > odometry.delay)
    at.throw_invalid("age", "0 for an observer that is localized by vision");
  odometry.velocity = at.number("velocity_error", positive("> 0 m/s"));
  odometry.turn = at.number("turn_error", positive("> 0 rad/s"));
  return odometry;
}

/// The certificate of a view, its filter and the largest speed.
/// @param views  all of the scenario: some may request the observer to slow down
/// @return its set as a part of the cost; of weight 0: none
Coupling certify(const TomlTable& at, const ScenarioSpec& scenario, const std::vector<CertifiedView>& views,
                 CertifiedView& view) {
  const Team& team = scenario.team;
  const Model& model = team.model(view.observer);
  ViewLimits limits = all_limits_of(scenario, view);
  if (std::none_of(limits.all.begin(), limits.all.end(),
                   [](const Potential& limit) { return observes(limit); }))
    at.throw_invalid("target",
                     fmt::format("a body that a coupling of {} observes", team.name(view.observer)));
  if (has_two_sensors(scenario, view))
    at.throw_invalid("target", fmt::format("a body that {} observes through one sensor in the whole scenario",
                                           team.name(view.observer)));
  const ViewOdometry odometry = read_odometry(at, scenario, view);
  const auto requests = [&](const CertifiedView& other) {
    return other.is_on_request() && other.target == view.observer;
  };
  // Beyond its set, such a robot would brake relative to its target.
  if (view.bounds.is_velocity_measured() && std::any_of(views.begin(), views.end(), requests))
    at.throw_invalid("acceleration_max",
                     "no such key for a robot that another certified view requests to slow down");
  at.checked([&] {
    const auto [u_min, u_max] = tightest_limits(team, view.observer, limits_to_come(scenario));
    ViewTask task = {view_motion(model, u_min, u_max, view_direction(limits.all)), view.bounds,
                     scenario.horizon.dt, odometry};
    const bool is_at_once = task.motion.climb.lag == 0 && task.motion.turn.lag == 0;
    if (odometry.is_used() && (!is_at_once || roles_of(model).velocity_G[0] >= 0))
      at.throw_invalid(
          "observer",
          "a robot whose climb and yaw rate follow its commands at once, with its velocity along "
          "its heading as states, as it is localized by vision");
    for (const CertifiedView& other : views) {
      if (!requests(other)) continue;
      task.requested = std::min(task.requested, other.bounds.speed);
      task.motion.climb.most = std::min(task.motion.climb.most, other.bounds.climb);
    }
    const ViewSection section(view_region(std::move(limits.all), task.motion));
    task.bounds = odometry.seen(task.bounds, section.reach(), task.dt);
    const CertifiedSpeed most = certified_speed(task, section);
    const double seen = task.bounds.speed - view.bounds.speed;  // of a target at rest
    view.speed_most = std::max(0.0, most.speed - seen), view.limited_by = to_string(most.limit);
    const ViewCertificate certificate = certify_view(task, section);
    if (certificate.exists()) view.filter = std::make_shared<const ViewFilter>(model, certificate);
  });
  if (view.filter)
    return {.term = {ViewCost::weight * limits.weight, ViewCost(view.filter->certificate())},
            .between = {view.observer, view.target},
            .felt_by = {AgentId{view.observer}}};
  const double rounded = std::floor(100 * view.speed_most) / 100;
  if (rounded == 0)
    at.throw_invalid(fmt::format("another view: not even a target at rest can be certified, {} limits it",
                                 view.limited_by));
  at.throw_invalid("speed_max", fmt::format("at most {:.2f} m/s: {} limits what can be certified", rounded,
                                            view.limited_by));
}

/// Adds to the bounds what a target gains that slows down on request.
void read_slow_down(const TomlTable& at, const ScenarioSpec& scenario, CertifiedView& view) {
  const Team& team = scenario.team;
  if (!view.is_on_request()) {
    if (view.request_delay > 0) at.throw_invalid("request_delay", "no such key without speed_unrequested");
    return;
  }
  constexpr const char* key = "speed_unrequested";
  if (!team.is_agent(view.target) || scenario.links)
    at.throw_invalid(key, "no such key for a target that no solver of this process steers");
  if (localized_robot(scenario, view.target) != nullptr)
    at.throw_invalid(key, "no such key for a target that is localized by vision");
  if (view.bounds.speed == 0 || view.unrequested < view.bounds.speed)
    at.throw_invalid(key, fmt::format("at least speed_max = {} m/s, which is above 0", view.bounds.speed));
  if (view.bounds.error > 0 || view.bounds.is_velocity_measured())
    at.throw_invalid(key, "no such key beside error or acceleration_max");
  at.checked([&] {
    const auto [u_min, u_max] = tightest_limits(team, view.target, limits_to_come(scenario));
    view.slowing = least_deceleration(view_motion(team.model(view.target), u_min, u_max), view.bounds.wind);
  });
  if (view.slowing <= 0)
    at.throw_invalid(
        key, fmt::format("no such key for {}, whose wind it cannot brake against", team.name(view.target)));
  view.request_gain = gain_until_slow(slow_down_options(view, scenario.horizon.dt), view.bounds.age);
  view.bounds.spread += view.request_gain;
}

CertifiedView read_view(const TomlTable& at, const ScenarioSpec& scenario) {
  const Team& team = scenario.team;
  CertifiedView view;
  read_keys(at, {}, view.bounds, view);
  view.observer = team.find(read_name(at, "observer", team, Among::robots, "a robot"));
  view.target = team.find(read_name(at, "target", team, Among::bodies, "a robot, target or obstacle"));
  if (scenario.links) {
    if (!scenario.safety || !scenario.safety->supervisor)
      at.throw_invalid("observer",
                       "a robot with safety.supervisor, which predicts its state, beside a [fleet]");
    if (view.bounds.age == 0) at.throw_invalid("age", "above 0 beside a [fleet], whose states arrive late");
  }
  for (const RobotCompensation& of : scenario.compensations) {
    if (of.robot != view.observer) continue;
    if (of.disturbance_time > 0)
      at.throw_invalid("observer",
                       "a robot without disturbance_time, whose commands are not part of the bounds");
    view.bounds.age += of.command_delay;
  }
  for (const UncooperativeBody& of : scenario.uncooperative) {
    if (of.body == view.target && of.velocity == SeenVelocity::unknown && view.bounds.is_velocity_measured())
      at.throw_invalid("acceleration_max", "no such key for a target with velocity = \"unknown\"");
  }
  // An estimate that follows a position slowly has another velocity than the target.
  if (view.bounds.error > 0 && view.bounds.is_velocity_measured())
    at.throw_invalid("acceleration_max", "no such key beside an error of the position");
  read_slow_down(at, scenario, view);
  return view;
}

}  // namespace

std::vector<CertifiedView> read_certified_views(const TomlTable& root, ScenarioSpec& scenario) {
  std::vector<CertifiedView> views;
  std::vector<Coupling> sets;
  std::vector<std::string> places;
  const std::vector<Coupling>& at_start = scenario.team.couplings();
  for (const TomlTable& at : root.tables("certify_view")) {
    CertifiedView view = read_view(at, scenario);
    places.push_back(at.where());
    const bool is_first = is_observed(at_start, view.observer, view.target);
    for (const CertifiedView& other : views) {
      if (view.target == other.target && view.is_on_request() != other.is_on_request())
        at.throw_invalid("target", "speed_unrequested in all certified views of a body, or in none");
      if (other.observer != view.observer) continue;
      if (other.target == view.target)
        at.throw_invalid("target", "a body without another view by this robot");
      if (is_first && is_observed(at_start, other.observer, other.target))
        at.throw_invalid("observer", "a robot that observes no other target of a certified view at once");
    }
    views.push_back(std::move(view));
  }
  for (const TomlTable& at : root.tables("certify_view")) {
    sets.push_back(certify(at, scenario, views, views[sets.size()]));
    sets.back().name = fmt::format("{}{}]", name_of_view_sets, sets.size() - 1);
  }
  couple_sets(scenario, views, std::move(sets), places);
  return views;
}

std::string describe(const CertifiedView& view, const Team& team) {
  const ViewCertificate& z = view.filter->certificate();
  const double middle = 0.5 * (z.near + z.far);
  std::string text = fmt::format(
      "certify     view of {} by {} is certified up to {:.2f} m/s; {} limits it\n"
      "certify     at {} m/s: {:.2f} to {:.2f} m away, within {:.1f} degrees of {}, {:.2f} to "
      "{:.2f} m "
      "above it at {:.2f} m, {:.2f} m/s sideward, {:.2f} rad/s\n",
      team.name(view.target), team.name(view.observer), std::floor(100 * view.speed_most) / 100,
      view.limited_by, view.bounds.speed, z.near, z.far, z.theta * 180 / std::numbers::pi,
      z.task.motion.ahead.x == 1 ? "the heading" : "the sensor's direction", z.at(z.low, middle),
      z.at(z.high, middle), middle, z.sideward, z.turn);
  if (const ViewOdometry& odometry = z.task.odometry; odometry.is_used())
    text += fmt::format(
        "certify     {} is localized by vision: while three standard deviations are within {} m "
        "relative to {}, {} m/s and {} rad/s; counted as a target of {:.2f} m/s seen within {:.2f} m\n",
        team.name(view.observer), view.bounds.error, team.name(view.target), odometry.velocity, odometry.turn,
        z.task.bounds.speed, z.task.bounds.error);
  if (view.is_on_request())
    text +=
        fmt::format("certify     {} flies at up to {} m/s, gains up to {:.2f} m, and slows down on request\n",
                    team.name(view.target), view.unrequested, view.request_gain);
  return text;
}

std::vector<std::string> warnings_of_views(const ScenarioSpec& scenario) {
  std::vector<std::string> sentences;
  const Team& team = scenario.team;
  for (const CertifiedView& view : scenario.certified_views) {
    const std::string who =
        fmt::format("the certified view of {} by {}", team.name(view.target), team.name(view.observer));
    const ViewFilter& filter = *view.filter;
    if (scenario.links || vehicle_of(scenario, view.observer) != nullptr)
      sentences.push_back(
          fmt::format("{} assumes that the vehicle accelerates within wind = {} m/s^2 of its model", who,
                      view.bounds.wind));
    for (const UncooperativeBody& of : scenario.uncooperative) {
      const double speed = of.motion ? top_speed(*of.motion) : 0.0;
      if (of.body == view.target && speed > view.bounds.speed)
        sentences.push_back(fmt::format("{} assumes speed_max = {} m/s, the target moves at up to {:.3g} m/s",
                                        who, view.bounds.speed, speed));
    }
    const bool has_barrier = scenario.safety && scenario.safety->barrier == BarrierMode::on;
    const auto d_hard = hard_distance(scenario, view.observer, view.target);
    for (const UncooperativeBody& of : scenario.uncooperative)
      if (of.body == view.target && has_barrier && d_hard && of.speed_max > view.bounds.speed)
        sentences.push_back(fmt::format(
            "{} assumes speed_max = {} m/s, and the barrier may break it, which assumes {} m/s of "
            "the target",
            who, view.bounds.speed, of.speed_max));
    const ViewCertificate& z = filter.certificate();
    double nearest = infinity;
    for (std::size_t k = 0; k < z.low.size(); ++k) {
      const double h = std::clamp(0.0, z.low[k], z.high[k]);
      nearest = std::min(nearest, norm(z.near + static_cast<double>(k) * z.step(), h));
    }
    constexpr double apart = 0.2;  // [m] within which the barrier acts on states of the set
    if (has_barrier && d_hard && *d_hard > nearest - apart)
      sentences.push_back(
          fmt::format("{} allows {:.2f} m, and the barrier may break it with d_hard = {} m, "
                      "expected at most {:.2f} m",
                      who, nearest, *d_hard, nearest - apart));
    if (!is_observed(team.couplings(), view.observer, view.target)) continue;
    const std::vector<double> u(static_cast<std::size_t>(team.model(view.target).nu()) + 1);
    const std::span<const double> x0 = scenario.x0;
    const Sight<double> target =
        team.model(view.target).sight(&x0[size(team.state_offset(view.target))], u.data());
    const ViewReserves reserves = filter.reserves(
        x0.subspan(size(team.state_offset(view.observer)), size(team.model(view.observer).nx())),
        {target.p, {target.v.x, target.v.y}});
    const auto least = std::min_element(reserves.begin(), reserves.end());
    if (*least < 0)
      sentences.push_back(
          fmt::format("{} does not hold at the start: {:.3g} m outside its set, by the reserve "
                      "\"{}\"",
                      who, -*least, to_string(static_cast<ViewReserve>(least - reserves.begin()))));
  }
  return sentences;
}

}  // namespace sightline
