#include "sightline/analysis/identification/flown_motion.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "sightline/base.hpp"

namespace sightline {
namespace {

constexpr SeenMotion unseen = {{no_value, no_value, no_value}, no_value, no_value, no_value};
constexpr double at_the_period = 1e-3;  // fraction of a period

/// @param before  earlier rows of this kind, to unwrap the heading
SeenMotion seen(const Model& model, const double* x, const std::array<double, 4>& u,
                const std::vector<SeenMotion>& before) {
  const Sight<double> s = model.sight(x, u.data());
  const Vec2<double> v = rotate<double>({s.d.x, -s.d.y}, {s.v.x, s.v.y});
  double psi = std::atan2(s.d.y, s.d.x);
  const auto last = std::find_if(before.rbegin(), before.rend(), is_seen);
  constexpr double turn = 2 * std::numbers::pi;
  if (last != before.rend()) psi -= turn * std::round((psi - last->psi) / turn);
  return {s.p, psi, v.x, v.y};
}

constexpr std::array identified = {Commands::tilt, Commands::velocity};
bool identifies(const Model& model) {
  const auto commands = commands_of(model);
  return commands && std::find(identified.begin(), identified.end(), *commands) != identified.end();
}

std::vector<std::string_view> multirotors(const Team& team) {
  std::vector<std::string_view> names;
  for (int i = 0; i < team.bodies(); ++i) {
    if (team.is_agent(BodyId{i}) && identifies(team.model(BodyId{i}))) names.push_back(team.name(BodyId{i}));
  }
  return names;
}

}  // namespace

bool is_seen(const SeenMotion& motion) {
  return std::isfinite(motion.p.x + motion.p.y + motion.p.z + motion.psi + motion.v_f + motion.v_s);
}

SeenMotion between(const SeenMotion& from, const SeenMotion& to, double share) {
  const auto on = [share](double a, double b) { return a + share * (b - a); };
  return {from.p + share * (to.p - from.p), on(from.psi, to.psi), on(from.v_f, to.v_f), on(from.v_s, to.v_s)};
}

bool FlownMotion::is_between_periods() const {
  return std::any_of(measured.begin(), measured.end(),
                     [](const SeenMotion& m) { return is_seen(m) && m.before > 0; });
}

void FlownMotion::add(const Model& of, const double* state, double age, const double* true_state,
                      const std::array<double, 4>& command) {
  u.push_back(command);
  measured.push_back(unseen);
  const std::size_t now = size() - 1;
  if (true_state != nullptr) truth.push_back(seen(of, true_state, command, truth));
  if (!(age < seconds())) return;
  const double rows = std::max(0.0, age) / period, late = std::floor(rows + at_the_period);
  if (late > static_cast<double>(now)) return;
  SeenMotion& row = measured[now - static_cast<std::size_t>(late)];
  row = seen(of, state, command, measured);
  if (rows - late > at_the_period) row.before = (rows - late) * period;
}

AgentId identified_robot(const Team& team, const std::string& name) {
  const std::vector<std::string_view> known = multirotors(team);
  if (name.empty()) {
    if (known.size() == 1) return AgentId{team.find(known.front())};
    if (known.empty())
      throw_invalid("--agent is missing and no robot is a multirotor, expected one of the kind {}",
                    robots_with_vehicles(identified));
    throw_invalid("--agent is missing, expected one of {}", fmt::join(known, ", "));
  }
  const BodyId body = team.find(name);
  if (body.index < 0) throw_invalid("--agent = {}, expected one of {}", name, fmt::join(known, ", "));
  if (!team.is_agent(body) || !identifies(team.model(body)))
    throw_invalid("--agent = {} is of the kind {}, expected a multirotor: {}", name, team.model(body).name(),
                  robots_with_vehicles(identified));
  return AgentId{body};
}

FlownMotion motion_of(const Team& team, AgentId robot, double period) {
  FlownMotion motion;
  motion.robot = team.name(robot);
  motion.model = team.model(robot).name();
  motion.commands = *commands_of(team.model(robot));
  const InputLimits& limits = team.agent(robot).limits;
  for (std::size_t i = 0; i < motion.u_max.size(); ++i) motion.u_max[i] = limits.u_max().front()[i];
  motion.period = period;
  return motion;
}

FlownMotion motion_of(const RecordedFlight& flight, double period, const std::string& robot) {
  const Team& team = flight.team();
  const AgentId agent = identified_robot(team, robot);
  FlownMotion motion = motion_of(team, agent, period);
  const Model& model = team.model(agent);
  const std::size_t x = size(team.state_offset(agent)), u = size(team.input_offset(agent));
  std::int64_t next = flight.periods().empty() ? 0 : flight.number(flight.periods().front().time);
  for (const RecordedPeriod& row : flight.periods()) {
    // Missed periods pass under the previous commands.
    for (; next < flight.number(row.time) && motion.size() > 0; ++next) {
      motion.u.push_back(motion.u.back());
      motion.measured.push_back(unseen);
      motion.truth.push_back(unseen);
    }
    std::array<double, 4> command;
    std::copy_n(row.u.begin() + static_cast<std::ptrdiff_t>(u), 4, command.begin());
    motion.add(model, &row.measured[x], row.time - row.stamps[at(agent)], &row.truth[x], command);
    next = flight.number(row.time) + 1;
  }
  return motion;
}

}  // namespace sightline
