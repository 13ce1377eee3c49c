// Team, its bodies, and the potentials and limits that act on them.
#include "sightline/team.hpp"

#include <fmt/format.h>
#include <pybind11/stl.h>

#include "python/bindings.hpp"
#include "sightline/events.hpp"

namespace sightline::python {
namespace {

/// A reference, or a constant state.
Reference reference_of(const py::object& given) {
  if (given.is_none()) return {};
  if (py::isinstance<Reference>(given)) return given.cast<Reference>();
  if (PyCallable_Check(given.ptr()) != 0)
    throw py::type_error(
        "x_ref = a function, expected a reference or a state; sightline.reference(f) makes one of f(t)");
  return list(given);
}

/// A weight times a potential; a potential alone has weight 1.
Weighted weighted_of(const py::object& given) {
  if (py::isinstance<Weighted>(given)) return given.cast<Weighted>();
  if (py::isinstance<Potential>(given)) return {1.0, given.cast<Potential>()};
  throw py::type_error(fmt::format("term = {}, expected a potential, or a weight times one",
                                   std::string(py::str(py::repr(given)))));
}

Between between_of(const py::sequence& given) {
  if (given.size() != 2)
    throw_invalid("between has {} bodies, expected the observer and the target", given.size());
  return {given[0].cast<BodyId>(), given[1].cast<BodyId>()};
}

std::vector<AgentId> agents_of(const py::object& given) {
  if (py::isinstance<AgentId>(given)) return {given.cast<AgentId>()};
  return given.cast<std::vector<AgentId>>();
}

/// The input limits of an agent; those of its model where none are given.
InputLimits limits_of(const Model& model, const py::object& u_min, const py::object& u_max) {
  return {list(u_min, {model.u_min().begin(), model.u_min().end()}),
          list(u_max, {model.u_max().begin(), model.u_max().end()})};
}

AgentId add_agent(Team& team, const Model& model, const py::object& Q, const py::object& R,
                  const py::object& Q_f, const py::object& x_ref, const py::object& u_ref,
                  const py::object& u_min, const py::object& u_max, const std::string& name,
                  const py::object& rate_max, const py::object& R_rate) {
  const auto nx = static_cast<std::size_t>(model.nx()), nu = static_cast<std::size_t>(model.nu());
  return team.add(Agent{.name = name,
                        .model = model,
                        .Q = list(Q, std::vector<double>(nx, 0.0)),
                        .R = list(R, std::vector<double>(nu, 1.0)),
                        .Q_f = list(Q_f, std::vector<double>(nx, 0.0)),
                        .x_ref = reference_of(x_ref),
                        .u_ref = list(u_ref, std::vector<double>(nu, 0.0)),
                        .limits = limits_of(model, u_min, u_max),
                        .rate_max = list(rate_max),
                        .R_rate = list(R_rate)});
}

void couple(Team& team, const py::object& term, const py::sequence& between, const py::object& felt_by,
            const std::optional<BodyId>& third) {
  Coupling coupling{.term = weighted_of(term), .between = between_of(between), .felt_by = {}};
  coupling.felt_by = felt_by.is_none() ? feeling(team, coupling.between, FeltBy::both) : agents_of(felt_by);
  coupling.third = third.value_or(BodyId{});
  team.couple(std::move(coupling));
}

/// Adds a potential that acts on one robot alone, or a limit of its state and input.
void constrain(Team& team, const py::object& term, AgentId agent) {
  if (py::isinstance<RelaxedBarrier>(term)) return team.constrain(term.cast<RelaxedBarrier>(), agent);
  team.constrain(weighted_of(term), agent);
}

void bind_bodies(py::module_& module) {
  py::class_<BodyId>(module, "Body", "Anything that has a position: a robot, a target, an obstacle.")
      .def_readonly("index", &BodyId::index)
      .def(
          "__eq__", [](const BodyId& a, const BodyId& b) { return a == b; }, py::is_operator())
      .def("__hash__", [](const BodyId& body) { return body.index; })
      .def("__repr__", [](const BodyId& body) { return fmt::format("<body {}>", body.index); });
  py::class_<AgentId, BodyId>(module, "Agent", "A robot that is controlled.")
      .def("__repr__", [](const AgentId& agent) { return fmt::format("<agent {}>", agent.index); });
  py::class_<RelaxedBarrier>(module, "RelaxedBarrier",
                             "The cost of a limit c(x, u) <= 0 (docs/equations.md, 12).")
      .def(
          py::init([](const Limit& limit, double mu, double delta) {
            RelaxedBarrier barrier{limit, mu, delta};
            barrier.check();
            return barrier;
          }),
          py::arg("limit"), py::arg("mu") = 0.05, py::arg("delta") = 0.02,
          "mu: weight, the smaller, the nearer one comes to the limit; delta: where the parabola takes over");
}

}  // namespace

void bind_team(py::module_& module) {
  bind_bodies(module);
  const py::object none = py::none();
  py::class_<Team>(module, "Team",
                   "Robots, targets and obstacles, and what couples them; checked as it is composed.")
      .def(py::init<>())
      .def("add", &add_agent, py::arg("model"), py::kw_only(), py::arg("Q") = none, py::arg("R") = none,
           py::arg("Q_f") = none, py::arg("x_ref") = none, py::arg("u_ref") = none, py::arg("u_min") = none,
           py::arg("u_max") = none, py::arg("name") = "", py::arg("rate_max") = none,
           py::arg("R_rate") = none,
           "Adds a robot with the cost (x* - x)' Q (x* - x) + (u* - u)' R (u* - u), at the end Q_f.\n\n"
           "Q, Q_f: nx, >= 0, 0 if not given; R: nu, > 0, 1 if not given; x_ref: a Reference or a state; "
           "u_ref: nu;\n"
           "u_min, u_max: nu, the model's if not given; name: uav0, uav1, ... if not given;\n"
           "rate_max: nu, > 0 [1/s]; R_rate: nu, >= 0 [s^2]")
      .def(
          "add_obstacle",
          [](Team& team, const std::string& name, bool has_heading) {
            return team.add(Obstacle{.name = name, .has_heading = has_heading});
          },
          py::arg("name"), py::kw_only(), py::arg("has_heading") = false,
          "Adds a body that is not controlled, predicted with constant velocity: a target or an obstacle.")
      .def("couple", &couple, py::arg("term"), py::arg("between"), py::arg("felt_by") = none,
           py::arg("third") = none,
           "Couples two bodies by a weighted potential, the observer first; felt by both robots, or by those "
           "listed. A potential that looks past a third body, as a Region with third.p_x, needs that one.")
      .def("constrain", &constrain, py::arg("term"), py::arg("agent"),
           "A potential that one robot feels by itself, or a RelaxedBarrier of a limit.")
      .def(
          "keep_apart",
          [](Team& team, const py::object& term, const std::vector<AgentId>& agents, double radius,
             int capacity) { team.keep_apart(weighted_of(term), agents, radius, capacity); },
          py::arg("term"), py::arg("agents"), py::arg("radius") = 2.5, py::arg("capacity") = 256,
          "A potential between all pairs of these robots that are nearer than the radius [m]; of more than\n"
          "`capacity` pairs the nearest count.")
      .def("find",
           [](const Team& team, const std::string& name) {
             const BodyId body = team.find(name);
             if (body.index < 0)
               throw py::key_error(fmt::format("\"{}\", expected the name of a body", name));
             return body;
           })
      .def(
          "name", [](const Team& team, BodyId body) { return std::string(team.name(body)); }, py::arg("body"))
      .def("model", &Team::model, py::arg("body"))
      .def("is_agent", &Team::is_agent, py::arg("body"))
      .def(
          "state",
          [](const Team& team, BodyId body) {
            const int from = team.state_offset(body);
            return py::slice(from, from + team.model(body).nx(), 1);
          },
          py::arg("body"), "Where a body's state stands in the stacked x.")
      .def(
          "input",
          [](const Team& team, BodyId body) {
            const int from = team.input_offset(body);
            return py::slice(from, from + team.model(body).nu(), 1);
          },
          py::arg("body"), "Where a robot's input stands in the stacked u.")
      .def_property_readonly("names",
                             [](const Team& team) {
                               std::vector<std::string> all;
                               for (int i = 0; i < team.bodies(); ++i) all.emplace_back(team.name(BodyId{i}));
                               return all;
                             })
      .def_property_readonly("nx", &Team::nx, "Numbers in the stacked state.")
      .def_property_readonly("nu", &Team::nu, "Numbers in the stacked input.")
      .def("__len__", &Team::bodies);
}

}  // namespace sightline::python
