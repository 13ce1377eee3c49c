// Solvers by name, and the simulated plant.
#include "sightline/solver.hpp"

#include <fmt/format.h>
#include <pybind11/stl.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <utility>

#include "python/bindings.hpp"
#include "sightline/scenario.hpp"
#include "sightline/scenario/read_part.hpp"
#include "sightline/solvers.hpp"
#include "sightline/worlds.hpp"

namespace sightline::python {
namespace {

/// Grants access to one thread at a time. Other threads get an error, since their data would change
/// during use.
class OneAtATime {
 public:
  /// @throws std::runtime_error if another thread has access
  OneAtATime(std::atomic_flag& taken, std::string_view what) : taken_(taken) {
    if (taken_.test_and_set(std::memory_order_acquire))
      throw std::runtime_error(
          fmt::format("the {} is at work in another thread, expected one for each thread", what));
  }
  ~OneAtATime() { taken_.clear(std::memory_order_release); }
  OneAtATime(const OneAtATime&) = delete;
  OneAtATime& operator=(const OneAtATime&) = delete;

 private:
  std::atomic_flag& taken_;
};

bool is_truth(const py::handle& value) {
  const std::string_view type = Py_TYPE(value.ptr())->tp_name;
  return py::isinstance<py::bool_>(value) || type == "numpy.bool_" || type == "numpy.bool";
}

/// The int of an object with __index__; none for other objects, such as an array of one real
/// number.
py::object whole_number(const py::handle& value) {
  if (PyIndex_Check(value.ptr()) == 0) return {};
  auto whole = py::reinterpret_steal<py::object>(PyNumber_Index(value.ptr()));
  if (!whole) PyErr_Clear();
  return whole;
}

/// Adds an option to a solver's table with its type: __index__ gives an integer, __float__ a
/// number, for Python and numpy objects.
void put_option(toml::table& table, const std::string& key, const py::handle& value) {
  if (table.contains(key)) throw_invalid("{} is given twice", key);
  if (py::isinstance<py::str>(value)) {
    table.insert(key, utf8(value, key));
  } else if (is_truth(value)) {
    table.insert(key, PyObject_IsTrue(value.ptr()) == 1);
  } else if (const auto whole = whole_number(value)) {
    int beyond = 0;
    const long long number = PyLong_AsLongLongAndOverflow(whole.ptr(), &beyond);
    if (beyond != 0)
      throw_invalid("{} = {}, expected a number of 64 bits", key, std::string(py::str(py::repr(value))));
    table.insert(key, static_cast<std::int64_t>(number));
  } else if (py::hasattr(value, "__float__")) {
    const double number = PyFloat_AsDouble(value.ptr());
    if (PyErr_Occurred() != nullptr) {
      PyErr_Clear();
      throw_invalid("{} = {}, expected a number", key, std::string(py::str(py::repr(value))));
    }
    table.insert(key, number);
  } else {
    throw py::type_error(
        fmt::format("{} = {}, expected a number or a word", key, std::string(py::str(py::repr(value)))));
  }
}

/// The options of a solver in the form of a scenario's [solver], and parsed as such.
SolverChoice choice_of(std::string_view name, const Horizon& horizon, const py::kwargs& options) {
  TomlDocument document{.file = fmt::format("options of {}", name), .root = {}};
  document.root.insert("name", std::string(name));
  for (const auto& [key, value] : options) put_option(document.root, utf8(key, name), value);
  return read_solver(TomlTable(document), horizon);
}

/// A solver with its access flag.
struct GuardedSolver {
  std::unique_ptr<Solver> solver;
  std::unique_ptr<InputGradient> input_gradient{};  // of the solver, made at its first use
  std::atomic_flag taken{};

