/// Radio of one Crazyflie as the Crazyswarm2 server uses it.
#pragma once

#include <cstdint>
#include <deque>
#include <functional>
#include <queue>
#include <utility>
#include <vector>

namespace sightline::dds {

/// Ports of packets to a Crazyflie; a lower port goes first.
enum class RadioPort : std::uint8_t { emergency = 6, setpoints = 7, commander = 8, arming = 13, echo = 15 };

/// Carries one packet after another, empty ones if none waits. A packet that is lost is sent again.
/// - The server numbers a packet by those that wait, so packets of one port may overtake each other.
/// - The Crazyflie answers each packet that arrives with one log. At most 200 logs wait, later ones
///   are lost. If it logs more often than packets come, its logs arrive seconds late.
/// - An echo measures the latency once a second, behind all other packets. One that takes longer
///   than a second does not count: the latency then keeps its earlier value.
/// Times are of the monotonic clock [ns]. Single thread.
class SimulatedRadio {
 public:
  using Act = std::function<void()>;
  static constexpr std::size_t logs_most = 200;

  /// @param interval  between two packets [ns], above 0
  /// @param share     of the packets that arrive, 0 to 1
  SimulatedRadio(std::int64_t begin, std::int64_t interval, double share = 1.0)
      : now_(begin), echo_at_(begin), interval_(interval), share_(share) {}

  void set(std::int64_t interval, double share) { interval_ = interval, share_ = share; }
  /// Queues a packet, and a log.
  void send(RadioPort port, Act arrives) { up_.push({port, up_.size(), std::move(arrives)}); }
  void log(Act arrives);
  /// Carries the packets up to this time.
  void run(std::int64_t now);

  std::int64_t now() const { return now_; }
  int latency() const { return latency_; }  ///< last echo [ms]; 0: none yet
  /// Packets so far, with the empty ones and those that were lost; and those that arrived.
  std::int64_t sent() const { return sent_; }
  std::int64_t received() const { return received_; }
  std::int64_t logs_lost() const { return logs_lost_; }

 private:
  struct Packet {
    RadioPort port;
    std::size_t number;
    Act arrives;
    bool operator>(const Packet& other) const {
      return std::pair(port, number) > std::pair(other.port, other.number);
    }
  };
  void carry();
  void send_echo();

  std::priority_queue<Packet, std::vector<Packet>, std::greater<>> up_;
  std::deque<Act> logs_;
  std::int64_t now_, echo_at_, interval_;
  double share_, arrived_ = 0.0;  // part of the next packet that has arrived
  int latency_ = 0, echoes_ = 0;
  std::int64_t sent_ = 0, received_ = 0, logs_lost_ = 0;
};

}  // namespace sightline::dds
