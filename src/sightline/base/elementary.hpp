/// Elementary functions with the same bits on every machine, at every optimisation level, on one
/// lane as on eight. Finite arguments give finite results, except where noted; NaN stays NaN.
#pragma once

#include <limits>

#include "sightline/base/lane.hpp"

namespace sightline {

template <class S>
S square(const S& x) {
  return x * x;
}

/// e^x, within 1.5 ulp; constant at e^-708 and e^709 outside [-708, 709].
template <Real L>
L exp(L x) {
  const L y = clamp(x, -708.0, 709.0);
  // x = n ln 2 + r, |r| <= ln 2 / 2, ln 2 in two parts.
  const L rounded = fma(y, L(1.4426950408889634074), L(detail::round_magic));
  const L n = rounded - L(detail::round_magic);
  const L r = fma(n, L(-1.90821492927058770002e-10), fma(n, L(-6.93147180369123816490e-01), y));
  // Taylor to r^13 / 13!, even and odd powers side by side.
  const L r2 = r * r;
  L even = L(1.0 / 479001600.0), odd = L(1.0 / 6227020800.0);
  even = fma(even, r2, L(1.0 / 3628800.0));
  odd = fma(odd, r2, L(1.0 / 39916800.0));
  even = fma(even, r2, L(1.0 / 40320.0));
  odd = fma(odd, r2, L(1.0 / 362880.0));
  even = fma(even, r2, L(1.0 / 720.0));
  odd = fma(odd, r2, L(1.0 / 5040.0));
  even = fma(even, r2, L(1.0 / 24.0));
  odd = fma(odd, r2, L(1.0 / 120.0));
  even = fma(even, r2, L(0.5));
  odd = fma(odd, r2, L(1.0 / 6.0));
  odd = fma(odd, r2, L(1.0));
  const L p = L(1.0) + fma(odd, r, even * r2);
  return detail::keep_nan(x, detail::scale_by_bits(p, rounded));
}

/// 1 / (1 + e^-x), within 3 ulp; (35) at kappa_A = 1, in two branches so that neither overflows.
template <Real L>
L logistic(L x) {
  const L e = exp(where_negative(x, x, -x));
  const L s = L(1.0) / (L(1.0) + e);
  return where_negative(x, e * s, s);
}

namespace detail {

/// ln x for a normal x > 0.
template <Real L>
L log_of_normal(L x) {
  // x = 2^n p, ln p = 2 artanh(f / (2 + f)), f = p - 1; ln 2 in two parts.
  L rounded;
  const L f = mantissa(x, rounded) - L(1.0);
  const L n = rounded - L(round_magic);
  const L s = f / (L(2.0) + f);
  const L z = s * s;
  L r = L(1.479819860511658591e-01);
  r = fma(r, z, L(1.531383769920937332e-01));
  r = fma(r, z, L(1.818357216161805012e-01));
  r = fma(r, z, L(2.222219843214978396e-01));
  r = fma(r, z, L(2.857142874366239149e-01));
  r = fma(r, z, L(3.999999999940941908e-01));
  r = fma(r, z, L(6.666666666666735130e-01));
  const L half = L(0.5) * f * f;
  const L tail = fma(n, L(1.90821492927058770002e-10), s * fma(r, z, half));
  return n * L(6.93147180369123816490e-01) - ((half - tail) - f);
}

}  // namespace detail

/// ln x for x >= 1; below 1, the parabola -(1 - x) - (1 - x)^2 / 2, which continues its value,
/// slope and curvature. Within 2 ulp for x >= 1. If the square overflows, so does the result.
template <Real L>
L relaxed_log(L x) {
  const L above = maximum(x, L(1.0)), below = above - x;
  return detail::log_of_normal(above) - fma(L(0.5) * below, below, below);
}

/// ln x, within 2 ulp. Zero and subnormals give the log of the smallest normal number, -708.4; x <
/// 0 gives NaN.
template <Real L>
L log(L x) {
  const L y = detail::log_of_normal(clamp(x, 2.2250738585072014e-308, 1.7976931348623157e308));
  return detail::keep_nan(x, where_negative(x, L(std::numeric_limits<double>::quiet_NaN()), y));
}

/// ln(1 + e^x), the integral of `logistic`, within 4 ulp; neither branch overflows.
template <Real L>
L softplus(L x) {
  const L e = exp(where_negative(x, x, -x));
  const L u = L(1.0) + e;
  const L tail = log(u) + (e - (u - L(1.0))) / u;  // adds the rounding error of u
  return where_negative(x, tail, x + tail);
}

/// The angle of (x, y) from the x axis, in [-pi, pi], within 3 ulp; 0 at the origin.
template <Real L>
L atan2(L y, L x) {
  const L ax = where_negative(x, -x, x), ay = where_negative(y, -y, y);
  const L steep = ax - ay;  // < 0: nearer to the y axis
  const L large = clamp(where_negative(steep, ay, ax), 2.2250738585072014e-308, 1.7976931348623157e308);
  const L small = where_negative(steep, ax, ay);
  // atan t, t = small / large in [0, 1]; above 0.66 as pi/4 + atan((t - 1) / (t + 1)).
  const L t = small / large;
  const L beyond = L(0.66) - t;
  const L r = where_negative(beyond, (small - large) / (small + large), t);
  const L z = r * r;
  L p = fma(z, L(-8.750608600031904122785e-01), L(-1.615753718733365076637e+01));
  p = fma(z, p, L(-7.500855792314704667340e+01));
  p = fma(z, p, L(-1.228866684490136173410e+02));
  p = fma(z, p, L(-6.485021904942025371773e+01));
  L q = z + L(2.485846490142306297962e+01);
  q = fma(z, q, L(1.650270098316988542046e+02));
  q = fma(z, q, L(4.328810604912902668951e+02));
  q = fma(z, q, L(4.853903996359136964868e+02));
  q = fma(z, q, L(1.945506571482613964425e+02));
  const L atan = fma(r, z * p / q, r);
  L a = where_negative(beyond, (atan + L(3.061616997868383e-17)) + L(7.85398163397448309616e-01), atan);
  a = where_negative(steep, (L(6.123233995736766e-17) - a) + L(1.57079632679489661923), a);
  a = where_negative(x, (L(1.2246467991473532e-16) - a) + L(3.14159265358979323846), a);
  a = where_negative(y, -a, a);
  return detail::keep_nan(x, detail::keep_nan(y, a));
}

template <Real L>
struct SinCos {
  L sin, cos;
};

/// sin x and cos x, within 1.6 ulp for |x| <= 1e6. Beyond 2^51 a double does not resolve the angle;
/// the results are only within [-1, 1].
template <Real L>
SinCos<L> sincos(L x) {
  // x = n pi/2 + r, |r| <= pi/4, pi/2 in three parts.
  const L rounded = fma(x, L(6.36619772367581382433e-01), L(detail::round_magic));
  const L n = rounded - L(detail::round_magic);
  L r = fma(n, L(-1.57079632679489655800e+00), x);
  r = fma(n, L(-6.12323399573676603587e-17), r);
  r = fma(n, L(1.49738490485916983e-33), r);
  r = clamp(r, -0.78539816339744839, 0.78539816339744839);
  // Minimax polynomials on [-pi/4, pi/4].
  const L z = r * r;
  L s = L(1.58969099521155010221e-10);
  s = fma(s, z, L(-2.50507602534068634195e-08));
  s = fma(s, z, L(2.75573137070700676789e-06));
  s = fma(s, z, L(-1.98412698298579493134e-04));
  s = fma(s, z, L(8.33333333332248946124e-03));
  s = fma(s, z, L(-1.66666666666666324348e-01));
  const L sine = fma(s * z, r, r);
  L c = L(-1.13596475577881948265e-11);
  c = fma(c, z, L(2.08757232129817482790e-09));
  c = fma(c, z, L(-2.75573143513906633035e-07));
  c = fma(c, z, L(2.48015872894767294178e-05));
  c = fma(c, z, L(-1.38888888888741095749e-03));
  c = fma(c, z, L(4.16666666666666019037e-02));
  const L half = L(0.5) * z;
  const L w = L(1.0) - half;
  const L cosine = w + fma(z * z, c, (L(1.0) - w) - half);
  // Rotate by n quarter turns.
  const L sin_x = detail::where_bit(rounded, 1, cosine, sine);
  const L cos_x = detail::where_bit(rounded, 1, sine, cosine);
  const L turned = rounded + L(1.0);  // cos is negative in quarters 1 and 2
  return {detail::where_bit(rounded, 2, -sin_x, sin_x), detail::where_bit(turned, 2, -cos_x, cos_x)};
}

template <Real L>
L sin(L x) {
  return sincos(x).sin;
}

template <Real L>
L cos(L x) {
  return sincos(x).cos;
}

}  // namespace sightline
