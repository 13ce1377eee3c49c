#include "bridges/dds/topics/services.hpp"

#include <algorithm>
#include <array>
#include <cstring>
#include <functional>
#include <utility>

extern "C" {
#include "ros.h"
}

namespace sightline::dds {
namespace {

using TriggerReply = std_srvs_srv_dds__Trigger_Response_;
constexpr std::size_t trigger_payload = 1, guid_prefix = 12;  // [bytes]

// The message text is a constant, so it outlives the reply.
void fill_in(const CallAnswer& answer, TriggerReply& reply) {
  reply.success = answer.success;
  reply.message = const_cast<char*>(answer.message.data());
}

}  // namespace

OperatorServices::Plain::Plain(dds_entity_t participant, const std::string& service,
                               std::function<CallAnswer()> call)
    : replies(participant, trigger_service.response, wire_reply(service), of_services),
      requests(participant, trigger_service.request, wire_request(service), of_services, trigger_payload,
               Writers::all, [this, call = std::move(call)](const void*, const Arrival&) {
                 TriggerReply reply{};
                 fill_in(call(), reply);
                 (void)replies.write(&reply);
               }) {}

OperatorServices::OperatorServices(dds_entity_t participant, std::string node, OperatorCalls& calls)
    : node_(std::move(node)) {
  dds_get_guid(participant, &ours_);
  using Call = CallAnswer (OperatorCalls::*)() noexcept;
  constexpr std::array<std::pair<const char*, Call>, 4> services = {
      {{"/start", &OperatorCalls::start},
       {"/stop", &OperatorCalls::stop},
       {"/land", &OperatorCalls::land},
       {"/emergency", &OperatorCalls::emergency}}};
  for (const auto& [name, member] : services) {
    const auto call = [&calls, member = member] { return (calls.*member)(); };
    servers_.emplace_back(participant, trigger_service, node_ + name, [call](const void*, void* response) {
      fill_in(call(), *static_cast<TriggerReply*>(response));
      return true;
    });
    plain_.emplace_back(participant, node_ + name, call);
  }
}

bool OperatorServices::has_rival(std::span<const SeenWriter> writers) const {
  const std::string topic = wire_reply(node_ + "/land");
  return std::any_of(writers.begin(), writers.end(), [&](const SeenWriter& writer) {
    return writer.topic == topic && std::memcmp(&writer.guid, &ours_, guid_prefix) != 0;
  });
}

}  // namespace sightline::dds