  GuardedSolver(const Team& team, const std::string& name, const Horizon& horizon,
                const py::kwargs& options) {
    const SolverChoice choice = choice_of(solver_named(name).name, horizon, options);
    const py::gil_scoped_release others_run;
    solver = make_solver(choice, team, horizon);
  }
  /// The solver of a scenario, with its options.
  explicit GuardedSolver(const Scenario& scenario) {
    const py::gil_scoped_release others_run;
    SolverChoice choice = scenario.solver;
    lift_deadline(choice);
    solver = make_solver(choice, scenario.team, scenario.horizon);
  }
  int nx() const { return solver->ocp().team().nx(); }
  int nu() const { return solver->ocp().team().nu(); }
};

/// A solution with its own memory.
struct KeptSolution {
  py::array_t<double> u, raw_u, x;
  Status status{};
  double residual = 0.0, elapsed = 0.0;
  int iterations = 0;
};

KeptSolution solve(GuardedSolver& of, double time, const Numbers& states) {
  const OneAtATime here(of.taken, "solver");
  const auto x = view(states, "states", of.nx());
  Solution s;
  {
    const py::gil_scoped_release others_run;
    s = of.solver->solve(time, x);
  }
  return {array(s.u),  array(s.raw_u), array(s.x, static_cast<py::ssize_t>(s.x.size()) / of.nx(), of.nx()),
          s.status,    s.residual,     s.elapsed,
          s.iterations};
}

py::array_t<double> step(GuardedSolver& of, double time, const Numbers& states) {
  const OneAtATime here(of.taken, "solver");
  const auto x = view(states, "states", of.nx());
  std::span<const double> u;
  {
    const py::gil_scoped_release others_run;
    u = of.solver->step(time, x);
  }
  return array(u);
}

double kkt(GuardedSolver& of, double time, const Numbers& states) {
  const OneAtATime here(of.taken, "solver");
  const auto x = view(states, "states", of.nx());
  const py::gil_scoped_release others_run;
  return of.solver->kkt(time, x);
}

py::array_t<double> planned(GuardedSolver& of, double time) {
  const OneAtATime here(of.taken, "solver");
  std::vector<double> u(static_cast<std::size_t>(of.nu()));
  of.solver->planned(time, u);
  return array(u);
}

/// Derivatives of g' u with their own memory.
struct KeptGradient {
  py::array_t<double> states, previous;
  py::dict parameters;
  int without_derivative = 0;  // updates of a flight
};

py::dict named(const std::vector<InputGradient::Parameter>& parameters, std::span<const double> values) {
  py::dict dict;
  for (std::size_t i = 0; i < values.size(); ++i) dict[parameters[i].name.c_str()] = values[i];
  return dict;
}

KeptGradient gradient(GuardedSolver& of, const Numbers& g) {
  const OneAtATime here(of.taken, "solver");
  const auto numbers = view(g, "g", of.nu());
  auto* const newton = dynamic_cast<NewtonRiccati*>(of.solver.get());
  if (newton == nullptr) {
    throw std::invalid_argument(
        fmt::format("gradient: solver = {}, expected newton_riccati", of.solver->name()));
  }
  if (of.input_gradient == nullptr) of.input_gradient = std::make_unique<InputGradient>(*newton);
  InputGradient& its = *of.input_gradient;
  if (!its.differentiate(numbers)) {
    throw std::invalid_argument(
        "gradient: the last call was no update with a full, undamped step, expected solve() until its status "
        "is "
        "converged or stepped, with headings within 120 degrees of their references");
  }
  return {array(its.states()), array(its.previous()), named(its.parameters(), its.by_parameters())};
}

/// A closed loop with its access flag.
struct GuardedLoop {
  LoopGradient loop;
  int nx, nu, periods = 0;  // of the last flight; 0: none
  std::atomic_flag taken{};

