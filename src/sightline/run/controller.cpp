#include "sightline/run/controller.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "sightline/base.hpp"

namespace sightline {
namespace {

Controller::Member match(const Team& world, const Team& team, BodyId body, std::size_t controller) {
  const std::string_view name = team.name(body);
  const BodyId found = world.find(name);
  if (found.index < 0)
    throw_invalid("controller {}: \"{}\" is not in the plant, expected one of its bodies", controller, name);
  const Model &model = team.model(body), &real = world.model(found);
  Controller::Member member{.body = found,
                            .nx = size(model.nx()),
                            .nu = size(model.nu()),
                            .ocp_nx = size(model.nx()),
                            .world_x = size(world.state_offset(found)),
                            .world_u = size(world.input_offset(found)),
                            .ocp_x = size(team.state_offset(body)),
                            .ocp_u = size(team.input_offset(body)),
                            .limits = nullptr};
  if (team.is_agent(body)) {
    if (!world.is_agent(found)) {
      throw_invalid("controller {}: \"{}\" is an obstacle of the plant, expected a robot", controller, name);
    }
    if (model.name() != real.name() || model.nx() != real.nx() || model.nu() != real.nu()) {
      throw_invalid("controller {}: \"{}\" is of model {} ({} states), expected the plant's {} ({})",
                    controller, name, model.name(), model.nx(), real.name(), real.nx());
    }
    member.limits = &team.agent(body).limits;
  } else if (world.is_agent(found)) {
    member.nx = 0;
  }
  return member;
}

}  // namespace

Controller::Controller(const Team& world, Solver& given, std::size_t number) : solver(&given) {
  const Team& team = given.ocp().team();
  states.resize(size(team.nx()));
  for (std::vector<double>* u : {&plan, &before, &added}) u->resize(size(team.nu()));
  lean.resize(size(team.bodies()));
  uncertainties.resize(lean.size());
  u_ref = resting_inputs(team);
  for (int i = 0; i < team.bodies(); ++i) members.push_back(match(world, team, BodyId{i}, number));
}

void Controller::gather(const Team& world, const ValidStates& x, std::span<const double> u) noexcept {
  const double* const states_of_world = std::span<const double>(x).data();
  for (const Member& m : members) {
    double* const to = &states[m.ocp_x];
    const double* const from = states_of_world + m.world_x;
    if (!x.is_valid(m.body))
      std::fill_n(to, m.ocp_nx, std::numeric_limits<double>::quiet_NaN());
    else if (m.nx > 0)
      std::copy_n(from, m.nx, to);
    else
      write_body(world.model(m.body).sight(from, &u[m.world_u]), {to, m.ocp_nx});
  }
}

void Controller::set_applied(const AppliedInputs& of_world) noexcept {
  for (std::size_t i = 0; i < members.size(); ++i) {
    const Member& m = members[i];
    if (m.limits == nullptr) continue;
    std::copy_n(of_world.previous.begin() + static_cast<std::ptrdiff_t>(m.world_u), m.nu, &before[m.ocp_u]);
    std::copy_n(of_world.offset.begin() + static_cast<std::ptrdiff_t>(m.world_u), m.nu, &added[m.ocp_u]);
    if (!of_world.lean.empty()) lean[i] = of_world.lean[at(m.body)];
  }
  solver->set_applied({before, added, lean, u_ref});
}

void Controller::set_view_uncertainty(std::span<const ViewUncertainty> of_world) noexcept {
  for (std::size_t i = 0; i < members.size(); ++i) uncertainties[i] = of_world[at(members[i].body)];
  solver->set_view_uncertainty(uncertainties);
}

UncontrolledRobot::UncontrolledRobot(const Team& world, BodyId robot, bool lands, double period)
    : body(robot),
      x(size(world.state_offset(robot))),
      u(size(world.input_offset(robot))),
      nx(size(world.model(robot).nx())),
      nu(size(world.model(robot).nu())),
      model(world.model(robot)),
      limits(world.agent(robot).limits),
      brake(model, world.agent(robot).u_ref, brake_time),
      wanted(nu),
      sink_speed(lands ? landing_speed : 0.0),
      most_change(change_rate * period) {}

void UncontrolledRobot::steer(double t, const ValidStates& estimate, std::span<const double> added,
                              std::span<double> u_min, std::span<double> u_max,
                              std::span<double> u_world) noexcept {
  const std::span<const double> state = std::span<const double>(estimate).subspan(x, nx);
  const std::span<double> input = u_world.subspan(u, nu);
  limits.at(t, u_min.first(nu), u_max.first(nu));
  for (std::size_t i = 0; i < nu; ++i) u_min[i] -= added[u + i], u_max[i] -= added[u + i];
  constexpr double touch_down = 0.5;  // time constant near the ground [s]
  const double height = model.sight(state.data(), input.data()).p.z - ground;
  const double sinking = std::clamp(height / touch_down, 0.0, sink_speed);
  brake(state, {0.0, 0.0, -sinking}, u_min.first(nu), u_max.first(nu), wanted);
  for (std::size_t i = 0; i < nu; ++i) {
    const double most = most_change * 0.5 * (u_max[i] - u_min[i]);
    input[i] = std::clamp(input[i] + std::clamp(wanted[i] - input[i], -most, most), u_min[i], u_max[i]);
  }
}

}  // namespace sightline
