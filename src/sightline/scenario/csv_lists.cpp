#include "sightline/scenario/csv_lists.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "sightline/readers/number_table.hpp"
#include "sightline/readers/px4_flight.hpp"
#include "sightline/readers/ros_bag.hpp"
#include "sightline/scenario/file_kind.hpp"

namespace sightline {
namespace {

constexpr std::string_view unused = "-";
constexpr std::array<std::string_view, 4> beside_file = {"body", "columns", "period", "begin"};
constexpr std::size_t body_size_max = 80;
constexpr double rows_apart = 0.02;  // of the text of a recording [s]
constexpr double begin_most = 1e5;   // beyond it the times are those of a clock [s]
constexpr std::array<std::string_view, 3> of_place = {"x", "y", "z"}, of_velocity = {"vx", "vy", "vz"};

/// In small letters; the names that ROS and spreadsheets use are replaced by ours.
std::string column_name(std::string_view text) {
  std::string name(text);
  for (char& c : name) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  if (name == "time") return "t";
  return name == "yaw" ? "heading" : name;
}

void check_column_names(const std::vector<std::string>& names, std::string_view file, std::size_t line) {
  if (names.size() > csv_columns_max)
    throw ScenarioError(file, line,
                        fmt::format("{} columns, expected at most {}", names.size(), csv_columns_max));
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] != unused && std::find(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(i),
                                        names[i]) != names.begin() + static_cast<std::ptrdiff_t>(i))
      throw ScenarioError(
          file, line, fmt::format("two columns are called \"{}\", expected one", shortened(names[i], 40)));
  }
}

constexpr std::string_view a_table = "a file of times and positions (CSV), relative to this one";

/// The kind of the file that the key `file` names, unknown for a scenario that is not a file.
FileKind kind_of_file(const TomlTable& at, const std::string& name) {
  return at.from_disk() ? kind_at(std::filesystem::path(at.file()).parent_path() / name) : FileKind{};
}

/// The text of the table that the key `file` names.
std::string table_text(const TomlTable& at, const std::string& name) {
  const FileKind kind = kind_of_file(at, name);
  if (kind.recording == RecordingKind::ulog)
    at.throw_invalid(
        "file", fmt::format("the key body beside {}: one of {}", kind.shown(), fmt::join(px4_motions, ", ")));
  if (kind.is_bag())
    at.throw_invalid("file", fmt::format("the key body beside {}: a topic or a name in it", kind.shown()));
  if (!kind.what.empty() && kind.recording != RecordingKind::table)
    at.throw_invalid("file", fmt::format("{}; this is {}", a_table, kind.shown()));
  try {
    return at.file_text(name);
  } catch (const ScenarioError& error) {
    at.throw_invalid("file", fmt::format("{} ({})", a_table, error.what()));
  }
}

/// The name of the text of a body, FILE.BODY.csv, with other characters than those of names as %2f.
std::string text_name(const std::string& file, std::string_view body) {
  std::string name = file + ".";
  for (const char c : body) {
    const bool plain =
        (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
    name += plain ? std::string(1, c) : fmt::format("%{:02x}", static_cast<unsigned char>(c));
  }
  return name + ".csv";
}

/// The motion of the key `body` in the recording that the key `file` names, as the text of a table.
std::string recording_text(const TomlTable& at, const std::string& name) {
  for (const std::string_view key : {"columns", "period"}) {
    if (at.has(key)) at.throw_invalid(key, "no such key beside body");
  }
  const std::string body = at.text("body", "a topic of the recording");
  if (body.empty() || body.size() > body_size_max)
    at.throw_invalid("body", fmt::format("a topic or a name of 1 to {} bytes", body_size_max));
  const bool of_px4 = std::find(px4_motions.begin(), px4_motions.end(), body) != px4_motions.end();
  if (!of_px4 && kind_of_file(at, name).recording == RecordingKind::ulog)
    at.throw_invalid("body", fmt::format("one of {}", fmt::join(px4_motions, ", ")));
  const auto read = [&](const std::filesystem::path& path) {
    const FileKind kind = kind_at(path);
    const bool bodies = kind.is_bag();
    if (!kind.what.empty() && !bodies && kind.recording != RecordingKind::ulog)
      throw_invalid("this is {}", kind.shown());
    const RecordedMotion motion = bodies ? RosBag(path).motion(body) : px4_motion(read_ulog(path), body);
    if (motion.empty()) throw_invalid("no valid sample of {}", body);
    return motion_text(motion);
  };
  try {
    return at.made_text(name, text_name(name, body), read);
  } catch (const std::exception& error) {
    at.throw_invalid("file", fmt::format("a log of PX4 (ULog), a bag of ROS 2 or the log of a run (MCAP), "
                                         "relative to this one ({})",
                                         error.what()));
  }
}

}  // namespace

