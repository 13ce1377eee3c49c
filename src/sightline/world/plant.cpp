#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "sightline/base.hpp"
#include "sightline/model/state_roles.hpp"
#include "sightline/worlds.hpp"

namespace sightline {
namespace {

const PlantOptions& checked(const PlantOptions& options) {
  options.disturbances.check();
  require(options.period >= 1e-4, "plant", "period", options.period, ">= 1e-4 s");
  options.downwash.check();
  require(options.downwash.scale == 0 || options.dynamics != nullptr, "plant", "downwash",
          options.downwash.scale, "0 where no vehicles move");
  return options;
}

/// Indices of the position and heading states.
std::vector<int> pose_states(const Model& model) {
  const StateRoles roles = roles_of(model);
  std::vector<int> all(roles.position.begin(), roles.position.end());
  all.insert(all.end(), roles.direction.begin(), roles.direction.end());
  all.push_back(roles.angle);
  std::erase(all, -1);
  return all;
}

/// Spectral radius of df/dx at the state x under resting inputs u [1/s], from the growth of its
/// powers up to A^64.
double fastest_rate(const Model& model, std::span<const double> x, std::span<const double> u) {
  const std::size_t n = x.size();
  std::vector<double> A(n * n), product(n * n), up(x.begin(), x.end()), down = up, more(n), less(n);
  for (std::size_t j = 0; j < n; ++j) {
    const double by = 1e-6 * std::max(1.0, std::abs(x[j]));
    up[j] = x[j] + by, down[j] = x[j] - by;
    model.f(up.data(), u.data(), more.data());
    model.f(down.data(), u.data(), less.data());
    up[j] = down[j] = x[j];
    for (std::size_t i = 0; i < n; ++i) A[i * n + j] = (more[i] - less[i]) / (2 * by);
  }
  double log_growth = 0.0;  // scale removed from A so far, per factor of the power
  constexpr int squarings = 6;
  for (int k = 0; k <= squarings; ++k) {
    double largest = 0.0;
    for (const double a : A) largest = std::max(largest, std::abs(a));
    if (!(largest > 1e-200) || !std::isfinite(largest)) return 0.0;
    for (double& a : A) a /= largest;
    log_growth += std::log(largest) / static_cast<double>(1 << k);
    for (std::size_t i = 0; k < squarings && i < n; ++i) {
      for (std::size_t j = 0; j < n; ++j) {
        product[i * n + j] = 0.0;
        for (std::size_t m = 0; m < n; ++m) product[i * n + j] += A[i * n + m] * A[m * n + j];
      }
    }
    if (k < squarings) A.swap(product);
  }
  return std::exp(log_growth);
}

}  // namespace

Plant::Plant(Team team, std::vector<double> x0, const PlantOptions& options)
    : team_(std::move(team)),
      disturbances_(checked(options).disturbances),
      nx_(static_cast<std::size_t>(team_.nx())),
      z_(std::move(x0)),
      u_(static_cast<std::size_t>(team_.nu())),
      delay_(disturbances_.input_delay, options.period, resting_inputs(team_)),
      motions_(team_, options.motions, options.seed, options.speed_max),
      dynamics_(options.dynamics),
      pool_(thread_pool_if(team_.bodies() >= PlantOptions::shared_from, options.pool)),
      steered_for_(options.period) {
  if (z_.size() != nx_) {
    throw std::invalid_argument(fmt::format("the plant's start has {} numbers, expected {}", z_.size(), nx_));
  }
  int robots = 0;
  for (int i = 0; i < team_.bodies(); ++i) {
    const BodyId body{i};
    const bool is_robot = team_.is_agent(body);
    Part& part = parts_.emplace_back(Part{team_.model(body),
                                          static_cast<std::size_t>(team_.state_offset(body)),
                                          static_cast<std::size_t>(team_.input_offset(body)),
                                          is_robot ? robots++ : -1,
                                          true,
                                          is_robot && dynamics_ != nullptr && dynamics_->moves(body),
                                          {}});
    if (disturbances_.slip > 0 && part.model.rolls()) part.slipping = pose_states(part.model);
    if (!part.model.normalise(&z_[part.x])) {
      throw std::invalid_argument(fmt::format(
          "the start of \"{}\" is not a state, expected finite numbers and a heading other than (0, 0)",
          team_.name(body)));
    }
    if (part.moved) dynamics_->begin(body, time_, &z_[part.x]);
    if (!part.moved && is_robot) {
      const double rate = fastest_rate(part.model, std::span(z_).subspan(part.x, size(part.model.nx())),
                                       team_.agent(body).u_ref);
      longest_ = std::min(longest_, part_of_fastest / rate);
    }
    if (disturbances_.yaw_lag == 0 || !is_robot) continue;
    const int yaw = yaw_input(part.model);
    if (yaw >= 0) lags_.push_back({part.u + size(yaw), nx_ + lags_.size()});
  }
  const std::span<const double> resting = delay_.at(0.0);
  for (const YawLag& lag : lags_) z_.push_back(disturbances_.input_gain * resting[lag.input]);
  start_ = z_;
  sensed_.resize(nx_);
  scratch_.resize(scratch_rows * z_.size());
  divide();

  const Vec3<double>& wind = disturbances_.wind;
  if (disturbances_.gust_sigma > 0) {
    gusts_.emplace(disturbances_.gust_sigma, disturbances_.gust_time, robots, options.seed);
  }
  if (disturbances_.airflow.amplitude > 0) wakes_.emplace(disturbances_.airflow, robots, options.seed);
  p_.resize(static_cast<std::size_t>(robots));
  acceleration_.resize(p_.size());
  pushed_ = gusts_ || wakes_ || wind.x != 0 || wind.y != 0 || wind.z != 0;
  motions_.steer(time_, steered_for_, u_, z_);
}

/// Groups bodies into bunches that are large enough for sharing to pay.
void Plant::divide() {
  constexpr std::size_t together = 32;
  Bunch next{};
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const Part& part = parts_[i];
    const std::size_t inputs_end = part.u + size(part.model.nu());
    ++next.parts;
    next.nx += size(part.model.nx());
    while (part.robot >= 0 && next.lag + next.lags < lags_.size() &&
           lags_[next.lag + next.lags].input < inputs_end)
      ++next.lags;
    if (next.parts < together && i + 1 < parts_.size()) continue;
    bunches_.push_back(next);
    next = {
        .part = i + 1, .parts = 0, .x = next.x + next.nx, .nx = 0, .lag = next.lag + next.lags, .lags = 0};
  }
}