  GuardedLoop(const Team& team, const Horizon& horizon, int delay)
      : loop(Ocp(team, horizon), delay), nx(team.nx()), nu(team.nu()) {}
};

/// States (K+1 x nx) and inputs (K x nu) of a flight.
std::pair<py::array_t<double>, py::array_t<double>> fly(GuardedLoop& of, const Numbers& x0, int periods) {
  const OneAtATime here(of.taken, "loop");
  const auto start = view(x0, "x0", of.nx);
  of.periods = 0;
  bool finite = false;
  {
    const py::gil_scoped_release others_run;
    finite = of.loop.fly(start, periods);
  }
  if (!finite)
    throw std::invalid_argument(
        "fly: a state of the flight is not finite, expected another x0 or other weights");
  of.periods = periods;
  std::vector<double> x, u;
  for (int k = 0; k <= periods; ++k) x.insert(x.end(), of.loop.x(k).begin(), of.loop.x(k).end());
  for (int k = 0; k < periods; ++k) u.insert(u.end(), of.loop.u(k).begin(), of.loop.u(k).end());
  return {array(x, periods + 1, of.nx), array(u, periods, of.nu)};
}

KeptGradient differentiate(GuardedLoop& of, const Numbers& by_x, const std::optional<Numbers>& by_u) {
  const OneAtATime here(of.taken, "loop");
  if (of.periods == 0) throw std::invalid_argument("differentiate: no flight, expected fly() before");
  const auto states = view(by_x, "by_x", of.periods + 1, of.nx);
  const auto inputs = by_u ? view(*by_u, "by_u", of.periods, of.nu) : std::span<const double>();
  int without = 0;
  {
    const py::gil_scoped_release others_run;
    without = of.loop.differentiate(states, inputs);
  }
  return {array(of.loop.by_start()), {}, named(of.loop.parameters(), of.loop.by_parameters()), without};
}

/// The simulated world with its access flag.
struct GuardedPlant {
  Plant plant;
  std::atomic_flag taken{};

