/// Rows of numbers in a text, with refusals that name file, line, column and value.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/base.hpp"

namespace sightline {

/// A column and the numbers that it accepts.
struct NumberColumn {
  std::string_view name, unit;
  Bounds bounds = any_finite;
};

/// Reads the rows of a text one by one; blank lines and those that begin with # are left out.
class NumberTable {
 public:
  /// @param separator  ',' or ' ', which stands for any blanks
  NumberTable(std::string file, std::string_view text, char separator)
      : file_(std::move(file)), rest_(text), separator_(separator) {}

  /// Advances to the next row. @return false at the end
  bool next();
  /// The fields of the row, without blanks around them.
  std::span<const std::string_view> fields() const { return fields_; }
  /// The number of a field. @throws std::invalid_argument if it is none, or out of its bounds
  double number(std::size_t field, const NumberColumn& column) const;
  /// All fields of a row, which must be as many as the columns.
  std::vector<double> numbers(std::span<const NumberColumn> columns) const;
  /// `file:line: sentence`, as std::invalid_argument.
  [[noreturn]] void refuse(const std::string& sentence) const;

 private:
  std::string file_;
  std::string_view rest_;
  char separator_;
  std::size_t line_ = 0;
  std::vector<std::string_view> fields_;
};

}  // namespace sightline
