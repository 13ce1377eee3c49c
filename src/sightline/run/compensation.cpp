#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "sightline/base.hpp"
#include "sightline/loop.hpp"
#include "sightline/run/feed_forward.hpp"
#include "sightline/run/steady_state.hpp"
#include "sightline/safety/carry.hpp"

namespace sightline {
namespace {

constexpr double never = -std::numeric_limits<double>::infinity();
constexpr double longest_gap = 0.5;    // between two measurements that an estimate uses [s]
constexpr double oldest = 1.0;         // greatest age of a measurement for an estimate [s]
constexpr double largest_rate = 20.0;  // limit on the estimate of an acceleration [m/s^2]

/// The inverse of a symmetric matrix, row by row.
std::array<Vec3<double>, 3> inverse(const std::array<Vec3<double>, 3>& m) {
  const auto cross = [](const Vec3<double>& a, const Vec3<double>& b) -> Vec3<double> {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
  };
  const double over = 1 / dot(m[0], cross(m[1], m[2]));
  return {over * cross(m[1], m[2]), over * cross(m[2], m[0]), over * cross(m[0], m[1])};
}

/// Effect of one input at rest, from a quarter of its range below u* to a quarter above it.
struct InputEffect {
  double half, by;  // half the range of the input, and the change of it
  SteadyState more, less;
  Vec3<double> b;  // acceleration by half the range [m/s^2]
};

/// Effects of the inputs by which a robot cancels a disturbance that is estimated over `time` [s].
std::vector<InputEffect> input_effects(const Agent& agent, double time) {
  std::vector<InputEffect> effects;
  double trace = 0.0;
  for (std::size_t k = 0; k < agent.u_ref.size(); ++k) {
    const double half = 0.5 * (agent.limits.u_max().front()[k] - agent.limits.u_min().front()[k]),
                 by = 0.5 * half;
    std::vector<double> up = agent.u_ref, down = agent.u_ref;
    up[k] += by, down[k] -= by;
    const SteadyState more = settle(agent.model, state_at_rest(agent.model), up),
                      less = settle(agent.model, state_at_rest(agent.model), down);
    const Vec3<double> b = (half / (2 * by)) * (more.acceleration - less.acceleration);
    trace += dot(b, b);
    effects.push_back({half, by, more, less, b});
  }
  constexpr double none = 1e-9;
  if (!(trace > none)) {
    throw_invalid(
        "disturbance_time of {} = {}, but its commands accelerate it in no direction, expected a robot whose "
        "velocity is a state",
        agent.name, time);
  }
  return effects;
}

void check_robots(const Team& team, const std::vector<RobotCompensation>& robots) {
  std::vector<BodyId> before;
  for (const auto& [robot, delay, time, feed_forward] : robots) {
    if (robot.index < 0 || robot.index >= team.bodies() || !team.is_agent(robot))
      throw_invalid("body {} is compensated, expected a robot of the team", robot.index);
    const std::string_view name = team.name(robot);
    if (std::find(before.begin(), before.end(), robot) != before.end())
      throw_invalid("{} is compensated twice, expected once", name);
    before.push_back(robot);
    if (!(delay >= 0 && delay <= Compensation::longest_delay))
      throw_invalid("command_delay of {} = {}, expected 0 to {} s", name, delay, Compensation::longest_delay);
    if (!(time == 0 || (time >= Compensation::least_time && time <= Compensation::longest_time)))
      throw_invalid("disturbance_time of {} = {}, expected {} to {} s", name, time, Compensation::least_time,
                    Compensation::longest_time);
  }
}

}  // namespace

void validate(const Team& team, const std::vector<RobotCompensation>& robots) {
  check_robots(team, robots);
  for (const RobotCompensation& of : robots)
    if (of.disturbance_time > 0) (void)input_effects(team.agent(of.robot), of.disturbance_time);
}

/// A body whose state is compensated, or only predicted.
struct Compensation::Member {
  std::size_t body, x, u, nx, nu;  // index in the team, offsets and lengths
  Model model;
  double delay, time;
  std::vector<double> counter;      // u_w over reach, for 1 m/s^2 along x, y, z of V, or of G: 3 x nu
  std::vector<double> held;         // steady-state change of each state per unit of an input: nu x nx
  std::vector<Vec2<double>> leans;  // steady-state tilt per unit of each input
  std::optional<FeedForward> feed_forward;
  std::vector<char> shown;    // whether each state is part of pose or velocity; others follow commands
  std::vector<double> reach;  // half the range of each input
  std::vector<double> last;   // previous measurement, with predicted inner states
  double stamp;               // time of `last` [s]; minus infinity: none
  Vec3<double> w{};
};

Compensation::~Compensation() = default;

Compensation::Compensation(const Team& team, const std::vector<RobotCompensation>& robots, double period)
    : member_of_(size(team.bodies()), -1),
      history_(size(2 + static_cast<int>((longest_delay + longest_gap + oldest) / period)),
               resting_inputs(team)),
      lead_(0.0),
      x_(size(team.nx())),
      added_(size(team.nu())),
      held_(x_.size()),
      lean_(size(team.bodies())) {
  check_robots(team, robots);
  const auto add = [&](BodyId body, double delay, double time) {
    member_of_[at(body.index)] = static_cast<int>(members_.size());
    const Model& model = team.model(body);
    members_.push_back({.body = at(body),
                        .x = size(team.state_offset(body)),
                        .u = team.is_agent(body) ? size(team.input_offset(body)) : 0,
                        .nx = size(model.nx()),
                        .nu = size(model.nu()),
                        .model = model,
                        .delay = delay,
                        .time = time,
                        .counter = {},
                        .held = {},
                        .leans = {},
                        .feed_forward = {},
                        .shown = {},
                        .reach = {},
                        .last = std::vector<double>(size(model.nx())),
                        .stamp = never});
    scratch_.resize(std::max(scratch_.size(), RungeKuttaScratch::rows_needed * size(model.nx())));
  };
  for (const auto& [robot, delay, time, feed_forward] : robots) {
    add(robot, delay, time);
    if (time > 0) find_counter(members_.back(), team.agent(robot));
    if (feed_forward == FeedForwardFrom::reference) members_.back().feed_forward.emplace(team.agent(robot));
    lead_ = std::max(lead_, delay);
  }
  for (int i = 0; lead_ > 0 && i < team.bodies(); ++i) {
    if (!team.is_agent(BodyId{i})) add(BodyId{i}, lead_, 0.0);
  }
}

void Compensation::find_counter(Member& member, const Agent& agent) {
  member.shown = shown_states(member.model);
  member.counter.resize(3 * member.nu);
  member.held.resize(member.nu * member.nx);
  std::array<Vec3<double>, 3> gram{};
  const std::vector<InputEffect> effects = input_effects(agent, member.time);
  for (std::size_t k = 0; k < member.nu; ++k) {
    const auto& [half, by, more, less, b] = effects[k];
    for (std::size_t i = 0; i < member.nx; ++i)
      member.held[k * member.nx + i] = (more.x[i] - less.x[i]) / (2 * by);
    member.leans.push_back({(more.lean.x - less.lean.x) / (2 * by), (more.lean.y - less.lean.y) / (2 * by)});
    gram[0] = gram[0] + b.x * b, gram[1] = gram[1] + b.y * b, gram[2] = gram[2] + b.z * b;
    member.reach.push_back(half);
  }
  constexpr double damping = 1e-9;
  const double trace = gram[0].x + gram[1].y + gram[2].z;
  gram[0].x += damping * trace, gram[1].y += damping * trace, gram[2].z += damping * trace;
  const std::array<Vec3<double>, 3> solved = inverse(gram);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    for (std::size_t k = 0; k < member.nu; ++k)
      member.counter[axis * member.nu + k] = -dot(effects[k].b, solved[axis]);
  }
}

