#include "bridges/dds/topics/prediction_exchange.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bridges/dds/topics/flight_publisher.hpp"
#include "bridges/dds/topics/ros_message.hpp"
#include "sightline/base.hpp"
#include "sightline/base/now.hpp"
#include "sightline/scenario/read_partition.hpp"

extern "C" {
#include "parts.h"
}

namespace sightline::dds {
namespace {

constexpr std::size_t messages_kept = 16;  // minimum queue length
constexpr Quality of_predictions = {false, false, 1};
constexpr Nanoseconds agreed_in = 300'000'000;       // time for all parts to receive the start time [ns]
constexpr Nanoseconds begins_soon = 10'000'000'000;  // [ns]

/// Clock difference: real-time minus monotonic.
Nanoseconds realtime_ahead() noexcept { return realtime_now() - monotonic_now(); }

/// A message with all vectors sized for good; copies of a vector have no spare capacity.
PartMessage full_message(std::size_t robots, std::size_t stages, std::size_t parts) {
  PartMessage message;
  message.predictions.resize(robots);
  for (Prediction& prediction : message.predictions) prediction.sights.resize(stages);
  message.echoes.resize(parts);
  return message;
}

int place_of(const std::vector<PlannedPart>& parts, std::string_view name) {
  const auto found =
      std::find_if(parts.begin(), parts.end(), [&](const PlannedPart& one) { return one.name == name; });
  return static_cast<int>(found - parts.begin());
}

/// Copies into existing capacity.
void copy(std::span<const Prediction> from, std::span<Prediction> to) noexcept {
  for (std::size_t i = 0; i < std::min(from.size(), to.size()); ++i) {
    to[i].who = from[i].who;
    to[i].h = from[i].h;
    to[i].sights.assign(from[i].sights.begin(), from[i].sights.end());
  }
}

}  // namespace

std::string prediction_topic(std::string_view team, std::string_view part) {
  return fmt::format("/sightline/{}/{}/prediction", topic_part(team), part);
}

PredictionExchange::PredictionExchange(const Scenario& scenario, dds_entity_t participant)
    : team_(scenario.team),
      own_(place_of(scenario.partition->parts, scenario.partition->part)),
      step_(scenario.horizon.h()),
      period_(to_nanoseconds(scenario.horizon.dt)),
      stages_(size(scenario.horizon.N + 1)),
      part_of_(size(team_.bodies()), -1),
      no_input_(size(std::max(1, team_.nu()))),
      exchange_(scenario.partition->exchange),
      peers_(static_cast<int>(scenario.partition->parts.size()), own_, to_nanoseconds(exchange_.stale_after)),
      session_(static_cast<std::uint64_t>(realtime_now())),
      writer_(participant, sightline_msgs_msg_dds__Prediction__desc,
              prediction_topic(scenario.name, scenario.partition->part), of_predictions),
      waiting_(messages_kept,
               full_message(team_.agents().size(), stages_, scenario.partition->parts.size())) {
  const std::vector<PlannedPart>& parts = scenario.partition->parts;
  for (std::size_t i = 0; i < parts.size(); ++i) {
    parts_.push_back(parts[i].name);
    for (const std::string& robot : parts[i].robots)
      part_of_[at(team_.find(robot).index)] = static_cast<int>(i);
  }
  for (int i = 0; i < team_.bodies(); ++i)
    if (team_.is_agent(BodyId{i})) robots_.push_back(BodyId{i});
  for (std::size_t i = 0; i < parts.size(); ++i) {
    others_.push_back(std::make_unique<OtherPart>());
    if (static_cast<int>(i) == own_) continue;
    OtherPart& other = *others_.back();
    other.name = parts[i].name;
    other.names = parts[i].robots;
    for (const std::string& robot : parts[i].robots) other.robots.push_back(team_.find(robot));
    other.newest = full_message(other.robots.size(), stages_, parts.size());
    const auto late = static_cast<std::size_t>((exchange_.delay + exchange_.jitter) / scenario.horizon.dt);
    other.came = std::make_unique<SpscQueue<PartMessage>>(
        messages_kept + 2 * late, full_message(other.robots.size(), stages_, parts.size()));
    other.reader = std::make_unique<RawReader>(
        participant, sightline_msgs_msg_dds__Prediction__desc, prediction_topic(scenario.name, other.name),
        of_predictions, std::nullopt, Writers::all,
        [this, &other](const void* message, const Arrival& arrival) { take(other, message, arrival); });
  }
  thread_.start([this] { write_all(); });
}

PredictionExchange::~PredictionExchange() {
  for (auto& other : others_) other->reader.reset();
  waiting_.close();
  thread_.join();
}

/// Receive thread. Messages of another shape than the scenario's are counted and dropped.
void PredictionExchange::take(OtherPart& from, const void* raw, const Arrival& arrival) {
  const auto& message = *static_cast<const sightline_msgs_msg_dds__Prediction_*>(raw);
  const bool fits = message.part != nullptr && from.name == message.part && message.stamp > 0 &&
                    message.phase <= static_cast<std::uint8_t>(PartPhase::landing) &&
                    (message.begins == 0 ||
                     (message.begins > 0 && std::abs(message.begins - message.stamp) < begins_soon)) &&
                    std::abs(message.step - step_) < 1e-9 && message.robots._length == from.robots.size();
  PartMessage* const slot = fits ? from.came->claim() : nullptr;
  if (slot == nullptr) {
    if (!fits) ++from.garbled;
    return;
  }
  slot->part = static_cast<int>(std::find(parts_.begin(), parts_.end(), from.name) - parts_.begin());
  slot->session = message.session;
  slot->sequence = message.number;
  slot->stamp = message.stamp;
  slot->steers = message.steers;
  slot->phase = message.phase;
  slot->begins = message.begins;
  for (std::size_t i = 0; i < from.robots.size(); ++i) {
    const auto& robot = message.robots._buffer[i];
    Prediction& prediction = slot->predictions[i];
    prediction.who = from.robots[i];
    prediction.h = step_;
    prediction.sights.clear();
    const bool whole = robot.robot != nullptr && from.names[i] == robot.robot &&
                       robot.sights._length == stages_ * sight_size;
    for (std::size_t k = 0; whole && k < stages_; ++k)
      prediction.sights.push_back(sight_from<double>(robot.sights._buffer + k * sight_size));
    if (whole && prediction.is_finite()) continue;
    ++from.garbled;
    return;  // the slot stays unpublished; the next claim() reuses it
  }
  std::fill(slot->echoes.begin(), slot->echoes.end(), Echo{});
  for (std::uint32_t i = 0; i < message.echoes._length; ++i) {
    const auto& echo = message.echoes._buffer[i];
    if (echo.part == nullptr) continue;
    const auto part = std::find(parts_.begin(), parts_.end(), echo.part);
    if (part != parts_.end())
      slot->echoes[static_cast<std::size_t>(part - parts_.begin())] = {echo.stamp, echo.held};
  }
  slot->arrived = arrival.monotonic;
  from.came->publish();
}

/// Simulated additional delay; negative: the message is lost.
Nanoseconds PredictionExchange::delay_of(const PartMessage& message) const noexcept {
  if (exchange_.flown_by == MessagesBy::network) return 0;
  const auto chance = [&](MessageChance what) {
    return chance_of(what, exchange_.seed, own_, message.part, message.sequence);
  };
  if (chance(MessageChance::loss) < exchange_.loss) return -1;
  return to_nanoseconds(exchange_.delay + exchange_.jitter * chance(MessageChance::jitter));
}

/// Processes all received messages, then updates the state of each part.
void PredictionExchange::drain() noexcept {
  const Nanoseconds ahead = realtime_ahead(), now = realtime_now();
  for (std::size_t i = 0; i < others_.size(); ++i) {
    OtherPart& other = *others_[i];
    if (other.came == nullptr) continue;
    while (const PartMessage* message = other.came->front()) {
      const Nanoseconds late = delay_of(*message), at_realtime = message->arrived + ahead + late;
      if (late >= 0 && at_realtime > now) break;
      if (late >= 0 && peers_.receive(*message, at_realtime)) {
        other.newest.stamp = message->stamp;
        copy(message->predictions, other.newest.predictions);
        other.has_newest = true;
      }
      other.came->pop();
    }
    const int part = static_cast<int>(i);
    other.state = peers_.state(part, now);
    other.offset = peers_.offset(part).value_or(0);
  }
}

void PredictionExchange::receive(double, Subteam& receiver) noexcept {
  drain();
  const Nanoseconds ahead = realtime_ahead();
  for (const auto& other : others_) {
    if (other->came == nullptr) continue;
    const PeerState state = other->state;
    const bool use = state == PeerState::received || state == PeerState::idle;
    if (!use && other->used)
      for (const BodyId robot : other->robots) receiver.forget(robot);
    if (use && other->has_newest) {
      const double time = to_seconds(other->newest.stamp - other->offset - ahead - origin_);
      for (const Prediction& prediction : other->newest.predictions) receiver.receive(prediction, time);
    }
    other->used = use;
  }
}

PartMessage* PredictionExchange::claim(ClockTime stamp, PartPhase phase, bool steers) noexcept {
  PartMessage* const message = waiting_.claim();
  ++number_;
  if (message == nullptr) return nullptr;
  message->part = own_;
  message->session = session_;
  message->sequence = number_;
  message->stamp = stamp;
  message->steers = steers;
  message->phase = static_cast<std::uint8_t>(phase);
  message->begins = phase == PartPhase::holding && begins_ ? *begins_ + realtime_ahead() : 0;
  peers_.answer(stamp, message->echoes);
  return message;
}

void PredictionExchange::send(double t, std::span<const Prediction> predictions) noexcept {
  const Nanoseconds stamp = origin_ + to_nanoseconds(t) + realtime_ahead();
  PartMessage* const message = claim(stamp, PartPhase::task, true);
  if (message == nullptr) return;
  copy(predictions, message->predictions);
  waiting_.publish();
}

void PredictionExchange::stand(PartPhase phase, std::span<const double> states) noexcept {
  drain();
  agree(phase);
  PartMessage* const message = claim(realtime_now(), phase, false);
  if (message == nullptr) return;
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    Prediction& prediction = message->predictions[i];
    Sight<double> sight =
        team_.model(robots_[i]).sight(states.data() + team_.state_offset(robots_[i]), no_input_.data());
    prediction.who = robots_[i];
    prediction.sights.clear();
    for (std::size_t k = 0; k < stages_; ++k) {
      prediction.sights.push_back(sight);
      sight.p = sight.p + step_ * sight.v;
    }
  }
  waiting_.publish();
}

