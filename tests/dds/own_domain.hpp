/// A domain that the tests of other programs do not speak on.
#pragma once

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <stdexcept>
#include <string>

#include "bridges/dds/fleet/link.hpp"

namespace sightline::test {

/// Until this program ends; `other` is a second one.
inline int own_domain(std::size_t other = 0) {
  static std::array<int, 2> owned = {-1, -1};
  for (int domain = 60; owned.at(other) < 0 && domain < 220; ++domain) {
    const auto file = std::filesystem::temp_directory_path() / ("sightline_domain_" + std::to_string(domain));
    const int lock = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (lock >= 0 && ::flock(lock, LOCK_EX | LOCK_NB) == 0)
      owned[other] = domain;  // the lock is the kernel's, and ends with the program
    else if (lock >= 0)
      ::close(lock);
  }
  if (owned[other] < 0) throw std::runtime_error("no domain is free");
  return owned[other];
}

inline FleetNetwork own_network(std::size_t other = 0) {
  FleetNetwork network;
  network.domain = own_domain(other);
  return network;
}

}  // namespace sightline::test
