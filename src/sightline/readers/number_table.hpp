/// Rows of numbers in a text, with refusals that name file, line, column and value.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sightline/base.hpp"

namespace sightline {

/// A column and the numbers that it accepts.
struct NumberColumn {
  std::string_view name, unit;
  Bounds bounds = any_finite;
};

/// The finite number that a text is, perhaps with a sign; empty if it is none.
std::optional<double> finite_number(std::string_view text);
/// A field as it is shown in a message: printable, and not too long.
std::string printable(std::string_view field);

/// Reads the rows of a text one by one. Commas or semicolons separate the fields of a row; in a row
/// without them, blanks do. Quotes around a field are left out. Blank lines are left out, and so are
/// remarks, which begin with #.
class NumberTable {
 public:
  NumberTable(std::string file, std::string_view text);

  /// Advances to the next row. @return false at the end
  bool next();
  /// The same, but remarks are rows, too, without their #.
  bool next_or_remark();
  bool is_remark() const { return is_remark_; }
  std::size_t line() const { return line_; }  ///< of the row in the text, from 1
  /// The fields of the row, without blanks and quotes around them.
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
  std::size_t line_ = 0;
  bool is_remark_ = false;
  std::vector<std::string_view> fields_;
};

}  // namespace sightline
