#include "sightline/server/tuning.hpp"

#include <fmt/format.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <deque>
#include <limits>
#include <mutex>
#include <stdexcept>
#include <thread>
#include <utility>

#include "sightline/base.hpp"
#include "sightline/base/json_text.hpp"
#include "sightline/base/sentence.hpp"
#include "sightline/server/tuner.hpp"

namespace sightline {
namespace {

using Message = nlohmann::ordered_json;

constexpr std::chrono::milliseconds look_after{50};  // interval of checks for occurred events
constexpr std::string_view expected_message =
    R"(expected one object as {"id": "1", "event": {"retune": {"couple": "couple[0]", "weight": 0.4}}})";

void check_message(const Message& message) {
  if (message.is_discarded() || !message.is_object()) throw_invalid("no JSON object, {}", expected_message);
  int requested = 0;
  for (const auto& [key, value] : message.items()) {
    requested += key == "event" || key == "pause" || key == "step" || key == "seed" ? 1 : 0;
    const bool known =
        key == "id" || key == "event" || key == "ramp" || key == "pause" || key == "step" || key == "seed";
    if (!known)
      throw_invalid("{}, expected one of id, event, ramp, pause, step, seed", json_text(Message(key)));
  }
  if (requested != 1) throw_invalid("{} of event, pause, step, seed, {}", requested, expected_message);
  if (message.contains("ramp") && !message.contains("event"))
    throw_invalid("ramp, expected beside event alone");
}

std::string id_of(const Message& message) {
  if (message.is_discarded() || !message.is_object() || !message.contains("id") || !message["id"].is_string())
    return {};
  return message["id"].get<std::string>().substr(0, Tuning::id_size_max);
}

std::int64_t whole_number(const Message& message, const char* key, std::int64_t low, std::int64_t high) {
  const Message& value = message.at(key);
  if (!value.is_number_integer() || value < low || value > high)
    throw_invalid("{} = {}, expected a whole number, {} to {}", key, json_text(value), low, high);
  return value.get<std::int64_t>();
}

}  // namespace

class Tuning::Thread {
 public:
  Thread(const Scenario& scenario, TuningControls controls)
      : tuned_(scenario.tuned), tuner_(scenario), controls_(std::move(controls)) {
    write_files(true);
    thread_.start([this] { run(); });
  }
  ~Thread() {
    {
      const std::scoped_lock lock(lock_);
      done_ = true;
    }
    come_.notify_one();
    thread_.join();
  }

  void receive(std::string_view message) {
    {
      const std::scoped_lock lock(lock_);
      if (waiting_.size() >= waiting_max || thread_.failed()) {
        ++stale;
        return;
      }
      waiting_.emplace_back(message);
    }
    come_.notify_one();
  }

  std::string reported() const {
    const std::scoped_lock lock(lock_);
    Message list = Message::array();
    for (const Answer& one : answers_) list.push_back({one.number, one.id, one.accepted, one.sentence});
    const bool paused = controls_.clock != nullptr && controls_.clock->paused();
    return fmt::format(",\"answers\":{},\"paused\":{}", json_text(list), paused);
  }

  PageFiles files() const {
    const std::scoped_lock lock(lock_);
    return files_;
  }

  std::atomic<double> time{0.0};
  std::atomic<bool> over{false};
  std::atomic<std::uint64_t> version{0};
  std::atomic<std::int64_t> refused{0}, stale{0};

 private:
  struct Answer {
    std::int64_t number;
    std::string id;
    bool accepted;
    std::string sentence;
  };

  void run() {
    for (;;) {
      std::string message;
      bool more = false;
      {
        std::unique_lock lock(lock_);
        come_.wait_for(lock, look_after, [&] { return done_ || !waiting_.empty(); });
        if (done_) return;
        if (!waiting_.empty()) {
          message = std::move(waiting_.front());
          waiting_.pop_front();
        }
        more = !waiting_.empty();
      }
      if (!message.empty()) answer(message);
      if (!more) write_files(false);
    }
  }

  void answer(const std::string& text) {
    const Message message = Message::parse(text, nullptr, false);
    Answer sent{0, id_of(message), true, {}};
    try {
      check_message(message);
      sent.sentence = act(message);
    } catch (const std::exception& error) {
      sent.accepted = false;
      sent.sentence = sentence_of(error);
      ++refused;
    }
    write_files(false);  // before the answer, so that its receiver finds the change in the files
    const std::scoped_lock lock(lock_);
    sent.number = answered_++;
    answers_.push_back(std::move(sent));
    if (answers_.size() > answers_reported) answers_.pop_front();
    ++version;
  }