bool PredictionExchange::waits_for(int part) const noexcept {
  const OtherPart& other = *others_[at(part)];
  return other.came != nullptr && other.state == PeerState::idle &&
         peers_.phase(part) < static_cast<std::uint8_t>(PartPhase::holding);
}

bool PredictionExchange::all_hold() const noexcept {
  for (int i = 0; i < static_cast<int>(others_.size()); ++i)
    if (waits_for(i)) return false;
  return true;
}

void PredictionExchange::agree(PartPhase phase) noexcept {
  if (phase != PartPhase::holding || !all_hold()) return begins_.reset();
  // In the middle of a period, so that clocks that differ by less than half a period select the
  // same period.
  if (!begins_) begins_ = next_multiple(monotonic_now() + agreed_in, period_) + period_ / 2;
  for (std::size_t i = 0; i < others_.size(); ++i) {
    const int part = static_cast<int>(i);
    const bool holds = others_[i]->came != nullptr && others_[i]->state == PeerState::idle &&
                       peers_.phase(part) == static_cast<std::uint8_t>(PartPhase::holding);
    if (!holds || peers_.begins(part) == 0) continue;
    const Nanoseconds theirs = peers_.begins(part) - others_[i]->offset - realtime_ahead();
    begins_ = std::min(*begins_, theirs);
  }
}

