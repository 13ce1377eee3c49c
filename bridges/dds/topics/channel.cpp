#include "bridges/dds/topics/channel.hpp"

#include <dds/ddsi/ddsi_serdata.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <memory>
#include <stdexcept>

#include "sightline/base/c_callback.hpp"
#include "sightline/base/now.hpp"

namespace sightline::dds {
namespace {

constexpr std::size_t header = 4;  // of a serialised message [bytes]
constexpr std::uint32_t writers_max = 4096;

struct QosDelete {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
using Qos = std::unique_ptr<dds_qos_t, QosDelete>;
struct SerdataUnref {
  void operator()(ddsi_serdata* data) const { ddsi_serdata_unref(data); }
};
using Listener = std::unique_ptr<dds_listener_t, void (*)(dds_listener_t*)>;

Qos qos_of(Quality quality, const MessageType& type) {
  Qos qos(dds_create_qos());
  dds_qset_reliability(qos.get(), quality.reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                       DDS_MSECS(100));
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, quality.depth);
  dds_qset_durability(qos.get(),
                      quality.transient_local ? DDS_DURABILITY_TRANSIENT_LOCAL : DDS_DURABILITY_VOLATILE);
  dds_qset_durability_service(qos.get(), 0, DDS_HISTORY_KEEP_LAST, quality.depth, DDS_LENGTH_UNLIMITED,
                              DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);  // for late-joining readers
  dds_qset_writer_data_lifecycle(qos.get(), false);
  const dds_data_representation_id_t plain = DDS_DATA_REPRESENTATION_XCDR1;
  dds_qset_data_representation(qos.get(), 1, &plain);
  const std::string hash = fmt::format("typehash={};", type_hash(type));
  dds_qset_userdata(qos.get(), hash.data(), hash.size());
  return qos;
}

/// Creates the topic with the type name used on the wire.
Entity made_topic(dds_entity_t participant, const dds_topic_descriptor_t& type, const std::string& topic) {
  const std::string type_name = wire_type(type.m_typename);
  dds_topic_descriptor_t named = type;
  named.m_typename = type_name.c_str();
  Entity made(dds_create_topic(participant, &named, topic.c_str(), nullptr, nullptr));
  if (made.get() < 0)
    throw std::runtime_error(fmt::format("topic {}: {}", topic, dds_strretcode(-made.get())));
  return made;
}

void note_reader(dds_entity_t, dds_publication_matched_status_t status, void* came) noexcept {
  if (status.current_count_change > 0) *static_cast<std::atomic<std::int64_t>*>(came) = monotonic_now();
}

std::string on_wire(const std::string& topic) { return topic.starts_with('/') ? wire_topic(topic) : topic; }

}  // namespace

RawWriter::RawWriter(Port at, const dds_topic_descriptor_t& type, const std::string& topic, Quality quality)
    : topic_(on_wire(topic)), type_(wire_type(type.m_typename)) {
  if (at.publish == PublishMode::off) return;
  const Qos qos = qos_of(quality, message_type(type.m_typename));
  const Listener listener(dds_create_listener(&reader_came_), dds_delete_listener);
  dds_lset_publication_matched(listener.get(), c_callback<note_reader>);
  of_topic_ = made_topic(at, type, topic_);
  entity_ = Entity(dds_create_writer(at, of_topic_.get(), qos.get(), listener.get()));
  if (entity_.get() < 0)
    throw std::runtime_error(fmt::format("writer of {}: {}", topic_, dds_strretcode(-entity_.get())));
}

bool RawWriter::received(std::span<const SeenWriter> readers) const {
  if (entity_.get() > 0) return matched() > 0;
  return std::any_of(readers.begin(), readers.end(), [&](const SeenWriter& reader) {
    return reader.topic == topic_ && reader.type == type_;
  });
}

int RawWriter::matched() const noexcept {
  if (entity_.get() == 0) return 0;
  return std::max(0, static_cast<int>(dds_get_matched_subscriptions(entity_.get(), nullptr, 0)));
}

int RawWriter::rivals(std::span<const SeenWriter> writers) const {
  dds_guid_t ours{};  // all zero with PublishMode::off: equal to no writer's
  if (entity_.get() > 0) dds_get_guid(entity_.get(), &ours);
  return static_cast<int>(std::count_if(writers.begin(), writers.end(), [&](const SeenWriter& writer) {
    return writer.topic == topic_ && std::memcmp(&writer.guid, &ours, sizeof ours) != 0;
  }));
}

WriterList::WriterList(dds_entity_t participant, dds_entity_t of)
    : reader_(dds_create_reader(participant, of, nullptr, nullptr)),
      samples_(writers_max),
      infos_(writers_max) {
  if (reader_.get() < 0)
    throw std::runtime_error(fmt::format("who writes: {}", dds_strretcode(-reader_.get())));
}

std::vector<SeenWriter> WriterList::look() {
  std::vector<SeenWriter> writers;
  samples_[0] = nullptr;  // null: Cyclone DDS lends its own samples
  const dds_return_t count =
      dds_read(reader_.get(), samples_.data(), infos_.data(), writers_max, writers_max);
  for (std::size_t i = 0; i < static_cast<std::size_t>(std::max(0, count)); ++i) {
    if (!infos_[i].valid_data || infos_[i].instance_state != DDS_ALIVE_INSTANCE_STATE) continue;
    const auto& endpoint = *static_cast<const dds_builtintopic_endpoint_t*>(samples_[i]);
    writers.push_back({endpoint.topic_name, endpoint.type_name, endpoint.key});
  }
  if (count > 0) dds_return_loan(reader_.get(), samples_.data(), count);
  return writers;
}

RawReader::RawReader(dds_entity_t participant, const dds_topic_descriptor_t& type, const std::string& topic,
                     Quality quality, std::optional<std::size_t> payload, Writers writers, Take take)
    : topic_(on_wire(topic)),
      type_(type),
      payload_(payload),
      writers_(writers),
      take_(std::move(take)),
      scratch_((type.m_size + 7) / 8) {
  const Qos qos = qos_of(quality, message_type(type.m_typename));
  const Listener listener(dds_create_listener(this), dds_delete_listener);
  dds_lset_data_available(listener.get(), c_callback<on_data>);
  dds_lset_subscription_matched(listener.get(), c_callback<on_writer>);
  of_topic_ = made_topic(participant, type, topic_);
  entity_ = Entity(dds_create_reader(participant, of_topic_.get(), qos.get(), listener.get()));
  if (entity_.get() < 0)
    throw std::runtime_error(fmt::format("reader of {}: {}", topic_, dds_strretcode(-entity_.get())));
}

int RawReader::matched() const noexcept {
  return std::max(0, static_cast<int>(dds_get_matched_publications(entity_.get(), nullptr, 0)));
}

void RawReader::take(const ddsi_serdata* data, std::uint64_t writer) {
  // Messages are padded to a multiple of 4 on the wire.
  const std::size_t size = ddsi_serdata_size(data) - header;
  const std::size_t wanted = payload_ ? (*payload_ + 3) / 4 * 4 : payload_max;
  if (payload_ ? size != wanted && size != *payload_ : size > wanted) {
    ++(size < wanted ? counts_.too_short : counts_.too_long);
    counts_.wrong_size = static_cast<std::uint32_t>(size);
    return;
  }
  if (first_writer_ == 0) first_writer_ = writer;
  if (writers_ == Writers::first && writer != first_writer_) {
    ++counts_.foreign;
    return;
  }
  std::fill(scratch_.begin(), scratch_.end(), 0);
  const auto free = [this](void* message) { dds_sample_free(message, &type_, DDS_FREE_CONTENTS); };
  const std::unique_ptr<void, decltype(free)> contents(scratch_.data(), free);  // take_() may throw
  if (ddsi_serdata_to_sample(data, scratch_.data(), nullptr, nullptr)) {
    ++counts_.received;
    take_(scratch_.data(), {monotonic_now(), writer, size});
  } else {
    ++counts_.unreadable;
  }
}

void RawReader::on_writer(dds_entity_t, dds_subscription_matched_status_t status, void* self) {
  if (status.current_count_change > 0) ++static_cast<RawReader*>(self)->writers_came_;
}

void RawReader::on_data(dds_entity_t reader, void* self) {
  auto& own = *static_cast<RawReader*>(self);
  constexpr std::uint32_t most = 8;
  ddsi_serdata* data[most] = {};
  dds_sample_info_t info[most];
  for (dds_return_t n; (n = dds_takecdr(reader, data, most, info, DDS_ANY_STATE)) > 0;) {
    const auto count = static_cast<std::size_t>(n);
    std::array<std::unique_ptr<ddsi_serdata, SerdataUnref>, most> held;  // released even if take() throws
    for (std::size_t i = 0; i < count; ++i) held[i].reset(data[i]);
    for (std::size_t i = 0; i < count; ++i)
      if (info[i].valid_data) own.take(data[i], info[i].publication_handle);
  }
}

}  // namespace sightline::dds
