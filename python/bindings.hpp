/// The functions that make up the Python module; each adds the names of one subject. Numbers cross
/// as numpy arrays; errors become ValueError with the library's message.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/base.hpp"

namespace sightline::python {

namespace py = pybind11;

/// Numbers from Python: a contiguous array of doubles without a copy, any other array-like as a copy.
using Numbers = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// A view of an array's numbers, valid while the array lives.
inline std::span<const double> view(const Numbers& numbers) {
  return {numbers.data(), static_cast<std::size_t>(numbers.size())};
}
/// @throws std::invalid_argument naming the argument, unless it is a row of n numbers
inline std::span<const double> view(const Numbers& numbers, std::string_view what, int n) {
  if (numbers.ndim() > 1)
    throw_invalid("{} has {} dimensions, expected {} numbers in one", what, numbers.ndim(), n);
  if (numbers.size() != n) throw_invalid("{} has {} numbers, expected {}", what, numbers.size(), n);
  return view(numbers);
}
/// @throws std::invalid_argument naming the argument, unless it has so many rows and columns
inline std::span<const double> view(const Numbers& numbers, std::string_view what, int rows, int columns) {
  if (numbers.ndim() != 2 || numbers.shape(0) != rows || numbers.shape(1) != columns)
    throw_invalid("{} has {} numbers in {} dimensions, expected {} x {}", what, numbers.size(),
                  numbers.ndim(), rows, columns);
  return view(numbers);
}
/// A Python string in UTF-8. @throws std::invalid_argument naming the argument if it has a lone
/// surrogate
inline std::string utf8(const py::handle& text, std::string_view what) {
  const char* const bytes = PyUnicode_AsUTF8(text.ptr());
  if (bytes != nullptr) return bytes;
  PyErr_Clear();
  throw_invalid("{} = {}, expected a text", what, std::string(py::str(py::repr(text))));
}
/// A list of numbers from Python; `otherwise` if the argument is None.
inline std::vector<double> list(const py::object& given, const std::vector<double>& otherwise = {}) {
  if (given.is_none()) return otherwise;
  const Numbers numbers = Numbers::ensure(given);
  if (!numbers) throw py::type_error(std::string(py::str(py::repr(given))) + ", expected a list of numbers");
  const std::span<const double> all = view(numbers);
  return {all.begin(), all.end()};
}

/// A new array with a copy of these numbers.
inline py::array_t<double> array(std::span<const double> numbers) {
  return py::array_t<double>(static_cast<py::ssize_t>(numbers.size()), numbers.data());
}
inline py::array_t<double> array(std::span<const double> numbers, py::ssize_t rows, py::ssize_t columns) {
  return py::array_t<double>(std::vector<py::ssize_t>{rows, columns}, numbers.data());
}

void bind_formula(
    py::module_& module);              ///< the recorder of formulas, and potentials and references made of it
void bind_parts(py::module_& module);  ///< robots, potentials, references, limits
void bind_team(py::module_& module);   ///< Team and its bodies
void bind_solver(py::module_& module);     ///< solvers, and the simulated plant
void bind_scenario(py::module_& module);   ///< Scenario, check, explain
void bind_flight(py::module_& module);     ///< run, replay, report
void bind_world(py::module_& module);      ///< World, period by period
void bind_campaign(py::module_& module);   ///< campaign
void bind_recording(py::module_& module);  ///< Log
void bind_localize(py::module_& module);   ///< localize

}  // namespace sightline::python
