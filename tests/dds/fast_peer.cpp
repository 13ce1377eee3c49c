// A program on Fast DDS, the second vendor. `fast_peer DOMAIN rover SECONDS` is a robot that drives
// by cmd_vel, reads its flyer's topics and ends the task by a service. `fast_peer DOMAIN px4
// SECONDS` publishes odometry as PX4's agent does, reads set-points and serves a Trigger. Messages
// are put together by Fast CDR, field by field. It prints what it saw, a line each.
#include <fastcdr/Cdr.h>
#if __has_include(<fastdds/utils/IPLocator.hpp>)  // Fast DDS 3
#include <fastdds/rtps/common/WriteParams.hpp>
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.hpp>
#include <fastdds/utils/IPLocator.hpp>
#define SIGHTLINE_FAST_DDS_3
#else
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>
#endif

#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

/// Fast DDS 2.9 deletes a writer by the size of its base, which AddressSanitizer would end this
/// program for.
extern "C" const char* __asan_default_options() { return "new_delete_type_mismatch=0"; }  // NOLINT

namespace {

namespace dds = eprosima::fastdds::dds;
#ifdef SIGHTLINE_FAST_DDS_3
namespace rtps = eprosima::fastdds::rtps;
constexpr auto received = dds::RETCODE_OK;
constexpr auto plain_cdr = eprosima::fastcdr::CdrVersion::DDS_CDR;
std::size_t length_of(const eprosima::fastcdr::Cdr& cdr) { return cdr.get_serialized_data_length(); }
#else
namespace rtps = eprosima::fastrtps::rtps;
const auto received = ReturnCode_t::RETCODE_OK;
constexpr auto plain_cdr = eprosima::fastcdr::Cdr::DDS_CDR;
std::size_t length_of(const eprosima::fastcdr::Cdr& cdr) { return cdr.getSerializedDataLength(); }
#endif
using eprosima::fastcdr::Cdr;
using eprosima::fastcdr::FastBuffer;
using Bytes = std::vector<char>;
constexpr std::size_t largest = 1U << 18U;

/// Any type under its name: what is sent and received are bytes with their header.
class AnyType final : public dds::TopicDataType {
 public:
#ifdef SIGHTLINE_FAST_DDS_3
  explicit AnyType(const std::string& name) {
    set_name(name);
    max_serialized_type_size = largest;
  }
  bool serialize(const void* data, rtps::SerializedPayload_t& payload, dds::DataRepresentationId_t) override {
    return put(data, payload);
  }
  bool deserialize(rtps::SerializedPayload_t& payload, void* data) override { return get(payload, data); }
  std::uint32_t calculate_serialized_size(const void* data, dds::DataRepresentationId_t) override {
    return size(data);
  }
  void* create_data() override { return new Bytes; }
  void delete_data(void* data) override { delete static_cast<Bytes*>(data); }
  bool compute_key(rtps::SerializedPayload_t&, rtps::InstanceHandle_t&, bool) override { return false; }
  bool compute_key(const void*, rtps::InstanceHandle_t&, bool) override { return false; }
#else
  explicit AnyType(const std::string& name) {
    setName(name.c_str());
    m_typeSize = largest;
    m_isGetKeyDefined = false;
    auto_fill_type_object(false);
    auto_fill_type_information(false);
  }
  bool serialize(void* data, rtps::SerializedPayload_t* payload) override { return put(data, *payload); }
  bool deserialize(rtps::SerializedPayload_t* payload, void* data) override { return get(*payload, data); }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) override {
    return [data] { return size(data); };
  }
  void* createData() override { return new Bytes; }
  void deleteData(void* data) override { delete static_cast<Bytes*>(data); }
  bool getKey(void*, rtps::InstanceHandle_t*, bool) override { return false; }
#endif

