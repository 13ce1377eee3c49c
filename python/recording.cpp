// A log as numpy arrays, which are read-only views of the log's memory.
#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <map>
#include <memory>

#include "python/bindings.hpp"
#include "sightline/log.hpp"

namespace sightline::python {
namespace {

static_assert(sizeof(Vec3<double>) == 3 * sizeof(double) && sizeof(Vec2<double>) == 2 * sizeof(double));

/// The full states of a body, one row per message; after keep(), one row per period.
struct LoggedStates {
  std::vector<double> time, x;
  std::size_t nx = 0;

  void add(double at, std::span<const double> row) {
    time.push_back(at);
    if (nx == 0) nx = row.size();
    if (row.size() != nx) throw_invalid("a state of {} numbers, expected {}", row.size(), nx);
    x.insert(x.end(), row.begin(), row.end());
  }
  /// Keeps the rows of the periods. A log has other rows, for missed periods and after the last
  /// command.
  void keep(const std::vector<double>& periods) {
    std::size_t kept = 0;
    for (std::size_t row = 0; row < time.size() && kept < periods.size(); ++row) {
      if (time[row] != periods[kept]) continue;
      std::copy_n(x.begin() + static_cast<std::ptrdiff_t>(row * nx), nx,
                  x.begin() + static_cast<std::ptrdiff_t>(kept++ * nx));
    }
    x.resize(periods.size() * nx);
  }
};

/// A recording and the states of its bodies, all from one pass over the file; a growing log is read
/// as it was then.
struct OpenLog {
  std::filesystem::path folder;
  std::map<std::string, LoggedStates, std::less<>> states{};  // by topic

 private:
  LogText text_{};  // the text that add() parses while the recording is read

 public:
  Recording recording;

  explicit OpenLog(const std::filesystem::path& of)
      : folder(of), recording(read_recording(of, [this](const McapMessage& message) { add(message); })) {
    for (auto& [topic, of_body] : states) of_body.keep(recording.time);
  }

 private:
  void add(const McapMessage& message) {
    if (message.encoding != "json" || !message.topic.ends_with("/state")) return;
    text_.read({reinterpret_cast<const char*>(message.bytes.data()), message.bytes.size()});
    states[std::string(message.topic)].add(text_.number("time"), text_.numbers("x"));
  }
};
using SharedLog = std::shared_ptr<OpenLog>;

/// A body of the log.
struct LoggedBody {
  SharedLog log;
  const Recording::Body* body;
};

/// A view of the log's numbers, without a copy.
py::array_t<double> shown(const SharedLog& log, const double* numbers, std::vector<py::ssize_t> shape) {
  const py::capsule holds(new SharedLog(log), [](void* held) { delete static_cast<SharedLog*>(held); });
  // An empty list has no memory to view.
  if (numbers == nullptr) return py::array_t<double>(std::move(shape));
  py::array_t<double> view(std::move(shape), numbers, holds);
  view.attr("flags").attr("writeable") = false;
  return view;
}
py::array_t<double> shown(const SharedLog& log, const std::vector<double>& list) {
  return shown(log, list.data(), {static_cast<py::ssize_t>(list.size())});
}
py::array_t<double> shown(const SharedLog& log, const std::vector<Vec3<double>>& list) {
  return shown(log, reinterpret_cast<const double*>(list.data()), {static_cast<py::ssize_t>(list.size()), 3});
}
py::array_t<double> shown(const SharedLog& log, const std::vector<Vec2<double>>& list) {
  return shown(log, reinterpret_cast<const double*>(list.data()), {static_cast<py::ssize_t>(list.size()), 2});
}

py::array_t<double> states_of(const LoggedBody& of) {
  static const LoggedStates none;
  const auto found = of.log->states.find("/" + of.body->name + "/state");
  const LoggedStates& all = found != of.log->states.end() ? found->second : none;
  return shown(of.log, all.x.data(),
               {static_cast<py::ssize_t>(of.log->recording.time.size()), static_cast<py::ssize_t>(all.nx)});
}

/// Applied inputs, one row per period.
py::array_t<double> inputs_of(const LoggedBody& of) {
  const auto rows = static_cast<py::ssize_t>(of.log->recording.time.size());
  const auto nu = static_cast<py::ssize_t>(of.body->u.size());
  py::array_t<double> u({rows, nu});
  auto to = u.mutable_unchecked<2>();
  for (py::ssize_t i = 0; i < nu; ++i)
    for (py::ssize_t k = 0; k < rows; ++k)
      to(k, i) = of.body->u[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)];
  return u;
}

/// A column of the solver's records; of the first controller if there are several.
const Recording::Controller& controller(const OpenLog& log) {
  if (log.recording.controllers.empty()) throw std::runtime_error("the log has no solver");
  return log.recording.controllers.front();
}

void bind_body(py::module_& module) {
  const auto column = [](auto member) {
    return [member](const LoggedBody& b) { return shown(b.log, (*b.body).*member); };
  };
  using Body = Recording::Body;
  py::class_<LoggedBody>(module, "LoggedBody", "A body of a log; one row a period, read-only.")
      .def_property_readonly("name", [](const LoggedBody& b) { return b.body->name; })
      .def_property_readonly(
          "robot", [](const LoggedBody& b) { return b.body->robot; }, "Its model; \"body\" of no robot.")
      .def_property_readonly("is_agent", [](const LoggedBody& b) { return b.body->is_agent; })
      .def_property_readonly("p", column(&Body::p), "True position in G [m], n x 3.")
      .def_property_readonly("v", column(&Body::v), "True velocity in G [m/s], n x 3.")
      .def_property_readonly("heading", column(&Body::heading), "psi [rad], unwrapped, n.")
      .def_property_readonly("lean", column(&Body::lean), "Forward and to the left, n x 2.")
      .def_property_readonly("x", &states_of, "True state, n x nx, all bits of it.")
      .def_property_readonly("u", &inputs_of, "Applied inputs, n x nu, a copy.")
      .def_property_readonly(
          "inputs", [](const LoggedBody& b) { return b.body->inputs; }, "Names of the inputs.")
      .def_property_readonly("reference_time", column(&Body::reference_time), "[s]")
      .def_property_readonly("reference_p", column(&Body::reference_p), "[m], empty where the place is free.")
      .def("__repr__", [](const LoggedBody& b) { return fmt::format("<logged {}>", b.body->name); });
}

}  // namespace