std::string PredictionExchange::awaited() const {
  std::string names;
  for (int i = 0; i < static_cast<int>(others_.size()); ++i)
    if (waits_for(i)) names += fmt::format("{}{}", names.empty() ? "" : ", ", others_[at(i)]->name);
  return names;
}

bool PredictionExchange::receives_from(BodyId, BodyId other) const noexcept { return is_received(other); }

bool PredictionExchange::is_received(BodyId body) const noexcept {
  const int part = part_of_[at(body.index)];
  return part < 0 || part == own_ || others_[at(part)]->state == PeerState::received;
}

std::vector<std::string> PredictionExchange::news() {
  std::vector<std::string> sentences;
  for (const auto& other : others_) {
    const PeerState state = other->state;
    if (other->came == nullptr || state == other->received) continue;
    other->received = state;
    switch (state) {
      case PeerState::silent:
      case PeerState::stale:
        sentences.push_back(fmt::format("part {}: its messages do not arrive", other->name));
        break;
      case PeerState::received:
        sentences.push_back(
            fmt::format("part {}: its messages arrive, its robots fly as they predict", other->name));
        break;
      case PeerState::idle:
        sentences.push_back(
            fmt::format("part {}: its messages arrive, its robots do not fly its task", other->name));
        break;
      case PeerState::other_time:
        sentences.push_back(
            fmt::format("part {}: its clock is {:+.1f} ms from ours, expected at most {:.0f} ms: its "
                        "messages do not arrive",
                        other->name, 1e-6 * static_cast<double>(other->offset), 1e-6 * Peers::offset_max));
        break;
    }
  }
  return sentences;
}