 private:
  static std::uint32_t size(const void* data) {
    return static_cast<std::uint32_t>(static_cast<const Bytes*>(data)->size());
  }
  static bool put(const void* data, rtps::SerializedPayload_t& payload) {
    payload.encapsulation = CDR_LE;
    payload.length = size(data);
    std::memcpy(payload.data, static_cast<const Bytes*>(data)->data(), payload.length);
    return true;
  }
  static bool get(const rtps::SerializedPayload_t& payload, void* data) {
    const auto* const begin = reinterpret_cast<const char*>(payload.data);
    static_cast<Bytes*>(data)->assign(begin, begin + payload.length);
    return true;
  }
};

Bytes written(const std::function<void(Cdr&)>& fields) {
  Bytes bytes(largest);
  FastBuffer buffer(bytes.data(), bytes.size());
  Cdr cdr(buffer, Cdr::LITTLE_ENDIANNESS, plain_cdr);
  cdr.serialize_encapsulation();
  fields(cdr);
  bytes.resize(length_of(cdr));
  return bytes;
}

void read(Bytes& bytes, const std::function<void(Cdr&)>& fields) {
  FastBuffer buffer(bytes.data(), bytes.size());
  Cdr cdr(buffer, Cdr::LITTLE_ENDIANNESS, plain_cdr);
  cdr.read_encapsulation();
  fields(cdr);
}

/// A field that is read for its place alone.
template <class T>
T next(Cdr& cdr) {
  T value{};
  cdr >> value;
  return value;
}
std::string next_header(Cdr& cdr) {
  next<std::int32_t>(cdr), next<std::uint32_t>(cdr);
  return next<std::string>(cdr);
}

struct Quality {
  bool reliable = false, transient_local = false;
};

class Peer {
 public:
  explicit Peer(int domain) {
    dds::DomainParticipantQos qos;
    const auto loopback = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
    loopback->interfaceWhiteList = {"127.0.0.1"};
    loopback->maxInitialPeersRange = 32;
    qos.transport().use_builtin_transports = false;
    qos.transport().user_transports.push_back(loopback);
    rtps::Locator_t here;
    rtps::IPLocator::setIPv4(here, "127.0.0.1");
    qos.wire_protocol().builtin.initialPeersList.push_back(here);
    participant_ = dds::DomainParticipantFactory::get_instance()->create_participant(
        static_cast<std::uint32_t>(domain), qos);
    publisher_ = participant_->create_publisher(dds::PUBLISHER_QOS_DEFAULT);
    subscriber_ = participant_->create_subscriber(dds::SUBSCRIBER_QOS_DEFAULT);
  }

  dds::DataWriter* writer(const std::string& topic, const std::string& type, Quality quality) {
    dds::DataWriterQos qos;
    qos.reliability().kind =
        quality.reliable ? dds::RELIABLE_RELIABILITY_QOS : dds::BEST_EFFORT_RELIABILITY_QOS;
    qos.durability().kind =
        quality.transient_local ? dds::TRANSIENT_LOCAL_DURABILITY_QOS : dds::VOLATILE_DURABILITY_QOS;
    qos.endpoint().history_memory_policy = rtps::DYNAMIC_RESERVE_MEMORY_MODE;
    return publisher_->create_datawriter(made(topic, type), qos);
  }
  dds::DataReader* reader(const std::string& topic, const std::string& type, Quality quality) {
    dds::DataReaderQos qos;
    qos.reliability().kind =
        quality.reliable ? dds::RELIABLE_RELIABILITY_QOS : dds::BEST_EFFORT_RELIABILITY_QOS;
    qos.history().depth = 10;
    qos.endpoint().history_memory_policy = rtps::DYNAMIC_RESERVE_MEMORY_MODE;
    return subscriber_->create_datareader(made(topic, type), qos);
  }

 private:
  dds::Topic* made(const std::string& topic, const std::string& type) {
    if (participant_->find_type(type).empty())
      dds::TypeSupport(new AnyType(type)).register_type(participant_);
    return participant_->create_topic(topic, type, dds::TOPIC_QOS_DEFAULT);
  }

  dds::DomainParticipant* participant_;
  dds::Publisher* publisher_;
  dds::Subscriber* subscriber_;
};