  std::string act(const Message& message) {
    if (over && !message.contains("seed")) throw_invalid("the flight is over, expected one that goes on");
    if (message.contains("event")) {
      double ramp = std::numeric_limits<double>::quiet_NaN();
      if (message.contains("ramp")) {
        if (!message["ramp"].is_number())
          throw_invalid("ramp = {}, expected a number", json_text(message["ramp"]));
        ramp = message["ramp"].get<double>();
      }
      return tuner_.change(message["event"], ramp, time);
    }
    if (message.contains("seed")) {
      const auto seed = whole_number(message, "seed", 0, std::numeric_limits<std::int64_t>::max());
      if (!controls_.restart)
        throw_invalid("seed, expected none: this flight is flown once, `sightline view --tune` begins anew");
      controls_.restart(static_cast<std::uint64_t>(seed));
      return fmt::format("another flight, with seed {}", seed);
    }
    if (controls_.clock == nullptr)
      throw_invalid("{}, expected none: this flight keeps the wall clock, `sightline view --tune` can wait",
                    message.contains("pause") ? "pause" : "step");
    if (message.contains("step")) {
      if (!controls_.clock->paused()) throw_invalid("step, expected a flight that is paused");
      const auto steps = whole_number(message, "step", 1, steps_max);
      for (std::int64_t i = 0; i < steps; ++i) controls_.clock->step();
      return fmt::format("{} period{}", steps, steps == 1 ? "" : "s");
    }
    if (!message["pause"].is_boolean())
      throw_invalid("pause = {}, expected true or false", json_text(message["pause"]));
    if (message["pause"].get<bool>()) {
      controls_.clock->pause();
      return "paused";
    }
    controls_.clock->resume();
    return "flies on";
  }

  /// Writes the files if a change was added, came into force or was ignored.
  void write_files(bool first) {
    std::size_t became = 0;
    for (std::size_t i = 0; i < tuned_->size(); ++i)
      became += (std::isnan(tuned_->at(i)) ? 1U : 2U) + (tuned_->is_ignored(i) ? 1U : 0U);
    if (!first && became == became_) return;
    became_ = became;
    PageFiles files;
    try {
      files = tuned_files();
    } catch (const std::exception& error) {
      // The tuning continues, but outdated files would not match the flight.
      for (const char* path : {"/tuned.toml", "/final.toml"})
        files[path] = {"text/plain; charset=utf-8",
                       fmt::format("# not written, as it could not be made: {}\n", sentence_of(error))};
    }
    const std::scoped_lock lock(lock_);
    for (auto& [path, file] : files) files_.insert_or_assign(path, std::move(file));
    ++version;
  }

  PageFiles tuned_files() {
    PageFiles files;
    Message tunables = tuner_.tunables();
    tunables["tune"] = true;
    tunables["can_pause"] = controls_.clock != nullptr;
    tunables["can_restart"] = static_cast<bool>(controls_.restart);
    const std::string type = "application/toml; charset=utf-8";
    files["/tuned.toml"] = {type, tuner_.flight_text()};
    tunables["no_final"] = nullptr;
    try {
      files["/final.toml"] = {type, tuner_.final_text()};
    } catch (const std::exception& error) {
      const std::string sentence = sentence_of(error);
      tunables["no_final"] = sentence;
      files["/final.toml"] = {"text/plain; charset=utf-8", fmt::format("# {}\n", sentence)};
    }
    files["/tune.json"] = {"application/json", json_text(tunables)};
    return files;
  }

  std::shared_ptr<const TunedScript> tuned_;
  Tuner tuner_;
  TuningControls controls_;
  std::size_t became_ = 0;
  std::int64_t answered_ = 0;

  mutable std::mutex lock_;
  std::condition_variable come_;
  std::deque<std::string> waiting_;
  std::deque<Answer> answers_;
  PageFiles files_;
  bool done_ = false;
  ServiceThread thread_{"the tuning"};  // last: it uses all other members
};

Tuning::Tuning(const Scenario& scenario, TuningControls controls)
    : thread_(std::make_unique<Thread>(scenario, std::move(controls))) {}
Tuning::~Tuning() = default;

void Tuning::receive(std::string_view message) { thread_->receive(message); }
void Tuning::set_time(double t) noexcept { thread_->time = t; }
void Tuning::end() noexcept { thread_->over = true; }
std::uint64_t Tuning::version() const noexcept { return thread_->version; }
std::string Tuning::reported() const { return thread_->reported(); }
PageFiles Tuning::files() const { return thread_->files(); }
std::int64_t Tuning::refused() const noexcept { return thread_->refused; }
std::int64_t Tuning::stale() const noexcept { return thread_->stale; }

}  // namespace sightline
