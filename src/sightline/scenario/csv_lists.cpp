#include "sightline/scenario/csv_lists.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>

namespace sightline {
namespace {

constexpr std::string_view separators = ",; \t\r", unused = "-";
constexpr std::array<std::string_view, 3> beside_file = {"columns", "period", "begin"};
constexpr double begin_most = 1e5;  // beyond it the times are those of a clock [s]
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

/// The entries of a line; those between two commas may be empty.
std::vector<std::string_view> split(std::string_view line) {
  const bool spaced = line.find_first_of(",;") == std::string_view::npos;
  const auto trimmed = [](std::string_view entry) {
    const std::size_t begin = entry.find_first_not_of(" \t\r\"");
    if (begin == std::string_view::npos) return std::string_view();
    return entry.substr(begin, entry.find_last_not_of(" \t\r\"") - begin + 1);
  };
  std::vector<std::string_view> entries;
  for (std::size_t begin = 0; begin <= line.size();) {
    const std::size_t end = std::min(line.find_first_of(spaced ? separators : ",;", begin), line.size());
    const std::string_view entry = trimmed(line.substr(begin, end - begin));
    if (!spaced || !entry.empty()) entries.push_back(entry);
    begin = end + 1;
  }
  return entries;
}

std::optional<double> number(std::string_view entry) {
  if (entry.starts_with('+')) entry.remove_prefix(1);
  double value{};
  const auto [end, error] = std::from_chars(entry.data(), entry.data() + entry.size(), value);
  if (error != std::errc() || end != entry.data() + entry.size() || !std::isfinite(value)) return {};
  return value;
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

}  // namespace

const std::vector<double>* CsvColumns::find(std::string_view name) const {
  const auto found = std::find(names.begin(), names.end(), name);
  return found == names.end() ? nullptr : &values[static_cast<std::size_t>(found - names.begin())];
}

CsvColumns read_csv(std::string_view text, std::string_view file, std::vector<std::string> names) {
  CsvColumns columns;
  columns.names = std::move(names);
  const bool named = !columns.names.empty();
  std::size_t line_number = 0, rows = 0;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    ++line_number;
    if (line_number == 1 && line.starts_with("\xef\xbb\xbf")) line.remove_prefix(3);
    const bool remark = line.starts_with('#');
    if (remark) line.remove_prefix(1);
    const std::vector<std::string_view> entries = split(line);
    const bool empty =
        std::all_of(entries.begin(), entries.end(), [](std::string_view entry) { return entry.empty(); });
    const bool numbers = !empty && number(entries.front()).has_value();
    if (empty || (remark && (rows > 0 || named || numbers))) continue;
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
      const std::optional<double> value = number(entries[i]);
      if (!value)
        throw ScenarioError(file, line_number,
                            fmt::format("{} = \"{}\", expected a number", shortened(columns.names[i], 40),
                                        shortened(entries[i], 40)));
      columns.values[i].push_back(*value);
    }
  }
  if (rows == 0) throw ScenarioError(file, line_number, "no row of numbers, expected at least one");
  return columns;
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
  constexpr std::string_view expected = "a file of times and positions (CSV), relative to this one";
  const std::string name = at.text("file", expected);
  file_ = (std::filesystem::path(at.file()).parent_path() / name).lexically_normal().native();
  std::vector<std::string> names;
  if (at.has("columns")) names = at.texts("columns", TomlTable::any_length, "names of columns in quotes");
  for (std::string& one : names) one = column_name(one);
  std::string text;
  try {
    text = at.file_text(name);
  } catch (const ScenarioError& error) {
    at.throw_invalid("file", fmt::format("{} ({})", expected, error.what()));
  }
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
