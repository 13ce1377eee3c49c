/// A value and its rate: the time derivative of a formula along a motion, in one pass.
///
/// It serves where one directional derivative suffices: a robot's velocity is the rate of its
/// pose(x) with x' = f(x, u). It works over double and over the recording scalar.
#pragma once

#include "sightline/base/elementary.hpp"

namespace sightline {

template <class S>
struct Tangent {
  S value{}, rate{};

  Tangent() = default;
  Tangent(double constant) : value(constant), rate(0.0) {}
  Tangent(const S& v, const S& r) : value(v), rate(r) {}

  friend Tangent operator+(const Tangent& a, const Tangent& b) {
    return {a.value + b.value, a.rate + b.rate};
  }
  friend Tangent operator-(const Tangent& a, const Tangent& b) {
    return {a.value - b.value, a.rate - b.rate};
  }
  friend Tangent operator-(const Tangent& a) { return {-a.value, -a.rate}; }
  friend Tangent operator*(const Tangent& a, const Tangent& b) {
    return {a.value * b.value, a.rate * b.value + a.value * b.rate};
  }
  friend Tangent operator/(const Tangent& a, const Tangent& b) {
    const S q = a.value / b.value;
    return {q, (a.rate - q * b.rate) / b.value};
  }
  Tangent& operator+=(const Tangent& b) { return *this = *this + b; }
  Tangent& operator-=(const Tangent& b) { return *this = *this - b; }
  Tangent& operator*=(const Tangent& b) { return *this = *this * b; }

  friend Tangent sqrt(const Tangent& a) {
    const S r = sqrt(a.value);
    return {r, a.rate / (2.0 * r)};
  }
  friend Tangent exp(const Tangent& a) {
    const S e = exp(a.value);
    return {e, a.rate * e};
  }
  friend Tangent logistic(const Tangent& a) {
    const S s = logistic(a.value);
    return {s, a.rate * (s * (1.0 - s))};
  }
  friend Tangent relaxed_log(const Tangent& a) {
    const S above = maximum(a.value, S(1.0));
    return {relaxed_log(a.value), a.rate * (1.0 / above + (above - a.value))};
  }
  friend Tangent log(const Tangent& a) { return {log(a.value), a.rate / a.value}; }
  friend Tangent softplus(const Tangent& a) { return {softplus(a.value), a.rate * logistic(a.value)}; }
  friend Tangent atan2(const Tangent& a, const Tangent& b) {
    const S squares = a.value * a.value + b.value * b.value;
    return {atan2(a.value, b.value), (a.rate * b.value - a.value * b.rate) / squares};
  }
  friend Tangent sin(const Tangent& a) { return {sin(a.value), a.rate * cos(a.value)}; }
  friend Tangent cos(const Tangent& a) { return {cos(a.value), -(a.rate * sin(a.value))}; }
};

}  // namespace sightline
