// Recorder of the formulas of Python functions (python/sightline/tracing.py), and the parts made
// from them.
#include <fmt/format.h>
#include <pybind11/stl.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "python/bindings.hpp"
#include "python/recorded.hpp"
#include "sightline/model.hpp"

namespace sightline::python {
namespace {

using Kind = Expression::Kind;

/// A formula under construction; its steps are identified by their indices.
class Recorder {
 public:
  explicit Recorder(int variables) : variables_(variables) {}

  int variable(int i) { return counted(builder_.variable(at(i, variables_))); }
  int constant(double value) {
    if (!std::isfinite(value)) throw_invalid("a number of the formula is {}, expected a finite one", value);
    return counted(builder_.constant(value));
  }
  template <Kind kind>
  int binary(int a, int b) {
    return counted(builder_.binary(kind, step(a), step(b)));
  }
  template <Kind kind>
  int unary(int a) {
    return counted(builder_.unary(kind, step(a)));
  }
  int power(int a, int n) {
    if (std::abs(n) > 64) throw_invalid("a power of {}, expected at most 64", n);
    return counted(builder_.power(step(a), n));
  }
  int absolute(int a) { return counted(builder_.absolute(step(a))); }
  int larger(int a, int b) { return counted(builder_.larger(step(a), step(b))); }
  int smaller(int a, int b) { return counted(builder_.smaller(step(a), step(b))); }
  Expression finish(int result) const {
    if (const auto number = builder_.value(step(result)); number && !std::isfinite(*number))
      throw_invalid("the formula is {}, expected a finite one", *number);
    return builder_.finish(step(result), std::nullopt, {});
  }

 private:
  static int at(int i, int n) {
    if (i < 0 || i >= n) throw std::out_of_range(fmt::format("{}, expected 0 to {}", i, n - 1));
    return i;
  }
  int step(int a) const { return at(a, static_cast<int>(builder_.size())); }
  int counted(int a) const {
    if (builder_.size() > formula_steps_max)
      throw_invalid("the formula has more than {} operations, expected a shorter one", formula_steps_max);
    return a;
  }

  ExpressionBuilder builder_;
  int variables_;
};

}  // namespace

void bind_formula(py::module_& module) {
  py::class_<Expression>(module, "Expression", "A recorded formula.")
      .def("__len__", [](const Expression& formula) { return formula.steps().size(); })
      .def("uses", &Expression::uses, py::arg("variable"));
  py::class_<Recorder>(module, "Recorder",
                       "Records a formula over variables; its steps are known by their numbers.")
      .def(py::init<int>(), py::arg("variables"))
      .def("variable", &Recorder::variable)
      .def("constant", &Recorder::constant)
      .def("add", &Recorder::binary<Kind::add>)
      .def("subtract", &Recorder::binary<Kind::subtract>)
      .def("multiply", &Recorder::binary<Kind::multiply>)
      .def("divide", &Recorder::binary<Kind::divide>)
      .def("atan2", &Recorder::binary<Kind::angle>)
      .def("negate", &Recorder::unary<Kind::negate>)
      .def("sqrt", &Recorder::unary<Kind::root>)
      .def("sin", &Recorder::unary<Kind::sine>)
      .def("cos", &Recorder::unary<Kind::cosine>)
      .def("exp", &Recorder::unary<Kind::exponential>)
      .def("log", &Recorder::unary<Kind::logarithm>)
      .def("logistic", &Recorder::unary<Kind::logistic>)
      .def("softplus", &Recorder::unary<Kind::softplus>)
      .def("power", &Recorder::power)
      .def("absolute", &Recorder::absolute)
      .def("maximum", &Recorder::larger)
      .def("minimum", &Recorder::smaller)
      .def("finish", &Recorder::finish);
  module.attr("sight_size") = sight_size;

  module.def(
      "recorded_pair",
      [](const std::string& name, const Expression& l, const std::optional<Expression>& limit,
         const std::optional<SensorMount>& mount) {
        return Potential(RecordedPair(name, l, limit, mount.value_or(SensorMount{})));
      },
      py::arg("name"), py::arg("l"), py::arg("limit"), py::arg("mount"));
  module.def(
      "recorded_single",
      [](const std::string& name, const Expression& l, const std::optional<Expression>& limit) {
        return Potential(RecordedSingle(name, l, limit));
      },
      py::arg("name"), py::arg("l"), py::arg("limit"));
  module.def(
      "recorded_reference",
      [](std::vector<Expression> states) {
        if (states.empty() || states.size() > Reference::max_states)
          throw_invalid("a reference of {} numbers, expected 1 to {}", states.size(), Reference::max_states);
        return Reference(RecordedReference{std::move(states)});
      },
      py::arg("states"));
  module.def(
      "recorded_robot",
      [](const std::string& name, std::vector<Expression> rates, const std::vector<std::string>& states,
         const std::vector<std::string>& inputs, const std::array<std::string, 3>& position,
         const std::vector<std::string>& heading, const py::object& u_min, const py::object& u_max) {
        return TextRobot{.name = name,
                         .states = states,
                         .inputs = inputs,
                         .f = {},
                         .position = position,
                         .heading = heading,
                         .parameters = {},
                         .u_min = list(u_min),
                         .u_max = list(u_max)}
            .model(std::move(rates));
      },
      py::arg("name"), py::arg("rates"), py::arg("states"), py::arg("inputs"), py::arg("position"),
      py::arg("heading"), py::arg("u_min"), py::arg("u_max"));
}

}  // namespace sightline::python
