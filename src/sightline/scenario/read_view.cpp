#include "sightline/scenario/read_view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

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

/// A coupling that may be in force, and which stated potential it has. Of the limits that a coupling leaves
/// behind, `part` numbers them.
struct PossibleCoupling {
  Coupling coupling;
  std::size_t origin = 0;
  int part = -1;

  bool operator==(const PossibleCoupling& o) const {
    const Between &a = coupling.between, &b = o.coupling.between;
    return origin == o.origin && part == o.part && a.first == b.first && a.second == b.second &&
           coupling.name == o.coupling.name && coupling.felt_by == o.coupling.felt_by;
  }
};

/// The couplings that events may put in force, in any order and any number of times: those that are stated,
/// those that an observer takes along to another target, and both with potentials that events give them.
class PossibleCouplings {
 public:
  explicit PossibleCouplings(const ScenarioSpec& scenario) : scenario_(scenario) {
    std::size_t origin = 0;
    for (Coupling& c : stated_couplings(scenario)) all_.push_back({std::move(c), origin++});
    for (std::size_t before = 0; before < all_.size();) {
      before = all_.size();
      std::size_t potential = origin;
      for (const TeamEvent& event : scenario.script.events) {
        for (const Action& action : event.actions) {
          if (const auto* observe = std::get_if<Observe>(&action)) turn(*observe);
          if (const auto* retune = std::get_if<RetuneTerm>(&action); retune && retune->potential)
            this->retune(*retune, potential++);
        }
      }
    }
    for (PossibleCoupling& it : all_) couplings_.push_back(std::move(it.coupling));
  }

  const std::vector<Coupling>& all() const { return couplings_; }

  /// Those that an action adds or gives another potential.
  std::vector<Coupling> made_by(const Action& action) const {
    if (const auto* add = std::get_if<AddCoupling>(&action)) return {add->coupling};
    if (const auto* hand_over = std::get_if<HandOver>(&action)) return hand_over->couplings;
    const auto* retune = std::get_if<RetuneTerm>(&action);
    std::vector<Coupling> made;
    if (retune == nullptr || !retune->potential) return made;
    for (const Coupling& c : couplings_) {
      if (c.name != retune->name) continue;
      made.push_back(c);
      made.back().term.potential = *retune->potential;
    }
    return made;
  }

 private:
  void add(PossibleCoupling it) {
    if (std::find(all_.begin(), all_.end(), it) == all_.end()) all_.push_back(std::move(it));
  }

  void retune(const RetuneTerm& retune, std::size_t origin) {
    for (std::size_t i = 0, n = all_.size(); i < n; ++i) {
      if (all_[i].coupling.name != retune.name) continue;
      PossibleCoupling next = {all_[i].coupling, origin};
      next.coupling.term.potential = *retune.potential;
      add(std::move(next));
    }
  }

  /// Adds what the observer takes along from each target that it may observe.
  void turn(const Observe& observe) {
    const auto is_through = [](const Potential& potential, const SensorMount* mount) {
      return mount == nullptr || potential.mount() == nullptr || *potential.mount() == *mount;
    };
    for (std::size_t look = 0, n = all_.size(); look < n; ++look) {
      const Coupling looks = all_[look].coupling;
      const BodyId before = looks.between.second;
      const SensorMount* mount = observe.through ? &*observe.through : nullptr;
      if (before == observe.target || !is_view_of(looks, {observe.observer, before}) ||
          !is_through(looks.term.potential, mount))
        continue;
      if (looks.term.potential.mount() != nullptr) mount = looks.term.potential.mount();
      for (std::size_t i = 0; i < n; ++i) {
        const auto [first, second] = all_[i].coupling.between;
        const Potential& potential = all_[i].coupling.term.potential;
        const bool is_own = first == observe.observer && second == before;
        if (is_own ? !is_through(potential, mount)
                   : first != before || second != observe.observer || observes(potential))
          continue;
        move(PossibleCoupling(all_[i]), observe, before);  // a copy: it adds others
      }
    }
  }

  void move(const PossibleCoupling& it, const Observe& observe, BodyId before) {
    const bool stays = keeps_apart(it.coupling.term.potential);
    PossibleCoupling next = it;
    Coupling& moved = next.coupling;
    (moved.between.first == before ? moved.between.first : moved.between.second) = observe.target;
    if (scenario_.team.is_agent(observe.target))
      std::replace(moved.felt_by.begin(), moved.felt_by.end(), AgentId{before}, AgentId{observe.target});
    else
      std::erase(moved.felt_by, AgentId{before});
    const bool acts = moved.third != observe.target && !moved.felt_by.empty();
    if (stays) {
      moved.name.clear();
      if (acts && !are_always_kept_apart(observe, moved.felt_by)) add(std::move(next));
      return;
    }
    if (acts) add(std::move(next));
    int part = 0;
    for (Potential& limit : keep_outs(it.coupling.term.potential)) {
      PossibleCoupling behind = it;
      behind.part = part++;
      behind.coupling.term.potential = std::move(limit);
      behind.coupling.name.clear();
      add(std::move(behind));
    }
  }

