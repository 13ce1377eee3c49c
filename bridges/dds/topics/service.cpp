#include "bridges/dds/topics/service.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstring>

extern "C" {
#include "crazyflie.h"
}

#define SERVICE_TYPE(name) \
  { name##_Request__desc, name##_Request_1__desc, name##_Response__desc, name##_Response_1__desc }

namespace sightline::dds {
namespace {

using CallHeader = rmw_cyclonedds_msg_dds__CallHeader_;

constexpr std::size_t largest_request = 64;  // [bytes]

}  // namespace

const ServiceType takeoff_service SERVICE_TYPE(crazyflie_interfaces_srv_dds__Takeoff),
    land_service SERVICE_TYPE(crazyflie_interfaces_srv_dds__Land),
    go_to_service SERVICE_TYPE(crazyflie_interfaces_srv_dds__GoTo),
    arm_service SERVICE_TYPE(crazyflie_interfaces_srv_dds__Arm),
    setpoints_stop_service SERVICE_TYPE(crazyflie_interfaces_srv_dds__NotifySetpointsStop),
    empty_service SERVICE_TYPE(std_srvs_srv_dds__Empty),
    trigger_service SERVICE_TYPE(std_srvs_srv_dds__Trigger);

Middleware middleware_of(const dds_guid_t& guid) {
  if (guid.v[0] != 0x01) return Middleware::unknown;
  return guid.v[1] == 0x10 ? Middleware::cyclone : guid.v[1] == 0x0f ? Middleware::fast : Middleware::unknown;
}

ServiceCaller::ServiceCaller(dds_entity_t participant, const ServiceType& type, std::string service,
                             Accepts accepts)
    : participant_(participant), type_(type), service_(std::move(service)), accepts_(accepts) {
  assert(type.request.m_size <= largest_request);
}

void ServiceCaller::watch(std::span<const SeenWriter> writers) {
  if (there()) return;
  if (requests_ == nullptr) {
    const std::string topic = wire_reply(service_);
    const auto server = std::find_if(writers.begin(), writers.end(),
                                     [&](const SeenWriter& writer) { return writer.topic == topic; });
    if (server == writers.end()) return;
    server_ = middleware_of(server->guid);
    const bool plain = server_ == Middleware::fast;
    requests_ = std::make_unique<RawWriter>(participant_, plain ? type_.request : type_.called_request,
                                            wire_request(service_), of_services);
    dds_guid_t ours{};
    dds_get_guid(requests_->entity(), &ours);
    std::memcpy(&client_, &ours.v[8], sizeof client_);
    replies_ = std::make_unique<RawReader>(
        participant_, plain ? type_.response : type_.called_response, topic, of_services, std::nullopt,
        Writers::all, [this, plain](const void* message, const Arrival&) {
          if (plain) return on_reply(message, waiting_);
          CallHeader header;
          std::memcpy(&header, message, sizeof header);
          if (header.client == client_)
            on_reply(static_cast<const char*>(message) + sizeof header, header.number);
        });
  }
  if (requests_->matched() > 0 && replies_->matched() > 0) there_.store(true, std::memory_order_release);
}

void ServiceCaller::on_reply(const void* response, std::int64_t number) noexcept {
  replied_ = 2 * number + (accepts_ != nullptr && !accepts_(response) ? 1 : 0);
}

bool ServiceCaller::call(const void* request) noexcept {
  if (!there()) return false;
  waiting_ = ++calls_;
  if (server_ == Middleware::fast) return requests_->write(request);
  struct {
    CallHeader header;
    alignas(8) std::array<char, largest_request> request;
  } called{{client_, calls_}, {}};
  std::memcpy(called.request.data(), request, type_.request.m_size);
  return requests_->write(&called);
}

Answer ServiceCaller::answer() const noexcept {
  const std::int64_t replied = replied_;
  if (calls_ == 0 || replied / 2 != calls_) return Answer::none;
  return replied % 2 == 0 ? Answer::accepted : Answer::refused;
}

ServiceServer::ServiceServer(dds_entity_t participant, const ServiceType& type, const std::string& service,
                             Serve serve)
    : serve_(std::move(serve)), response_((type.called_response.m_size + 7) / 8) {
  replies_ = std::make_unique<RawWriter>(participant, type.called_response, wire_reply(service), of_services);
  requests_ = std::make_unique<RawReader>(
      participant, type.called_request, wire_request(service), of_services, std::nullopt, Writers::all,
      [this](const void* message, const Arrival&) {
        std::fill(response_.begin(), response_.end(), 0);
        std::memcpy(response_.data(), message, sizeof(CallHeader));
        const char* const request = static_cast<const char*>(message) + sizeof(CallHeader);
        if (serve_(request, response_.data() + sizeof(CallHeader) / 8))
          (void)replies_->write(response_.data());
      });
}

}  // namespace sightline::dds
