#include "sightline/scenario/scenario_parts.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "sightline/potential/bearing.hpp"
#include "sightline/potential/bounds.hpp"
#include "sightline/potential/distance.hpp"
#include "sightline/potential/limits.hpp"
#include "sightline/potential/pass_right.hpp"
#include "sightline/potential/sensor_cone.hpp"
#include "sightline/potential/slope.hpp"
#include "sightline/scenario/region_parts.hpp"

namespace sightline {
namespace {

// --- potentials ---

/// The mount of the observer's sensor, which it must have.
SensorMount mount_of(const TomlTable& at, const Observer& observer) {
  if (!observer.mount) {
    at.refuse(fmt::format("a robot with a sensor as observer, there is no [agent.{}.sensor]", observer.name));
  }
  return *observer.mount;
}

Potential read_sensor_cone(const TomlTable& at, const Observer& observer) {
  SensorCone cone;
  at.read({{"alpha", &cone.alpha}, {"kappa_G", &cone.kappa_G}, {"kappa_A", &cone.kappa_A}}, {"form"});
  constexpr std::array<std::string_view, 2> forms = {"sine", "tangent"};
  if (at.has("form")) cone.form = at.word("form", forms) == "sine" ? ConeForm::sine : ConeForm::tangent;
  cone.mount = mount_of(at, observer);
  return at.checked([&] { return Potential(cone); });
}

Potential read_bearing(const TomlTable& at, const Observer& observer) {
  Bearing bearing;
  at.read({{"alpha", &bearing.alpha}, {"width", &bearing.width}, {"tilt", &bearing.tilt}});
  bearing.mount = mount_of(at, observer);
  return at.checked([&] { return Potential(bearing); });
}

template <class Distance>
Potential read_distance(const TomlTable& at, double Distance::*limit, std::string_view limit_name) {
  Distance d;
  at.read(
      {{limit_name, &(d.*limit)}, {"kappa_H", &d.kappa_H}, {"kappa_G", &d.kappa_G}, {"kappa_A", &d.kappa_A}});
  return at.checked([&] { return Potential(d); });
}
Potential read_keep_out(const TomlTable& at, const Observer&) {
  return read_distance(at, &KeepOut::d_min, "d_min");
}
Potential read_cohesion(const TomlTable& at, const Observer&) {
  return read_distance(at, &Cohesion::d_max, "d_max");
}

Potential read_too_near(const TomlTable& at, const Observer&) {
  TooNear near;
  at.read({{"d_min", &near.d_min}, {"kappa", &near.kappa}});
  return at.checked([&] { return Potential(near); });
}
Potential read_pass_right(const TomlTable& at, const Observer&) {
  PassRight pass;
  at.read({{"d_min", &pass.d_min}, {"delta", &pass.delta}, {"kappa", &pass.kappa}});
  return at.checked([&] { return Potential(pass); });
}
Potential read_too_far(const TomlTable& at, const Observer&) {
  TooFar far;
  at.read({{"d_max", &far.d_max}, {"kappa", &far.kappa}});
  return at.checked([&] { return Potential(far); });
}
Potential read_relative_velocity(const TomlTable& at, const Observer&) {
  RelativeVelocity relative;
  at.read({{"v_0", &relative.v_0}});
  return at.checked([&] { return Potential(relative); });
}

Potential read_altitude_band(const TomlTable& at, const Observer&) {
  AltitudeBand band;
  at.read({{"z_min", &band.z_min},
           {"z_max", &band.z_max},
           {"kappa_G", &band.kappa_G},
           {"kappa_A", &band.kappa_A}});
  return at.checked([&] { return Potential(band); });
}

Potential read_geofence(const TomlTable& at, const Observer&) {
  Geofence fence;
  at.read({{"kappa_G", &fence.kappa_G}, {"kappa_A", &fence.kappa_A}}, {"low", "high"});
  const auto corner = [&](std::string_view key, std::array<double, 3>& to) {
    if (!at.has(key)) return;
    const Vec3<double> p = at.vec3(key);
    to = {p.x, p.y, p.z};
  };
  corner("low", fence.low);
  corner("high", fence.high);
  return at.checked([&] { return Potential(fence); });
}

Potential read_own(const TomlTable& at, const Observer& observer) {
  Region region = read_region(at);
  if (region.is_view()) (void)mount_of(at, observer);
  if (observer.mount) region = region.seen_from(*observer.mount);
  return at.checked([&] { return Potential(region); });
}

using ReadPotential = Potential (*)(const TomlTable& parameters, const Observer& observer);
constexpr std::array potentials = {
    Named<ReadPotential>{SensorCone::name, read_sensor_cone},
    Named<ReadPotential>{KeepOut::name, read_keep_out},
    Named<ReadPotential>{Cohesion::name, read_cohesion},
    Named<ReadPotential>{Bearing::name, read_bearing},
    Named<ReadPotential>{TooNear::name, read_too_near},
    Named<ReadPotential>{PassRight::name, read_pass_right},
    Named<ReadPotential>{TooFar::name, read_too_far},
    Named<ReadPotential>{RelativeVelocity::name, read_relative_velocity},
    Named<ReadPotential>{AltitudeBand::name, read_altitude_band},
    Named<ReadPotential>{Geofence::name, read_geofence},
    Named<ReadPotential>{"region", read_own},
    Named<ReadPotential>{"sensor", read_own},
};

double read_weight(const TomlTable& at) {
  return at.has("weight") ? at.number("weight", not_negative(">= 0")) : 1.0;
}

// --- limits ---

template <class C>
RelaxedBarrier read_barrier(const TomlTable& at, double C::*bound, std::string_view bound_name) {
  C limit;
  double mu = RelaxedBarrier{limit}.mu, delta = RelaxedBarrier{limit}.delta;
  at.read({{bound_name, &(limit.*bound)}, {"mu", &mu}, {"delta", &delta}});
  return at.checked([&] {
    RelaxedBarrier barrier{limit, mu, delta};
    barrier.check();
    return barrier;
  });
}
RelaxedBarrier read_speed(const TomlTable& at) { return read_barrier(at, &SpeedLimit::max, "max"); }
RelaxedBarrier read_input_disc(const TomlTable& at) { return read_barrier(at, &InputDisc::radius, "radius"); }

using ReadLimit = RelaxedBarrier (*)(const TomlTable& parameters);
constexpr std::array limits = {
    Named<ReadLimit>{SpeedLimit::name, read_speed},
    Named<ReadLimit>{InputDisc::name, read_input_disc},
};

// --- references; each reads its own key of `choice` ---

Reference read_circle(const TomlTable& choice, const Model&) {
  const TomlTable at = choice.table("circle");
  Circle circle;
  at.read({{"radius", &circle.radius, not_negative(">= 0 m")}, {"rate", &circle.rate}}, {"centre"});
  circle.centre = at.vec3("centre");
  return circle;
}

template <class Timed>
Reference read_timed(const TomlTable& choice, const Model&) {
  const TomlTable at = choice.table(Timed::name);
  at.expect_only({"times", "p", "heading"});
  Timed timed;
  timed.times = at.rising("times");
  const std::size_t n = timed.times.size();
  for (const std::vector<double>& p : at.rows("p", n, 3)) timed.p.push_back({p[0], p[1], p[2]});
  if (at.has("heading")) timed.heading = at.numbers("heading", n);
  return timed;
}

Reference read_constant(const TomlTable& choice, const Model&) {
  const TomlTable at = choice.table("constant");
  at.expect_only({"p", "heading"});
  Pose<double> pose{at.vec3("p"), {}};
  if (at.has("heading")) {
    const double heading = at.number("heading");
    pose.d = {cos(heading), sin(heading)};
  }
  return [pose](double) { return pose; };
}

Reference read_state(const TomlTable& choice, const Model& model) {
  return choice.numbers("state", static_cast<std::size_t>(model.nx()));
}

using ReadReference = Reference (*)(const TomlTable& choice, const Model& model);
constexpr std::array references = {
    Named<ReadReference>{"constant", read_constant},
    Named<ReadReference>{Circle::name, read_circle},
    Named<ReadReference>{Waypoints::name, read_timed<Waypoints>},
    Named<ReadReference>{Steps::name, read_timed<Steps>},
    Named<ReadReference>{"state", read_state},
};

// --- solvers ---

ContinuationOptions read_continuation(const TomlTable& at, const Horizon& horizon) {
  ContinuationOptions o;
  at.read({{"zeta", &o.zeta, positive("> 0 1/s")},
           {"alpha", &o.alpha, positive("> 0 1/s")},
           {"difference_step", &o.difference_step, {1e-15, 0.1, "1e-15 to 0.1 s"}},
           {"slack_weight", &o.slack_weight, positive("> 0")},
           {"gmres_tolerance", &o.gmres_tolerance, not_negative(">= 0")},
           {"tolerance", &o.tolerance, positive("> 0")}},
          {"name", "k_max", "jacobian"});
  if (!(o.zeta * horizon.dt < 2)) {
    at.refuse("zeta", fmt::format("less than 2 / horizon.period = {} 1/s, beyond which it oscillates",
                                  2 / horizon.dt));
  }
  if (at.has("k_max")) o.k_max = static_cast<int>(at.integer("k_max", 1, 1000));
  constexpr std::array<std::string_view, 2> products = {"exact", "forward_difference"};
  if (at.has("jacobian")) {
    o.jacobian = at.word("jacobian", products) == "exact" ? JacobianProduct::exact
                                                          : JacobianProduct::forward_difference;
  }
  return o;
}

SolverChoice read_cmscgmres(const TomlTable& at, const Horizon& horizon) {
  return {"cmscgmres", read_continuation(at, horizon)};
}
SolverChoice read_cgmres(const TomlTable& at, const Horizon& horizon) {
  return {"cgmres", read_continuation(at, horizon)};
}

SolverChoice read_newton_riccati(const TomlTable& at, const Horizon&) {
  NewtonRiccatiOptions o;
  at.read({{"tolerance", &o.tolerance, positive("> 0")},
           {"krylov_stop", &o.krylov_stop, not_negative(">= 0")},
           {"step_cap", &o.step_cap, positive("> 0")},
           {"deadline", &o.deadline, not_negative(">= 0 s, 0 for none")}},
          {"name", "max_newton_steps", "start_steps", "max_krylov"});
  if (at.has("max_newton_steps"))
    o.max_newton_steps = static_cast<int>(at.integer("max_newton_steps", 1, 1000));
  if (at.has("start_steps")) o.start_steps = static_cast<int>(at.integer("start_steps", 1, 1000));
  if (at.has("max_krylov")) o.max_krylov = static_cast<int>(at.integer("max_krylov", 0, 1000));
  return {"newton_riccati", o};
}

using ReadSolver = SolverChoice (*)(const TomlTable& at, const Horizon& horizon);
constexpr std::array solvers = {
    Named<ReadSolver>{"newton_riccati", read_newton_riccati},
    Named<ReadSolver>{"cmscgmres", read_cmscgmres},
    Named<ReadSolver>{"cgmres", read_cgmres},
};

}  // namespace

std::vector<std::string_view> body_names(const Team& team, Among among) {
  std::vector<std::string_view> known;
  for (int i = 0; i < team.bodies(); ++i) {
    if (among == Among::bodies || team.is_agent(BodyId{i})) known.push_back(team.name(BodyId{i}));
  }
  return known;
}

std::string read_name(const TomlTable& at, std::string_view key, const Team& team, Among among,
                      std::string_view expected) {
  return std::string(at.word(key, body_names(team, among), expected));
}

std::string read_label(const TomlTable& at, std::string_view key) {
  const std::string expected = fmt::format("a name of 1 to {} characters on one line", name_size_max);
  std::string label = at.text(key, expected);
  if (label.empty() || label.size() > name_size_max || one_line(label) != label) at.refuse(key, expected);
  return label;
}

Weighted read_potential(const TomlTable& at, const Observer& observer) {
  const TomlTable choice = at.table("potential");
  const std::string_view name = choice.choice(names(potentials));
  return {read_weight(at), find(potentials, name)(choice.table(name), observer)};
}

Weighted read_weighted(const TomlTable& at, const Observer& observer) {
  const std::string_view name = at.choice(names(potentials), {"weight"});
  return {read_weight(at), find(potentials, name)(at.table(name), observer)};
}

RelaxedBarrier read_limit(const TomlTable& at) {
  const TomlTable choice = at.table("limit");
  const std::string_view name = choice.choice(names(limits));
  return find(limits, name)(choice.table(name));
}

Reference read_reference(const TomlTable& agent, const Model& model) {
  if (!agent.has("reference")) return {};
  const TomlTable choice = agent.table("reference");
  return find(references, choice.choice(names(references)))(choice, model);
}

SolverChoice read_solver(const TomlTable& solver, const Horizon& horizon) {
  const std::string_view name =
      solver.has("name") ? solver.word("name", names(solvers)) : solvers.front().name;
  return find(solvers, name)(solver, horizon);
}

std::vector<std::string_view> solver_names() {
  const auto known = names(solvers);
  return {known.begin(), known.end()};
}

SolverChoice solver_named(std::string_view name) {
  const auto known = names(solvers);
  if (std::find(known.begin(), known.end(), name) == known.end()) {
    throw std::invalid_argument(
        fmt::format("solver = {}, expected one of {}", one_line(name), fmt::join(known, ", ")));
  }
  static const TomlDocument defaults{};
  return find(solvers, name)(TomlTable(defaults), Horizon{});
}

std::unique_ptr<Solver> make_solver(const SolverChoice& choice, const Team& team, const Horizon& horizon) {
  struct Make {
    std::string_view name;
    const Team& team;
    const Horizon& horizon;
    std::unique_ptr<Solver> operator()(const ContinuationOptions& o) const {
      if (name == "cgmres") return std::make_unique<Cgmres>(team, horizon, o);
      return std::make_unique<Cmscgmres>(team, horizon, o);
    }
    std::unique_ptr<Solver> operator()(const NewtonRiccatiOptions& o) const {
      return std::make_unique<NewtonRiccati>(team, horizon, o);
    }
  };
  return std::visit(Make{choice.name, team, horizon}, choice.options);
}

}  // namespace sightline
