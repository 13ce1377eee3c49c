#include "sightline/analysis/identification/excitation.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "sightline/base.hpp"
#include "sightline/model/state_roles.hpp"
#include "sightline/safety/zone.hpp"
#include "sightline/scenario.hpp"
#include "sightline/scenario/starts.hpp"

namespace sightline {
namespace {

constexpr std::size_t yaw = 3;
constexpr double yaw_part = 0.7;  // of a random step: a full step would turn the heading too far

/// 3-2-1-1 of each input in turn.
std::array<double, 4> three_two_one_one(double t) {
  constexpr double unit = 0.3, pattern = 7 * unit, span = 2 * pattern;
  const double at = std::fmod(t, 4 * span), within = std::fmod(at, span);
  const double n = std::fmod(within, pattern) / unit, sign = within < pattern ? 1 : -1;
  std::array<double, 4> u{};
  u[std::min<std::size_t>(3, static_cast<std::size_t>(at / span))] = sign * (n < 3   ? 1
                                                                             : n < 5 ? -1
                                                                             : n < 6 ? 1
                                                                                     : -1);
  return u;
}

/// A sine for each input. Its frequency rises from f0 to f1 in two sweeps; each input is a quarter
/// of a sweep ahead of the one before.
std::array<double, 4> chirp(double t, double seconds) {
  constexpr double f0 = 0.15, f1 = 2.5, part = 0.6;
  const double span = 0.5 * seconds, rate = std::log(f1 / f0) / span;
  std::array<double, 4> u;
  for (std::size_t i = 0; i < u.size(); ++i) {
    const double within = std::fmod(t + 0.25 * span * static_cast<double>(i), span);
    u[i] = part * std::sin(2 * std::numbers::pi * f0 * (std::exp(rate * within) - 1) / rate);
  }
  return u;
}

/// Feedback towards the start: a command for each input as a fraction of its limit.
class WayBack {
 public:
  WayBack(const FlownMotion& of, const SeenMotion& start, const ExcitationOptions& options)
      : tilts_(of.commands == Commands::tilt), u_max_(of.u_max), start_(start), options_(options) {}

  /// @param vertical  velocity [m/s]
  /// @return whether the excitation must wait
  bool returns(const SeenMotion& now, double vertical) {
    constexpr double ahead = 1.0, inside = 0.4;
    const Vec2<double> v = rotate<double>({std::cos(now.psi), std::sin(now.psi)}, {now.v_f, now.v_s});
    const double off = norm(now.p.x + ahead * v.x - start_.p.x, now.p.y + ahead * v.y - start_.p.y);
    const double over = std::abs(now.p.z + 0.5 * ahead * vertical - start_.p.z);
    const double part = std::max(off / options_.radius, over / options_.climb);
    returning_ = part > (returning_ ? inside : 1.0);
    return returning_;
  }

  std::array<double, 4> command(const SeenMotion& now, bool alone) const {
    const Vec3<double> r = start_.p - now.p;
    const Vec2<double> d = {std::cos(now.psi), std::sin(now.psi)};
    const Vec2<double> to_start = rotate<double>({d.x, -d.y}, {r.x, r.y});
    const double more = alone ? 1.0 : 0.4;
    std::array<double, 4> u;
    if (tilts_) {
      // Equals a spring of 0.4 1/s^2 and a damper of 0.9 1/s for b = 2 m/s^2.
      u = {more * (0.2 * to_start.x - 0.45 * now.v_f), -more * (0.2 * to_start.y - 0.45 * now.v_s),
           more * 0.8 * r.z, 0.0};
    } else {
      u = {more * 0.6 * to_start.x / u_max_[0], more * 0.6 * to_start.y / u_max_[1],
           more * 0.8 * r.z / u_max_[2], 0.0};
    }
    for (double& part : u) part = std::clamp(part, -1.0, 1.0);
    return u;
  }

