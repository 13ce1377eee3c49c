/// A pack of doubles that one instruction processes: stages, pairs or agents side by side.
///
/// The same operations exist for plain `double`, so a formula or a kernel is written once over
/// `Real`. It then gives the same bits on one lane as on eight: nothing here sums across lanes, and
/// a fused product is fused everywhere.
///
/// The library build fixes the width of a pack (lane_width.hpp). A program may be built for a
/// lesser machine; each pack then takes several of its registers. The calling convention of a pack
/// depends on that machine, so the name of Lane contains both. The linker therefore never replaces
/// a function over lanes of one file by that of another.
#pragma once

#include <bit>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <utility>

#include "sightline/base/lane_width.hpp"

#if defined(__AVX512F__) || defined(__AVX__) || defined(__FMA__)
#include <immintrin.h>
#elif defined(__aarch64__)
#include <arm_neon.h>
#endif

namespace sightline {

/// The library alone defines it, and every file that computes on lanes references it. A file of
/// another width does not link.
extern const int SIGHTLINE_LANES_AGREE;

inline namespace SIGHTLINE_LANES {
[[gnu::used]] inline const int* const lanes_agree = &SIGHTLINE_LANES_AGREE;

/// Doubles in one register of the machine for which the library is built.
inline constexpr int native_width = SIGHTLINE_LANE_WIDTH;
/// Width of packs for three or four robots: where a register holds eight, half of it takes less
/// time.
inline constexpr int narrow_width = native_width < 4 ? native_width : 4;
}  // namespace SIGHTLINE_LANES

/// Rows of lanes begin on a multiple of this many bytes and hold a multiple of `row_quantum`
/// doubles.
inline constexpr int row_alignment = 64;
inline constexpr int row_quantum = row_alignment / static_cast<int>(sizeof(double));

/// Length of a row that holds n doubles, padded to whole packs of any width.
constexpr int padded(int n) { return (n + row_quantum - 1) / row_quantum * row_quantum; }

namespace detail {
/// The compiler's vector types; GCC accepts their size only as a literal.
template <int W>
struct Storage;
template <>
struct Storage<1> {
  typedef double Vector __attribute__((vector_size(8)));
  typedef std::int64_t Bits __attribute__((vector_size(8)));
};
template <>
struct Storage<2> {
  typedef double Vector __attribute__((vector_size(16)));
  typedef std::int64_t Bits __attribute__((vector_size(16)));
};
template <>
struct Storage<4> {
  typedef double Vector __attribute__((vector_size(32)));
  typedef std::int64_t Bits __attribute__((vector_size(32)));
};
template <>
struct Storage<8> {
  typedef double Vector __attribute__((vector_size(64)));
  typedef std::int64_t Bits __attribute__((vector_size(64)));
};
}  // namespace detail

inline namespace SIGHTLINE_LANES {

/// W doubles, W = 1, 2, 4 or 8; arithmetic is elementwise.
template <int W>
struct Lane {
  using Vector = typename detail::Storage<W>::Vector;
  using Bits = typename detail::Storage<W>::Bits;
  static constexpr int width = W;

  Vector v;

  Lane() = default;
  Lane(double s) : v(s - Vector{}) {}  // a constant of a formula is equal in all lanes
  explicit Lane(Vector vector) : v(vector) {}

  static Lane load(const double* row) {
    Lane lane;
    __builtin_memcpy(&lane.v, row, sizeof(Vector));
    return lane;
  }
  /// Loads from[offsets[i]] into lane i.
  template <class Offsets>
  static Lane gather(const double* from, const Offsets& offsets) {
    return [&]<std::size_t... i>(std::index_sequence<i...>) { return Lane(Vector{from[offsets[i]]...}); }
    (std::make_index_sequence<W>());
  }
  void store(double* row) const { __builtin_memcpy(row, &v, sizeof(Vector)); }
  double operator[](int i) const { return v[i]; }

  friend Lane operator+(Lane a, Lane b) { return Lane(a.v + b.v); }
  friend Lane operator-(Lane a, Lane b) { return Lane(a.v - b.v); }
  friend Lane operator*(Lane a, Lane b) { return Lane(a.v * b.v); }
  friend Lane operator/(Lane a, Lane b) { return Lane(a.v / b.v); }
  friend Lane operator-(Lane a) { return Lane(-a.v); }
  Lane& operator+=(Lane b) { return *this = *this + b; }
  Lane& operator-=(Lane b) { return *this = *this - b; }
  Lane& operator*=(Lane b) { return *this = *this * b; }
};

using NativeLane = Lane<native_width>;

}  // namespace SIGHTLINE_LANES

namespace detail {
template <class T>
inline constexpr bool is_lane = false;
template <int W>
inline constexpr bool is_lane<Lane<W>> = true;
}  // namespace detail

/// A number for computation, not recording: double, or a pack of doubles.
template <class T>
concept Real = std::same_as<T, double> || detail::is_lane<T>;

/// a b + c, rounded once. The overload for double is a template too, so that the C library's fma is
/// no ambiguous overload.
template <std::same_as<double> D>
D fma(D a, D b, D c) {
  return __builtin_fma(a, b, c);
}

template <int W>
Lane<W> fma(Lane<W> a, Lane<W> b, Lane<W> c) {
  using L [[maybe_unused]] = Lane<W>;
#if defined(__AVX512F__)
  if constexpr (W == 8)
    return L((typename L::Vector)_mm512_fmadd_pd((__m512d)a.v, (__m512d)b.v, (__m512d)c.v));
#endif
#if defined(__FMA__)
  if constexpr (W == 4)
    return L((typename L::Vector)_mm256_fmadd_pd((__m256d)a.v, (__m256d)b.v, (__m256d)c.v));
  if constexpr (W == 2) return L((typename L::Vector)_mm_fmadd_pd((__m128d)a.v, (__m128d)b.v, (__m128d)c.v));
#elif defined(__aarch64__)
  if constexpr (W == 2)
    return L((typename L::Vector)vfmaq_f64((float64x2_t)c.v, (float64x2_t)a.v, (float64x2_t)b.v));
#endif
  L r;
  for (int i = 0; i < W; ++i) r.v[i] = __builtin_fma(a.v[i], b.v[i], c.v[i]);
  return r;
}

/// a b - c, rounded once.
template <std::same_as<double> D>
D multiply_subtract(D a, D b, D c) {
  return __builtin_fma(a, b, -c);
}

/// c - a b, rounded once.
template <std::same_as<double> D>
D subtract_product(D a, D b, D c) {
  return __builtin_fma(-a, b, c);
}

// These use their own instructions: the compiler does not fold the sign of a vector into a fused
// product.
template <int W>
Lane<W> multiply_subtract(Lane<W> a, Lane<W> b, Lane<W> c) {
  using L [[maybe_unused]] = Lane<W>;
#if defined(__AVX512F__)
  if constexpr (W == 8)
    return L((typename L::Vector)_mm512_fmsub_pd((__m512d)a.v, (__m512d)b.v, (__m512d)c.v));
#endif
#if defined(__FMA__)
  if constexpr (W == 4)
    return L((typename L::Vector)_mm256_fmsub_pd((__m256d)a.v, (__m256d)b.v, (__m256d)c.v));
  if constexpr (W == 2) return L((typename L::Vector)_mm_fmsub_pd((__m128d)a.v, (__m128d)b.v, (__m128d)c.v));
#endif
  return fma(a, b, -c);
}

template <int W>
Lane<W> subtract_product(Lane<W> a, Lane<W> b, Lane<W> c) {
  using L [[maybe_unused]] = Lane<W>;
#if defined(__AVX512F__)
  if constexpr (W == 8)
    return L((typename L::Vector)_mm512_fnmadd_pd((__m512d)a.v, (__m512d)b.v, (__m512d)c.v));
#endif
#if defined(__FMA__)
  if constexpr (W == 4)
    return L((typename L::Vector)_mm256_fnmadd_pd((__m256d)a.v, (__m256d)b.v, (__m256d)c.v));
  if constexpr (W == 2) return L((typename L::Vector)_mm_fnmadd_pd((__m128d)a.v, (__m128d)b.v, (__m128d)c.v));
#endif
  return fma(-a, b, c);
}

template <std::same_as<double> D>
D sqrt(D a) {
  return __builtin_sqrt(a);
}

template <int W>
Lane<W> sqrt(Lane<W> a) {
  Lane<W> r;
  for (int i = 0; i < W; ++i) r.v[i] = __builtin_sqrt(a.v[i]);
  return r;
}

/// a where c < 0, else b.
inline double where_negative(double c, double a, double b) { return c < 0 ? a : b; }

template <int W>
Lane<W> where_negative(Lane<W> c, Lane<W> a, Lane<W> b) {
  return Lane<W>(c.v < 0.0 ? a.v : b.v);
}

/// The larger of a and b; b where one of them is not a number.
template <std::same_as<double> D>
D maximum(D a, D b) {
  return a > b ? a : b;
}

template <int W>
Lane<W> maximum(Lane<W> a, Lane<W> b) {
  return Lane<W>(a.v > b.v ? a.v : b.v);
}

/// The smaller of a and b; b where one of them is not a number.
template <std::same_as<double> D>
D minimum(D a, D b) {
  return a < b ? a : b;
}

template <int W>
Lane<W> minimum(Lane<W> a, Lane<W> b) {
  return Lane<W>(a.v < b.v ? a.v : b.v);
}

/// |a|.
template <Real L>
L absolute(L a) {
  return maximum(a, -a);
}

/// The largest lane above zero, else 0.
template <int W>
double largest(Lane<W> a) {
  double most = 0.0;
  for (int i = 0; i < W; ++i) most = a[i] > most ? a[i] : most;
  return most;
}

/// Whether a lane is below zero.
inline bool any_negative(double a) { return a < 0; }

template <int W>
bool any_negative(Lane<W> a) {
#if defined(__AVX512F__)
  if constexpr (W == 8) return _mm512_cmp_pd_mask((__m512d)a.v, _mm512_setzero_pd(), _CMP_LT_OQ) != 0;
#endif
  const auto below = a.v < 0.0;
  std::int64_t any = 0;
  for (int i = 0; i < W; ++i) any |= below[i];
  return any != 0;
}

/// x limited to [low, high]; NaN stays NaN.
inline double clamp(double x, double low, double high) {
  x = x < low ? low : x;
  return x > high ? high : x;
}

template <int W>
Lane<W> clamp(Lane<W> x, Lane<W> low, Lane<W> high) {
  const Lane<W> y(x.v < low.v ? low.v : x.v);
  return Lane<W>(y.v > high.v ? high.v : y.v);
}

template <int W>
Lane<W> clamp(Lane<W> x, double low, double high) {
  return clamp(x, Lane<W>(low), Lane<W>(high));
}

/// Lane i of the result is lane from[i] of a, 0 <= from[i] < W.
template <int W>
Lane<W> permuted(Lane<W> a, typename Lane<W>::Bits from) {
#if defined(__clang__)
  Lane<W> r;
  for (int i = 0; i < W; ++i) r.v[i] = a.v[from[i]];
  return r;
#else
  return Lane<W>(__builtin_shuffle(a.v, from));
#endif
}

namespace detail {

/// Adding this constant rounds a double to the nearest integer and leaves that integer in its low
/// bits.
inline constexpr double round_magic = 6755399441055744.0;  // 1.5 * 2^52

/// p * 2^n, n the integer in the low bits of `rounded`; p and the result are normal.
inline double scale_by_bits(double p, double rounded) {
  return std::bit_cast<double>(std::bit_cast<std::int64_t>(p) +
                               static_cast<std::int64_t>(std::bit_cast<std::uint64_t>(rounded) << 52));
}

template <int W>
Lane<W> scale_by_bits(Lane<W> p, Lane<W> rounded) {
  using L = Lane<W>;
  const auto bits = (typename L::Bits)p.v + ((typename L::Bits)rounded.v << 52);
  return L((typename L::Vector)bits);
}

/// a where the given bit of the integer in `rounded` is set, else b.
inline double where_bit(double rounded, std::int64_t bit, double a, double b) {
  return (std::bit_cast<std::int64_t>(rounded) & bit) != 0 ? a : b;
}

template <int W>
Lane<W> where_bit(Lane<W> rounded, std::int64_t bit, Lane<W> a, Lane<W> b) {
  using L = Lane<W>;
  const auto set = ((typename L::Bits)rounded.v & bit) != 0;
  return L(set ? a.v : b.v);
}

/// Splits x = 2^n p, x > 0 and normal: returns p in [sqrt(1/2), sqrt 2). The low bits of `exponent`
/// receive n, as with round_magic.
inline double mantissa(double x, double& exponent) {
  constexpr std::int64_t root_half = 0x3fe6a09e667f3bcd;
  const std::int64_t n = (std::bit_cast<std::int64_t>(x) - root_half) >> 52;
  exponent = std::bit_cast<double>(std::bit_cast<std::int64_t>(round_magic) + n);
  return std::bit_cast<double>(std::bit_cast<std::int64_t>(x) - (n << 52));
}

template <int W>
Lane<W> mantissa(Lane<W> x, Lane<W>& exponent) {
  Lane<W> p;
  for (int i = 0; i < W; ++i) {
    double e = 0.0;
    p.v[i] = mantissa(x.v[i], e);
    exponent.v[i] = e;
  }
  return p;
}

/// y, or x where x is not a number.
inline double keep_nan(double x, double y) { return x != x ? x : y; }

template <int W>
Lane<W> keep_nan(Lane<W> x, Lane<W> y) {
  return Lane<W>(x.v != x.v ? x.v : y.v);
}

}  // namespace detail
}  // namespace sightline
