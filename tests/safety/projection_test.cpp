#include "sightline/safety/projection.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "tests/support/random.hpp"

namespace sightline {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

struct Problem {
  std::vector<HalfSpace> rows;
  std::vector<double> u_min, u_max, nominal;

  std::size_t nu() const { return nominal.size(); }
};

/// All conditions n . x >= e of a problem, rows first; with a slack it is the last variable.
struct Conditions {
  MatrixXd normals;
  VectorXd offsets, nominal;
};

Conditions conditions(const Problem& p, bool slack) {
  const auto nu = static_cast<Eigen::Index>(p.nu()), m = static_cast<Eigen::Index>(p.rows.size());
  const Eigen::Index n = nu + (slack ? 1 : 0);
  Conditions c{MatrixXd::Zero(m + 2 * nu, n), VectorXd::Zero(m + 2 * nu), VectorXd::Zero(n)};
  for (Eigen::Index i = 0; i < m; ++i) {
    const HalfSpace& row = p.rows[static_cast<std::size_t>(i)];
    for (Eigen::Index k = 0; k < nu; ++k) c.normals(i, k) = row.a[static_cast<std::size_t>(k)];
    if (slack) c.normals(i, nu) = 1.0 / std::sqrt(slack_weight);
    c.offsets(i) = row.b;
  }
  for (Eigen::Index k = 0; k < nu; ++k) {
    const auto q = static_cast<std::size_t>(k);
    c.normals(m + 2 * k, k) = 1.0;
    c.offsets(m + 2 * k) = p.u_min[q];
    c.normals(m + 2 * k + 1, k) = -1.0;
    c.offsets(m + 2 * k + 1) = -p.u_max[q];
    c.nominal(k) = p.nominal[q];
  }
  for (Eigen::Index i = 0; i < c.offsets.size(); ++i) {
    const double length = c.normals.row(i).norm();
    if (length > 0) c.normals.row(i) /= length, c.offsets(i) /= length;
  }
  return c;
}

struct Best {
  bool found = false;
  double distance = std::numeric_limits<double>::infinity();
  VectorXd x;
};

/// The nearest point among those that keep all conditions and are nearest on some set of at most n
/// of them.
class Enumeration {
 public:
  explicit Enumeration(const Conditions& c) : c_(c) { visit({}, 0); }
  Best best() const { return best_; }

 private:
  void visit(std::vector<Eigen::Index> set, Eigen::Index from) {
    consider(set);
    if (static_cast<Eigen::Index>(set.size()) == c_.nominal.size()) return;
    for (Eigen::Index i = from; i < c_.offsets.size(); ++i) {
      set.push_back(i);
      visit(set, i + 1);
      set.pop_back();
    }
  }

  void consider(const std::vector<Eigen::Index>& set) {
    const auto size = static_cast<Eigen::Index>(set.size());
    VectorXd x = c_.nominal;
    if (size > 0) {
      MatrixXd A(size, c_.nominal.size());
      VectorXd e(size);
      for (Eigen::Index j = 0; j < size; ++j) {
        A.row(j) = c_.normals.row(set[static_cast<std::size_t>(j)]);
        e(j) = c_.offsets(set[static_cast<std::size_t>(j)]);
      }
      const Eigen::CompleteOrthogonalDecomposition<MatrixXd> factors(A);
      if (factors.rank() < size) return;
      for (int round = 0; round < 3; ++round) x += factors.solve(e - A * x);
    }
    constexpr double kept = 1e-9;
    for (Eigen::Index i = 0; i < c_.offsets.size(); ++i) {
      if (c_.normals.row(i).dot(x) - c_.offsets(i) < -kept) return;
    }
    const double distance = (x - c_.nominal).squaredNorm();
    if (distance < best_.distance) best_ = {true, distance, x};
  }

