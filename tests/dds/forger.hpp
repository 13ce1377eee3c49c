/// Forged packets of RTPS, in a network that nobody else is in.
#pragma once

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <linux/if_packet.h>
#include <net/ethernet.h>
#include <net/if.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <functional>
#include <random>
#include <thread>
#include <vector>

namespace sightline::test {

/// Does it in a process and a network of its own, with a loopback and nothing else. What it expects
/// counts for this test.
inline void in_own_network(const std::function<void()>& act) {
  const pid_t child = ::fork();
  ASSERT_GE(child, 0) << std::strerror(errno);
  if (child == 0) {
    const int apart = ::geteuid() == 0 ? CLONE_NEWNET : CLONE_NEWUSER | CLONE_NEWNET;
    EXPECT_EQ(::unshare(apart), 0) << "no network of its own can be made on this machine: "
                                   << std::strerror(errno)
                                   << ", expected root, or a kernel that lets users have namespaces";
    const int any = ::socket(AF_INET, SOCK_DGRAM, 0);
    ifreq lo{};
    std::strcpy(lo.ifr_name, "lo");
    lo.ifr_flags = IFF_UP | IFF_RUNNING | IFF_LOOPBACK;
    EXPECT_EQ(::ioctl(any, SIOCSIFFLAGS, &lo), 0) << std::strerror(errno);
    ::close(any);
    if (!testing::Test::HasFailure()) act();
    std::fflush(nullptr);
    ::_exit(testing::Test::HasFailure() ? 1 : 0);
  }
  int status = -1;
  while (::waitpid(child, &status, 0) != child && errno == EINTR) {
  }
  EXPECT_EQ(WIFEXITED(status) ? WEXITSTATUS(status) : -1, 0) << "see above";
}

struct Packet {
  std::uint16_t port;
  std::vector<unsigned char> bytes;
};

/// Packets of RTPS that pass the loopback of this network, as they are.
inline std::vector<Packet> overheard(std::size_t most, std::chrono::seconds within) {
  constexpr std::size_t ethernet = 14, udp = 8, rtps_header = 20;
  constexpr unsigned char protocol_udp = 17;
  std::vector<Packet> seen;
  const int tap = ::socket(AF_PACKET, SOCK_RAW, htons(ETH_P_ALL));
  sockaddr_ll all{};
  all.sll_family = AF_PACKET;
  all.sll_protocol = htons(ETH_P_ALL);
  all.sll_ifindex = static_cast<int>(::if_nametoindex("lo"));
  EXPECT_EQ(::bind(tap, reinterpret_cast<sockaddr*>(&all), sizeof all), 0) << std::strerror(errno);
  const timeval wait = {0, 100'000};
  ::setsockopt(tap, SOL_SOCKET, SO_RCVTIMEO, &wait, sizeof wait);
  std::vector<unsigned char> b(65536);
  const auto end = std::chrono::steady_clock::now() + within;
  while (seen.size() < most && std::chrono::steady_clock::now() < end) {
    const ssize_t got = ::recv(tap, b.data(), b.size(), 0);
    if (got < static_cast<ssize_t>(ethernet + 20) || b[ethernet + 9] != protocol_udp) continue;
    const std::size_t to = ethernet + (b[ethernet] & 15U) * 4, at = to + udp,
                      n = static_cast<std::size_t>(got);
    if (n < at + rtps_header || std::memcmp(&b[at], "RTPS", 4) != 0) continue;
    seen.push_back({static_cast<std::uint16_t>(b[to + 2] << 8 | b[to + 3]),
                    {b.begin() + static_cast<std::ptrdiff_t>(at), b.begin() + got}});
  }
  ::close(tap);
  return seen;
}

/// Sends packets that are nearly those, to where they went.
/// @param rate  a second
inline long forge(const std::vector<Packet>& models, long count, double rate) {
  constexpr std::size_t header = 20;
  const int out = ::socket(AF_INET, SOCK_DGRAM, 0);
  std::mt19937_64 random(11);
  const auto below = [&](std::size_t n) { return n > 0 ? random() % n : 0; };
  const auto byte = [&] { return static_cast<unsigned char>(random()); };
  const auto begin = std::chrono::steady_clock::now();
  long sent = 0;
  for (long k = 0; k < count; ++k) {
    if (k % 16 == 0)
      std::this_thread::sleep_until(
          begin + std::chrono::microseconds(static_cast<long>(1e6 * static_cast<double>(k) / rate)));
    Packet p = models[below(models.size())];
    std::vector<unsigned char>& x = p.bytes;
    switch (below(6)) {
      case 0:
        x.resize(header + below(x.size() - header));
        break;
      case 1:
        for (std::size_t j = 1 + below(12); j > 0; --j) x[below(x.size())] = byte();
        break;
      case 2: {
        const std::array<std::uint32_t, 5> words = {0xffffffff, 0x7fffffff, 0, 0x80000000,
                                                    static_cast<std::uint32_t>(random())};
        const std::size_t at = header + 4 * below((x.size() - header) / 4);
        if (at + 4 <= x.size()) std::memcpy(&x[at], &words.at(below(words.size())), 4);
        break;
      }
      case 3:
        x.resize(x.size() + below(300), byte());
        break;
      case 4:
        x.resize(header + below(600));
        for (std::size_t j = header; j < x.size(); ++j) x[j] = byte();
        break;
      default:
        for (std::size_t j = header; j < x.size(); ++j)
          if (below(40) == 0) x[j] = byte();
    }
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(p.port);
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    sent += ::sendto(out, x.data(), x.size(), 0, reinterpret_cast<sockaddr*>(&to), sizeof to) > 0 ? 1 : 0;
  }
  ::close(out);
  return sent;
}

}  // namespace sightline::test
