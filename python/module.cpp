// The Python module: `import sightline` is python/sightline/__init__.py, which imports its names
// from here.
#include <exception>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "python/bindings.hpp"
#include "sightline/base/sentence.hpp"
#include "sightline/config.hpp"
#include "sightline/scenario.hpp"

PYBIND11_MODULE(_sightline, module) {
  namespace python = sightline::python;
  module.doc() = "Real-time nonlinear model predictive control of coupled robots.";
  module.attr("__version__") = std::string(sightline::version);
  module.attr("compiler") = std::string(sightline::compiler);
  pybind11::register_exception<sightline::ScenarioError>(module, "ScenarioError", PyExc_ValueError);
  // Exceptions of third-party libraries, translated into messages of sightline.
  pybind11::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const std::filesystem::filesystem_error& error) {
      PyErr_SetString(PyExc_RuntimeError, sightline::sentence_of(error).c_str());
    } catch (const nlohmann::json::exception& error) {
      PyErr_SetString(PyExc_RuntimeError, sightline::sentence_of(error).c_str());
    }
  });
  python::bind_formula(module);
  python::bind_parts(module);
  python::bind_team(module);
  python::bind_scenario(module);
  python::bind_solver(module);
  python::bind_flight(module);
  python::bind_world(module);
  python::bind_campaign(module);
  python::bind_recording(module);
  python::bind_localize(module);
}
