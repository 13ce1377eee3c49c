/// Services of ROS 2: callers, and servers for what stands in.
///
/// The two middlewares of ROS 2 differ: that of Cyclone DDS puts a header before request and reply by which they find each other; that of
/// Fast DDS has none on the wire, and answers a plain request plainly. A caller speaks as the server does, which the first bytes of the
/// server's GUID say.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "bridges/dds/channel.hpp"

namespace sightline::dds {

/// Whose middleware an endpoint is of.
enum class Middleware : std::uint8_t { unknown, cyclone, fast };
Middleware middleware_of(const dds_guid_t& guid);

/// The messages of a service. A message with the header has it in its first 16 bytes, then the plain one.
struct ServiceType {
  const dds_topic_descriptor_t &request, &called_request, &response, &called_response;
};

// Those that we speak. What they are called: "takeoff" of Crazyswarm2, "Trigger" of std_srvs.
extern const ServiceType takeoff_service, land_service, arm_service, setpoints_stop_service, empty_service,
    trigger_service;

enum class Answer : std::uint8_t { none, accepted, refused };

/// Calls one service, one call at a time: of another one's reply it knows nothing.
class ServiceCaller {
 public:
  /// Whether a response says that it was done.
  using Accepts = bool (*)(const void* response);

  /// @param service  "/a/s"
  /// @param accepts  none: whatever is answered
  ServiceCaller(dds_entity_t participant, const ServiceType& type, std::string service,
                Accepts accepts = nullptr);

  /// Looks for the server and takes up its way of speaking, once and for all. Of one thread, with watch() of others.
  void watch(std::span<const SeenWriter> writers);

  // Of the control thread; nothing is allocated.
  bool there() const noexcept { return there_.load(std::memory_order_acquire); }
  /// Sends a request. @return false where nobody is there
  bool call(const void* request) noexcept;
  /// To the last call.
  Answer answer() const noexcept;

  const std::string& service() const { return service_; }

 private:
  void on_reply(const void* response, std::int64_t number) noexcept;

  dds_entity_t participant_;
  const ServiceType& type_;
  std::string service_;
  Accepts accepts_;
  Middleware server_ = Middleware::unknown;
  std::uint64_t client_ = 0;
  std::int64_t calls_ = 0;                // of the control thread
  std::atomic<std::int64_t> replied_{0};  // twice the call's number, and 1 where it was refused
  std::atomic<std::int64_t> waiting_{0};  // the last call's number
  std::atomic<bool> there_{false};
  std::unique_ptr<RawWriter> requests_;
  std::unique_ptr<RawReader> replies_;  // last: it ends before what it fills
};

/// Answers one service, as a node of the middleware of Cyclone DDS.
class ServiceServer {
 public:
  /// Fills the response, which is zeroed; @return false for none. In the thread that receives.
  using Serve = std::function<bool(const void* request, void* response)>;

  ServiceServer(dds_entity_t participant, const ServiceType& type, const std::string& service, Serve serve);

 private:
  Serve serve_;
  std::vector<std::uint64_t> response_;  // with its header
  std::unique_ptr<RawWriter> replies_;
  std::unique_ptr<RawReader> requests_;  // last: it ends before what it fills
};

}  // namespace sightline::dds
