#include "sightline/loop.hpp"

#include <algorithm>
#include <cmath>

#include "sightline/base.hpp"
#include "sightline/run/stages/command.hpp"
#include "sightline/run/stages/estimate.hpp"
#include "sightline/run/stages/log.hpp"
#include "sightline/run/stages/measure.hpp"
#include "sightline/run/stages/solve.hpp"
#include "sightline/run/stages/team_change.hpp"

namespace sightline {
namespace {

/// The horizon that defines the stages of the predicted paths.
const Horizon& longest_horizon(const Controllers& controllers) {
  const auto fewer = [](const Solver& a, const Solver& b) {
    return a.ocp().horizon().N < b.ocp().horizon().N;
  };
  return std::max_element(controllers.begin(), controllers.end(), fewer)->get().ocp().horizon();
}

LoopOptions checked(LoopOptions o, const Controllers& controllers) {
  if (!(o.period >= 1e-4)) throw_invalid("loop.period = {}, expected >= 1e-4 s", o.period);
  if (!(o.duration > 0 && o.duration / o.period <= 1e9)) {
    throw_invalid("loop.duration = {}, expected > 0 s and at most 1e9 periods", o.duration);
  }
  if (!(o.path_interval >= 0)) throw_invalid("loop.path_interval = {}, expected >= 0 s", o.path_interval);
  if (!(o.warm_up >= 0 && o.warm_up < o.period))
    throw_invalid("loop.warm_up = {}, expected >= 0 s and shorter than the period", o.warm_up);
  if (controllers.empty()) throw_invalid("the loop has no controller, expected at least one");
  std::stable_sort(o.signals.begin(), o.signals.end(),
                   [](const TimedSignal& a, const TimedSignal& b) { return a.at < b.at; });
  return o;
}

/// Presence if all bodies of a team are present.
std::vector<Presence> everybody(const Team& team) {
  std::vector<Presence> presence;
  for (int i = 0; i < team.bodies(); ++i) {
    presence.push_back(team.is_agent(BodyId{i}) ? Presence::steered : Presence::hold);
  }
  return presence;
}

}  // namespace

Sample sized_sample(const World& world, const Controllers& controllers, const TeamSwitcher* team_switcher) {
  Sample sample = sized_sample(world.team(), controllers, team_switcher);
  const MeasuredMost most = world.measured_max();
  sample.detections.resize(most.detections);
  sample.motions.resize(most.motions);
  sample.broadcasts.resize(most.broadcasts);
  sample.fits.resize(most.motions > 0 ? most.detections : 0);
  sample.estimates.resize(most.motions > 0 ? size(world.team().bodies()) : 0);
  return sample;
}

Sample sized_sample(const Team& team, const Controllers& controllers, const TeamSwitcher* team_switcher) {
  const std::size_t nx = size(team.nx()), nu = size(team.nu());
  const Horizon horizon = controllers.empty() ? Horizon{} : longest_horizon(controllers);
  Sample sample;
  sample.x.resize(nx);
  sample.measured.resize(nx);
  sample.attitudes.resize(size(team.bodies()), no_attitude);
  sample.stamps.resize(size(team.bodies()));
  sample.u.resize(nu);
  sample.raw_u.resize(nu);
  sample.solvers.resize(controllers.size());
  sample.barriers.resize(team.agents().size());
  sample.views.resize(team.agents().size());
  sample.presence = everybody(team);
  sample.levels.resize(sample.presence.size());
  sample.path.resize(size(horizon.N + 1) * nx);
  sample.path_step = horizon.h();
  sample.events.resize(16 + 4 * sample.presence.size() +
                       (team_switcher != nullptr ? team_switcher->events_max() : 0));
  return sample;
}

/// The stages in the order of a period, what they share, and their construction.
struct Loop::Stages {
  Stages(World& world, const Controllers& controllers, Clock& of_loop, Sink<Sample>& of_samples,
         const LoopOptions& given)
      : clock(of_loop),
        sink(of_samples),
        options(checked(given, controllers)),
        period(world, options, everybody(world.team())),
        change_team(world, controllers, clock, options, period),
        measure{world},
        localize{options.localizer},
        supervise{options.guard, options.localizer},
        compensate(options.compensation, options.guard, period),
        solve(world, controllers, options, period),
        filter(options.guard, period),
        gate{options.guard, options.compensation},
        log(sink, clock, options, sized_sample(world, controllers, options.team_switcher), period),
        apply{world, options.localizer, log, options.period} {
    // Until the first good command, robots hold their u*, within their limits.
    for (int i = 0; i < world.team().bodies(); ++i) period.gate.rest(BodyId{i}, 0.0, period.u);
    (void)period.gate.pass(period.u, {});
  }
  Stages(const Stages&) = delete;  // they point into each other
  Stages& operator=(const Stages&) = delete;

  Clock& clock;
  Sink<Sample>& sink;
  const LoopOptions options;
  stages::Period period;
  stages::TeamChange change_team;
  stages::Measure measure;
  stages::Localize localize;
  stages::Validate validate;
  stages::Supervise supervise;
  stages::Compensate compensate;
  stages::Solve solve;
  stages::Filter filter;
  stages::Gate gate;
  stages::Log log;
  stages::Apply apply;
};

Loop::Loop(World& world, const Controllers& controllers, Clock& clock, Sink<Sample>& sink,
           const LoopOptions& options)
    : stages_(std::make_unique<Stages>(world, controllers, clock, sink, options)) {}

Loop::~Loop() = default;

LoopOutcome Loop::run() noexcept {
  Stages& s = *stages_;
  stages::Period& p = s.period;
  const std::int64_t periods = std::llround(s.options.duration / s.options.period);
  s.clock.start(s.options.period);
  for (std::int64_t next = 0;; ++next) {
    s.solve.warm_up(s.clock, next);
    p.k = std::min(s.clock.wait(next), periods);
    p.t = static_cast<double>(p.k) * s.options.period;
    if (const std::int64_t missed = p.k - next; missed > 0) {
      p.outcome.missed += missed;
      p.emit({p.t, EventKind::missed_period, 0, static_cast<double>(missed)});
      s.apply.run(p, static_cast<double>(next) * s.options.period, missed);
      next = p.k;
    }
    p.outcome.stopped =
        p.k < periods && s.options.stop != nullptr && s.options.stop->load(std::memory_order_relaxed);
    if (p.k == periods || p.outcome.stopped || !p.outcome.finite) break;

    s.log.open(p);
    s.change_team.run(p);
    s.measure.run(p);
    s.localize.run(p);
    s.validate.run(p);
    s.change_team.join(p);
    s.supervise.run(p);
    s.compensate.run(p);
    s.solve.run(p);
    s.filter.run(p);
    s.gate.run(p);
    s.change_team.look(p);
    s.log.run(p);
    s.apply.run(p);
  }
  if (p.outcome.updates > 0) s.log.show_end(p, s.measure.world);
  s.sink.close();
  return p.outcome;
}

}  // namespace sightline
