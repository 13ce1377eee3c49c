#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "sightline/loop.hpp"

namespace sightline {

ValidStates::ValidStates(const Team& team, std::span<const double> start)
    : x_(sightline::size(team.nx())),
      stamps_(sightline::size(team.bodies()), -std::numeric_limits<double>::infinity()),
      valid_(stamps_.size()) {
  assert(start.size() == x_.size() && "a start is of all bodies of the team");
  for (int b = 0; b < team.bodies(); ++b) {
    const Model& model = team.model(BodyId{b});
    const Body& body = bodies_.emplace_back(
        Body{model, sightline::size(team.state_offset(BodyId{b})), sightline::size(model.nx())});
    scratch_.resize(std::max(scratch_.size(), body.nx));
    const std::span<const double> x = start.subspan(body.x, body.nx);
    if (admits(body, x))
      std::copy(x.begin(), x.end(), x_.begin() + static_cast<std::ptrdiff_t>(body.x));
    else
      model.at_rest({{}, {1.0, 0.0}}, &x_[body.x]);
  }
}

void ValidStates::take_body(std::size_t i, std::span<const double> x, double stamp,
                            bool can_be_valid) noexcept {
  const Body& body = bodies_[i];
  const std::span<const double> measured = x.subspan(body.x, body.nx);
  valid_[i] = can_be_valid && stamp < std::numeric_limits<double>::infinity() && admits(body, measured);
  if (valid_[i] == 0) return;
  std::copy(measured.begin(), measured.end(), x_.begin() + static_cast<std::ptrdiff_t>(body.x));
  stamps_[i] = stamp;
}

const ValidStates& ValidStates::take(std::span<const double> x, std::span<const double> stamps) noexcept {
  for (std::size_t i = 0; i < bodies_.size(); ++i) take_body(i, x, stamps[i], true);
  return *this;
}

const ValidStates& ValidStates::take(std::span<const double> x, const ValidStates& of) noexcept {
  for (std::size_t i = 0; i < bodies_.size(); ++i) take_body(i, x, of.stamps_[i], of.valid_[i] != 0);
  return *this;
}

bool ValidStates::admits(const Body& body, std::span<const double> x) noexcept {
  if (!std::all_of(x.begin(), x.end(), [](double v) { return std::abs(v) <= largest; }))
    return false;  // also for NaN
  std::copy(x.begin(), x.end(), scratch_.begin());
  return body.model.normalise(scratch_.data());
}

}  // namespace sightline
