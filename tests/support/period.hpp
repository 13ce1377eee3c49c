/// The period of most tests.
#pragma once

namespace sightline::test {

inline constexpr double control_period = 0.01;  ///< [s]

}  // namespace sightline::test
