/// Small matrices of a fixed size: covariances, gains and rotations of filters. Nothing allocates.
#pragma once

#include <array>
#include <cstddef>
#include <limits>

#include "sightline/base/fixed.hpp"

namespace sightline {

/// r x c numbers, row by row; initially 0.
template <int r, int c>
struct Mat {
  static_assert(r > 0 && c > 0);
  static constexpr int rows = r, columns = c;

  std::array<std::array<double, static_cast<std::size_t>(c)>, static_cast<std::size_t>(r)> row{};

  double& operator()(int i, int j) noexcept {
    return row[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
  }
  double operator()(int i, int j) const noexcept {
    return row[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
  }

  friend Mat operator+(Mat a, const Mat& b) noexcept { return a += b; }
  friend Mat operator-(Mat a, const Mat& b) noexcept {
    for (int i = 0; i < r; ++i)
      for (int j = 0; j < c; ++j) a(i, j) -= b(i, j);
    return a;
  }
  friend Mat operator*(double s, Mat a) noexcept {
    for (int i = 0; i < r; ++i)
      for (int j = 0; j < c; ++j) a(i, j) *= s;
    return a;
  }
  Mat& operator+=(const Mat& b) noexcept {
    for (int i = 0; i < r; ++i)
      for (int j = 0; j < c; ++j) (*this)(i, j) += b(i, j);
    return *this;
  }
  bool operator==(const Mat&) const = default;
};

/// Each sum runs over the rows of b in their order, for any size.
template <int r, int k, int c>
Mat<r, c> operator*(const Mat<r, k>& a, const Mat<k, c>& b) noexcept {
  Mat<r, c> y;
  for (int i = 0; i < r; ++i) {
    std::array<double, static_cast<std::size_t>(c)> sum{};  // a row that fits in registers
    for (int l = 0; l < k; ++l)
      for (int j = 0; j < c; ++j) sum[static_cast<std::size_t>(j)] += a(i, l) * b(l, j);
    y.row[static_cast<std::size_t>(i)] = sum;
  }
  return y;
}

template <int r, int c>
Mat<c, r> transposed(const Mat<r, c>& a) noexcept {
  Mat<c, r> y;
  for (int i = 0; i < r; ++i)
    for (int j = 0; j < c; ++j) y(j, i) = a(i, j);
  return y;
}

template <int n>
Mat<n, n> identity(double scale = 1.0) noexcept {
  Mat<n, n> y;
  for (int i = 0; i < n; ++i) y(i, i) = scale;
  return y;
}

template <int n>
double trace(const Mat<n, n>& a) noexcept {
  double sum = 0.0;
  for (int i = 0; i < n; ++i) sum += a(i, i);
  return sum;
}

/// The h x w block whose first entry is (i, j).
template <int h, int w, int r, int c>
Mat<h, w> block(const Mat<r, c>& a, int i, int j) noexcept {
  Mat<h, w> y;
  for (int k = 0; k < h; ++k)
    for (int l = 0; l < w; ++l) y(k, l) = a(i + k, j + l);
  return y;
}
template <int h, int w, int r, int c>
void set_block(Mat<r, c>& a, int i, int j, const Mat<h, w>& b) noexcept {
  for (int k = 0; k < h; ++k)
    for (int l = 0; l < w; ++l) a(i + k, j + l) = b(k, l);
}
/// Sets the same block, and its transpose at (j, i), of a symmetric matrix.
template <int h, int w, int n>
void set_both(Mat<n, n>& a, int i, int j, const Mat<h, w>& b) noexcept {
  set_block(a, i, j, b);
  set_block(a, j, i, transposed(b));
}

/// a <- (a + a^T) / 2.
template <int n>
void make_symmetric(Mat<n, n>& a) noexcept {
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < i; ++j) a(i, j) = a(j, i) = 0.5 * (a(i, j) + a(j, i));
}

template <int n>
using Column = Mat<n, 1>;

inline Column<3> column(const Vec3<double>& v) noexcept { return {{{{v.x}, {v.y}, {v.z}}}}; }
template <int n>
Vec3<double> vec3(const Column<n>& a, int from = 0) noexcept {
  return {a(from, 0), a(from + 1, 0), a(from + 2, 0)};
}
inline Vec3<double> operator*(const Mat<3, 3>& a, const Vec3<double>& v) noexcept {
  return {a(0, 0) * v.x + a(0, 1) * v.y + a(0, 2) * v.z, a(1, 0) * v.x + a(1, 1) * v.y + a(1, 2) * v.z,
          a(2, 0) * v.x + a(2, 1) * v.y + a(2, 2) * v.z};
}
/// a b^T.
inline Mat<3, 3> outer(const Vec3<double>& a, const Vec3<double>& b) noexcept {
  return {{{{a.x * b.x, a.x * b.y, a.x * b.z},
            {a.y * b.x, a.y * b.y, a.y * b.z},
            {a.z * b.x, a.z * b.y, a.z * b.z}}}};
}

/// Factor A = L L^T of a symmetric positive definite matrix. For any other matrix, or one that is
/// not finite, `positive` is false and solve() must not be called.
template <int n>
class Cholesky {
 public:
  explicit Cholesky(const Mat<n, n>& A) noexcept {
    for (int i = 0; i < n && positive; ++i) {
      for (int j = 0; j <= i; ++j) {
        double sum = A(i, j);
        for (int k = 0; k < j; ++k) sum -= L(i, k) * L(j, k);
        if (j < i) {
          L(i, j) = sum / L(j, j);
        } else {
          positive = sum > 0 && sum < 1e300;
          L(i, i) = positive ? sqrt(sum) : 1.0;
        }
      }
    }
  }

  /// L^-1 B.
  template <int c>
  Mat<n, c> forward(Mat<n, c> B) const noexcept {
    for (int i = 0; i < n; ++i) {
      for (int k = 0; k < i; ++k)
        for (int j = 0; j < c; ++j) B(i, j) -= L(i, k) * B(k, j);
      for (int j = 0; j < c; ++j) B(i, j) /= L(i, i);
    }
    return B;
  }
  /// A^-1 B.
  template <int c>
  Mat<n, c> solve(const Mat<n, c>& B) const noexcept {
    Mat<n, c> y = forward(B);
    for (int i = n - 1; i >= 0; --i) {
      for (int k = i + 1; k < n; ++k)
        for (int j = 0; j < c; ++j) y(i, j) -= L(k, i) * y(k, j);
      for (int j = 0; j < c; ++j) y(i, j) /= L(i, i);
    }
    return y;
  }

  Mat<n, n> L;
  bool positive = true;
};

/// The upper triangle of a symmetric matrix, row by row from the diagonal on.
template <int n>
std::array<double, static_cast<std::size_t>(n*(n + 1) / 2)> upper_triangle(const Mat<n, n>& A) noexcept {
  std::array<double, static_cast<std::size_t>(n * (n + 1) / 2)> all{};
  std::size_t place = 0;
  for (int i = 0; i < n; ++i)
    for (int j = i; j < n; ++j) all[place++] = A(i, j);
  return all;
}

/// e^T A^-1 e, the squared Mahalanobis distance of e under the covariance A; infinite where A is
/// not positive definite.
template <int n>
double mahalanobis(const Column<n>& e, const Mat<n, n>& A) noexcept {
  const Cholesky<n> factor(A);
  if (!factor.positive) return std::numeric_limits<double>::infinity();
  const Column<n> y = factor.forward(e);
  double sum = 0.0;
  for (int i = 0; i < n; ++i) sum += y(i, 0) * y(i, 0);
  return sum;
}

}  // namespace sightline
