#include "sightline/supervisor.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "sightline/potential.hpp"

namespace sightline {
namespace {

constexpr double at_the_ground = 0.02;  // [m]

/// Greatest age of a useful measurement [s]: older ones arrive when the robot already lands.
double oldest(const SupervisorOptions& o) { return o.times.land_after + 0.5; }

/// Capacity of the input history, for the greatest age of a measurement.
std::size_t entries(const SupervisorOptions& o) {
  return static_cast<std::size_t>(std::ceil(oldest(o) / o.period)) + 2;
}

}  // namespace

void SupervisorOptions::check() const {
  const auto expect = [](bool holds, std::string_view field, double value, std::string_view expected) {
    require(holds, "supervisor", field, value, expected);
  };
  check_parameters(times, "supervisor");
  check_parameters(sigmas, "supervisor");
  check_parameters(limits, "supervisor");
  check_parameters(*this, "supervisor");
  expect(times.slow_after >= times.fresh, "slow_after", times.slow_after, ">= fresh");
  expect(times.hold_after >= times.slow_after, "hold_after", times.hold_after, ">= slow_after");
  expect(times.land_after >= times.hold_after && times.land_after <= 60, "land_after", times.land_after,
         ">= hold_after, at most 60 s");
  expect(sigmas.land > sigmas.hold, "sigma_land", sigmas.land, "> sigma_hold");
  expect(limits.world > 0, "world", limits.world, "> 0 m");
  expect(limits.position_sigma >= 0, "position_sigma", limits.position_sigma, ">= 0 m");
  expect(limits.heading_sigma >= 0, "heading_sigma", limits.heading_sigma, ">= 0 rad");
  expect(period >= 1e-4, "period", period, ">= 1e-4 s");
}

const SupervisorOptions& validate(const Team& team, const SupervisorOptions& options) {
  options.check();
  for (const Agent& agent : team.agents()) {
    if (agent.u_ref.size() <= Brake::inputs_max) continue;
    throw std::invalid_argument(fmt::format("\"{}\" has {} inputs, expected at most {} under a supervisor",
                                            agent.name, agent.u_ref.size(), Brake::inputs_max));
  }
  return options;
}

Supervisor::Supervisor(const Team& team, const SupervisorOptions& options)
    : team_(team),
      options_(validate(team, options)),
      history_(entries(options), resting_inputs(team)),
      robot_of_(static_cast<std::size_t>(team.bodies())),
      presence_(robot_of_.size(), Presence::steered),
      estimated_(static_cast<std::size_t>(team.nx())),
      sigmas_(robot_of_.size()),
      positioned_(robot_of_.size()) {
  for (int i = 0; i < team_.bodies(); ++i) {
    const BodyId body{i};
    const Model& model = team_.model(body);
    const auto x = static_cast<std::size_t>(team_.state_offset(body));
    const auto u = static_cast<std::size_t>(team_.input_offset(body));
    TrackLimits limits = options_.limits;
    limits.oldest = oldest(options_);
    if (!options_.command_delays.empty()) limits.command_delay = options_.command_delays[at(body)];
    tracks_.emplace_back(model, u, limits);
    const std::span<const double> state = tracks_.back().state();
    std::copy(state.begin(), state.end(), estimated_.begin() + static_cast<std::ptrdiff_t>(x));
    if (!team_.is_agent(body)) continue;
    const Agent& agent = team_.agent(body);
    robot_of_[at(body)] = robots_.size();
    robots_.push_back({.body = body,
                       .x = x,
                       .u = u,
                       .nx = state.size(),
                       .nu = agent.u_ref.size(),
                       .u_ref = agent.u_ref,
                       .u_min = agent.u_ref,
                       .u_max = agent.u_ref,
                       .partners = partners_of(team_, body),
                       .limits = &agent.limits,
                       .brake = Brake(model, agent.u_ref, options_.brake_time),
                       .level = FallbackLevel::valid});
    robots_.back().partners.reserve(robot_of_.size());
  }
  notices_.reserve(2 * tracks_.size());
}

std::vector<BodyId> Supervisor::partners_of(const Team& team, BodyId robot) {
  std::vector<BodyId> partners;
  for (const Coupling& coupling : team.couplings()) {
    const bool felt = std::any_of(coupling.felt_by.begin(), coupling.felt_by.end(),
                                  [&](BodyId feeling) { return feeling == robot; });
    if (!felt) continue;
    const auto& [first, second] = coupling.between;
    const BodyId other = first == robot ? second : first;
    if (std::find(partners.begin(), partners.end(), other) == partners.end()) partners.push_back(other);
  }
  return partners;
}

void Supervisor::follow(const Membership& now, double t, std::span<const double> x) noexcept {
  std::size_t at = 0;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    const std::size_t nx = tracks_[i].state().size();
    const bool comes = presence_[i] == Presence::absent && now.presence[i] != Presence::absent;
    presence_[i] = now.presence[i];
    if (comes) {
      positioned_[i] = false;
      tracks_[i].begin(x.subspan(at, nx), t);
      if (team_.is_agent(BodyId{static_cast<int>(i)})) robots_[robot_of_[i]].level = FallbackLevel::valid;
    }
    at += nx;
  }
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    robots_[i].partners.assign(now.partners[i].begin(), now.partners[i].end());
    robots_[i].limits = &now.limits[i];
  }
}

