// Flights: run, and replay of a log.
#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "python/waited.hpp"
#include "sightline/log.hpp"
#include "sightline/registry.hpp"
#include "sightline/report.hpp"
#include "sightline/scenario/file_kind.hpp"

namespace sightline::python {
namespace {

namespace fs = std::filesystem;

/// The scenario with the given seed and solver, prepared for a flight that can be replayed.
Scenario prepared(Scenario scenario, const std::optional<std::uint64_t>& seed,
                  const std::optional<std::string>& solver) {
  if (seed) scenario.simulation.seed = *seed;
  // The scenario's options apply only to its own solver.
  if (solver && *solver != scenario.solver.name)
    scenario.solver = solver_named(*solver, registry_of(scenario));
  scenario.simulation.compare.clear();
  lift_deadline(scenario.solver);
  check_solvers(scenario);
  return scenario;
}

struct Flown {
  fs::path folder;
  std::string summary;
  std::vector<std::string> faults;
};

Flown run(const Scenario& given, const fs::path& out, const std::optional<std::uint64_t>& seed,
          const std::optional<std::string>& solver, const py::object& progress) {
  const Scenario scenario = prepared(given, seed, solver);
  const RunFolder folder(out.empty() ? fs::path("out") / scenario.name : out, scenario);
  std::atomic<bool> stop = false;
  std::atomic<double> flown = 0.0;
  auto flight = run_for_value([&] {
    const Controls controls(scenario);
    SimulatedClock clock;
    return fly_logged(
        scenario, folder.path(), clock, controls.controllers(),
        {.team_switcher = controls.team_switcher(), .stop = &stop, .written = [&](double t) { flown = t; }});
  });
  const LoggedFlight logged = waited_for(flight, stop, flown, progress);
  if (!logged.logged)
    throw std::runtime_error(logged.faults.empty() ? "the log is not whole" : logged.faults.back());
  return {folder.path(), logged.summary, logged.faults};
}

std::string replay(const fs::path& folder, const std::optional<std::string>& solver,
                   const std::vector<std::string>& set) {
  const fs::path log = log_of(folder);
  std::atomic<bool> stop = false;
  const std::atomic<double> flown = 0.0;
  auto flight = run_for_value([&] {
    const FlownAs as = flown_as(log);
    if (!as.partition.empty() && !solver)
      throw_invalid(
          "{}: flown in parts, {}; expected a solver for the whole team, or the command sightline replay",
          folder.native(), as.partition);
    const Scenario scenario = flown_scenario(as, log, with_links(), solver, set);
    RecordedFlight recorded(log, scenario.team, scenario.x0, scenario.horizon.dt, scenario.goals);
    const Controls controls(scenario);
    const Controllers controllers = controls.controllers();
    CommandComparison compared(recorded, sized_sample(recorded, controllers, controls.team_switcher()));
    ClosedLoop loop(scenario, recorded, controllers, recorded, compared, nullptr, controls.team_switcher(),
                    &stop);
    (void)loop.fly();
    return comparison_json(compared, scenario, recorded);
  });
  return waited_for(flight, stop, flown, py::none());
}

void report(const fs::path& folder) {
  const py::gil_scoped_release others_run;
  const FolderLock lock(folder, {"run.mcap", "timing.csv", "summary.json", "report.html"});
  write_report(folder);
}

}  // namespace

void bind_flight(py::module_& module) {
  py::class_<Flown>(module, "Flown")
      .def_readonly("folder", &Flown::folder)
      .def_readonly("summary", &Flown::summary)
      .def_readonly("faults", &Flown::faults);
  module.def("run", &run, py::arg("scenario"), py::arg("out"), py::arg("seed"), py::arg("solver"),
             py::arg("progress"));
  module.def("replay", &replay, py::arg("folder"), py::arg("solver"), py::arg("set"));
  module.def("write_report", &report, py::arg("folder"));
}

}  // namespace sightline::python
