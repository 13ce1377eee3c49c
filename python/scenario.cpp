// Scenarios, and their checks before a flight.
#include "sightline/scenario.hpp"

#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include "python/bindings.hpp"
#include "sightline/analysis.hpp"
#include "sightline/registry.hpp"
#include "sightline/scenario/templates.hpp"

namespace sightline::python {
namespace {

using Values = std::vector<std::string>;

Scenario read(const std::filesystem::path& file, const Values& set) {
  const py::gil_scoped_release others_run;
  return read_scenario(file, with_links(), set);
}

Scenario parse(const std::string& text, const std::filesystem::path& file, const Values& set) {
  const py::gil_scoped_release others_run;
  return parse_scenario(text, file, with_links(), {.set = set});
}

/// The result of `sightline check` for an accepted scenario.
struct Checked {
  std::string summary;
  std::vector<std::string> remarks, warnings;
};

/// @throws std::invalid_argument listing what cannot be flown, one sentence per line
Checked check(const Scenario& scenario) {
  const py::gil_scoped_release others_run;
  const Controls controls(scenario);
  Preflight known = preflight(scenario);
  if (!known.refusals.empty()) {
    std::string all;
    for (const std::string& refusal : known.refusals) all += (all.empty() ? "" : "\n") + refusal;
    throw std::invalid_argument(all);
  }
  return {summary(scenario), std::move(known.remarks), std::move(known.warnings)};
}

std::string explained(const Scenario& scenario) {
  const py::gil_scoped_release others_run;
  return explain_text(scenario);
}

/// The text of the scenario with templates and layers expanded.
std::string expanded(const Scenario& scenario) {
  TomlDocument document = parse_toml(scenario.text, scenario.file.native());
  expand(document);
  return printed(document);
}

}  // namespace

void bind_scenario(py::module_& module) {
  py::class_<Checked>(module, "Checked", "What is known of a scenario before it flies.")
      .def_readonly("summary", &Checked::summary, "A few words per robot, coupling and setting.")
      .def_readonly("remarks", &Checked::remarks, "Corners that are rounded off, a sentence each.")
      .def_readonly("warnings", &Checked::warnings, "A sentence each.")
      .def("__str__", [](const Checked& c) {
        std::string text = c.summary;
        for (const std::string& remark : c.remarks) text += "smooth      " + remark + "\n";
        for (const std::string& warning : c.warnings) text += "warning     " + warning + "\n";
        return text;
      });

  py::class_<Horizon>(module, "Horizon", "T: length [s]; N: stages; dt: control period [s].")
      .def_readonly("T", &Horizon::T)
      .def_readonly("N", &Horizon::N)
      .def_readonly("dt", &Horizon::dt);

  py::class_<Scenario>(module, "Scenario", "Everything a run needs, from one TOML file.")
      .def_static("read", &read, py::arg("file"), py::arg("set") = Values{},
                  "Reads a file; `set` are \"KEY=VALUE\" over its values.\n\nRaises ScenarioError, "
                  "\"file:line: key = value, "
                  "expected ...\".")
      .def_static("parse", &parse, py::arg("text"), py::arg("file") = "scenario.toml",
                  py::arg("set") = Values{},
                  "The same from a text; `file` stands in refusals, and gives the scenario its name.")
      .def_readonly("name", &Scenario::name)
      .def_readonly("text", &Scenario::text, "As it was read; with values set, the equivalent text.")
      .def_readonly("file", &Scenario::file)
      .def_readonly("team", &Scenario::team, py::return_value_policy::copy)
      .def_readonly("horizon", &Scenario::horizon)
      .def_readonly("world", &Scenario::world)
      .def_property_readonly("solver", [](const Scenario& s) { return s.solver.name; })
      .def_property_readonly(
          "x0", [](const Scenario& s) { return array(s.x0); }, "States of all bodies at the start (nx).")
      .def_property_readonly(
          "duration", [](const Scenario& s) { return s.simulation.duration; }, "[s]")
      .def_property_readonly("seed", [](const Scenario& s) { return s.simulation.seed; })
      .def_property_readonly("expanded", &expanded, "Its text with templates and layers written out.")
      .def("__str__", [](const Scenario& s) { return summary(s); })
      .def("__repr__", [](const Scenario& s) { return fmt::format("<scenario {}>", s.name); });

  module.def("check", &check, py::arg("scenario"),
             "The report of `sightline check`. Raises ValueError where it cannot be flown.");
  module.def("explain", &explained, py::arg("scenario"),
             "Which of its limits can hold together and what each is worth, as `sightline explain`.");
}

}  // namespace sightline::python
