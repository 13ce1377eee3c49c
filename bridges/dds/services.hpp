/// The services by which a person starts and ends a flight from elsewhere: std_srvs/Trigger under the flyer's name.
#pragma once

#include <list>
#include <memory>
#include <span>
#include <string>

#include "bridges/dds/operator_calls.hpp"
#include "bridges/dds/service.hpp"

namespace sightline::dds {

/// Serves ~/start, ~/stop, ~/land and ~/emergency, to callers of both middlewares. One of Fast DDS is answered plainly; its rmw looks
/// for a mark in the reply that Cyclone DDS cannot send, and waits on: what it asked for is done all the same.
class OperatorServices {
 public:
  /// @param node   "/sightline"
  /// @param calls  outlives this
  /// @throws std::runtime_error where a topic cannot be had
  OperatorServices(dds_entity_t participant, std::string node, OperatorCalls& calls);
  OperatorServices(const OperatorServices&) = delete;  // its readers point into it
  OperatorServices& operator=(const OperatorServices&) = delete;

  /// Whether another program serves under this name.
  bool has_rival(std::span<const SeenWriter> writers) const;

 private:
  /// Of callers without a header.
  struct Plain {
    Plain(dds_entity_t participant, const std::string& service, std::function<CallAnswer()> call);
    RawWriter replies;
    RawReader requests;  // last: it ends before what it writes by
  };

  std::string node_;
  dds_guid_t ours_{};
  std::list<ServiceServer> servers_;
  std::list<Plain> plain_;
};

}  // namespace sightline::dds
