// Steps the world of a scenario period by period, for controllers written in Python.
#include "sightline/world.hpp"

#include <fmt/format.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "python/bindings.hpp"
#include "sightline/base.hpp"
#include "sightline/scenario.hpp"

namespace sightline::python {
namespace {

/// The world of a scenario in simulated time, at the beginning of a period.
class SteppedWorld {
 public:
  /// @throws std::invalid_argument as make_world(), and if the team changes in flight
  SteppedWorld(const Scenario& scenario, const std::optional<std::uint64_t>& seed) : scenario_(scenario) {
    if (changes_in_flight(scenario)) {
      throw_invalid("{}: the team changes in flight, expected one that stays, or sightline.run",
                    scenario.file.native());
    }
    restart(seed);
  }

  /// Restarts; with another seed if one is given.
  void restart(const std::optional<std::uint64_t>& seed) {
    if (seed) scenario_.simulation.seed = *seed;
    world_ = make_world(scenario_);
    gate_ = std::make_unique<CommandGate>(world_->team(), period());
    periods_ = 0;
    ended_ = false;
    now_ = world_->measure(0.0);
  }

  /// Applies inputs for one period, each within the limits in force.
  /// @throws std::invalid_argument for a number that is not finite
  /// @throws std::runtime_error if the world cannot continue
  void step(const Numbers& given) {
    const std::span<const double> requested = view(given, "u", team().nu());
    if (ended_) throw std::runtime_error("the world has ended, expected restart()");
    for (std::size_t i = 0; i < requested.size(); ++i)
      if (!std::isfinite(requested[i]))
        throw_invalid("u[{}] = {}, expected a finite number", i, requested[i]);
    gate_->open(time());
    const Command command = gate_->pass(requested, {});
    u_.assign(command.begin(), command.end());
    const py::gil_scoped_release others_run;
    ended_ = !world_->apply(time(), now_.measured, command, period(), 1);
    if (ended_) {
      const std::string why = world_->ended();
      throw std::runtime_error(why.empty() ? "a state is no longer finite" : why);
    }
    ++periods_;
    now_ = world_->measure(time());
  }

  const Team& team() const { return scenario_.team; }
  double period() const { return scenario_.horizon.dt; }
  double time() const { return static_cast<double>(periods_) * period(); }
  const Measured& now() const { return now_; }
  const std::vector<double>& applied() const { return u_; }
  std::uint64_t seed() const { return scenario_.simulation.seed; }
  std::string name_of(BodyId body) const { return std::string(team().name(body)); }

 private:
  Scenario scenario_;
  std::unique_ptr<World> world_;
  std::unique_ptr<CommandGate> gate_;
  Measured now_;
  std::int64_t periods_ = 0;
  bool ended_ = false;
  std::vector<double> u_;
};

/// A detection as a Python object.
struct SeenBody {
  std::string observer, target;
  Detection detection;
};

std::vector<SeenBody> detections(const SteppedWorld& world) {
  std::vector<SeenBody> all;
  for (const Detection& d : world.now().detections)
    all.push_back({world.name_of(d.observer), world.name_of(d.target), d});
  return all;
}

py::array_t<double> covariance(const SeenBody& seen) {
  const Mat<6, 6> all = seen.detection.covariance_matrix();
  py::array_t<double> out({6, 6});
  auto to = out.mutable_unchecked<2>();
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) to(i, j) = all(i, j);
  return out;
}

void bind_detection(py::module_& module) {
  py::class_<SeenBody>(
      module, "Detection",
      "A body seen by a camera: its pose in the frame S of the observer's first camera, x along the axis.")
      .def_readonly("observer", &SeenBody::observer)
      .def_readonly("target", &SeenBody::target)
      .def_property_readonly(
          "stamp", [](const SeenBody& s) { return s.detection.stamp; }, "When it was so [s].")
      .def_property_readonly(
          "arrival", [](const SeenBody& s) { return s.detection.arrival; }, "When the observer has it [s].")
      .def_property_readonly(
          "p",
          [](const SeenBody& s) {
            const Vec3<double>& p = s.detection.p;
            return array(std::array<double, 3>{p.x, p.y, p.z});
          },
          "Of the target in S [m].")
      .def_property_readonly(
          "q",
          [](const SeenBody& s) {
            const Quaternion& q = s.detection.q;
            return array(std::array<double, 4>{q.w, q.x, q.y, q.z});
          },
          "The target's axes in S, w first; NaN where the position alone is known.")
      .def_property_readonly("covariance", &covariance, "Of position [m] and turn [rad] in S, 6 x 6.")
      .def_property_readonly("tags", [](const SeenBody& s) { return s.detection.tags; })
      .def("__repr__",
           [](const SeenBody& s) { return fmt::format("<detection of {} by {}>", s.target, s.observer); });
}

}  // namespace

void bind_world(py::module_& module) {
  bind_detection(module);
  py::class_<SteppedWorld>(module, "World",
                           "What a scenario flies, with its sensors, wind and seed, period by period, for a "
                           "controller of one's own. For one thread.")
      .def(py::init<const Scenario&, const std::optional<std::uint64_t>&>(), py::arg("scenario"),
           py::arg("seed") = std::nullopt)
      .def("step", &SteppedWorld::step, py::arg("u"),
           "Applies the inputs of all robots (nu), clamped to their limits, for one period.\n\nRaises "
           "ValueError where one is not finite, "
           "RuntimeError with a sentence where the world cannot go on.")
      .def("restart", &SteppedWorld::restart, py::arg("seed") = std::nullopt,
           "Begins anew, with another seed where one is given.")
      .def_property_readonly("team", &SteppedWorld::team, py::return_value_policy::reference_internal)
      .def_property_readonly("dt", &SteppedWorld::period, "Control period [s].")
      .def_property_readonly("time", &SteppedWorld::time, "Now [s].")
      .def_property_readonly("seed", &SteppedWorld::seed)
      .def_property_readonly(
          "x", [](const SteppedWorld& w) { return array(w.now().measured); },
          "What is measured of all bodies now (nx).")
      .def_property_readonly(
          "stamps", [](const SteppedWorld& w) { return array(w.now().stamps); },
          "Of each body, when that was so [s]; -inf: never.")
      .def_property_readonly(
          "truth", [](const SteppedWorld& w) { return array(w.now().truth); },
          "True states of all bodies (nx).")
      .def_property_readonly(
          "u", [](const SteppedWorld& w) { return array(w.applied()); }, "As applied last (nu).")
      .def_property_readonly("detections", &detections, "That arrived in this period, a Detection each.")
      .def("__repr__", [](const SteppedWorld& w) { return fmt::format("<world at {:.3f} s>", w.time()); });
}

}  // namespace sightline::python