/// Takes all that came.
template <class Take>
void take(dds::DataReader* reader, Take&& each) {
  Bytes bytes;
  dds::SampleInfo info;
  while (reader->take_next_sample(&bytes, &info) == received)
    if (info.valid_data) each(bytes, info);
}

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}
void put_stamp(Cdr& cdr) {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const auto ns = std::chrono::duration_cast<std::chrono::nanoseconds>(now).count();
  cdr << static_cast<std::int32_t>(ns / 1'000'000'000) << static_cast<std::uint32_t>(ns % 1'000'000'000);
}

int drive(int domain, double seconds) {
  Peer peer(domain);
  const auto odometry = peer.writer("rt/r/odom", "nav_msgs::msg::dds_::Odometry_", {true, false});
  const auto cmd_vel = peer.reader("rt/r/cmd_vel", "geometry_msgs::msg::dds_::Twist_", {true, false});
  const auto poses =
      peer.reader("rt/sightline/rover/pose", "geometry_msgs::msg::dds_::PoseStamped_", {true, false});
  const auto markers =
      peer.reader("rt/sightline/markers", "visualization_msgs::msg::dds_::MarkerArray_", {true, false});
  const auto request =
      peer.writer("rq/sightline/stopRequest", "std_srvs::srv::dds_::Trigger_Request_", {true, false});
  const auto reply =
      peer.reader("rr/sightline/stopReply", "std_srvs::srv::dds_::Trigger_Response_", {true, false});
  double x = 0, y = 0, psi = 0, v = 0, r = 0, farthest = 0;
  long commands = 0, seen = 0, arrays = 0, drawn = 0, replies = 0;
  double moved_at = -1, called_at = -1, px = 0;
  std::string frame, words;
  bool whole = true;
  constexpr double period = 0.01;
  const auto begin = Clock::now();
  for (auto wake = begin; seconds_since(begin) < seconds; std::this_thread::sleep_until(wake)) {
    wake += std::chrono::milliseconds(10);
    take(cmd_vel, [&](Bytes& bytes, const dds::SampleInfo&) {
      ++commands;
      std::array<double, 6> twist{};
      read(bytes, [&](Cdr& cdr) { cdr >> twist; });
      v = twist[0], r = twist[5];
    });
    if (moved_at < 0 && std::abs(v) > 0.05) moved_at = seconds_since(begin);
    psi += period * r, x += period * v * std::cos(psi), y += period * v * std::sin(psi);
    farthest = std::max(farthest, std::hypot(x, y));
    Bytes message = written([&](Cdr& cdr) {
      put_stamp(cdr);
      cdr << std::string("odom") << std::string("base_link");
      cdr << std::array<double, 7>{x, y, 0, 0, 0, std::sin(psi / 2), std::cos(psi / 2)};
      cdr << std::array<double, 36>{} << std::array<double, 6>{v, 0, 0, 0, 0, r} << std::array<double, 36>{};
    });
    odometry->write(&message);
    take(poses, [&](Bytes& bytes, const dds::SampleInfo&) {
      ++seen;
      read(bytes, [&](Cdr& cdr) {
        frame = next_header(cdr);
        px = next<double>(cdr);
      });
    });
    take(markers, [&](Bytes& bytes, const dds::SampleInfo&) {
      ++arrays;
      read(bytes, [&](Cdr& cdr) {
        drawn = next<std::uint32_t>(cdr);
        for (long i = 0; i < drawn; ++i) {
          next_header(cdr), next<std::string>(cdr);
          next<std::array<std::int32_t, 3>>(cdr);                                    // id, type, action
          next<std::array<double, 10>>(cdr);                                         // pose, scale
          next<std::array<float, 4>>(cdr), next<std::array<std::uint32_t, 2>>(cdr);  // colour, lifetime
          next<bool>(cdr);
          for (auto k = next<std::uint32_t>(cdr); k > 0; --k) next<std::array<double, 3>>(cdr);
          for (auto k = next<std::uint32_t>(cdr); k > 0; --k) next<std::array<float, 4>>(cdr);
          next<std::string>(cdr), next_header(cdr), next<std::string>(cdr);  // texture
          next<std::vector<std::uint8_t>>(cdr);
          for (auto k = next<std::uint32_t>(cdr); k > 0; --k) next<std::array<float, 2>>(cdr);
          next<std::string>(cdr), next<std::string>(cdr), next<std::string>(cdr);  // text, meshes
          next<std::vector<std::uint8_t>>(cdr), next<bool>(cdr);
        }
        whole = whole && length_of(cdr) + 4 > bytes.size();  // filled up to 4
      });
    });
    if (moved_at > 0 && called_at < 0 && seconds_since(begin) > moved_at + 3) {
      Bytes empty = written([](Cdr& cdr) { cdr << std::uint8_t{0}; });
      request->write(&empty);
      called_at = seconds_since(begin);
    }
    take(reply, [&](Bytes& bytes, const dds::SampleInfo&) {
      ++replies;
      read(bytes,
           [&](Cdr& cdr) { words = next<bool>(cdr) ? "yes, " : "no, ", words += next<std::string>(cdr); });
    });
    if (replies > 0 && std::abs(v) < 1e-3 && seconds_since(begin) > called_at + 2) break;
  }
  std::printf("%ld commands, farthest %.2f m, at rest %s\n", commands, farthest,
              std::abs(v) < 1e-3 ? "yes" : "no");
  std::printf("%ld poses in %s, %s\n", seen, frame.c_str(),
              std::abs(px - x) < 0.05 ? "where it is" : "elsewhere");
  std::printf("%ld marker arrays of %ld, %s\n", arrays, drawn, whole ? "whole" : "broken");
  std::printf("%ld replies: %s\n", replies, words.c_str());
  return 0;
}