  /// Whether an event removes, replaces or retunes the coupling or constraint of that name.
  bool is_changed(const std::string& name) const {
    const auto changes = [&](const Action& action) {
      if (const auto* remove = std::get_if<RemoveTerm>(&action)) return remove->name == name;
      if (const auto* retune = std::get_if<RetuneTerm>(&action)) return retune->name == name;
      const auto* over = std::get_if<HandOver>(&action);
      return over != nullptr && std::find(over->names.begin(), over->names.end(), name) != over->names.end();
    };
    const std::vector<TeamEvent>& events = scenario_.script.events;
    return std::any_of(events.begin(), events.end(), [&](const TeamEvent& event) {
      return std::any_of(event.actions.begin(), event.actions.end(), changes);
    });
  }

  /// Whether a coupling that no event changes does so: then the new target gets no other.
  bool are_always_kept_apart(const Observe& observe, const std::vector<AgentId>& felt_by) const {
    const auto& couplings = scenario_.team.couplings();
    return std::any_of(couplings.begin(), couplings.end(), [&](const Coupling& c) {
      const auto [a, b] = c.between;
      const bool joins =
          (a == observe.observer && b == observe.target) || (a == observe.target && b == observe.observer);
      return joins && !is_changed(c.name) && c.term.weight > 0 && keeps_apart(c.term.potential) &&
             std::all_of(felt_by.begin(), felt_by.end(), [&](AgentId agent) {
               return std::find(c.felt_by.begin(), c.felt_by.end(), agent) != c.felt_by.end();
             });
    });
  }

  const ScenarioSpec& scenario_;
  std::vector<PossibleCoupling> all_;
  std::vector<Coupling> couplings_;
};

/// The limits that the pair may have at any time: the set keeps all of them at all times.
ViewLimits all_limits_of(const ScenarioSpec& scenario, const PossibleCouplings& possible,
                         const CertifiedView& view) {
  ViewLimits limits = limits_of(couplings_of_view(scenario, view), view.observer, view.target);
  limits.all.clear();
  for (Potential& one : limits_of(possible.all(), view.observer, view.target).all) {
    const auto is_same = [&](const Potential& known) {
      return one.mount() != nullptr && known.mount() == one.mount();
    };
    if (std::none_of(limits.all.begin(), limits.all.end(), is_same)) limits.all.push_back(std::move(one));
  }
  return limits;
}

/// Whether the observer may observe the target by this action, which it did not before.
bool begins_view(const Action& action, const PossibleCouplings& possible, const CertifiedView& view) {
  return turns_to(action, view) || is_observed(possible.made_by(action), view.observer, view.target);
}

/// Whether the observer observes the target through two sensors in the scenario; at one time or not.
bool has_two_sensors(const PossibleCouplings& possible, const CertifiedView& view) {
  const SensorMount* first = nullptr;
  return std::any_of(possible.all().begin(), possible.all().end(), [&](const Coupling& c) {
    const SensorMount* mount = c.term.potential.mount();
    if (!is_view_of(c, {view.observer, view.target}) || mount == nullptr) return false;
    if (first == nullptr) first = mount;
    return *mount != *first;
  });
}

/// Adds the sets of the views to the costs: at the start, and at the end of the events that begin a
/// view. A set leaves by itself with the last coupling that observes its pair (apply_action()).
/// @param sets  of each view; of weight 0: none
void couple_sets(ScenarioSpec& scenario, const PossibleCouplings& possible,
                 const std::vector<CertifiedView>& views, std::vector<Coupling> sets,
                 const std::vector<std::string>& places) {
  for (TeamEvent& event : scenario.script.events) {
    std::vector<Action>& actions = event.actions;
    for (std::size_t k = 0; k < views.size(); ++k) {
      const bool begins = std::any_of(actions.begin(), actions.end(), [&](const Action& action) {
        return begins_view(action, possible, views[k]);
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
Coupling certify(const TomlTable& at, const ScenarioSpec& scenario, const PossibleCouplings& possible,
                 const std::vector<CertifiedView>& views, CertifiedView& view) {
  const Team& team = scenario.team;
  const Model& model = team.model(view.observer);
  ViewLimits limits = all_limits_of(scenario, possible, view);
  if (std::none_of(limits.all.begin(), limits.all.end(),
                   [](const Potential& limit) { return observes(limit); }))
    at.throw_invalid("target",
                     fmt::format("a body that a coupling of {} observes", team.name(view.observer)));
  if (has_two_sensors(possible, view))
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
  if (views.empty()) return views;
  const PossibleCouplings possible(scenario);
  for (const TomlTable& at : root.tables("certify_view")) {
    sets.push_back(certify(at, scenario, possible, views, views[sets.size()]));
    sets.back().name = fmt::format("{}{}]", name_of_view_sets, sets.size() - 1);
  }
  couple_sets(scenario, possible, views, std::move(sets), places);
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
