#include "bridges/dds/links/px4_diagnostics.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "bridges/dds/links/px4_release.hpp"
#include "sightline/base/now.hpp"

extern "C" {
#include "px4.h"
}

namespace sightline::dds {
namespace {

constexpr int requested_most = 5;
constexpr Nanoseconds battery_old = 5'000'000'000;
constexpr std::string_view transmitter_flag = "manual_control_signal_lost";
// Flags that are set before every offboard flight, or are irrelevant to one.
constexpr std::array<std::string_view, 4> usual_flags = {transmitter_flag, px4_offboard_flag,
                                                         "auto_mission_missing", "gcs_connection_lost"};
constexpr std::array<std::string_view, 5> warnings = {"none", "low", "critical", "an emergency", "failed"};

bool is_usual(std::string_view flag) {
  return std::find(usual_flags.begin(), usual_flags.end(), flag) != usual_flags.end();
}

}  // namespace

Px4Diagnostics::Px4Diagnostics(dds_entity_t participant, const Px4Link& link)
    : link_(link),
      release_(px4_first + static_cast<int>(link.release)),
      flags_layout_("FailsafeFlags", release_) {
  for (const Field& field : flags_layout_.type().fields) {
    if (field.type != "boolean" || flag_names_.size() == flags_most) continue;
    if (field.name == transmitter_flag) transmitter_ = flag_names_.size();
    if (field.name == px4_global_flag) global_ = flag_names_.size();
    flag_names_.push_back(field.name);
    flag_places_.push_back(flags_layout_.place(field.name));
  }
  readers_.push_back(std::make_unique<RawReader>(
      participant, flags_layout_.descriptor(), topic_of("FailsafeFlags", release_), of_sensors,
      flags_layout_.size(), Writers::all, [this](const void* m, const Arrival& a) {
        Flags flags{a.monotonic};
        for (std::size_t i = 0; i < flag_places_.size(); ++i)
          flags.set[i] = read_at<bool>(m, flag_places_[i]);
        flags_.put(flags);
      }));
  readers_.push_back(std::make_unique<RawReader>(
      participant, px4_msgs_msg_dds__TimesyncStatus__desc, topic_of("TimesyncStatus", release_), of_sensors,
      payload_size(px4_type("TimesyncStatus", release_)), Writers::all,
      [this](const void* m, const Arrival&) {
        const auto& sync = *static_cast<const px4_msgs_msg_dds__TimesyncStatus_*>(m);
        stamps_behind_.put(1e-6 * static_cast<double>(sync.estimated_offset - sync.observed_offset));
      }));
  read_signs(participant);
  if (release_ >= px4_answers_formats_from) read_formats(participant);
}

std::string Px4Diagnostics::topic_of(std::string_view message, int release) const {
  return px4_topic(link_.name_space, Px4Side::out, message, release);
}

// Reads only the common beginning of a message: each reader accepts all layouts and records their
// sizes.
void Px4Diagnostics::read_signs(dds_entity_t participant) {
  int version = -1;
  std::string before;
  for (const std::string message : {"VehicleStatus", "VehicleLocalPosition"}) {
    for (int release = px4_first; release <= px4_last; ++release) {
      if (message == before && px4_version(message, release) == version) continue;
      before = message;
      version = px4_version(message, release);
      Sign& one = *signs_.emplace_back(new Sign{message, version, px4_msgs_msg_dds__Beginning__desc});
      one.descriptor.m_typename = px4_type(message, release).idl_name.c_str();
      one.reader = std::make_unique<RawReader>(
          participant, one.descriptor, topic_of(message, release), of_sensors, std::nullopt, Writers::all,
          [&one](const void*, const Arrival& a) { one.size = static_cast<std::uint32_t>(a.size); });
    }
  }
}

void Px4Diagnostics::read_formats(dds_entity_t participant) {
  request_ = std::make_unique<RawWriter>(
      participant, px4_msgs_msg_dds__MessageFormatRequest__desc,
      px4_topic(link_.name_space, Px4Side::in, "MessageFormatRequest", release_), of_sensors);
  readers_.push_back(std::make_unique<RawReader>(
      participant, px4_msgs_msg_dds__MessageFormatResponse__desc, topic_of("MessageFormatResponse", release_),
      Quality{.depth = 8}, payload_size(px4_type("MessageFormatResponse", release_)), Writers::all,
      [this](const void* m, const Arrival&) {
        const auto& response = *static_cast<const px4_msgs_msg_dds__MessageFormatResponse_*>(m);
        std::string_view topic(response.topic_name, sizeof response.topic_name);
        topic = topic.substr(0, topic.find('\0'));
        for (std::size_t i = 0; i < sent.size(); ++i)
          if (topic == px4_topic("", Px4Side::in, sent[i], px4_first))
            answers_[i].put({true, response.success, response.message_hash});
      }));
}

void Px4Diagnostics::request_formats() {
  if (!request_ || requested_ == requested_most || request_->matched() == 0) return;
  ++requested_;
  for (std::size_t i = 0; i < sent.size(); ++i) {
    if (answers_[i].count() > 0) continue;
    px4_msgs_msg_dds__MessageFormatRequest_ request{};
    request.protocol_version = 1;
    const std::string topic = px4_topic("", Px4Side::in, sent[i], px4_first);
    topic.copy(request.topic_name, sizeof request.topic_name - 1);
    (void)request_->write(&request);
  }
}

const Px4Diagnostics::Sign& Px4Diagnostics::sign(std::string_view message, int version) const {
  return **std::find_if(signs_.begin(), signs_.end(), [&](const std::unique_ptr<Sign>& one) {
    return one->message == message && one->version == version;
  });
}

Px4Diagnostics::Looks Px4Diagnostics::looks_like(const Surroundings& around) const {
  const auto came = [&](std::string_view message, int version) { return sign(message, version).size > 0; };
  if (came("VehicleStatus", 4)) return {"1.18", "vehicle_status_v4"};
  if (came("VehicleStatus", 1)) {
    if (came("VehicleLocalPosition", 1)) return {"1.17", "vehicle_status_v1 and vehicle_local_position_v1"};
    if (came("VehicleLocalPosition", 0)) return {"1.16", "vehicle_status_v1 and vehicle_local_position"};
    return {release_ == 17 ? "1.17" : "1.16", "vehicle_status_v1"};
  }
  if (const std::uint32_t size = sign("VehicleStatus", 0).size; size > 0) {
    for (const int release : {14, 15}) {
      const std::size_t known = *payload_size(px4_type("VehicleStatus", release));
      if (size >= known && size < known + 4)
        return {fmt::format("1.{}", release), fmt::format("vehicle_status of {} bytes", known)};
    }
    return {"a release that is not known", fmt::format("vehicle_status of {} bytes", size)};
  }
  // Releases after 1.18: a vehicle_status topic version that no known release has.
  const std::string begin = wire_topic(link_.name_space + "/fmu/out/vehicle_status_v");
  for (const SeenWriter& writer : around.writers) {
    const bool ours = std::any_of(signs_.begin(), signs_.end(), [&](const std::unique_ptr<Sign>& one) {
      return one->reader->topic() == writer.topic;
    });
    if (writer.topic.starts_with(begin) && !ours) return {"a newer release than 1.18", writer.topic};
  }
  return {};
}

void Px4Diagnostics::examine_release(const Surroundings& around, FindingList& to) const {
  const std::string wanted = fmt::format("1.{}", release_);
  const Looks looks = looks_like(around);
  if (looks.release.empty()) {
    to.add(Aspect::release, Light::unknown, "no vehicle_status of any release came");
    return;
  }
  if (looks.release != wanted) {
    to.add(Aspect::release, Light::red, "it looks like PX4 {}, by {}; expected {}", looks.release, looks.by,
           wanted);
    return;
  }
  examine_formats(to);
  const bool answered = std::all_of(answers_.begin(), answers_.end(),
                                    [](const Mailbox<Answer>& answer) { return answer.count() > 0; });
  to.add_green(Aspect::release, "PX4 {}, by {}; {}", wanted, looks.by,
               answered ? "it takes what we send"
               : release_ < px4_answers_formats_from
                   ? "the layouts that it takes cannot be requested before 1.15"
                   : "it did not answer which layouts it takes");
}

void Px4Diagnostics::examine_formats(FindingList& to) const {
  for (std::size_t i = 0; i < sent.size(); ++i) {
    Answer answer;
    if (!answers_[i].look(answer)) continue;
    const std::string topic = px4_topic("", Px4Side::in, sent[i], px4_first);
    if (!answer.success) {
      to.add(Aspect::release, Light::red, "it has no {}, by its own answer: its dds_topics.yaml lacks it",
             topic);
      continue;
    }
    if (answer.hash == px4_hash(px4_type(sent[i], release_))) continue;
    std::string of = "of no release that is known";
    for (int release = px4_first; release <= px4_last; ++release)
      if (answer.hash == px4_hash(px4_type(sent[i], release))) of = fmt::format("of PX4 1.{}", release);
    to.add(Aspect::release, Light::red, "it takes the {} {}, by its own answer; expected that of 1.{}", topic,
           of, release_);
  }
}

void Px4Diagnostics::examine_battery(const Px4Battery& battery, FindingList& to) const {
  if (battery.arrived == 0 || monotonic_now() - battery.arrived > battery_old || !battery.connected) {
    to.add(Aspect::battery, Light::unknown, "it does not report a battery");
    return;
  }
  const double remaining = double{battery.remaining};
  const bool says = std::isfinite(remaining) && remaining >= 0;
  const std::string level =
      fmt::format("{}{:.1f} V", says ? fmt::format("{:.0f} %, ", 100 * remaining) : "", battery.voltage);
  if (battery.warning > 0)
    to.add(Aspect::battery, Light::red, "{}, which it says is {}", level,
           warnings[std::min<std::size_t>(battery.warning, warnings.size() - 1)]);
  else if (says && remaining < link_.battery_min)
    to.add(Aspect::battery, Light::red, "{}, expected battery_min = {:.0f} %", level,
           100 * link_.battery_min);
  else
    to.add(Aspect::battery, Light::green, "{}", level);
}

void Px4Diagnostics::examine(const Surroundings& around, const Px4Battery& battery, FindingList& to) {
  request_formats();
  examine_release(around, to);
  examine_battery(battery, to);
  Flags flags;
  if (!flags_.look(flags))
    to.add(Aspect::pilot, Light::unknown, "it does not report whether it receives a pilot's transmitter");
  else if (flags.set[transmitter_])
    to.add(Aspect::pilot, Light::red,
           "it receives no pilot's transmitter: no pilot can take over by a switch");
  else
    to.add(Aspect::pilot, Light::green, "it receives a pilot's transmitter");
}

bool Px4Diagnostics::lacks_origin() const noexcept {
  Flags flags;
  return flags_.look(flags) && flags.set[global_];
}

double Px4Diagnostics::stamps_behind() const noexcept {
  double behind = 0.0;
  (void)stamps_behind_.look(behind);
  return behind;
}

std::string Px4Diagnostics::failing(std::string_view needed) const {
  Flags flags;
  if (!flags_.look(flags)) return "";
  std::vector<std::string_view> set;
  for (std::size_t i = 0; i < flag_names_.size(); ++i)
    if (flags.set[i] && (flag_names_[i] == needed || !is_usual(flag_names_[i])))
      set.emplace_back(flag_names_[i]);
  return set.empty() ? "" : fmt::format(" ({})", fmt::join(set, ", "));
}

}  // namespace sightline::dds
