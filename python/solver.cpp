// Solvers by name, and the simulated plant.
#include "sightline/solver.hpp"

#include <fmt/format.h>
#include <pybind11/stl.h>

#include <atomic>
#include <memory>
#include <mutex>

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
};

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
  KeptGradient kept{array(its.states()), array(its.previous()), {}};
  for (std::size_t i = 0; i < its.parameters().size(); ++i)
    kept.parameters[its.parameters()[i].name.c_str()] = its.by_parameters()[i];
  return kept;
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
  py::class_<KeptGradient>(module, "Gradient", "Derivatives of g' u, u the inputs of an update.")
      .def_readonly("states", &KeptGradient::states, "By the measured states of all bodies (nx).")
      .def_readonly("previous", &KeptGradient::previous, "By the inputs in force before the update (nu).")
      .def_readonly("parameters", &KeptGradient::parameters,
                    "By each weight, reference and parameter of a potential: name to number, as uav0.Q[3], "
                    "uav0.x_ref[2] (a shift of the reference), couple[0].weight, couple[0].d_min.");
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
           "next after "
           "solve or step; for newton_riccati.")
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
}

}  // namespace sightline::python
