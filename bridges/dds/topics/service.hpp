/// ROS 2 services: callers, and servers for the vehicle simulators.
///
/// The two ROS 2 middlewares differ. That of Cyclone DDS puts a header before each request and
/// reply, which pairs them.
/// That of Fast DDS has no header on the wire, and answers a plain request with a plain reply. A
/// caller uses the server's form, which it derives from the first bytes of the server's GUID.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "bridges/dds/topics/channel.hpp"

namespace sightline::dds {

/// Middleware of a DDS endpoint.
enum class Middleware : std::uint8_t { unknown, cyclone, fast };
Middleware middleware_of(const dds_guid_t& guid);

/// Message types of a service. The called_ types hold the header in the first 16 bytes, then the
/// plain message.
struct ServiceType {
  const dds_topic_descriptor_t &request, &called_request, &response, &called_response;
};

// Services of the bridge: those of Crazyswarm2 and std_srvs.
extern const ServiceType takeoff_service, land_service, go_to_service, arm_service, setpoints_stop_service,
    empty_service, trigger_service;

enum class Answer : std::uint8_t { none, accepted, refused };

/// Calls one service, one call at a time: a reply to an earlier call is ignored.
class ServiceCaller {
 public:
  /// Whether a response reports success.
  using Accepts = bool (*)(const void* response);

  /// @param service  "/a/s"
  /// @param accepts  null: every response counts as success
  ServiceCaller(dds_entity_t participant, const ServiceType& type, std::string service,
                Accepts accepts = nullptr);

  /// Finds the server and adopts its middleware, once. Called by the thread that runs watch() of
  /// the link ends.
  void watch(std::span<const SeenWriter> writers);

  // Control thread only; nothing is allocated.
  bool there() const noexcept { return there_.load(std::memory_order_acquire); }
  /// Sends a request. @return false if there is no server
  bool call(const void* request) noexcept;
  /// Answer to the last call.
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
  std::int64_t calls_ = 0;                // control thread only
  std::atomic<std::int64_t> replied_{0};  // twice the call's number, plus 1 if it was rejected
  std::atomic<std::int64_t> waiting_{0};  // number of the last call
  std::atomic<bool> there_{false};
  std::unique_ptr<RawWriter> requests_;
  std::unique_ptr<RawReader> replies_;  // last member: destroyed before the members it fills
};

/// Serves one service, as a node on the middleware of Cyclone DDS.
class ServiceServer {
 public:
  /// Fills the response, which is zeroed. @return false to send no reply. Runs in the receive
  /// thread.
  using Serve = std::function<bool(const void* request, void* response)>;

  ServiceServer(dds_entity_t participant, const ServiceType& type, const std::string& service, Serve serve);

 private:
  Serve serve_;
  std::vector<std::uint64_t> response_;  // with its header
  std::unique_ptr<RawWriter> replies_;
  std::unique_ptr<RawReader> requests_;  // last member: destroyed before the members it fills
};

}  // namespace sightline::dds