 private:
  bool tilts_;
  std::array<double, 4> u_max_;
  SeenMotion start_;
  ExcitationOptions options_;
  bool returning_ = false;
};

/// The scenario with the robot at its initial height of the excitation.
Scenario raised(Scenario scenario, AgentId robot, const ExcitationOptions& options) {
  const int p_z = roles_of(scenario.team.model(robot)).position[2];
  if (p_z >= 0) {
    double& z = scenario.x0[size(scenario.team.state_offset(robot) + p_z)];
    z = options.height.value_or(std::max(z, ExcitationOptions::least_height));
  }
  scenario.simulation.seed = options.seed;
  return scenario;
}

}  // namespace

void ExcitationOptions::check() const {
  if (!(seconds >= 5 && seconds <= 600)) throw_invalid("--seconds = {}, expected 5 to 600 s", seconds);
  if (height && !(*height >= 1 && *height <= 1000))
    throw_invalid("--height = {}, expected 1 to 1000 m", *height);
  if (!(radius >= 0.5 && radius <= 1000)) throw_invalid("--radius = {}, expected 0.5 to 1000 m", radius);
  if (!(climb > 0 && climb <= 1000)) throw_invalid("climb = {}, expected above 0 to 1000 m", climb);
}

ExcitationSignal::ExcitationSignal(const ExcitationOptions& options)
    : options_(options), random_(options.seed, StreamId::motion, 0) {}

std::array<double, 4> ExcitationSignal::at(double t) {
  if (options_.kind == ExcitationKind::three_two_one_one) return three_two_one_one(t);
  if (options_.kind == ExcitationKind::chirp) return chirp(t, options_.seconds);
  const bool whole = options_.kind == ExcitationKind::bang_bang;
  for (std::size_t i = 0; i < held_.size(); ++i) {
    if (t < until_[i]) continue;
    const double drawn = 2 * random_.uniform() - 1;
    held_[i] = whole ? (drawn < 0 ? -1.0 : 1.0) : (i == yaw ? yaw_part : 1.0) * drawn;
    until_[i] = t + 0.2 + (whole ? 1.3 : 0.8) * random_.uniform();
  }
  return held_;
}

namespace {

/// Reduces radius and climb to the room around the position p.
ExcitationOptions fitted(ExcitationOptions options, const Scenario& scenario, AgentId robot,
                         const Vec3<double>& p) {
  constexpr double beyond = 1.5, least_radius = 0.5, least_climb = 0.2;
  double level = beyond * options.radius, climb = beyond * options.climb;
  if (scenario.safety) {
    const BarrierOptions& walls = scenario.safety->barrier_options;
    level = std::min(level, scenario.safety->world - std::max(std::abs(p.x), std::abs(p.y)));
    climb = std::min({climb, p.z - walls.floor, walls.ceiling - p.z});
    for (const Zone& zone : walls.zones) {
      // Of the level and the vertical way together.
      const double room = std::sqrt(0.5) * zone_reserve(zone, p);
      level = std::min(level, room), climb = std::min(climb, room);
    }
  }
  options.radius = level / beyond, options.climb = climb / beyond;
  if (!(options.radius >= least_radius && options.climb >= least_climb))
    throw_invalid(
        "it began at [{:.2f}, {:.2f}, {:.2f}] m, expected room of {:.2f} m level and {:.2f} m up and down "
        "within the "
        "walls",
        p.x, p.y, p.z, beyond * least_radius, beyond * least_climb);
  const Team& team = scenario.team;
  for (const UncooperativeBody& other : scenario.uncooperative) {
    const Vec3<double> r = sight_at_start(scenario, other.body).p - p;
    const double kept = other.d_hard.value_or(scenario.safety ? scenario.safety->d_hard : 0.0);
    if (norm(r.x, r.y) < beyond * options.radius + kept)
      throw_invalid("{} is {:.2f} m from {}, expected more than {:.2f} m: less radius, or another place",
                    team.name(other.body), norm(r.x, r.y), team.name(robot), beyond * options.radius + kept);
  }
  return options;
}

enum class Room { free, within_walls };
constexpr double first_seen_by = 0.2;  // [s]

FlownMotion excite(const Scenario& scenario, AgentId robot, const ExcitationOptions& requested, World& world,
                   Clock& clock, Room room, const std::atomic<bool>* stop) {
  const Team& team = scenario.team;
  const Model& model = team.model(robot);
  const double period = scenario.horizon.dt;
  FlownMotion motion = motion_of(team, robot, period);
  const std::size_t x = size(team.state_offset(robot)), u_at = size(team.input_offset(robot));
  ExcitationOptions options = requested;
  ExcitationSignal signal(options);
  std::optional<WayBack> back;
  std::vector<double> u(size(team.nu()));
  CommandGate gate(team, period);
  std::array<double, 4> command{};
  double last_height = 0.0;
  const std::int64_t periods = std::llround((ExcitationOptions::hover_seconds + options.seconds) / period);
  motion.u.reserve(static_cast<std::size_t>(periods));
  motion.measured.reserve(static_cast<std::size_t>(periods));
  clock.start(period);
  for (std::int64_t next = 0; next < periods; ++next) {
    const std::int64_t k = std::min(clock.wait(next), periods - 1);
    if (stop != nullptr && *stop)
      throw_invalid("the excitation was ended, expected {} s of it", options.seconds);
    // Missed periods pass under the previous command.
    for (; next < k; ++next) motion.add(model, nullptr, no_value, nullptr, command);
    const double t = static_cast<double>(k) * period;
    const Measured now = world.measure(t);
    motion.add(model, &now.measured[x], t - now.stamps[sightline::at(robot)],
               now.truth.empty() ? nullptr : &now.truth[x], command);
    const auto last = std::find_if(motion.measured.rbegin(), motion.measured.rend(), is_seen);
    // On a link the first pose may predate the first period.
    const bool is_known = last != motion.measured.rend();
    if (!is_known && (room == Room::free || t > first_seen_by))
      throw_invalid("{} was not seen at {} s, expected a measurement", motion.robot, t);
    if (is_known) {
      if (!back) {
        if (room == Room::within_walls) options = fitted(options, scenario, robot, last->p);
        back.emplace(motion, *last, options), last_height = last->p.z;
      }

      // Vertical velocity by a low-pass filter with a time constant of about 0.1 s.
      const double share = std::min(1.0, period / 0.1);
      const double vertical = (last->p.z - last_height) / 0.1;
      last_height += share * (last->p.z - last_height);
      const bool excites = t >= ExcitationOptions::hover_seconds;
      const bool waits = back->returns(*last, vertical) || !excites;
      const std::array<double, 4> home = back->command(*last, waits);
      const std::array<double, 4> wanted =
          excites ? signal.at(t - ExcitationOptions::hover_seconds) : std::array<double, 4>{};
      for (std::size_t i = 0; i < command.size(); ++i) {
        const double part = home[i] + (waits && i != yaw ? 0.0 : wanted[i]);
        command[i] = motion.u_max[i] * std::clamp(part, -1.0, 1.0);
      }
    }
    std::copy(command.begin(), command.end(), u.begin() + static_cast<std::ptrdiff_t>(u_at));
    gate.open(t);
    const Command applied = gate.pass(u, {});
    std::copy_n(applied.begin() + static_cast<std::ptrdiff_t>(u_at), command.size(), command.begin());
    motion.u.back() = command;
    if (!world.apply(t, now.measured, applied, period, 1)) {
      const std::string why = world.ended();
      throw_invalid("{}: {}, expected a flight of {} s; begin higher (--height) or with more room (--radius)",
                    scenario.file.native(), why.empty() ? "a state is no longer finite" : why,
                    options.seconds);
    }
  }
  return motion;
}

}  // namespace

FlownMotion fly_excitation(const Scenario& scenario, AgentId robot, const ExcitationOptions& options) {
  options.check();
  const Scenario begun = raised(scenario, robot, options);
  const std::unique_ptr<World> world = make_world(begun);
  std::vector<Presence> alone(size(begun.team.bodies()), Presence::absent);
  alone[sightline::at(robot)] = Presence::steered;
  world->set_presence(alone);
  SimulatedClock clock;
  return excite(begun, robot, options, *world, clock, Room::free, nullptr);
}

FlownMotion fly_excitation(const Scenario& scenario, AgentId robot, const ExcitationOptions& options,
                           World& world, Clock& clock, const std::atomic<bool>& stop) {
  options.check();
  return excite(scenario, robot, options, world, clock, Room::within_walls, &stop);
}

}  // namespace sightline
