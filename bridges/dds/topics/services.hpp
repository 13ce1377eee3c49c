/// Services by which an operator starts and ends a flight: std_srvs/Trigger under the flyer's node
/// name.
#pragma once

#include <list>
#include <memory>
#include <span>
#include <string>

#include "bridges/dds/topics/operator_calls.hpp"
#include "bridges/dds/topics/service.hpp"

namespace sightline::dds {

/// Serves ~/start, ~/stop, ~/land and ~/emergency to callers of both middlewares. A Fast DDS caller
/// receives a plain reply.
/// Its rmw needs a mark in the reply that Cyclone DDS cannot send, so the caller keeps waiting; the
/// request is executed nevertheless.
class OperatorServices {
 public:
  /// @param node   "/sightline"
  /// @param calls  must outlive this
  /// @throws std::runtime_error if a topic cannot be created
  OperatorServices(dds_entity_t participant, std::string node, OperatorCalls& calls);
  OperatorServices(const OperatorServices&) = delete;  // its readers hold pointers to it
  OperatorServices& operator=(const OperatorServices&) = delete;

  /// Whether another program serves under this node name.
  bool has_rival(std::span<const SeenWriter> writers) const;

 private:
  /// Server for callers without a header.
  struct Plain {
    Plain(dds_entity_t participant, const std::string& service, std::function<CallAnswer()> call);
    RawWriter replies;
    RawReader requests;  // last member: destroyed before the writer it uses
  };

  std::string node_;
  dds_guid_t ours_{};
  std::list<ServiceServer> servers_;
  std::list<Plain> plain_;
};

}  // namespace sightline::dds