  const Conditions& c_;
  Best best_;
};

/// Rows of many kinds: any, parallel, opposed, repeated, of limits, through one point, without
/// influence.
Problem random_problem(Random& random, std::size_t nu, std::size_t m) {
  Problem p;
  for (std::size_t i = 0; i < nu; ++i) {
    const double a = uniform(random, -1, 1), b = uniform(random, -1, 1);
    p.u_min.push_back(random() % 4 == 0 ? std::min(a, b) : -1.0);
    p.u_max.push_back(random() % 4 == 0 ? std::max(a, b) : 1.0);
    p.u_max.back() = std::max(p.u_min.back(), p.u_max.back());
    p.nominal.push_back(random() % 5 == 0 ? (random() % 2 == 0 ? 1.0 : -1.0) : uniform(random, -1, 1));
  }
  const double scale = random() % 2 == 0 ? 1.0 : 0.03;
  for (std::size_t j = 0; j < m; ++j) {
    HalfSpace row;
    const auto kind = random() % 8;
    for (std::size_t i = 0; i < nu; ++i) row.a[i] = scale * uniform(random, -1.5, 1.5);
    row.b = scale * uniform(random, -1.1, 0.5);
    if (kind == 0 && j > 0) {
      row.a = p.rows[j - 1].a;
      if (random() % 2 == 0) row.b = p.rows[j - 1].b;
    }
    if (kind == 1 && j > 0) {
      for (std::size_t i = 0; i < nu; ++i) row.a[i] = -p.rows[j - 1].a[i];
    }
    if (kind == 2) {
      row.a = {};
      row.a[random() % nu] = scale;
    }
    if (kind == 3) {  // through a corner of the limits
      row.b = 0;
      for (std::size_t i = 0; i < nu; ++i) row.b += row.a[i] * (random() % 2 == 0 ? p.u_min[i] : p.u_max[i]);
    }
    if (kind == 4 && random() % 4 == 0) row.a = {};
    p.rows.push_back(row);
  }
  return p;
}

double violation(const Problem& p, std::span<const double> u) {
  double worst = 0.0;
  for (const HalfSpace& row : p.rows) {
    double value = 0.0;
    for (std::size_t i = 0; i < p.nu(); ++i) value += row.a[i] * u[i];
    worst = std::max(worst, row.b - value);
  }
  return worst;
}

double distance(const Problem& p, std::span<const double> u) {
  double sum = 0.0;
  for (std::size_t i = 0; i < p.nu(); ++i) sum += (u[i] - p.nominal[i]) * (u[i] - p.nominal[i]);
  return sum;
}

void expect_optimal(const Problem& p, int& feasible, int& infeasible) {
  std::vector<double> u = p.nominal;
  const ProjectionResult result = project(p.rows, p.u_min, p.u_max, u);
  EXPECT_LT(result.steps, 100);
  for (std::size_t i = 0; i < p.nu(); ++i) {
    EXPECT_GE(u[i], p.u_min[i]);
    EXPECT_LE(u[i], p.u_max[i]);
  }
  const Best hard = Enumeration(conditions(p, false)).best();
  ASSERT_EQ(result.feasible, hard.found);
  if (hard.found) {
    ++feasible;
    EXPECT_LE(violation(p, u), 1e-9);
    EXPECT_NEAR(distance(p, u), hard.distance, 1e-7);
    for (std::size_t i = 0; i < p.nu(); ++i) EXPECT_NEAR(u[i], hard.x(static_cast<Eigen::Index>(i)), 1e-6);
    return;
  }
  ++infeasible;
  const Best soft = Enumeration(conditions(p, true)).best();
  ASSERT_TRUE(soft.found);
  EXPECT_NEAR(result.violation, violation(p, u), 1e-12);
  const double least = soft.x(static_cast<Eigen::Index>(p.nu())) / std::sqrt(slack_weight);
  EXPECT_NEAR(result.violation, least, 1e-9);
  for (std::size_t i = 0; i < p.nu(); ++i) EXPECT_NEAR(u[i], soft.x(static_cast<Eigen::Index>(i)), 1e-4);
}

TEST(Projection, IsTheBestOfAllActiveSetsAndSeesWhatCannotBeKept) {
  Random random(1);
  int feasible = 0, infeasible = 0;
  for (int k = 0; k < 20000 && !HasFailure(); ++k) {
    const std::size_t nu = 1 + random() % 4;
    const std::size_t m = nu == 4 ? random() % 4 : random() % 7;
    expect_optimal(random_problem(random, nu, m), feasible, infeasible);
  }
  EXPECT_GT(feasible, 5000);
  EXPECT_GT(infeasible, 2000);
}

TEST(Projection, IsTheBestOfAllActiveSetsAmongSixteenRows) {
  Random random(2);
  int feasible = 0, infeasible = 0;
  for (int k = 0; k < 40 && !HasFailure(); ++k) {
    Problem p = random_problem(random, 3, 16);
    if (k % 2 == 0) {
      for (HalfSpace& row : p.rows) row.b -= 1.0 * std::abs(row.a[0] + row.a[1] + row.a[2]);
    }
    expect_optimal(p, feasible, infeasible);
  }
  EXPECT_GT(feasible, 1);
  EXPECT_GT(infeasible, 3);
}

// The optimum is known where the rows are made to hold there and to push against the step that led
// there.
TEST(Projection, FindsTheOptimumThatTheRowsWereMadeFor) {
  Random random(3);
  for (int k = 0; k < 30000 && !HasFailure(); ++k) {
    constexpr std::size_t nu = 4, m = 16;
    Problem p{.rows = {}, .u_min = std::vector(nu, -1.0), .u_max = std::vector(nu, 1.0), .nominal = {}};
    const auto optimum = uniform_array<nu>(random, -0.95, 0.95);
    auto nominal = optimum;
    const std::size_t binding = random() % 8;
    for (std::size_t j = 0; j < m; ++j) {
      HalfSpace row{.a = uniform_array<nu>(random, -1.0, 1.0), .b = 0.0};
      for (std::size_t i = 0; i < nu; ++i) row.b += row.a[i] * optimum[i];
      const double multiplier = uniform(random, 0.0, 0.5);
      if (j < binding) {
        for (std::size_t i = 0; i < nu; ++i) nominal[i] -= multiplier * row.a[i];
      } else {
        row.b -= uniform(random, 0.0, 1.0);
      }
      p.rows.push_back(row);
    }
    p.nominal.assign(nominal.begin(), nominal.end());
    std::vector<double> u = p.nominal;
    EXPECT_TRUE(project(p.rows, p.u_min, p.u_max, u).feasible);
    for (std::size_t i = 0; i < nu; ++i) EXPECT_NEAR(u[i], optimum[i], 1e-5);
  }
}

TEST(Projection, LeavesACommandAloneThatKeepsAll) {
  Random random(4);
  for (int k = 0; k < 1000; ++k) {
    Problem p = random_problem(random, 4, 8);
    for (std::size_t i = 0; i < 4; ++i) p.nominal[i] = std::clamp(p.nominal[i], p.u_min[i], p.u_max[i]);
    for (HalfSpace& row : p.rows) {
      double value = 0.0;
      for (std::size_t i = 0; i < 4; ++i) value += row.a[i] * p.nominal[i];
      row.b = std::min(row.b, value);
    }
    std::vector<double> u = p.nominal;
    EXPECT_TRUE(project(p.rows, p.u_min, p.u_max, u).feasible);
    EXPECT_EQ(u, p.nominal);
  }
}

TEST(Projection, DividesAConflictEvenly) {
  const std::vector<HalfSpace> rows = {{.a = {1, 0, 0, 0}, .b = 0.5}, {.a = {-1, 0, 0, 0}, .b = 0.1}};
  std::vector<double> u = {0.9, 0.3}, low = {-1, -1}, high = {1, 1};
  const ProjectionResult result = project(rows, low, high, u);
  EXPECT_FALSE(result.feasible);
  EXPECT_NEAR(result.violation, 0.3, 1e-6);
  EXPECT_NEAR(u[0], 0.2, 1e-6);
  EXPECT_NEAR(u[1], 0.3, 1e-9);
}

/// The largest violation of the rows of one priority.
double violation_of(const Problem& p, std::span<const double> u, bool hard) {
  Problem part = p;
  std::erase_if(part.rows, [&](const HalfSpace& row) { return row.hard != hard; });
  return violation(part, u);
}

TEST(Projection, NeverTradesAHardRowForOneThatIsNot) {
  Random random(4);
  int contradicted = 0, hard_alone = 0;
  for (int k = 0; k < 20000; ++k) {
    const std::size_t nu = 1 + random() % 4;
    Problem p = random_problem(random, nu, 2 + random() % 8);
    for (std::size_t i = 0; i < 1 + random() % 2; ++i) p.rows[i].hard = true;
    std::vector<double> u = p.nominal;
    if (project(p.rows, p.u_min, p.u_max, u).feasible) continue;
    ++contradicted;
    Problem walls = p;
    std::erase_if(walls.rows, [](const HalfSpace& row) { return !row.hard; });
    std::vector<double> alone = p.nominal;
    const ProjectionResult least = project(walls.rows, p.u_min, p.u_max, alone);
    hard_alone += !least.feasible;
    EXPECT_LE(violation_of(p, u, true), least.violation + 2e-9);
    // What is left to the others is theirs: no command that keeps the hard rows as well misses them
    // by less.
    const double missed = violation_of(p, u, false);
    for (int i = 0; i < 20; ++i) {
      std::vector<double> other = u;
      for (std::size_t j = 0; j < nu; ++j)
        other[j] = std::clamp(u[j] + uniform(random, -0.1, 0.1), p.u_min[j], p.u_max[j]);
      if (violation_of(p, other, true) > least.violation) continue;
      EXPECT_GE(violation_of(p, other, false), missed - 1e-5);
    }
  }
  EXPECT_GT(contradicted, 5000);
  EXPECT_GT(hard_alone, 1000);
}

}  // namespace
}  // namespace sightline