std::vector<std::string> PredictionExchange::counts() const {
  std::vector<std::string> lines = {
      fmt::format("part {}: {} predictions sent", parts_[at(own_)], sent_.load())};
  for (int i = 0; i < static_cast<int>(others_.size()); ++i) {
    const OtherPart& other = *others_[at(i)];
    if (other.came == nullptr) continue;
    const Peers::Counts& c = peers_.counts(i);
    lines.push_back(fmt::format(
        "part {}: {} predictions, {} lost, {} late, {} not readable; clock {:+.3f} ms", other.name,
        c.received, c.lost, c.late, other.garbled.load(), 1e-6 * static_cast<double>(other.offset)));
  }
  return lines;
}

/// Main function of the writing thread.
void PredictionExchange::write_all() {
  std::vector<std::vector<double>> numbers(robots_.size());
  std::vector<sightline_msgs_msg_dds__RobotPrediction_> robots(robots_.size());
  std::vector<sightline_msgs_msg_dds__Echo_> echoes(parts_.size());
  std::vector<std::string> names;
  for (const BodyId robot : robots_) names.emplace_back(team_.name(robot));
  while (const PartMessage* message = waiting_.wait()) {
    sightline_msgs_msg_dds__Prediction_ out{};
    out.part = parts_[at(own_)].data();
    out.session = message->session;
    out.number = message->sequence;
    out.stamp = message->stamp;
    out.step = step_;
    out.steers = message->steers;
    out.phase = message->phase;
    out.begins = message->begins;
    for (std::size_t i = 0; i < robots.size(); ++i) {
      const std::vector<Sight<double>>& sights = message->predictions[i].sights;
      numbers[i].resize(sights.size() * sight_size);
      for (std::size_t k = 0; k < sights.size(); ++k)
        write_sight(sights[k], std::span(numbers[i]).subspan(k * sight_size, sight_size));
      robots[i].robot = names[i].data();
      set_sequence(robots[i].sights, numbers[i]);
    }
    for (std::size_t i = 0; i < echoes.size(); ++i)
      echoes[i] = {parts_[i].data(), message->echoes[i].stamp, message->echoes[i].held};
    set_sequence(out.robots, robots);
    set_sequence(out.echoes, echoes);
    if (writer_.write(&out)) ++sent_;
    waiting_.pop();
  }
}

}  // namespace sightline::dds
