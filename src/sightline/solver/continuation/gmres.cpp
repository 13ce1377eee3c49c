#include <array>
#include <cmath>

#include "sightline/base.hpp"
#include "sightline/solvers.hpp"

namespace sightline {
namespace {

constexpr int packs_of_sums = dot_quantum / native_width;
using Sums = std::array<NativeLane, packs_of_sums>;

/// Pairwise total of the partial sums, in an order independent of the lane width.
double total(const Sums& sums) {
  std::array<double, dot_quantum> s;
  for (std::size_t p = 0; p < sums.size(); ++p) sums[p].store(s.data() + p * native_width);
  for (std::size_t half = dot_quantum / 2; half > 0; half /= 2) {
    for (std::size_t i = 0; i < half; ++i) s[i] += s[i + half];
  }
  return s[0];
}

constexpr int round_up(int n) { return (n + dot_quantum - 1) / dot_quantum * dot_quantum; }

/// w -= c v, and the dot product of the new w with u, in one pass over w.
double subtract_and_dot(double* w, double c, const double* v, const double* u, int n) noexcept {
  Sums sums;
  sums.fill(NativeLane(0.0));
  const NativeLane minus_c(-c);
  for (int i = 0; i < n; i += dot_quantum) {
    for (int p = 0; p < packs_of_sums; ++p) {
      const int j = i + p * native_width;
      const NativeLane r = fma(minus_c, NativeLane::load(v + j), NativeLane::load(w + j));
      r.store(w + j);
      auto& sum = sums[static_cast<std::size_t>(p)];
      sum = fma(r, u == w ? r : NativeLane::load(u + j), sum);
    }
  }
  return total(sums);
}

}  // namespace

double dot(const double* a, const double* b, int n) noexcept {
  Sums sums;
  sums.fill(NativeLane(0.0));
  for (int i = 0; i < n; i += dot_quantum) {
    for (int p = 0; p < packs_of_sums; ++p) {
      const int j = i + p * native_width;
      auto& sum = sums[static_cast<std::size_t>(p)];
      sum = fma(NativeLane::load(a + j), NativeLane::load(b + j), sum);
    }
  }
  return total(sums);
}

Gmres::Gmres(int n, int k_max)
    : length_(round_up(n)),
      k_max_(k_max),
      basis_(k_max + 1, length_),
      h_(static_cast<std::size_t>(k_max + 1) * static_cast<std::size_t>(k_max)),
      cos_(static_cast<std::size_t>(k_max)),
      sin_(static_cast<std::size_t>(k_max)),
      g_(static_cast<std::size_t>(k_max) + 1),
      y_(static_cast<std::size_t>(k_max)) {}

double Gmres::orthogonalise(int k) noexcept {
  // Modified Gram-Schmidt; each pass removes one direction and computes the next projection.
  double* const w = basis_[k + 1];
  const double before = dot(w, w, length_);
  double projection = dot(basis_[0], w, length_);
  for (int j = 0; j <= k; ++j) {
    hessenberg(j, k) = projection;
    projection = subtract_and_dot(w, projection, basis_[j], j < k ? basis_[j + 1] : w, length_);
  }
  // The remainder of a vector inside the space is rounding, not a direction.
  constexpr double rounding = 1e-28;  // of a squared length
  const double length = projection > rounding * before ? std::sqrt(projection) : 0.0;
  hessenberg(k + 1, k) = length;
  if (length > 0) {
    for (int i = 0; i < length_; ++i) w[i] /= length;
  }
  return length;
}

bool Gmres::rotate(int k) noexcept {
  const auto at = [](int i) { return static_cast<std::size_t>(i); };
  double square = 0.0;
  for (int j = 0; j <= k + 1; ++j) square += hessenberg(j, k) * hessenberg(j, k);
  for (int j = 0; j < k; ++j) {
    const double a = hessenberg(j, k), b = hessenberg(j + 1, k);
    hessenberg(j, k) = cos_[at(j)] * a + sin_[at(j)] * b;
    hessenberg(j + 1, k) = cos_[at(j)] * b - sin_[at(j)] * a;
  }
  const double diagonal = norm(hessenberg(k, k), hessenberg(k + 1, k));
  // A singular matrix leaves only rounding on the diagonal.
  if (!(diagonal > 1e-12 * std::sqrt(square)) || !std::isfinite(diagonal)) return false;
  cos_[at(k)] = hessenberg(k, k) / diagonal;
  sin_[at(k)] = hessenberg(k + 1, k) / diagonal;
  hessenberg(k, k) = diagonal;
  g_[at(k + 1)] = -sin_[at(k)] * g_[at(k)];
  g_[at(k)] *= cos_[at(k)];
  return true;
}

void Gmres::advance(int k, double* x) noexcept {
  const auto at = [](int i) { return static_cast<std::size_t>(i); };
  for (int i = k - 1; i >= 0; --i) {
    double sum = g_[at(i)];
    for (int j = i + 1; j < k; ++j) sum -= hessenberg(i, j) * y_[at(j)];
    y_[at(i)] = sum / hessenberg(i, i);
  }
  for (int j = 0; j < k; ++j) {
    const double* const v = basis_[j];
    for (int i = 0; i < length_; ++i) x[i] += y_[at(j)] * v[i];
  }
}

}  // namespace sightline