void Compensation::look(BodyId robot, const ValidStates& measured) noexcept {
  const int place = member_of_[at(robot.index)];
  if (place < 0 || !measured.is_valid(robot)) return;
  Member& member = members_[at(place)];
  const double stamp = measured.stamps()[at(robot.index)];
  if (member.time == 0 || !(stamp > member.stamp)) return;
  const std::span<const double> x = std::span<const double>(measured).subspan(member.x, member.nx);
  const double s = stamp - member.stamp;
  if (s > longest_gap) {
    std::copy(x.begin(), x.end(), member.last.begin());
  } else {
    const auto u = carry(member.model, member.last, history_, member.u, member.stamp - member.delay,
                         stamp - member.delay, member.w, scratch_);
    if (u.empty()) return;  // no time has passed
    Vec3<double> r =        // residual acceleration
        (1 / s) *
        (member.model.sight(x.data(), u.data()).v - member.model.sight(member.last.data(), u.data()).v);
    const double length = norm(r);
    if (length > largest_rate) r = (largest_rate / length) * r;
    member.w = member.w + (1 - std::exp(-s / member.time)) * r;
    for (std::size_t i = 0; i < member.nx; ++i) {
      if (member.shown[i]) member.last[i] = x[i];
    }
  }
  member.stamp = stamp;
}

