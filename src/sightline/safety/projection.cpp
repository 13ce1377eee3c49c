#include "sightline/safety/projection.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "sightline/base.hpp"

namespace sightline {
namespace {

constexpr int most_variables = most_inputs + 1;  // the inputs and the slack
constexpr int most_conditions = padded(most_half_spaces) + padded(2 * most_inputs);
constexpr double dependent = 1e-9;  // a unit normal with a shorter remainder depends on the set
constexpr int most_steps = 400;
constexpr double hard_tolerance = 1e-9;  // accuracy of the least violation of the hard rows

using Vector = std::array<double, most_variables>;

double dot(const Vector& a, const Vector& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < most_variables; ++i) sum += a[i] * b[i];
  return sum;
}

/// min |x - x_nom|^2 under conditions n_i . x >= e_i with |n_i| = 1.
class ActiveSet {
 public:
  void add(const Vector& normal, double e) {
    const std::size_t i = count_++;
    for (std::size_t k = 0; k < most_variables; ++k) normal_[k][i] = normal[k];
    offset_[i] = e;
  }

  /// Scales the added conditions to unit normals.
  void normalise() {
    fill();
    const Pack zero(0.0);
    for (std::size_t i = 0; i < count_; i += width) {
      Pack square = zero;
      for (const auto& column : normal_) {
        const Pack n = Pack::load(&column[i]);
        square += n * n;
      }
      const Pack length = sqrt(square), e = Pack::load(&offset_[i]);
      for (auto& column : normal_)
        where_negative(-length, Pack::load(&column[i]) / length, zero).store(&column[i]);
      // A condition with a zero normal is either always kept, or never.
      where_negative(-length, e / length, Pack(-infinity)).store(&offset_[i]);
      impossible_ = impossible_ || any_negative(where_negative(-length, zero, -e));
    }
  }

  /// Fills the last pack with conditions that always hold.
  void fill() {
    for (; count_ % width != 0; ++count_) {
      for (auto& column : normal_) column[count_] = 0.0;
      offset_[count_] = -infinity;
    }
  }

  /// @return false if no x satisfies all conditions
  bool solve(Vector& x) {
    if (impossible_) return false;
    for (; steps < most_steps;) {
      const int entering = most_violated(x);
      if (entering < 0) return true;
      if (!take_in(entering, x)) return false;
    }
    return true;
  }

  int steps = 0;

 private:
  using Pack = NativeLane;
  static constexpr auto width = static_cast<std::size_t>(Pack::width);

  Vector normal(int i) const {
    Vector n;
    for (std::size_t k = 0; k < most_variables; ++k) n[k] = normal_[k][static_cast<std::size_t>(i)];
    return n;
  }

  /// The first condition with the least n . x - e, or -1 if all are within the tolerance.
  int most_violated(const Vector& x) const {
    alignas(row_alignment) std::array<double, most_conditions> gap;
    Pack least(-projection_tolerance);
    for (std::size_t i = 0; i < count_; i += width) {
      Pack sum = -Pack::load(&offset_[i]);
      for (std::size_t k = 0; k < most_variables; ++k) sum += Pack::load(&normal_[k][i]) * Pack(x[k]);
      sum.store(&gap[i]);
      least = minimum(sum, least);
    }
    if (!any_negative(least + Pack(projection_tolerance))) return -1;
    double most = least[0];
    for (int lane = 1; lane < Pack::width; ++lane) most = minimum(least[lane], most);
    return static_cast<int>(std::find(gap.begin(), gap.begin() + count_, most) - gap.begin());
  }

  /// Moves x until the condition is kept, and removes blocking ones; r and z are the parts of its
  /// normal within and orthogonal to the span of the set.
  bool take_in(int entering, Vector& x) {
    const Vector n = normal(entering);
    double multiplier = 0.0;
    for (; steps < most_steps; ++steps) {
      Vector r{}, z = n;
      split(r, z);
      const double reach = dot(z, z);
      const double missing = offset_[static_cast<std::size_t>(entering)] - dot(n, x);
      const double whole = reach > dependent * dependent ? std::max(missing, 0.0) / reach : infinity;
      int leaving = -1;
      double step = whole;
      for (int j = 0; j < size_; ++j) {
        const auto q = static_cast<std::size_t>(j);
        if (r[q] <= 0 || multiplier_[q] >= step * r[q]) continue;
        step = multiplier_[q] / r[q];
        leaving = j;
      }
      if (step == infinity) return false;
      if (whole < infinity) {
        for (std::size_t k = 0; k < most_variables; ++k) x[k] += step * z[k];
      }
      for (int j = 0; j < size_; ++j)
        multiplier_[static_cast<std::size_t>(j)] -= step * r[static_cast<std::size_t>(j)];
      multiplier += step;
      if (leaving >= 0) {
        drop(leaving);
        continue;
      }
      ++steps;
      push(entering, multiplier, z, reach);
      return true;
    }
    return true;
  }

