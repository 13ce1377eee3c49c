#include "bridges/dds/simulators/simulated_radio.hpp"

#include <utility>

#include "sightline/base/now.hpp"

namespace sightline::dds {
namespace {

constexpr std::int64_t echo_period = one_second, millisecond = 1'000'000;  // [ns]

}  // namespace

void SimulatedRadio::log(Act arrives) {
  if (logs_.size() < logs_most)
    logs_.push_back(std::move(arrives));
  else
    ++logs_lost_;
}

void SimulatedRadio::send_echo() {
  send(RadioPort::echo, [this, sent = now_, number = ++echoes_] {
    log([this, sent, number] {
      if (number == echoes_) latency_ = static_cast<int>((now_ - sent) / millisecond);
    });
  });
}

void SimulatedRadio::carry() {
  ++sent_;
  arrived_ += share_;
  if (arrived_ < 1.0) return;
  arrived_ -= 1.0;
  ++received_;
  // The answer was ready before the packet came.
  const Act answer = logs_.empty() ? Act{} : std::move(logs_.front());
  if (answer) logs_.pop_front();
  if (!up_.empty()) {
    const Act arrives = up_.top().arrives;
    up_.pop();
    arrives();
  }
  if (answer) answer();
}

void SimulatedRadio::run(std::int64_t now) {
  while (now_ + interval_ <= now) {
    now_ += interval_;
    if (now_ >= echo_at_) {
      echo_at_ = now_ + echo_period;
      send_echo();
    }
    carry();
  }
}

}  // namespace sightline::dds