std::span<const double> Compensation::ahead(double t, const ValidStates& estimate) noexcept {
  const std::span<const double> now = estimate;
  std::copy(now.begin(), now.end(), x_.begin());
  for (Member& member : members_) {
    const std::span<double> x = std::span(x_).subspan(member.x, member.nx);
    carry(member.model, x, history_, member.u, t - member.delay, t, member.w, scratch_);
    if (member.time == 0) continue;
    find_steady(member, x);
    Vec2<double>& lean = lean_[member.body] = {};
    for (std::size_t k = 0; k < member.nu; ++k) {
      lean.x += added_[member.u + k] * member.leans[k].x;
      lean.y += added_[member.u + k] * member.leans[k].y;
    }
    for (std::size_t i = 0; i < member.nx; ++i) {
      double& held = held_[member.x + i] = 0.0;
      for (std::size_t k = 0; k < member.nu; ++k) {
        const double by = member.held[k * member.nx + i] * added_[member.u + k];
        x[i] -= by, held += by;
      }
    }
  }
  return x_;
}

/// Computes u_w at the heading of x.
void Compensation::find_steady(const Member& member, std::span<const double> x) noexcept {
  const std::span<double> steady = std::span(added_).subspan(member.u, member.nu);
  Vec3<double> w = member.w;
  if (member.model.turns()) {
    const Vec2<double> d = member.model.sight(x.data(), steady.data()).d;
    const Vec2<double> w_V = rotate<double>({d.x, -d.y}, {w.x, w.y});
    w.x = w_V.x, w.y = w_V.y;
  }
  double part = most_part;
  for (std::size_t k = 0; k < member.nu; ++k) {
    const double* const by = &member.counter[k];
    steady[k] = by[0] * w.x + by[member.nu] * w.y + by[2 * member.nu] * w.z;
    part = std::max(part, std::abs(steady[k]));
  }
  for (std::size_t k = 0; k < member.nu; ++k) steady[k] *= member.reach[k] * most_part / part;
}

void Compensation::write_reference_inputs(BodyId robot, const Reference& x_ref, double t, const double* x,
                                          std::span<double> u_ref) noexcept {
  const int i = member_of_[at(robot.index)];
  if (i < 0 || !members_[at(i)].feed_forward) return;
  Member& member = members_[at(i)];
  (*member.feed_forward)(x_ref, t, member.model.sight(x, u_ref.data()).d, u_ref);
}

void Compensation::forget(BodyId robot) noexcept {
  const int i = member_of_[at(robot.index)];
  if (i < 0) return;
  Member& member = members_[at(i)];
  member.stamp = never;
  member.w = {};
  std::fill_n(added_.begin() + static_cast<std::ptrdiff_t>(member.u), member.nu, 0.0);
  std::fill_n(held_.begin() + static_cast<std::ptrdiff_t>(member.x), member.nx, 0.0);
  lean_[member.body] = {};
}

Vec3<double> Compensation::disturbance(BodyId robot) const noexcept {
  const int i = member_of_[at(robot.index)];
  return i < 0 ? Vec3<double>{} : members_[at(i)].w;
}

}  // namespace sightline
