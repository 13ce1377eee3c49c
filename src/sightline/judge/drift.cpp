#include "sightline/judge/drift.hpp"

#include <algorithm>
#include <cmath>

#include "sightline/base.hpp"
#include "sightline/estimator.hpp"

namespace sightline {
namespace {

constexpr double apart = 1.0;            // time between two marks [s]
constexpr double creep = 0.02;           // a smaller speed counts as rest [m/s]
constexpr double share_of_anchor = 0.3;  // of the anchor's speed
constexpr double share_at_end = 0.5;     // of the mean growth

constexpr std::array axes = {&Vec3<double>::x, &Vec3<double>::y, &Vec3<double>::z};

// Length of r, horizontally or vertically.
double length(const Vec3<double>& r, bool horizontally) {
  return horizontally ? norm(r.x, r.y) : std::abs(r.z);
}

}  // namespace

Drift::Drift(const Team& team, double settle)
    : settle_(settle), lands_(static_cast<std::size_t>(team.bodies())) {
  for (Mark& mark : marks_) mark.places.resize(static_cast<std::size_t>(team.bodies()));
  restart(team.couplings());
}

bool Drift::due(double time) const noexcept {
  return time >= settle_ - same_time && (count_ == 0 || time >= mark_of(count_ - 1).time + apart - same_time);
}

void Drift::restart(std::span<const Coupling> couplings) {
  count_ = 0;
  felt_.assign(marks_[0].places.size(), {});
  for (const Coupling& c : couplings) {
    for (const AgentId agent : c.felt_by) {
      const BodyId other = agent == c.between.first ? c.between.second : c.between.first;
      felt_[at(agent)].push_back(at(other));
    }
  }
}

Drift::Place Drift::place_of(double time, const Sight<double>& sight, Presence presence, const Agent* agent) {
  Place place{
      .there = presence != Presence::absent && is_finite(sight.p), .p = sight.p, .requested = sight.p};
  if (agent == nullptr) return place;
  place.free = true;
  const Model& model = agent->model;
  x_ref_.resize(agent->Q.size());
  agent->x_ref(time, model, x_ref_);
  const auto sight_at = [&](const std::vector<double>& x) {
    return model.sight(x.data(), agent->u_ref.data());
  };
  const Vec3<double> reference = sight_at(x_ref_).p;
  // Effect of each state on the position and velocity of a robot at rest in the origin.
  std::vector<double>& x = x_;
  x.resize(x_ref_.size());
  model.at_rest({{}, {1, 0}}, x.data());
  const Vec3<double> origin = sight_at(x).p;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (agent->Q[i] <= 0) continue;
    const double rest = x[i];
    x[i] = rest + 1;
    const Vec3<double> moved = sight_at(x).p - origin;
    for (std::size_t axis = 0; axis < axes.size(); ++axis) {
      if (moved.*axes[axis] != 0)
        place.axes[axis] = true, place.requested.*axes[axis] = reference.*axes[axis];
    }
    x[i] = rest + x_ref_[i];
    if (dot(moved, moved) == 0 && norm(sight_at(x).v) > creep) place.moves = true;
    x[i] = rest;
  }
  return place;
}

void Drift::add(const Sample& sample, std::span<const Sight<double>> sights, const PresentTeam& present) {
  for (int i = 0; i < sample.event_count; ++i) {
    const Event& event = sample.events[static_cast<std::size_t>(i)];
    if (event.kind == EventKind::land) lands_[static_cast<std::size_t>(event.value)] = true;
  }
  if (sample.of != Sample::Of::update || !due(sample.time)) return;
  Mark& mark = next_mark(sample.time);
  for (std::size_t i = 0; i < mark.places.size(); ++i) {
    const Agent* const agent = lands_[i] ? nullptr : present.agent(BodyId{static_cast<int>(i)});
    mark.places[i] = place_of(sample.time, sights[i], sample.presence[i], agent);
  }
}

