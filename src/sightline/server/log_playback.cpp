#include "sightline/server/log_playback.hpp"

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <thread>
#include <utility>

#include "sightline/base/now.hpp"
#include "sightline/log.hpp"
#include "sightline/readers/cdr.hpp"
#include "sightline/solver.hpp"
#include "sightline/supervisor.hpp"
#include "sightline/world.hpp"

namespace sightline {
namespace {

using WallTime = std::chrono::steady_clock;

constexpr double look_step = 1.0 / 30;  // between two batches [s]
constexpr double unseen_after = 0.5;    // a body without a pose for this time is absent [s]
constexpr double all_subscribed =
    0.2;  // delay after the first subscription [s]: a viewer subscribes topic by topic

/// Thrown to leave the pass through a log when no topic has a subscriber.
struct NobodyListens {};

/// State of a flight at the present position in its log.
class StateOfLog {
 public:
  explicit StateOfLog(const std::vector<std::string>& names) : names_(names) {
    state_.seen.resize(names.size());
    seen_at_.resize(names.size());
    state_.levels.assign(names.size(), to_string(FallbackLevel::valid));
  }

  const ShownState& state() {
    for (std::size_t i = 0; i < seen_at_.size(); ++i)
      if (state_.time - seen_at_[i] > unseen_after) state_.seen[i].reset();
    return state_;
  }

  void take(const McapMessage& message) {
    state_.time = to_seconds(message.log_time);
    if (message.topic == "/solver" || message.topic == "/controller0/solver") return take_solver(message);
    if (message.topic == "/events") return take_event(message);
    const std::size_t slash = message.topic.rfind('/');
    if (slash == std::string_view::npos || slash == 0) return;
    const auto name = std::find(names_.begin(), names_.end(), message.topic.substr(1, slash - 1));
    if (name == names_.end()) return;
    const auto body = static_cast<std::size_t>(name - names_.begin());
    auto& seen = state_.seen[body];
    const std::string_view what = message.topic.substr(slash + 1);
    if (what == "pose") {
      if (const auto pose = decode_pose(message.bytes))
        seen = Sight<double>{{{pose->p[0], pose->p[1], pose->p[2]}, {pose->d[0], pose->d[1]}}, {}};
      seen_at_[body] = state_.time;
    } else if (what == "attitude" && seen) {  // follows the pose of the same period
      if (const auto reported = decode_attitude(message.bytes))
        seen->lean = lean(rotation({reported->q[3], reported->q[0], reported->q[1], reported->q[2]}));
    }
  }

 private:
  void read(const McapMessage& message) {
    text_.read({reinterpret_cast<const char*>(message.bytes.data()), message.bytes.size()});
  }

  void take_solver(const McapMessage& message) {
    read(message);
    state_.residual = text_.number("residual");
    state_.iterations = static_cast<int>(text_.number("iterations"));
    for (int i = 0; i < status_count; ++i)
      if (to_string(static_cast<Status>(i)) == text_.word("status"))
        state_.status = to_string(static_cast<Status>(i));
  }

  void take_event(const McapMessage& message) {
    read(message);
    const double body = text_.number("value");
    if (!(body >= 0 && body < static_cast<double>(names_.size()))) return;
    for (int i = 0; i < fallback_level_count; ++i)
      if (to_string(static_cast<FallbackLevel>(i)) == text_.word("kind"))
        state_.levels[static_cast<std::size_t>(body)] = to_string(static_cast<FallbackLevel>(i));
  }

  const std::vector<std::string>& names_;
  ShownState state_;
  std::vector<double> seen_at_;  // time of each body's last pose [s]
  LogText text_;
};

}  // namespace

LogPlayback::LogPlayback(std::filesystem::path log, const Scenario& scenario)
    : log_(std::move(log)), feed_(scenario.name), drawn_(scenario, feed_) {
  for (int i = 0; i < scenario.team.bodies(); ++i) names_.emplace_back(scenario.team.name(BodyId{i}));
  McapReader reader(log_);
  for (const McapReader::Topic& one : reader.topics()) {
    const SchemaId schema = feed_.schema(one.schema, one.schema_encoding, one.schema_text);
    channels_[one.topic] = feed_.channel(schema, one.topic, one.encoding, {});
  }
  if (!reader.ok()) throw std::runtime_error(reader.error());
  thread_.start([this] { run(); });
}

LogPlayback::~LogPlayback() {
  done_ = true;
  thread_.join();
}

bool LogPlayback::wait(double seconds) const {
  const auto end = WallTime::now() + std::chrono::duration<double>(seconds);
  while (!done_ && feed_.is_requested() && WallTime::now() < end)
    std::this_thread::sleep_for(std::chrono::duration<double>(std::min(seconds, look_step)));
  return !done_ && feed_.is_requested();
}

void LogPlayback::run() {
  while (!done_) {
    if (!wait(all_subscribed)) {
      std::this_thread::sleep_for(std::chrono::duration<double>(look_step));
      continue;
    }
    try {
      play();
    } catch (const NobodyListens&) {
    } catch (const std::exception&) {  // an invalid message: the messages before it were played
      (void)wait(rest);
    }
  }
}

void LogPlayback::play() {
  McapReader reader(log_);  // reopened: the log may have grown
  StateOfLog flight(names_);
  const auto begin = WallTime::now();
  std::uint64_t first = 0, shown = 0;  // times of the log [ns]; messages before `shown` may be sent
  bool any = false;
  (void)reader.visit([&](const McapMessage& message) {
    if (!std::exchange(any, true)) first = shown = message.log_time;
    while (message.log_time > shown) {
      drawn_.add(flight.state());
      feed_.hand_over(shown);
      if (!wait(look_step)) throw NobodyListens();
      const std::chrono::duration<double> gone = WallTime::now() - begin;
      shown = std::max(shown, first + static_cast<std::uint64_t>(1e9 * gone.count()));
    }
    flight.take(message);
    const auto channel = channels_.find(message.topic);
    if (channel != channels_.end())
      feed_.message(channel->second, message.sequence, message.log_time, message.bytes);
  });
  drawn_.add(flight.state());
  feed_.hand_over(shown);
  (void)wait(rest);
}

}  // namespace sightline