bool Plant::step(std::span<const double> u, double dt) noexcept {
  constexpr double longest_step = 1e6;  // [s]
  if (u.size() != u_.size() || !(dt > 0 && dt <= longest_step)) return false;
  if (dt != steered_for_) motions_.steer(time_, steered_for_ = dt, u_, z_);
  if (wind_moves_) set_wind();
  if (pushed_) set_accelerations();
  delay_.give(time_, u);

  // A command that comes into force divides the step. A short yaw lag does too: Runge-Kutta is
  // accurate only for steps of a fraction of the lag, and unstable beyond 2.8 lags.
  constexpr double most_parts = 1000;
  const double fast = std::max(longest_, dt / most_parts);
  const double longest = lags_.empty() ? fast : std::min(fast, disturbances_.yaw_lag / 4);
  for (double done = 0; dt - done > same_time || done == 0;) {
    const std::span<const double> held = delay_.at(time_ + done);
    const double until_next = delay_.next_arrival() - (time_ + done);
    double s = std::min(dt - done, longest);
    if (until_next < s - same_time) s = until_next;
    integrate(held, time_ + done, s);
    done += s;
  }

  if (gusts_) gusts_->advance(dt);
  if (wakes_) wakes_->advance(dt);
  time_ += dt;
  motions_.steer(time_, dt, u_, z_);
  bool finite = true;
  for (const Part& part : parts_) finite = part.model.normalise(&z_[part.x]) && finite;
  return finite;
}

void Plant::set_presence(std::span<const Presence> presence) noexcept {
  for (std::size_t i = 0; i < std::min(parts_.size(), presence.size()); ++i) {
    Part& part = parts_[i];
    const bool was_there = std::exchange(part.there, presence[i] != Presence::absent);
    if (was_there || !part.there) continue;
    const int n = part.robot >= 0 ? part.model.nx() : 3;
    std::copy_n(&start_[part.x], n, &z_[part.x]);
    if (part.robot < 0) motions_.leave(BodyId{static_cast<int>(i)});
    if (part.moved) dynamics_->begin(BodyId{static_cast<int>(i)}, time_, &z_[part.x]);
  }
}

void Plant::surround(const Surroundings& around) noexcept {
  for (const Surroundings::Move& move : around.moves) motions_.move(move, z_);
  if (!around.wind || (wind_moves_ && around.wind->begin == wind_.begin)) return;
  wind_ = *around.wind;
  wind_before_ = disturbances_.wind;
  wind_moves_ = pushed_ = true;
}

