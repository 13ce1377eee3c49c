/// A connection of a page's server, and the other end of it.
#pragma once

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <string>
#include <string_view>

#include "sightline/server/connection.hpp"

namespace sightline::test {

struct ConnectedPair {
  std::array<int, 2> fds = [] {
    std::array<int, 2> both{};
    ::socketpair(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK, 0, both.data());
    return both;
  }();
  OwnedDescriptor other{fds[1]};
  Connection::Time now = std::chrono::steady_clock::now();
  Connection one{OwnedDescriptor(fds[0]), now, 1024, 3};

  void say(std::string_view bytes) {
    ASSERT_EQ(::write(fds[1], bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  }
  std::string receive() const {
    std::string received(1'000'000, ' ');
    const ssize_t n = ::read(fds[1], received.data(), received.size());
    received.resize(n > 0 ? static_cast<std::size_t>(n) : 0);
    return received;
  }
};

}  // namespace sightline::test