  /// Removes from z its part in the span of the set, twice because of rounding; r are the
  /// coefficients of that part.
  void split(Vector& r, Vector& z) const {
    Vector part{};
    for (int round = 0; round < 2; ++round) {
      for (std::size_t j = 0; j < static_cast<std::size_t>(size_); ++j) {
        const double along = dot(basis_[j], z);
        part[j] += along;
        for (std::size_t k = 0; k < most_variables; ++k) z[k] -= along * basis_[j][k];
      }
    }
    for (int j = size_ - 1; j >= 0; --j) {
      const auto row = static_cast<std::size_t>(j);
      double sum = part[row];
      for (std::size_t k = row + 1; k < static_cast<std::size_t>(size_); ++k) sum -= triangle_[k][row] * r[k];
      r[row] = sum / triangle_[row][row];
    }
  }

  /// Adds a condition. The set's normals are the product of basis_ and the triangle, column by
  /// column.
  void push(int entering, double multiplier, const Vector& z, double reach) {
    const auto at = static_cast<std::size_t>(size_++);
    const Vector n = normal(entering);
    for (std::size_t j = 0; j < at; ++j) triangle_[at][j] = dot(basis_[j], n);
    triangle_[at][at] = std::sqrt(reach);
    for (std::size_t k = 0; k < most_variables; ++k) basis_[at][k] = z[k] / triangle_[at][at];
    member_[at] = entering;
    multiplier_[at] = multiplier;
  }

  void drop(int leaving) {
    const int old_size = size_;
    const auto members = member_;
    const auto multipliers = multiplier_;
    size_ = leaving;
    for (int j = leaving + 1; j < old_size; ++j) {
      const auto q = static_cast<std::size_t>(j);
      Vector r{}, z = normal(members[q]);
      split(r, z);
      push(members[q], multipliers[q], z, dot(z, z));
    }
  }

  alignas(row_alignment) std::array<std::array<double, most_conditions>, most_variables> normal_;
  alignas(row_alignment) std::array<double, most_conditions> offset_;
  std::size_t count_ = 0;
  bool impossible_ = false;

  int size_ = 0;
  std::array<int, most_variables> member_{};
  Vector multiplier_{};
  std::array<Vector, most_variables> basis_{}, triangle_{};
};

constexpr double slack_part = 1e-4;  // 1 / sqrt(slack_weight): coefficient of the slack in a row
static_assert(slack_part * slack_part * slack_weight == 1.0);

/// Solves for u under the limits and the rows that count; those of `missable` have the slack.
template <class Counts, class Missable>
bool solve(std::span<const HalfSpace> rows, std::span<const double> u_min, std::span<const double> u_max,
           Counts counts, Missable missable, std::span<double> u, int& steps) noexcept {
  ActiveSet set;
  Vector x{};
  for (const HalfSpace& row : rows) {
    if (counts(row))
      set.add({row.a[0], row.a[1], row.a[2], row.a[3], missable(row) ? slack_part : 0.0}, row.b);
  }
  set.normalise();
  for (std::size_t i = 0; i < u.size(); ++i) {
    x[i] = u[i];
    Vector low{}, high{};
    low[i] = 1.0;
    high[i] = -1.0;
    set.add(low, u_min[i]);
    set.add(high, -u_max[i]);
  }
  set.fill();
  const bool feasible = set.solve(x);
  steps += set.steps;
  for (std::size_t i = 0; i < u.size(); ++i) u[i] = std::clamp(x[i], u_min[i], u_max[i]);
  return feasible;
}

double largest_violation(std::span<const HalfSpace> rows, std::span<const double> u, bool hard_alone) {
  double most = 0.0;
  for (const HalfSpace& row : rows) {
    if (hard_alone && !row.hard) continue;
    double value = 0.0;
    for (std::size_t i = 0; i < u.size(); ++i) value += row.a[i] * u[i];
    most = std::max(most, row.b - value);
  }
  return most;
}

}  // namespace

ProjectionResult project(std::span<const HalfSpace> rows, std::span<const double> u_min,
                         std::span<const double> u_max, std::span<double> u) noexcept {
  assert(u.size() <= most_inputs && "a command has at most most_inputs inputs");
  assert(rows.size() <= most_half_spaces && "the rows fit the arrays");
  constexpr auto all = [](const HalfSpace&) { return true; };
  constexpr auto none = [](const HalfSpace&) { return false; };
  constexpr auto hard = [](const HalfSpace& row) { return row.hard; };
  constexpr auto soft = [](const HalfSpace& row) { return !row.hard; };
  std::array<double, most_inputs> nominal{};
  std::copy(u.begin(), u.end(), nominal.begin());
  ProjectionResult result;
  result.feasible = solve(rows, u_min, u_max, all, none, u, result.steps);
  if (result.feasible) return result;

  const auto again = [&](std::span<const HalfSpace> of, auto counts, auto missable) {
    std::copy_n(nominal.begin(), u.size(), u.begin());
    return solve(of, u_min, u_max, counts, missable, u, result.steps);
  };
  if (!again(rows, all, soft)) {
    again(rows, hard, hard);
    const double missed = largest_violation(rows, u, true);
    std::array<double, most_inputs> least{};
    std::copy(u.begin(), u.end(), least.begin());
    std::array<HalfSpace, most_half_spaces> left;
    std::copy(rows.begin(), rows.end(), left.begin());
    for (HalfSpace& row : left) row.b -= row.hard ? missed + hard_tolerance : 0.0;
    if (!again(std::span(left).first(rows.size()), all, soft))
      std::copy_n(least.begin(), u.size(), u.begin());
  }
  result.violation = largest_violation(rows, u, false);
  return result;
}

}  // namespace sightline
