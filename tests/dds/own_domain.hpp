/// A domain that the tests of other programs do not speak on.
#pragma once

#include <unistd.h>

#include "sightline/scenario/link.hpp"

namespace sightline::test {

/// One for each program that runs at the time; `other` is a second one.
inline int own_domain(int other = 0) { return 60 + (2 * static_cast<int>(::getpid()) + other) % 160; }

inline FleetNetwork own_network(int other = 0) {
  FleetNetwork network;
  network.domain = own_domain(other);
  return network;
}

}  // namespace sightline::test