const std::vector<double>* CsvColumns::find(std::string_view name) const {
  const auto found = std::find(names.begin(), names.end(), name);
  return found == names.end() ? nullptr : &values[static_cast<std::size_t>(found - names.begin())];
}

CsvColumns read_csv(std::string_view text, std::string_view file, std::vector<std::string> names) {
  CsvColumns columns;
  columns.names = std::move(names);
  for (std::string& one : columns.names) one = column_name(one);
  const bool named = !columns.names.empty();
  NumberTable table(std::string(file), text);
  std::size_t rows = 0;
  while (table.next_or_remark()) {
    const std::span<const std::string_view> entries = table.fields();
    const std::size_t line_number = table.line();
    const bool numbers = finite_number(entries.front()).has_value();
    if (table.is_remark() && (rows > 0 || named || numbers)) continue;
    if (rows == 0 && !numbers) {
      // Of several lines of names the last before the first row counts.
      if (!named) {
        columns.names.clear();
        for (const std::string_view entry : entries) columns.names.push_back(column_name(entry));
      }
      continue;
    }
    if (rows == 0) {
      if (columns.names.empty())
        throw ScenarioError(
            file, line_number,
            "no names of columns before the first row, expected a line such as t,x,y,z, or the key "
            "columns");
      check_column_names(columns.names, file, line_number);
      columns.values.resize(columns.names.size());
    }
    if (entries.size() != columns.names.size())
      throw ScenarioError(
          file, line_number,
          fmt::format("{} entries, expected {}, one for each column", entries.size(), columns.names.size()));
    if (++rows > csv_rows_max)
      throw ScenarioError(file, line_number,
                          fmt::format("more than {} rows, expected at most these", csv_rows_max));
    for (std::size_t i = 0; i < entries.size(); ++i) {
      if (columns.names[i] == unused) continue;
      const std::optional<double> value = finite_number(entries[i]);
      if (!value)
        throw ScenarioError(file, line_number,
                            fmt::format("{} = \"{}\", expected a number", shortened(columns.names[i], 40),
                                        shortened(entries[i], 40)));
      columns.values[i].push_back(*value);
    }
  }
  if (rows == 0) throw ScenarioError(file, table.line(), "no row of numbers, expected at least one");
  return columns;
}

std::string motion_text(const RecordedMotion& motion) {
  const bool has_heading = std::all_of(motion.begin(), motion.end(),
                                       [](const RecordedSample& one) { return std::isfinite(one.heading); });
  const bool has_velocity = std::all_of(motion.begin(), motion.end(), [](const RecordedSample& one) {
    return std::isfinite(one.v.x + one.v.y + one.v.z);
  });
  std::string text =
      fmt::format("t,x,y,z{}{}\n", has_heading ? ",heading" : "", has_velocity ? ",vx,vy,vz" : "");
  double last = -infinity;
  for (const RecordedSample& one : motion) {
    const double t = one.t - motion.front().t;
    if (t - last < rows_apart) continue;
    last = t;
    text += fmt::format("{:.4f},{:.4f},{:.4f},{:.4f}", t, one.p.x, one.p.y, one.p.z);
    if (has_heading) text += fmt::format(",{:.4f}", one.heading);
    if (has_velocity) text += fmt::format(",{:.4f},{:.4f},{:.4f}", one.v.x, one.v.y, one.v.z);
    text += '\n';
  }
  return text;
}