/// Blends the wind of an event; it is held over the step that starts now.
void Plant::set_wind() noexcept {
  const double part = blended(time_, wind_.begin, wind_.duration);
  disturbances_.wind = wind_before_ + part * (wind_.acceleration - wind_before_);
}

std::span<const double> Plant::sensed() noexcept {
  if (dynamics_ == nullptr) return x();
  std::copy_n(z_.begin(), nx_, sensed_.begin());
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    if (parts_[i].moved) dynamics_->sense(BodyId{static_cast<int>(i)}, &sensed_[parts_[i].x]);
  }
  return sensed_;
}

void Plant::set_accelerations() noexcept {
  for (const Part& part : parts_) {
    if (part.robot < 0) continue;
    const auto robot = static_cast<std::size_t>(part.robot);
    constexpr double nowhere = 1e100;  // [m]
    p_[robot] = part.there ? part.model.sight(&z_[part.x], &u_[part.u]).p
                           : Vec3<double>{nowhere * (1 + part.robot), nowhere, 0.0};
    acceleration_[robot] = disturbances_.wind;
    if (gusts_) acceleration_[robot] = acceleration_[robot] + gusts_->acceleration(part.robot);
  }
  if (wakes_) wakes_->push(p_, acceleration_);
}

/// Moves the robots of dynamics_ to t [s].
void Plant::move_by_dynamics(double t) noexcept {
  // A lagging yaw rate is held over the step.
  for (const YawLag& lag : lags_) u_[lag.input] = z_[lag.state];
  const auto each = [&](const auto& act) {
    for (std::size_t i = 0; i < parts_.size(); ++i) {
      if (parts_[i].moved && parts_[i].there) act(BodyId{static_cast<int>(i)}, parts_[i]);
    }
  };
  each([&](BodyId robot, const Part& part) {
    const Vec3<double> none{};
    dynamics_->steer(robot, u_.data() + part.u,
                     pushed_ ? acceleration_[static_cast<std::size_t>(part.robot)] : none);
  });
  dynamics_->move(t);
  each([&](BodyId robot, const Part& part) { dynamics_->show(robot, &z_[part.x]); });
}

void Plant::integrate(std::span<const double> u, double from, double s) noexcept {
  for (std::size_t i = 0; i < u_.size(); ++i) u_[i] = disturbances_.input_gain * u[i];
  if (dynamics_ != nullptr) move_by_dynamics(from + s);
  pool_->share(static_cast<int>(bunches_.size()),
               [&](int b, int) noexcept { integrate(bunches_[at(b)], u, s); });
}

void Plant::integrate(const Bunch& bunch, std::span<const double> u, double s) noexcept {
  const std::size_t nx = bunch.nx, n = nx + bunch.lags;
  const auto parts = std::span(parts_).subspan(bunch.part, bunch.parts);
  const auto lags = std::span(lags_).subspan(bunch.lag, bunch.lags);
  const std::span<double> scratch = std::span(scratch_).subspan(scratch_rows * (bunch.x + bunch.lag)),
                          z = scratch.first(n);
  const std::span<double> states = std::span(z_).subspan(bunch.x, nx),
                          lagging = std::span(z_).subspan(nx_ + bunch.lag, lags.size());
  std::copy(states.begin(), states.end(), z.begin());
  std::copy(lagging.begin(), lagging.end(), z.begin() + static_cast<std::ptrdiff_t>(nx));
  const auto f = [&](std::span<const double> now, std::span<double> rate) {
    for (std::size_t k = 0; k < lags.size(); ++k) {
      const std::size_t input = lags[k].input;
      rate[nx + k] = (disturbances_.input_gain * u[input] - now[nx + k]) / disturbances_.yaw_lag;
      u_[input] = now[nx + k];
    }
    for (const Part& part : parts) {
      const std::size_t x = part.x - bunch.x;
      if (!part.there || part.moved) {
        std::fill_n(&rate[x], part.model.nx(), 0.0);
        continue;
      }
      part.model.f(&now[x], u_.data() + part.u, &rate[x]);
      for (const int state : part.slipping) rate[x + size(state)] *= 1.0 - disturbances_.slip;
      if (pushed_ && part.robot >= 0) {
        part.model.push(&now[x], acceleration_[static_cast<std::size_t>(part.robot)], &rate[x]);
      }
    }
  };
  rk4_step(f, z, s, {scratch.subspan(n, RungeKuttaScratch::rows_needed * n)});
  std::copy_n(z.begin(), nx, states.begin());
  std::copy(z.begin() + static_cast<std::ptrdiff_t>(nx), z.end(), lagging.begin());
}

}  // namespace sightline
