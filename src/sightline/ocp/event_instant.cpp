#include <limits>

#include "sightline/base.hpp"
#include "sightline/events.hpp"

namespace sightline {
namespace {

constexpr double no_measure = std::numeric_limits<double>::quiet_NaN();

double value(const DistanceOf& of, const EventInstant& now) {
  return now.is_there(of.a) && now.is_there(of.b) ? norm(now.sight(of.a).p - now.sight(of.b).p) : no_measure;
}

double value(const ViewAngleOf& of, const EventInstant& now) {
  if (!now.is_there(of.observer) || !now.is_there(of.target)) return no_measure;
  return view_angle(of.mount, now.sight(of.observer), now.sight(of.target).p);
}

double value(const AgeOf& of, const EventInstant& now) {
  return now.is_there(of.body) ? now.age(of.body) : no_measure;
}

double value(const ExcessOf& of, const EventInstant& now) {
  if (!now.is_there(of.a) || !now.is_there(of.b)) return no_measure;
  return of.potential.violation(now.sight(of.a), now.sight(of.b), now.known.t);
}

double value(const NearerThan& of, const EventInstant& now) {
  if (!now.is_steered(of.b) || !now.is_there(of.target)) return no_measure;
  if (!now.is_steered(of.a)) return std::numeric_limits<double>::infinity();
  const Vec3<double> p = now.sight(of.target).p;
  return norm(now.sight(of.a).p - p) - norm(now.sight(of.b).p - p);
}

double value(const TurnedTo& of, const EventInstant& now) {
  if (of.choice >= now.choosers.size()) return no_measure;
  const ViewChooser& chooser = now.choosers[of.choice];
  return chooser.changed(of.observer) && chooser.target(of.observer) == of.target ? 1.0 : 0.0;
}

bool occurs(const Condition& condition, const EventInstant& now) {
  const double measured = std::visit([&](const auto& of) { return value(of, now); }, condition.measure);
  const double beyond = condition.side == Condition::Side::above ? measured - condition.threshold
                                                                 : condition.threshold - measured;
  auto& [holds, fired, since] = now.condition;
  const bool held = holds;
  holds = held ? beyond >= -condition.hysteresis : beyond > 0;  // false for NaN
  if (!holds) fired = false;
  if (holds && !held) since = now.known.t;
  if (!holds || fired || now.known.t - since < condition.dwell - same_time) return false;
  fired = true;
  return true;
}

}  // namespace

bool occurs(const Trigger& trigger, const EventInstant& now) noexcept {
  if (const auto* at = std::get_if<AtTime>(&trigger)) return now.known.t >= at->t - same_time;
  if (const auto* after = std::get_if<AfterTime>(&trigger))
    return now.known.t - now.began >= after->delay - same_time;
  if (const auto* condition = std::get_if<Condition>(&trigger)) return occurs(*condition, now);
  return now.signalled;
}

}  // namespace sightline