Drift::Mark& Drift::next_mark(double time) {
  Mark& mark = marks_[count_++ % marks_max];
  mark.time = time;
  return mark;
}

void Drift::mark(double time, std::span<const Sight<double>> sights, std::span<const Presence> presence,
                 std::span<const Agent* const> agents) {
  Mark& mark = next_mark(time);
  for (std::size_t i = 0; i < mark.places.size(); ++i)
    mark.places[i] = place_of(time, sights[i], presence[i], agents[i]);
}

bool Drift::leaves(std::size_t robot, Group group, std::size_t begin) const {
  const bool across = group == horizontal;
  const auto is_requested = [&](const Place& place) {
    return across ? place.axes[0] || place.axes[1] : place.axes[2];
  };
  const Place& now = mark_of(count_ - 1).places[robot];
  // True if the robot moves away from place_at(k, p), with p the position of the robot.
  const auto from = [&](auto&& place_at) {
    double sum = 0.0, last = 0.0;
    for (std::size_t k = begin; k + 1 < count_; ++k) {
      const Vec3<double>&p0 = mark_of(k).places[robot].p, &p1 = mark_of(k + 1).places[robot].p;
      const Vec3<double> a0 = place_at(k, p0), a1 = place_at(k + 1, p1);
      last = std::min(length(p1 - a1, across), length(p1 - a0, across)) - length(p0 - a0, across);
      sum += last;
      const double least = std::max(creep * (mark_of(k + 1).time - mark_of(k).time),
                                    share_of_anchor * length(a1 - a0, across));
      if (!(last >= least)) return false;
    }
    return last >= share_at_end * sum / static_cast<double>(count_ - 1 - begin);
  };
  if (is_requested(now)) {
    return from([&](std::size_t k, const Vec3<double>& p) {
      Vec3<double> a = p;
      for (std::size_t axis = 0; axis < axes.size(); ++axis) {
        if (now.axes[axis]) a.*axes[axis] = mark_of(k).places[robot].requested.*axes[axis];
      }
      return a;
    });
  }
  if (now.moves) return false;

  std::vector<std::size_t> reached = {robot};
  std::vector<bool> known(felt_.size());
  known[robot] = true;
  bool anchored = false;
  for (std::size_t next = 0; next < reached.size(); ++next) {
    const std::size_t body = reached[next];
    const Place& place = mark_of(count_ - 1).places[body];
    if (body != robot && place.there && (!place.free || place.moves || is_requested(place))) {
      anchored = true;
      if (!from([&](std::size_t k, const Vec3<double>&) { return mark_of(k).places[body].requested; }))
        return false;
    }
    for (const std::size_t other : felt_[body]) {
      if (!known[other]) known[other] = true, reached.push_back(other);
    }
  }
  return anchored || from([&](std::size_t, const Vec3<double>&) { return mark_of(begin).places[robot].p; });
}

std::optional<std::vector<Drift::Found>> Drift::found() const {
  if (count_ <= seconds_min) return std::nullopt;
  const std::size_t begin = count_ - 1 - std::clamp((count_ - 1) / 2, seconds_min, marks_max - 1);
  const Mark &first = mark_of(begin), &last = mark_of(count_ - 1);
  std::vector<Found> found;
  for (std::size_t i = 0; i < last.places.size(); ++i) {
    bool steered = true;
    for (std::size_t k = begin; k < count_; ++k)
      steered = steered && mark_of(k).places[i].there && mark_of(k).places[i].free;
    if (!steered || !(leaves(i, horizontal, begin) || leaves(i, vertical, begin))) continue;
    const auto& requested = last.places[i].axes;
    found.push_back({BodyId{static_cast<int>(i)},
                     1 / (last.time - first.time) * (last.places[i].p - first.places[i].p),
                     std::any_of(requested.begin(), requested.end(), [](bool axis) { return axis; })});
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Found& a, const Found& b) { return norm(a.v) > norm(b.v); });
  return found;
}

}  // namespace sightline
