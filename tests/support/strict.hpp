/// A scalar that gives nothing away: what compiles on it uses the operations a formula may use and
/// no others.
#pragma once

#include <concepts>

#include "sightline/base.hpp"

namespace sightline {

/// A double that becomes no other number, is compared with none, and is made of a double alone.
class Strict {
 public:
  Strict() = default;
  Strict(double constant) : value_(constant) {}
  template <class T>
  requires(!std::same_as<T, double>) Strict(T)
  = delete;

  /// The number, for the test alone.
  double value() const { return value_; }

  friend Strict operator+(Strict a, Strict b) { return a.value_ + b.value_; }
  friend Strict operator-(Strict a, Strict b) { return a.value_ - b.value_; }
  friend Strict operator*(Strict a, Strict b) { return a.value_ * b.value_; }
  friend Strict operator/(Strict a, Strict b) { return a.value_ / b.value_; }
  friend Strict operator-(Strict a) { return -a.value_; }
  friend Strict sqrt(Strict a) { return sightline::sqrt(a.value_); }
  friend Strict exp(Strict a) { return sightline::exp(a.value_); }
  friend Strict logistic(Strict a) { return sightline::logistic(a.value_); }
  friend Strict maximum(Strict a, Strict b) { return sightline::maximum(a.value_, b.value_); }
  friend Strict relaxed_log(Strict a) { return sightline::relaxed_log(a.value_); }
  friend Strict log(Strict a) { return sightline::log(a.value_); }
  friend Strict softplus(Strict a) { return sightline::softplus(a.value_); }
  friend Strict atan2(Strict a, Strict b) { return sightline::atan2(a.value_, b.value_); }
  friend Strict sin(Strict a) { return sightline::sin(a.value_); }
  friend Strict cos(Strict a) { return sightline::cos(a.value_); }

 private:
  double value_ = 0.0;
};

}  // namespace sightline