bool Supervisor::knows_all() const noexcept {
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    if (presence_[i] != Presence::absent && !tracks_[i].known()) return false;
  }
  return true;
}

bool Supervisor::awaits_position() const noexcept {
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    if (presence_[i] != Presence::absent && std::isinf(sigmas_[i]) && !tracks_[i].known()) return true;
  }
  return false;
}

std::span<const double> Supervisor::accept_measurement(double t, std::span<const double> measured,
                                                       std::span<const double> stamps,
                                                       std::span<const double> sigma) noexcept {
  assert(measured.size() == estimated_.size() && stamps.size() == tracks_.size() &&
         (sigma.empty() || sigma.size() == tracks_.size()) && "a measurement is of all bodies of the team");
  time_ = t;
  notices_.clear();
  std::size_t at = 0;
  for (std::size_t i = 0; i < tracks_.size(); ++i) {
    Track& track = tracks_[i];
    const std::size_t nx = track.state().size(), from = std::exchange(at, at + nx);
    if (presence_[i] == Presence::absent) continue;
    sigmas_[i] = sigma.empty() ? 0.0 : sigma[i];
    positioned_[i] |= !std::isinf(sigmas_[i]);
    const std::span<const double> x = measured.subspan(from, nx);
    std::span<const double> state = track.state();
    if (!std::isinf(sigmas_[i])) {
      const bool trusted = track.trusted();
      const MeasurementFault fault = track.take(x, stamps[i], t, history_, sigmas_[i]);
      if (trusted && !track.trusted()) notify({BodyId{static_cast<int>(i)}, fault});
    } else if (!track.known() && all_finite(x)) {
      state = x;  // its velocities allow braking
    }
    track.predict(t, history_);
    std::copy(state.begin(), state.end(), estimated_.begin() + static_cast<std::ptrdiff_t>(from));
  }
  return estimated_;
}

Ages Supervisor::ages_of(const Robot& robot, std::span<const double> plan_ages) const noexcept {
  Ages ages{.own = age(robot.body), .partners = 0.0, .plan = plan_ages[at(robot.body)]};
  for (const BodyId partner : robot.partners) ages.partners = std::max(ages.partners, age(partner));
  return ages;
}

FallbackLevel Supervisor::level_by_sigma(const Robot& robot) const noexcept {
  FallbackLevel level = level_at(options_.sigmas, sigmas_[at(robot.body)]);
  for (const BodyId partner : robot.partners) {
    if (!is_there(partner)) continue;
    level = std::max(level, std::min(level_at(options_.sigmas, sigmas_[at(partner)]), FallbackLevel::hold));
  }
  return level;
}

void Supervisor::command(double t, std::span<const double> x, std::span<const double> plan_ages,
                         std::span<const double> added, std::span<double> u) noexcept {
  assert(plan_ages.size() == tracks_.size() && "a plan has an age for each body");
  const bool awaits = awaits_position();  // no plans are requested meanwhile
  for (Robot& robot : robots_) {
    if (!is_there(robot.body)) continue;
    robot.limits->at(t, robot.u_min, robot.u_max);
    for (std::size_t i = 0; i < robot.nu; ++i)
      robot.u_min[i] -= added[robot.u + i], robot.u_max[i] -= added[robot.u + i];
    Ages ages = ages_of(robot, plan_ages);
    if (awaits) ages.plan = std::min(ages.plan, options_.times.land_after);
    const double height = team_.model(robot.body).sight(&x[robot.x], robot.u_ref.data()).p.z;
    const bool on_ground = height <= options_.ground + at_the_ground;
    FallbackLevel next = next_level(robot.level, options_.times, ages, on_ground, level_by_sigma(robot));
    // Without a known position the robot cannot land.
    if (std::isinf(ages.own) || !positioned_[at(robot.body)]) next = FallbackLevel::hold;
    if (next != robot.level) notify({robot.body, next});
    robot.level = next;
    apply(robot, x.subspan(robot.x, robot.nx), u.subspan(robot.u, robot.nu));
  }
}

void Supervisor::apply(Robot& robot, std::span<const double> x, std::span<double> u) noexcept {
  switch (robot.level) {
    case FallbackLevel::valid:
    case FallbackLevel::predicted:
      break;
    case FallbackLevel::slowed:
      for (std::size_t i = 0; i < u.size(); ++i) {
        u[i] = robot.u_ref[i] + options_.slow_factor * (u[i] - robot.u_ref[i]);
      }
      break;
    case FallbackLevel::hold:
      robot.brake(x, {}, robot.u_min, robot.u_max, u);
      break;
    case FallbackLevel::land:
      robot.brake(x, {0.0, 0.0, -options_.land_speed}, robot.u_min, robot.u_max, u);
      break;
    case FallbackLevel::grounded:
      robot.brake(x, {}, robot.u_min, robot.u_max, u);
      break;
  }
  for (std::size_t i = 0; i < u.size(); ++i) {
    const double finite = std::isfinite(u[i]) ? u[i] : robot.u_ref[i];
    u[i] = std::clamp(finite, robot.u_min[i], robot.u_max[i]);
  }
}

void Supervisor::notify(const Notice& notice) noexcept {
  if (notices_.size() < notices_.capacity()) notices_.push_back(notice);
}

}  // namespace sightline
