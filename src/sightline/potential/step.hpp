/// Step functions of an inequality: epsilon(c) is 1 where c <= 0 is violated and 0 where it holds,
/// (29).
///
/// A potential is written once over its step. UnitStep gives the exact region, for plots and tests;
/// SigmoidStep the smooth form, (35), which the solver uses.
#pragma once

#include "sightline/base/elementary.hpp"

namespace sightline {

/// epsilon(c), (29).
struct UnitStep {
  template <class S>
  S operator()(const S& c) const {
    return c > 0.0 ? S(1.0) : S(0.0);
  }
};

/// sig(c, kappa_A) = 1 / (1 + e^(-kappa_A c)), (35); tends to (29) as kappa_A grows, (37).
struct SigmoidStep {
  double kappa_A;

  template <class S>
  S operator()(const S& c) const {
    return logistic(kappa_A * c);
  }
};

}  // namespace sightline