void bind_recording(py::module_& module) {
  bind_body(module);
  py::class_<OpenLog, SharedLog>(module, "Log",
                                 "The log of a run, of its folder; of a killed run as far as it is sound.")
      .def(py::init([](const std::filesystem::path& folder) {
             const py::gil_scoped_release others_run;
             return std::make_shared<OpenLog>(folder);
           }),
           py::arg("folder"), "Raises RuntimeError with a sentence where it cannot be read.")
      .def_readonly("folder", &OpenLog::folder)
      .def_property_readonly(
          "scenario", [](const OpenLog& l) { return l.recording.scenario; }, "Text of the scenario.")
      .def_property_readonly("name", [](const OpenLog& l) { return l.recording.name; })
      .def_property_readonly("solver", [](const OpenLog& l) { return l.recording.solver; })
      .def_property_readonly("seed", [](const OpenLog& l) { return l.recording.seed; })
      .def_property_readonly("version", [](const OpenLog& l) { return l.recording.version; })
      .def_property_readonly(
          "period", [](const OpenLog& l) { return l.recording.period; }, "[s]")
      .def_property_readonly(
          "complete", [](const OpenLog& l) { return l.recording.complete && !l.recording.lost_after; },
          "False: the run was killed, the log ends in the middle, or it lacks periods.")
      .def_property_readonly(
          "time", [](const SharedLog& l) { return shown(l, l->recording.time); }, "[s], n")
      .def_property_readonly(
          "cost", [](const SharedLog& l) { return shown(l, l->recording.cost); }, "Stage cost l, n.")
      .def_property_readonly(
          "residual", [](const SharedLog& l) { return shown(l, controller(*l).residual); }, "[1/s], n")
      .def_property_readonly(
          "status", [](const SharedLog& l) { return controller(*l).status; }, "A word a period.")
      .def_property_readonly("iterations", [](const SharedLog& l) { return controller(*l).iterations; })
      .def_property_readonly(
          "solve_us", [](const SharedLog& l) { return shown(l, l->recording.solve_us); },
          "Measured times [us], a row of timing.csv each.")
      .def_property_readonly(
          "events",
          [](const SharedLog& l) {
            std::vector<std::tuple<double, std::string, double>> all;
            for (const auto& e : l->recording.events) all.emplace_back(e.time, e.kind, e.value);
            return all;
          },
          "(time [s], kind, value) each.")
      .def_property_readonly(
          "bodies",
          [](const SharedLog& l) {
            py::dict all;
            for (const auto& body : l->recording.bodies) all[py::str(body.name)] = LoggedBody{l, &body};
            return all;
          },
          "By their names, in the order of the team.")
      .def("__getitem__",
           [](const SharedLog& l, const std::string& name) {
             for (const auto& body : l->recording.bodies)
               if (body.name == name) return LoggedBody{l, &body};
             throw py::key_error(fmt::format("\"{}\", expected the name of a body", name));
           })
      .def("__len__", [](const SharedLog& l) { return l->recording.time.size(); });
}

}  // namespace sightline::python