int be_px4(int domain, double seconds) {
  Peer peer(domain);
  const auto odometry = peer.writer("rt/px4_0/fmu/out/vehicle_odometry",
                                    "px4_msgs::msg::dds_::VehicleOdometry_", {false, true});
  const auto setpoints = peer.reader("rt/px4_0/fmu/in/trajectory_setpoint",
                                     "px4_msgs::msg::dds_::TrajectorySetpoint_", {false, false});
  const auto requests =
      peer.reader("rq/land/triggerRequest", "std_srvs::srv::dds_::Trigger_Request_", {true, false});
  const auto replies =
      peer.writer("rr/land/triggerReply", "std_srvs::srv::dds_::Trigger_Response_", {true, false});
  long taken = 0, calls = 0;
  float v = 0;
  const auto begin = Clock::now();
  while (seconds_since(begin) < seconds) {
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    const auto us =
        static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::microseconds>(now).count());
    Bytes message = written([&](Cdr& cdr) {
      cdr << us << us << std::uint8_t{1} << std::array<float, 3>{1.5F, -2.5F, -0.5F}
          << std::array<float, 4>{1, 0, 0, 0} << std::uint8_t{1} << std::array<float, 15>{} << std::uint8_t{0}
          << std::int8_t{0};
    });
    odometry->write(&message);
    take(setpoints, [&](Bytes& bytes, const dds::SampleInfo&) {
      ++taken;
      read(bytes, [&](Cdr& cdr) {
        next<std::uint64_t>(cdr), next<std::array<float, 3>>(cdr);
        v = next<float>(cdr);
      });
    });
    // As rmw_fastrtps answers: plainly, with the caller's mark beside.
    take(requests, [&](Bytes&, const dds::SampleInfo& info) {
      ++calls;
      Bytes answer = written([&](Cdr& cdr) { cdr << true << std::string("landing"); });
      rtps::WriteParams mark;
      mark.related_sample_identity(info.sample_identity);
      replies->write(&answer, mark);
    });
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  std::printf("%ld set-points, north %.2f m/s\n%ld calls\n", taken, static_cast<double>(v), calls);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return 2;
  const int domain = std::atoi(argv[1]);
  const double seconds = std::atof(argv[3]);
  return std::string(argv[2]) == "rover" ? drive(domain, seconds) : be_px4(domain, seconds);
}
