#include "sightline/estimate/observability.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sightline/base.hpp"

namespace sightline {
namespace {

constexpr double zero_entry = 1e-9;  // for rows of length about 1

using Row = std::vector<double>;

/// Rows in reduced echelon form; each row is reduced when it is added.
class Echelon {
 public:
  explicit Echelon(std::size_t columns) : columns_(columns) {}

  void add(Row row) {
    for (std::size_t r = 0; r < rows_.size(); ++r) subtract(row, rows_[r], row[pivots_[r]]);
    std::size_t pivot = 0;
    for (std::size_t c = 1; c < columns_; ++c)
      if (std::abs(row[c]) > std::abs(row[pivot])) pivot = c;
    if (!(std::abs(row[pivot]) > zero_entry)) return;
    const double by = row[pivot];
    for (double& entry : row) entry /= by;
    for (Row& earlier : rows_) subtract(earlier, row, earlier[pivot]);
    rows_.push_back(std::move(row));
    pivots_.push_back(pivot);
  }

  /// Basis of the null space of all rows.
  std::vector<Row> null_space() const {
    std::vector<Row> basis;
    for (std::size_t c = 0; c < columns_; ++c) {
      if (std::find(pivots_.begin(), pivots_.end(), c) != pivots_.end()) continue;
      Row& free = basis.emplace_back(columns_);
      free[c] = 1.0;
      for (std::size_t r = 0; r < rows_.size(); ++r) free[pivots_[r]] = -rows_[r][c];
    }
    return basis;
  }

 private:
  static void subtract(Row& from, const Row& row, double share) {
    if (share == 0.0) return;
    for (std::size_t c = 0; c < from.size(); ++c) from[c] -= share * row[c];
  }

  std::size_t columns_;
  std::vector<Row> rows_;
  std::vector<std::size_t> pivots_;
};

}  // namespace

std::vector<Unobservable> unobservable_states(const std::vector<SensingRobot>& robots,
                                              const std::vector<PlacedRobot>& places,
                                              const std::vector<Sees>& sightings) {
  if (places.size() != robots.size())
    throw_invalid("{} places of {} robots, expected one of each", places.size(), robots.size());
  const std::size_t columns = 4 * robots.size();
  Echelon rows(columns);
  const auto one = [&](std::size_t robot, std::size_t state) {
    Row row(columns);
    row[4 * robot + state] = 1.0;
    return row;
  };
  for (std::size_t i = 0; i < robots.size(); ++i) {
    for (std::size_t k = 0; k < 3 && robots[i].position; ++k) rows.add(one(i, k));
    if (robots[i].heading) rows.add(one(i, 3));
  }
  for (const Sees& sees : sightings) {
    const int n = static_cast<int>(robots.size());
    if (sees.observer < 0 || sees.observer >= n || sees.target < 0 || sees.target >= n ||
        sees.observer == sees.target)
      throw_invalid("robot {} sees robot {}, expected two of {} robots", sees.observer, sees.target, n);
    const std::size_t i = size(sees.observer), j = size(sees.target);
    const SinCos<double> h = sincos(places[i].heading);
    const double dx = places[j].x - places[i].x, dy = places[j].y - places[i].y;
    // R^T (p_j - p_i) = (along, across, up); its derivative by the heading is (across, -along, 0).
    const double along = h.cos * dx + h.sin * dy, across = h.cos * dy - h.sin * dx;
    const double R[3][3] = {{h.cos, h.sin, 0}, {-h.sin, h.cos, 0}, {0, 0, 1}};
    const double turn[3] = {across, -along, 0};
    for (std::size_t k = 0; k < 3; ++k) {
      Row row(columns);
      for (std::size_t m = 0; m < 3; ++m) {
        row[4 * j + m] = R[k][m];
        row[4 * i + m] = -R[k][m];
      }
      row[4 * i + 3] = turn[k];
      rows.add(std::move(row));
    }
    if (!sees.yaw) continue;
    Row row = one(j, 3);
    row[4 * i + 3] = -1.0;
    rows.add(std::move(row));
  }

  const std::vector<Row> free = rows.null_space();
  std::vector<Unobservable> all;
  for (std::size_t i = 0; i < robots.size(); ++i) {
    const auto moves = [&](std::size_t robot, std::size_t state) {
      return std::any_of(free.begin(), free.end(),
                         [&](const Row& row) { return std::abs(row[4 * robot + state]) > 1e-6; });
    };
    Unobservable what{.robot = static_cast<int>(i),
                      .heading = moves(i, 3),
                      .horizontal = moves(i, 0) || moves(i, 1),
                      .height = moves(i, 2)};
    if (!what.heading && !what.horizontal && !what.height) continue;
    // An observed body with known position leaves the rotation about it undetermined.
    for (const Sees& sees : sightings) {
      const std::size_t j = size(sees.target);
      const bool known = !moves(j, 0) && !moves(j, 1) && !moves(j, 2);
      if (sees.observer == what.robot && known && what.about < 0) what.about = sees.target;
    }
    all.push_back(what);
  }
  return all;
}

std::string to_string(const Unobservable& what, const std::vector<SensingRobot>& robots) {
  const std::string& name = robots[size(what.robot)].name;
  if (what.about >= 0) {
    return fmt::format(
        "the heading of {0} is unobservable{2}: a turn about {1} changes nothing that is measured, expected "
        "a "
        "heading that is measured, by tags or a compass",
        name, robots[size(what.about)].name,
        what.horizontal ? ", and with it its position in the plane" : "");
  }
  const std::string_view of = what.horizontal && what.heading  ? "position and heading"
                              : what.horizontal || what.height ? "position"
                                                               : "heading";
  return fmt::format(
      "the {} of {} {} unobservable: no path of views leads from it to a body that knows its place, expected "
      "one",
      of, name, what.horizontal && what.heading ? "are" : "is");
}

}  // namespace sightline