  GuardedPlant(const Team& team, const Numbers& x0, std::uint64_t seed)
      : plant(team, {view(x0).begin(), view(x0).end()}, {.seed = seed}) {}
};

bool advance(GuardedPlant& of, const Numbers& u, double dt) {
  const OneAtATime here(of.taken, "plant");
  const auto inputs = view(u, "u", of.plant.team().nu());
  const py::gil_scoped_release others_run;
  return of.plant.step(inputs, dt);
}

void bind_solution(py::module_& module) {
  py::enum_<Status> statuses(module, "Status", "How an update ended, the better first.");
  for (int i = 0; i < status_count; ++i) {
    const auto status = static_cast<Status>(i);
    statuses.value(std::string(to_string(status)).c_str(), status);
  }
  py::class_<KeptSolution>(module, "Solution", "The outcome of one update.")
      .def_readonly("u", &KeptSolution::u, "Inputs to apply now, of all robots (nu).")
      .def_readonly("raw_u", &KeptSolution::raw_u, "The same before they were clamped to their limits (nu).")
      .def_readonly("x", &KeptSolution::x,
                    "Predicted states of all bodies (N+1 x nx): the trajectory that was linearised.")
      .def_readonly("status", &KeptSolution::status)
      .def_readonly("residual", &KeptSolution::residual,
                    "Infinity norm of the optimality conditions [1/s]; inf: not known.")
      .def_readonly("iterations", &KeptSolution::iterations, "Of the Krylov method.")
      .def_readonly("elapsed", &KeptSolution::elapsed, "Wall time of the update [s].");
}

void bind_gradient(py::module_& module) {
  py::class_<KeptGradient>(module, "Gradient",
                           "Derivatives of g' u, u the inputs of an update, or of a cost of a flight.")
      .def_readonly("states", &KeptGradient::states,
                    "By the measured states of all bodies, or their start (nx).")
      .def_readonly("previous", &KeptGradient::previous,
                    "By the inputs in force before the update (nu); of a flight empty.")
      .def_readonly("parameters", &KeptGradient::parameters,
                    "By each weight, reference and parameter of a potential: name to number, as uav0.Q[3], "
                    "uav0.x_ref[2] (a shift of the reference), couple[0].weight, couple[0].d_min.")
      .def_readonly("without_derivative", &KeptGradient::without_derivative,
                    "Updates of a flight that have no derivative: their inputs count as constant.");
}

}  // namespace

void bind_solver(py::module_& module) {
  bind_solution(module);
  bind_gradient(module);
  const auto made = [](const Team& team, const std::string& name, double T, int N, double dt,
                       const py::kwargs& options) {
    return std::make_unique<GuardedSolver>(team, name, Horizon{.T = T, .N = N, .dt = dt}, options);
  };
  py::class_<GuardedSolver>(
      module, "Solver",
      "A solver of a team over a horizon. For one thread; solve, step and kkt let other threads run.")
      .def(py::init(made), py::arg("team"), py::arg("name") = "newton_riccati", py::kw_only(),
           py::arg("T") = 1.0, py::arg("N") = 20, py::arg("dt") = 0.01,
           "T: horizon [s]; N: stages; dt: control period [s]; options as [solver] of a scenario has them")
      .def_static(
          "of", [](const Scenario& scenario) { return std::make_unique<GuardedSolver>(scenario); },
          py::arg("scenario"), "The solver of a scenario's team, with its options.")
      .def_property_readonly("name", [](const GuardedSolver& s) { return std::string(s.solver->name()); })
      .def("solve", &solve, py::arg("time"), py::arg("states"),
           "One update: from the measured states of all bodies (nx) at `time` [s] to a Solution.")
      .def("step", &step, py::arg("time"), py::arg("states"), "solve() for who wants the inputs alone (nu).")
      .def("kkt", &kkt, py::arg("time"), py::arg("states"),
           "Projected KKT infinity norm of the present iterate at these states.")
      .def("gradient", &gradient, py::arg("g"),
           "Derivatives of g' u (g: nu) by all that u, the inputs of the last update, depends on. Call it "
           "next "
           "after solve or step; for newton_riccati.")
      .def("planned", &planned, py::arg("time"), "Inputs (nu) that the last good plan has for `time` [s].")
      .def(
          "restart",
          [](GuardedSolver& s) {
            const OneAtATime here(s.taken, "solver");
            s.solver->restart();
          },
          "Forgets the iterate: the next update starts as the first did.")
      .def("__repr__", [](const GuardedSolver& s) { return fmt::format("<solver {}>", s.solver->name()); });
  for (const std::string_view name : solver_names()) {
    module.attr(std::string(name).c_str()) = py::cpp_function(
        [name = std::string(name), made](const Team& team, double T, int N, double dt,
                                         const py::kwargs& options) {
          return made(team, name, T, N, dt, options);
        },
        py::name(std::string(name).c_str()), py::scope(module), py::arg("team"), py::kw_only(),
        py::arg("T") = 1.0, py::arg("N") = 20, py::arg("dt") = 0.01, "The Solver of this name.");
  }

  py::class_<GuardedPlant>(module, "Plant",
                           "The simulated world: the continuous models of all bodies, undisturbed.")
      .def(py::init<const Team&, const Numbers&, std::uint64_t>(), py::arg("team"), py::arg("x0"),
           py::arg("seed") = 1, "x0: states of all bodies in the order of the team (nx)")
      .def("step", &advance, py::arg("u"), py::arg("dt"),
           "Advances by dt [s] under the inputs u (nu). False where a state is no longer finite.")
      .def_property_readonly(
          "x",
          [](GuardedPlant& p) {
            const OneAtATime here(p.taken, "plant");
            return array(p.plant.x());
          },
          "States of all bodies (nx), a copy.")
      .def_property_readonly(
          "time", [](const GuardedPlant& p) { return p.plant.time(); }, "[s]");

  py::class_<GuardedLoop>(
      module, "LoopGradient",
      "A closed loop of a team's models and newton_riccati, and derivatives of its costs.")
      .def(py::init([](const Team& team, double T, int N, double dt, int delay) {
             return std::make_unique<GuardedLoop>(team, Horizon{.T = T, .N = N, .dt = dt}, delay);
           }),
           py::arg("team"), py::kw_only(), py::arg("T") = 1.0, py::arg("N") = 20, py::arg("dt") = 0.01,
           py::arg("delay") = 0, "delay: of the commands, in periods")
      .def("fly", &fly, py::arg("x0"), py::arg("periods"),
           "Flies K periods from x0 (nx): the states (K+1 x nx) and the inputs (K x nu).")
      .def("differentiate", &differentiate, py::arg("by_x"), py::arg("by_u") = py::none(),
           "Gradient of a cost of the last flight, from its derivatives by the states (K+1 x nx) and the "
           "inputs (K x nu).");
}

}  // namespace sightline::python
