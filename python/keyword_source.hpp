/// Parameters of a part from the keyword arguments of a call, by the part's description
/// (base.hpp).
#pragma once

#include <string>
#include <vector>

#include "python/bindings.hpp"
#include "sightline/base.hpp"

namespace sightline::python {

/// A view: the arguments must outlive it. Its errors are ValueErrors "keep_out.d_min = -1.0,
/// expected > 0 m". An argument that no part has is a TypeError that names the nearest known one.
class KeywordSource final : public ParameterSource {
 public:
  KeywordSource(std::string part, const py::dict& given) : part_(std::move(part)), given_(given) {}

  bool has(std::string_view key) const override;
  void expect_only(std::span<const std::string_view> keys) const override;
  double number(std::string_view key, const Bounds& bounds, std::string_view unit) const override;
  int integer(std::string_view key, const Bounds& bounds) const override;
  std::vector<double> numbers(std::string_view key, std::size_t length, const Bounds& bounds,
                              std::string_view unit) const override;
  std::vector<double> rising(std::string_view key) const override;
  std::vector<std::vector<double>> rows(std::string_view key, std::size_t count,
                                        std::size_t length) const override;
  std::size_t word(std::string_view key, std::span<const std::string_view> known) const override;
  [[noreturn]] void throw_invalid(std::string_view sentence) const override;

 private:
  /// The argument. @throws std::invalid_argument if it was not given
  py::object at(std::string_view key, std::string_view expected) const;
  [[noreturn]] void throw_invalid(std::string_view key, std::string_view expected) const;
  /// The argument as numbers of any shape. @throws std::invalid_argument if it has none, or they
  /// are not finite
  Numbers array_at(std::string_view key, std::string_view expected) const;

  std::string part_;
  const py::dict& given_;
};

}  // namespace sightline::python