bool has_timed_lists(const PartText& part) {
  return std::any_of(part.parameters.begin(), part.parameters.end(),
                     [](const ParameterText& parameter) { return parameter.key == "times"; });
}

ListSource::ListSource(const TomlTable& at) : TableSource(at) {
  if (!at.has("file")) {
    for (const std::string_view key : beside_file) {
      if (at.has(key)) at.throw_invalid(key, "the key file beside it");
    }
    return;
  }
  const std::string name = at.text("file", a_table);
  file_ = (std::filesystem::path(at.file()).parent_path() / name).lexically_normal().native();
  std::vector<std::string> names;
  if (at.has("columns")) names = at.texts("columns", TomlTable::any_length, "names of columns in quotes");
  const std::string text = at.has("body") ? recording_text(at, name) : table_text(at, name);
  columns_ = read_csv(text, file_, std::move(names));
  for (const std::string_view key : {"times", "p", "heading", "v"}) {
    if (at.has(key)) at.throw_invalid(key, "no such key beside file, which gives it");
  }
  if (at.has("period")) {
    const double period = at.number("period", positive("> 0 s"));
    if (columns_->find("t") != nullptr) at.throw_invalid("period", "no such key beside a column t");
    columns_->names.emplace_back("t");
    std::vector<double>& t = columns_->values.emplace_back(column("x").size());
    for (std::size_t i = 0; i < t.size(); ++i) t[i] = static_cast<double>(i) * period;
  }
  const std::vector<double>* t = columns_->find("t");
  if (t == nullptr) return;  // rising() refuses it
  const double first = t->front();
  if (at.has("begin")) {
    const double begin = at.number("begin", any_number());
    for (double& time : columns_->values[static_cast<std::size_t>(t - columns_->values.data())])
      time += begin - first;
  } else if (std::fabs(first) > begin_most) {
    throw ScenarioError(
        file_, 1,
        fmt::format("t = {} s in the first row, expected at most {} s, or the key begin", first, begin_most));
  }
}

bool ListSource::is_of_file(std::string_view key) const {
  return columns_ && (key == "times" || key == "p" || key == "heading" || key == "v");
}

bool ListSource::has(std::string_view key) const {
  if (!is_of_file(key)) return TableSource::has(key);
  if (key == "heading") return columns_->find(key) != nullptr;
  if (key == "v") return columns_->find(of_velocity[0]) != nullptr;
  return true;
}

const std::vector<double>& ListSource::column(std::string_view name) const {
  const std::vector<double>* found = columns_->find(name);
  if (found == nullptr)
    throw ScenarioError(file_, 1,
                        fmt::format("no column \"{}\", expected the columns t, x, y, z{}", name,
                                    name == "t" ? ", or the key period" : ""));
  return *found;
}

std::vector<double> ListSource::rising(std::string_view key) const {
  if (!is_of_file(key)) return TableSource::rising(key);
  std::vector<double> times = column("t");
  for (std::size_t i = 1; i < times.size(); ++i) {
    if (!(times[i] > times[i - 1]))
      throw ScenarioError(file_, 1,
                          fmt::format("t = {} in row {} of numbers after {}, expected times that rise [s]",
                                      times[i], i + 1, times[i - 1]));
  }
  return times;
}

std::vector<double> ListSource::numbers(std::string_view key, std::size_t length, const Bounds& bounds,
                                        std::string_view unit) const {
  return is_of_file(key) ? column(key) : TableSource::numbers(key, length, bounds, unit);
}

std::vector<std::vector<double>> ListSource::rows(std::string_view key, std::size_t count,
                                                  std::size_t length) const {
  if (!is_of_file(key)) return TableSource::rows(key, count, length);
  const std::array<std::string_view, 3>& names = key == "v" ? of_velocity : of_place;
  const std::array<const std::vector<double>*, 3> of = {&column(names[0]), &column(names[1]),
                                                        &column(names[2])};
  std::vector<std::vector<double>> all(of[0]->size());
  for (std::size_t i = 0; i < all.size(); ++i) all[i] = {(*of[0])[i], (*of[1])[i], (*of[2])[i]};
  return all;
}

}  // namespace sightline
