/// Cost of one robot, (62)-(67): its deviation from a reference and its control effort.
#pragma once

#include <span>

namespace sightline {

/// (x* - x)' diag(Q) (x* - x) + (u* - u)' diag(R) (u* - u); with the heading's entries of Q this is
/// (25). All spans have the lengths nx and nu. Also the terminal cost, with Q_f and no inputs.
template <class S>
S tracking_cost(std::span<const S> x, std::span<const S> x_ref, std::span<const S> Q, std::span<const S> u,
                std::span<const S> u_ref, std::span<const S> R) {
  S cost = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const S e = x_ref[i] - x[i];
    cost = cost + Q[i] * (e * e);
  }
  for (std::size_t i = 0; i < u.size(); ++i) {
    const S e = u_ref[i] - u[i];
    cost = cost + R[i] * (e * e);
  }
  return cost;
}

}  // namespace sightline
