#include <algorithm>
#include <cmath>

#include "sightline/base.hpp"
#include "sightline/scenario.hpp"

namespace sightline {

GoalTrack::GoalTrack(Model model, Reference own, double speed)
    : model_(std::move(model)),
      own_(std::move(own)),
      speed_(speed),
      rest_(size(model_.nu())),
      legs_(legs_most) {
  messages_.list.resize(messages_most);
}

const GoalTrack::Message* GoalTrack::at(double t) const noexcept {
  const auto begin = messages_.list.begin(), end = begin + static_cast<std::ptrdiff_t>(messages());
  const auto later =
      std::upper_bound(begin, end, t, [](double time, const Message& message) { return time < message.t; });
  return later != begin ? &*(later - 1) : nullptr;
}

const GoalTrack::Leg& GoalTrack::leg(const Message& message, double t) const noexcept {
  std::size_t i = message.first;
  while (i + 1 < message.first + message.legs && legs_[i + 1].begin <= t) ++i;
  return legs_[i];
}

GoalTrack::Moving GoalTrack::along(const Leg& leg, double t) noexcept {
  const double T = leg.end - leg.begin;
  if (t >= leg.end) return {leg.p_1, {}, leg.heading_1, true};
  const double s = std::max(0.0, t - leg.begin) / T, s2 = s * s, s3 = s2 * s;
  const double blend = 3 * s2 - 2 * s3;
  const Vec3<double> p =
      (1 - blend) * leg.p_0 + ((s3 - 2 * s2 + s) * T) * leg.v_0 + blend * leg.p_1 + ((s3 - s2) * T) * leg.v_1;
  const Vec3<double> v = ((6 * s - 6 * s2) / T) * (leg.p_1 - leg.p_0) + (3 * s2 - 4 * s + 1) * leg.v_0 +
                         (3 * s2 - 2 * s) * leg.v_1;
  return {p, v, leg.heading_0 + blend * (leg.heading_1 - leg.heading_0), true};
}

Sight<double> GoalTrack::own(double t) const noexcept {
  std::array<double, Reference::max_states> x{};
  own_(t, model_, std::span(x).first(size(model_.nx())));
  return model_.sight(x.data(), rest_.data());
}

GoalTrack::Moving GoalTrack::moving(double t) const noexcept {
  if (const Message* message = at(t)) return along(leg(*message, t), t);
  constexpr double h = 1e-3;  // [s]
  const Sight<double> now = own(t);
  const Vec3<double> v = (1 / (2 * h)) * (own(t + h).p - own(t - h).p);
  const bool heads = square(now.d.x) + square(now.d.y) > 0.5;
  return {now.p, v, heads ? std::atan2(now.d.y, now.d.x) : 0.0, heads};
}

GoalAnswer GoalTrack::add(double t, std::span<const Waypoint> waypoints) noexcept {
  const std::size_t count = messages();
  const std::size_t first = count > 0 ? messages_.list[count - 1].first + messages_.list[count - 1].legs : 0;
  if (count == messages_most || first + waypoints.size() > legs_most) return GoalAnswer::full;
  Moving from = moving(t);
  double begin = t;
  for (std::size_t i = 0; i < waypoints.size(); ++i) {
    const Waypoint& to = waypoints[i];
    Leg& next = legs_[first + i];
    next = {.begin = begin, .end = t + to.after, .p_0 = from.p, .v_0 = from.v, .p_1 = to.p, .waypoint = to};
    next.heading_0 = from.heads ? from.heading : to.heading;
    next.heading_1 = next.heading_0 + wrap_angle(to.heading - next.heading_0);
    const double distance = norm(to.p - from.p);
    if (to.after == 0.0) {
      next.end = t + std::max({least_time, 1.5 * distance / speed_,
                               1.5 * std::abs(next.heading_1 - next.heading_0) / turn_speed});
    } else if (!(distance <= path_speed * (next.end - begin))) {
      return GoalAnswer::too_fast;
    }
    if (i > 0) {
      next.v_0 = next.v_1 = (1 / (next.end - begin)) * (next.p_1 - next.p_0);
      if (i == 1) legs_[first].v_1 = next.v_0;
    }
    begin = next.end;
    from = {next.p_1, {}, next.heading_1, true};
  }
  messages_.list[count] = {t, first, waypoints.size()};
  messages_.count.store(count + 1, std::memory_order_release);
  return GoalAnswer::taken;
}

void GoalTrack::waypoints(std::size_t message, std::vector<Waypoint>& waypoints) const {
  const Message& goal = messages_.list[message];
  waypoints.clear();
  for (std::size_t i = 0; i < goal.legs; ++i) waypoints.push_back(legs_[goal.first + i].waypoint);
}

GoalTrack::State GoalTrack::state(double t) const {
  State state{{}, size(model_.nx())};
  if (at(t) == nullptr) {
    own_(t, model_, std::span(state.x).first(state.n));
  } else {
    const Moving m = moving(t);
    model_.at_rest({m.p, {cos(m.heading), sin(m.heading)}}, state.x.data());
  }
  return state;
}

Reference GoalTrack::reference(std::shared_ptr<const GoalTrack> track) {
  return Reference([track = std::move(track)](double t) { return track->state(t); });
}

}  // namespace sightline
