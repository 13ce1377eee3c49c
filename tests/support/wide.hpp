/// A long double that knows how far a computation in double may be off: the yardstick of every
/// formula.
#pragma once

#include <cmath>

namespace sightline {

/// Value by the C library in long double, and the running bound of the rounding that double would
/// have seen.
///
/// The bound of a sum counts both operands, so it also holds where constants were gathered first.
/// That of a logistic is absolute: sig(-c) may be computed as 1 - sig(c).
class Wide {
 public:
  Wide() = default;
  Wide(double constant) : value_(constant) {}
  Wide(long double value, long double rounding) : value_(value), rounding_(rounding) {}

  long double value() const { return value_; }
  double rounding() const { return static_cast<double>(rounding_); }

  friend Wide operator+(const Wide& a, const Wide& b) {
    return {a.value_ + b.value_,
            a.rounding_ + b.rounding_ + unit * (std::fabs(a.value_) + std::fabs(b.value_))};
  }
  friend Wide operator-(const Wide& a, const Wide& b) { return a + -b; }
  friend Wide operator*(const Wide& a, const Wide& b) {
    const long double ab = a.value_ * b.value_;
    return {ab, std::fabs(a.value_) * b.rounding_ + std::fabs(b.value_) * a.rounding_ + unit * std::fabs(ab)};
  }
  friend Wide operator/(const Wide& a, const Wide& b) {
    const long double q = a.value_ / b.value_;
    return {q, (a.rounding_ + std::fabs(q) * b.rounding_) / std::fabs(b.value_) + 2 * unit * std::fabs(q)};
  }
  friend Wide operator-(const Wide& a) { return {-a.value_, a.rounding_}; }
  friend bool operator>(const Wide& a, const Wide& b) { return a.value_ > b.value_; }
  friend Wide sqrt(const Wide& a) {
    const long double r = std::sqrt(a.value_);
    return {r, a.rounding_ / (2 * r) + unit * r};
  }
  friend Wide exp(const Wide& a) {
    const long double e = std::exp(a.value_);
    return {e, e * (a.rounding_ + 2 * unit)};
  }
  friend Wide logistic(const Wide& a) {
    const long double s = 1 / (1 + std::exp(-a.value_));
    return {s, s * (1 - s) * a.rounding_ + 3 * unit};
  }
  friend Wide relaxed_log(const Wide& a) {
    const long double below = a.value_ < 1 ? 1 - a.value_ : 0, above = a.value_ < 1 ? 1 : a.value_;
    const long double log = std::log(above) - below - below * below / 2;
    return {log, (1 / above + below) * a.rounding_ + 3 * unit * std::fabs(log)};
  }
  friend Wide log(const Wide& a) {
    const long double l = std::log(a.value_);
    return {l, a.rounding_ / std::fabs(a.value_) + 2 * unit * std::fabs(l)};
  }
  friend Wide softplus(const Wide& a) {
    const long double e = std::exp(-std::fabs(a.value_)), l = std::fmax(a.value_, 0.0L) + std::log1p(e);
    return {l, a.rounding_ + 4 * unit * l};
  }
  friend Wide atan2(const Wide& a, const Wide& b) {
    const long double angle = std::atan2(a.value_, b.value_);
    return {angle,
            (a.rounding_ + b.rounding_) / std::hypot(a.value_, b.value_) + 3 * unit * std::fabs(angle)};
  }
  friend Wide sin(const Wide& a) {
    return {std::sin(a.value_), std::fabs(std::cos(a.value_)) * a.rounding_ + 2 * unit};
  }
  friend Wide cos(const Wide& a) {
    return {std::cos(a.value_), std::fabs(std::sin(a.value_)) * a.rounding_ + 2 * unit};
  }

 private:
  static constexpr long double unit = 0x1p-53L;

  long double value_ = 0, rounding_ = 0;
};

}  // namespace sightline
