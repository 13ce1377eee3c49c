/// Lists of a part, positions and headings at times, from the columns of a text file, or from the
/// motion of a body in a recording:
///
///     reference = { waypoints = { file = "path.csv" } }
///     motion = { waypoints = { file = "flight.ulg", body = "vehicle_local_position" } }
///     motion = { waypoints = { file = "flight.mcap", body = "cf1" } }
///
/// Full description: docs/robots.md.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "sightline/readers/recorded_motion.hpp"
#include "sightline/scenario/read_part.hpp"

namespace sightline {

/// Columns of numbers with names.
struct CsvColumns {
  std::vector<std::string> names;
  std::vector<std::vector<double>> values;  ///< of each column, of equal length

  /// The column of that name, or null.
  const std::vector<double>* find(std::string_view name) const;
};

/// Most rows and columns of a file.
inline constexpr std::size_t csv_rows_max = 100'000, csv_columns_max = 64;

/// Reads rows of numbers, separated by commas, semicolons, tabs or spaces. Empty lines and those
/// that begin with # are skipped, except that a line of names before the first row may begin so.
/// @param names  of the columns, in their order; "-" for one that is not used; empty: from the
/// first line
/// @throws ScenarioError for a row with another number of entries, an entry that is not a finite
/// number, a name that comes twice, no row, or more rows or columns than the most
CsvColumns read_csv(std::string_view text, std::string_view file, std::vector<std::string> names = {});

/// Keys of a table whose lists at times a file gives.
struct ListFile {
  static constexpr auto parameters() {
    return Parameters{
        KeyText{"file", "a file (CSV, ULog, MCAP)",
                "columns t, x, y, z, perhaps heading, vx, vy, vz, in place of the lists, or a log of PX4, a "
                "bag of ROS 2, the log of a run",
                "none"},
        KeyText{"body", "a topic or a name",
                "of the log: vehicle_local_position, its _groundtruth or vehicle_odometry; of the bag: "
                "/odom, /poses:cf1, or cf1",
                "none"},
        KeyText{"columns", "names", "of the columns of the file, in their order; \"-\": not used",
                "its first line"},
        KeyText{"period", "> 0 s", "between the rows of a file without a column t", "none"},
        KeyText{"begin", "a time in s", "of the first row of the file", "as in the file"}};
  }
};

/// Rows t, x, y, z, perhaps heading and vx, vy, vz, of a motion, as read_csv() reads them: from t = 0
/// on, at least 20 ms apart, with a resolution of 0.1 mm.
std::string motion_text(const RecordedMotion& motion);

/// Whether the part has lists at times, which a file may give.
bool has_timed_lists(const PartText& part);

/// A table as the source of a part whose lists `times`, `p`, `heading` and `v` a file gives, if the
/// table has the key `file`. A view: the table must outlive it.
class ListSource final : public TableSource {
 public:
  /// @throws ScenarioError for a file that cannot be read, lacks a column, or stands beside a list
  explicit ListSource(const TomlTable& at);

  bool has(std::string_view key) const override;
  std::vector<double> numbers(std::string_view key, std::size_t length, const Bounds& bounds,
                              std::string_view unit) const override;
  std::vector<double> rising(std::string_view key) const override;
  std::vector<std::vector<double>> rows(std::string_view key, std::size_t count,
                                        std::size_t length) const override;

 private:
  const std::vector<double>& column(std::string_view name) const;
  bool is_of_file(std::string_view key) const;

  std::optional<CsvColumns> columns_;
  std::string file_;
};

}  // namespace sightline
