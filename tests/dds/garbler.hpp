/// Messages as others would write them by mistake or malice: whole ones with odd numbers, and their
/// bytes changed.
#pragma once

#include <dds/dds.h>
#include <dds/ddsi/ddsi_serdata.h>
#include <dds/ddsi/ddsi_sertype.h>

#include <array>
#include <bit>
#include <cstring>
#include <limits>
#include <memory>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "bridges/dds/topics/channel.hpp"
#include "sightline/base/now.hpp"

namespace sightline::dds {

using Bytes = std::vector<unsigned char>;
constexpr std::size_t cdr_header = 4;

/// Payloads of XCDR1, little endian, with their header.
class Payloads {
 public:
  explicit Payloads(std::uint64_t seed) : random_(seed) {}

  /// One that a writer of this type could send: stamps are of now, most numbers small, some of them
  /// as odd as numbers can be.
  Bytes whole(const MessageType& type) {
    Bytes bytes = {0, 1, 0, 0};
    fields(type, bytes);
    return bytes;
  }
  /// The same with something wrong with its bytes.
  Bytes changed(Bytes b) {
    const std::size_t body = b.size() - cdr_header;
    switch (below(6)) {
      case 0:  // fewer
        b.resize(cdr_header + below(body));
        break;
      case 1:  // more
        b.resize(b.size() + 1 + below(200), static_cast<unsigned char>(random_()));
        break;
      case 2:  // lengths, above all
        for (std::size_t k = 1 + below(3); k > 0 && body >= 4; --k) {
          constexpr std::array<std::uint32_t, 8> words = {0xffffffff, 0x7fffffff, 0x80000000, 0x10000000,
                                                          1000000,    0,          1,          200};
          std::memcpy(&b[cdr_header + 4 * below(body / 4)], &words.at(below(words.size())), 4);
        }
        break;
      case 3:
        for (std::size_t k = 1 + below(16); k > 0 && body > 0; --k) b[cdr_header + below(body)] = byte();
        break;
      case 4:  // of another encoding
        b[below(cdr_header)] = static_cast<unsigned char>(below(16));
        break;
      default:
        if (body > 0) b[cdr_header + below(body)] = static_cast<unsigned char>(2 + below(254));
    }
    return b;
  }
  std::size_t below(std::size_t n) { return n > 0 ? random_() % n : 0; }

 private:
  unsigned char byte() { return static_cast<unsigned char>(random_()); }

