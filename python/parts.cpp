// Robots, potentials, references and limits: one function for each registered part
// (sightline/registry.hpp). It is called as scenarios call the part, with the parameters as keyword
// arguments. The registered descriptions are the docstrings here.
#include <fmt/format.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <array>

#include "python/bindings.hpp"
#include "python/keyword_source.hpp"
#include "sightline/formula.hpp"
#include "sightline/registry.hpp"

namespace sightline::python {
namespace {

template <class Part>
std::string documentation(std::string_view kind, const Part& part) {
  std::string text = fmt::format("The {} \"{}\" of scenarios.\n", kind, part.name);
  if (!part.presets.empty()) {
    text += "\npreset: the start for all others, one of";
    for (const std::string& preset : part.presets) text += " " + preset;
    text += "\n";
  }
  for (const ParameterText& p : part.parameters) {
    const std::string otherwise = p.must_be_given      ? "must be given"
                                  : p.fallback.empty() ? "may be left out"
                                                       : fmt::format("{} if not given", p.fallback);
    text += fmt::format("\n{}: {}{}{}, {}; {}", p.key, p.meaning, p.unit.empty() ? "" : " [",
                        p.unit.empty() ? std::string() : std::string(p.unit) + "]", p.range, otherwise);
  }
  return text;
}

template <class Made>
void add_all(py::module_& module, const PartList<Made>& list) {
  py::list names;
  for (const auto& part : list.all()) {
    names.append(part->name);
    module.attr(part->name.c_str()) = py::cpp_function(
        [part](const py::kwargs& given) { return part->read(KeywordSource(part->name, given), {}); },
        py::name(part->name.c_str()), py::scope(module), py::doc(documentation(list.kind(), *part).c_str()));
  }
  module.attr(fmt::format("{}s", list.kind()).c_str()) = py::tuple(names);
}

/// The parameters with their present values: {"d_min": "1.5"}.
py::dict parameters_of(const std::vector<ParameterText>& texts) {
  py::dict all;
  for (const ParameterText& p : texts) all[py::str(p.key.data(), p.key.size())] = p.value;
  return all;
}

Sight<double> sight_of(const Numbers& p, const Numbers& d, const Numbers& v, const Numbers& lean) {
  const auto a = view(p, "p", 3), b = view(d, "d", 2), c = view(v, "v", 3), e = view(lean, "lean", 2);
  return {{{a[0], a[1], a[2]}, {b[0], b[1]}}, {c[0], c[1], c[2]}, {e[0], e[1]}};
}

void bind_sight(py::module_& module) {
  const auto zeros = [](py::ssize_t n) {
    Numbers all(n);
    std::fill_n(all.mutable_data(), n, 0.0);
    return all;
  };
  Numbers ahead(2);
  ahead.mutable_data()[0] = 1.0, ahead.mutable_data()[1] = 0.0;
  py::class_<Sight<double>>(module, "Sight", "What a potential sees of a body: pose, velocity and lean in G.")
      .def(py::init(&sight_of), py::arg("p"), py::arg("d") = ahead, py::arg("v") = zeros(3),
           py::arg("lean") = zeros(2),
           "p: position [m], 3; d: heading (cos psi, sin psi); v: velocity [m/s], 3; lean: forward and to "
           "the left")
      .def_property_readonly("p",
                             [](const Sight<double>& s) {
                               return array(std::array{s.p.x, s.p.y, s.p.z});
                             })
      .def_property_readonly("d",
                             [](const Sight<double>& s) {
                               return array(std::array{s.d.x, s.d.y});
                             })
      .def_property_readonly("v",
                             [](const Sight<double>& s) {
                               return array(std::array{s.v.x, s.v.y, s.v.z});
                             })
      .def_property_readonly("lean", [](const Sight<double>& s) {
        return array(std::array{s.lean.x, s.lean.y});
      });
}

/// The mount frame with this name. @throws std::invalid_argument for another name
MountFrame frame_of(std::string_view word) {
  const auto found = std::find(mount_frames.begin(), mount_frames.end(), word);
  if (found == mount_frames.end())
    throw_invalid("frame = \"{}\", expected one of {}", word, words_text(mount_frames));
  return static_cast<MountFrame>(found - mount_frames.begin());
}

/// A lever arm from three numbers, or from one ahead. @throws std::invalid_argument for another length
LeverArm arm_of(const Numbers& given) {
  if (given.ndim() == 0) return *given.data();
  const auto d = view(given, "offset", 3);
  return {d[0], d[1], d[2]};
}

/// Gradient of the recorded formula that the solver uses, with respect to the numbers of both sights
/// (2 x 10).
py::array_t<double> gradient_of(const Potential& potential, const Sight<double>& a, const Sight<double>& b,
                                double t);

void bind_potential(py::module_& module) {
  py::class_<SensorMount>(module, "SensorMount", "Where the sensor sits on the robot, (45).")
      .def(py::init([](double pitch, const Numbers& offset, const std::string& frame, double sigmas,
                       double yaw, double roll) {
             return SensorMount{pitch, arm_of(offset), frame_of(frame), sigmas, yaw, roll};
           }),
           py::arg("pitch") = 0.5, py::arg("offset") = 0.17, py::arg("frame") = "level",
           py::arg("sigmas") = 0.0, py::arg("yaw") = 0.0, py::arg("roll") = 0.0,
           "pitch [rad], > 0 looks down; offset: lever arm (ahead, left, up) [m], or a number ahead; frame: "
           "\"level\" or \"body\"; sigmas: standard deviations of what is seen by which regions of view "
           "shrink, >= 0; yaw [rad], > 0 looks to the left; roll [rad], about the axis, > 0: left side up")
      .def_readonly("pitch", &SensorMount::pitch)
      .def_property_readonly("offset",
                             [](const SensorMount& mount) {
                               return array(std::array{mount.offset.x, mount.offset.y, mount.offset.z});
                             })
      .def_readonly("sigmas", &SensorMount::sigmas)
      .def_readonly("yaw", &SensorMount::yaw)
      .def_readonly("roll", &SensorMount::roll);

  py::class_<Weighted>(module, "Weighted", "A potential times its weight, as 0.4 * potential.")
      .def_readonly("weight", &Weighted::weight)
      .def_readonly("potential", &Weighted::potential);

  py::class_<Potential>(module, "Potential", "A potential between two bodies, or of one.")
      .def_property_readonly("name", [](const Potential& p) { return std::string(p.name()); })
      .def_property_readonly("is_pair", &Potential::is_pair)
      .def_property_readonly("parameters", [](const Potential& p) { return parameters_of(p.parameters()); })
      .def("seen_from", &Potential::seen_from, py::arg("mount"), "The same with the observer's sensor there.")
      .def(
          "__call__",
          [](const Potential& p, const Sight<double>& a, const Sight<double>& b, double t) {
            return p(a, b, t);
          },
          py::arg("observer"), py::arg("target") = Sight<double>{}, py::arg("t") = 0.0,
          "l [-] at time t [s].")
      .def("violation", &Potential::violation, py::arg("observer"), py::arg("target") = Sight<double>{},
           py::arg("t") = 0.0, "> 0 where the limit is broken, in its unit; -inf where it states none.")
      .def("gradient", &gradient_of, py::arg("observer"), py::arg("target") = Sight<double>{},
           py::arg("t") = 0.0,
           "Derivatives of l by p, d, v, lean of the observer (row 0) and of the target (row 1), 2 x 10.")
      .def("__rmul__",
           [](const Potential& p, double weight) {
             return Weighted{weight, p};
           })
      .def("__repr__", [](const Potential& p) { return fmt::format("<potential {}>", p.name()); });
}

py::array_t<double> gradient_of(const Potential& potential, const Sight<double>& a, const Sight<double>& b,
                                double t) {
  Graph graph;
  const std::vector<Symbol> z = variables(graph, 0, 2 * sight_size + 1);
  const Symbol l =
      potential(sight_from<Symbol>(z.data()), sight_from<Symbol>(z.data() + sight_size), z.back());
  std::vector<Term> by;
  for (int i = 0; i < 2 * sight_size; ++i) by.push_back(z[static_cast<std::size_t>(i)].in(graph));
  std::array<double, 2 * sight_size + 1> numbers{};
  write_sight(a, numbers.data());
  write_sight(b, numbers.data() + sight_size);
  numbers.back() = t;
  const std::vector<Term> slopes = sightline::gradient(graph, l.in(graph), by);
  return array(evaluate(Program(graph, slopes, 2 * sight_size + 1), numbers), 2, sight_size);
}

}  // namespace

void bind_parts(py::module_& module) {
  bind_sight(module);
  py::class_<Model>(module, "Model", "A robot: x' = f(x, u), and what is seen of it.")
      .def_property_readonly("name", [](const Model& m) { return std::string(m.name()); })
      .def_property_readonly("nx", &Model::nx)
      .def_property_readonly("nu", &Model::nu)
      .def_property_readonly(
          "states",
          [](const Model& m) { return std::vector<std::string>(m.states().begin(), m.states().end()); })
      .def_property_readonly(
          "inputs",
          [](const Model& m) { return std::vector<std::string>(m.inputs().begin(), m.inputs().end()); })
      .def_property_readonly("u_min", [](const Model& m) { return array(m.u_min()); })
      .def_property_readonly("u_max", [](const Model& m) { return array(m.u_max()); })
      .def_property_readonly("parameters", [](const Model& m) { return parameters_of(m.parameters()); })
      .def(
          "f",
          [](const Model& m, const Numbers& x, const Numbers& u) {
            std::vector<double> rate(static_cast<std::size_t>(m.nx()));
            m.f(view(x, "x", m.nx()).data(), view(u, "u", m.nu()).data(), rate.data());
            return array(rate);
          },
          py::arg("x"), py::arg("u"), "x' = f(x, u).")
      .def(
          "sight",
          [](const Model& m, const Numbers& x, const Numbers& u) {
            return m.sight(view(x, "x", m.nx()).data(), view(u, "u", m.nu()).data());
          },
          py::arg("x"), py::arg("u"), "What is seen of it at state x under input u.")
      .def("__repr__", [](const Model& m) { return fmt::format("<robot {}>", m.name()); });
  bind_potential(module);

  py::class_<Reference>(module, "Reference", "x*(t) of a robot: a state, or a pose at rest.")
      .def(py::init([](const Numbers& state) {
             const auto all = view(state);
             return Reference(std::vector<double>(all.begin(), all.end()));
           }),
           py::arg("state"), "A constant state (nx).")
      .def_property_readonly("length", &Reference::length, "Numbers of the state; 0 for a pose.")
      .def(
          "__call__",
          [](const Reference& r, double t, const Model& model) {
            std::vector<double> x(static_cast<std::size_t>(model.nx()));
            r(t, model, x);
            return array(x);
          },
          py::arg("t"), py::arg("model"), "x*(t) of a robot (nx); NaN where it is of another length.");

  py::class_<Limit>(module, "Limit", "A limit c(x, u) <= 0 of one robot.")
      .def_property_readonly("name", [](const Limit& l) { return std::string(l.name()); })
      .def_property_readonly("parameters", [](const Limit& l) { return parameters_of(l.parameters()); });

  const Registry& registry = built_in_registry();
  add_all(module, registry.robots);
  add_all(module, registry.potentials);
  add_all(module, registry.references);
  add_all(module, registry.limits);
}

}  // namespace sightline::python
