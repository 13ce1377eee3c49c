/// Numbers that stay when what they were taken from moves on.
#pragma once

#include <span>
#include <vector>

namespace sightline::test {

inline std::vector<double> copied(std::span<const double> x) { return {x.begin(), x.end()}; }

}  // namespace sightline::test