  template <class T>
  static void put(Bytes& bytes, T value) {
    while ((bytes.size() - cdr_header) % sizeof value != 0) bytes.push_back(0);
    const auto raw = std::bit_cast<std::array<unsigned char, sizeof value>>(value);
    bytes.insert(bytes.end(), raw.begin(), raw.end());
  }
  static void put_text(Bytes& bytes, std::string_view text) {
    put(bytes, static_cast<std::uint32_t>(text.size() + 1));
    bytes.insert(bytes.end(), text.begin(), text.end());
    bytes.push_back(0);
  }
  template <class T>
  T real(std::string_view name) {
    using Limits = std::numeric_limits<T>;
    constexpr std::array<T, 9> odd = {Limits::quiet_NaN(),
                                      Limits::infinity(),
                                      -Limits::infinity(),
                                      Limits::max(),
                                      -Limits::max(),
                                      Limits::denorm_min(),
                                      T(-0.0),
                                      T(1e9),
                                      T(-1e6)};
    if (below(60) == 0) return odd.at(below(odd.size()));
    if (name == "w") return T(1);
    return T(4) * static_cast<T>(static_cast<double>(random_() >> 11) * 0x1p-53 - 0.5);
  }
  /// Of what a field with this name says in a message that is meant well.
  std::uint64_t whole_number(std::string_view name) {
    if (below(20) == 0) return random_();
    if (name.starts_with("timestamp")) return static_cast<std::uint64_t>(realtime_now() / 1000);
    if (name == "sec") return static_cast<std::uint64_t>(realtime_now() / 1'000'000'000);
    if (name == "nanosec") return static_cast<std::uint64_t>(realtime_now() % 1'000'000'000);
    if (name.ends_with("_frame")) return 1;
    if (name == "arming_state") return 2;
    if (name == "nav_state") return 14;
    return below(3);
  }
  void fields(const MessageType& type, Bytes& bytes) {
    for (const Field& field : type.fields) {
      std::size_t n = field.many == Many::array ? field.length : 1;
      if (field.many == Many::sequence) {
        n = below(4);
        put(bytes, static_cast<std::uint32_t>(n));
      }
      for (std::size_t i = 0; i < n; ++i) value(field, i, bytes);
    }
  }
  void value(const Field& field, std::size_t i, Bytes& bytes) {
    constexpr std::array<std::string_view, 6> words = {"map",  "base_link", "odom",
                                                       "uav0", "",          "a name of 21 letters."};
    const std::string_view t = field.type;
    if (field.nested()) {
      for (const MessageType& type : message_types())
        if (type.name == field.type) return fields(type, bytes);
      throw std::invalid_argument(field.type);
    }
    if (t == "string") return put_text(bytes, words.at(below(words.size())));
    if (t == "double") return put(bytes, real<double>(field.name));
    if (t == "float") return put(bytes, field.name == "q" && i == 0 ? 1.0F : real<float>(field.name));
    const std::uint64_t n = whole_number(field.name);
    if (t == "boolean") return put(bytes, static_cast<unsigned char>(n % 2));
    if (t.ends_with("64")) return put(bytes, n);
    if (t.ends_with("32")) return put(bytes, static_cast<std::uint32_t>(n));
    if (t.ends_with("16")) return put(bytes, static_cast<std::uint16_t>(n));
    put(bytes, static_cast<unsigned char>(n));
  }

  std::mt19937_64 random_;
};

/// Writes payloads to a topic of this program as they would come from the network. What Cyclone DDS
/// cannot read is dropped; the reader has the rest when send() returns.
class PayloadWriter {
 public:
  /// @param participant  another than the reader's
  /// @param topic        as on the wire; a reader of it is there
  PayloadWriter(dds_entity_t participant, const dds_topic_descriptor_t& type, const std::string& topic) {
    const std::string type_name = wire_type(type.m_typename);
    dds_topic_descriptor_t named = type;
    named.m_typename = type_name.c_str();
    const dds_entity_t made = dds_create_topic(participant, &named, topic.c_str(), nullptr, nullptr);
    dds_qos_t* qos = dds_create_qos();
    dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, 0);
    dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
    dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 1);
    dds_qset_writer_data_lifecycle(qos, false);
    const dds_data_representation_id_t plain = DDS_DATA_REPRESENTATION_XCDR1;
    dds_qset_data_representation(qos, 1, &plain);
    writer_ = dds_create_writer(participant, made, qos, nullptr);
    // How Cyclone DDS reads the type, it says with a message: one of zeros.
    const dds_entity_t own = dds_create_reader(participant, made, qos, nullptr);
    dds_delete_qos(qos);
    alignas(8) static constexpr std::array<unsigned char, 8192> zeros{};
    dds_sample_info_t info{};
    if (writer_ < 0 || own < 0 || dds_write(writer_, zeros.data()) != DDS_RETCODE_OK ||
        dds_takecdr(own, &first_, 1, &info, DDS_ANY_STATE) != 1)
      throw std::runtime_error("no writer of " + topic);
    dds_delete(own);
  }
  ~PayloadWriter() {
    ddsi_serdata_unref(first_);
    dds_delete(writer_);
  }
  PayloadWriter(const PayloadWriter&) = delete;
  PayloadWriter& operator=(const PayloadWriter&) = delete;

  /// @return whether it could be read
  bool send(const Bytes& payload) {
    // A copy of its exact size, so that a sanitizer sees what reads past its end.
    const std::unique_ptr<unsigned char[]> exact(new unsigned char[payload.size()]);
    std::memcpy(exact.get(), payload.data(), payload.size());
    const ddsrt_iovec_t piece = {exact.get(), payload.size()};
    ddsi_serdata* const data = ddsi_serdata_from_ser_iov(first_->type, SDK_DATA, 1, &piece, payload.size());
    return data != nullptr && dds_writecdr(writer_, data) == DDS_RETCODE_OK;
  }

 private:
  dds_entity_t writer_ = 0;
  ddsi_serdata* first_ = nullptr;
};

}  // namespace sightline::dds
