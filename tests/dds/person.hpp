/// Somebody beside a flight who calls its services.
#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <mutex>
#include <string>
#include <vector>

#include "bridges/dds/domain.hpp"
#include "bridges/dds/topics/channel.hpp"
#include "bridges/dds/topics/ros_message.hpp"
#include "bridges/dds/topics/services.hpp"
#include "tests/support/child.hpp"

extern "C" {
#include "ros.h"
}

namespace sightline::dds {

/// Calls ~/start, ~/stop, ~/land, ~/emergency as rmw_cyclonedds does, and keeps each reply to it.
class Person {
 public:
  Person(Domain& domain, std::uint64_t id, const std::string& service)
      : at_(domain.another_participant()),
        id_(id),
        requests_(at_, trigger_service.called_request, wire_request(service), of_services),
        replies_(at_, trigger_service.called_response, wire_reply(service), of_services, std::nullopt,
                 Writers::all, taking<Response>([this](const Response& r, const Arrival&) {
                   if (r.header.client != id_) return;
                   const std::scoped_lock held(lock_);
                   answers_.push_back(fmt::format("{} {}{}", r.header.number,
                                                  r.response.success ? "yes: " : "no: ", r.response.message));
                 })) {}

  bool there() const { return requests_.matched() > 0 && replies_.matched() > 0; }
  void send(std::int64_t number) {
    const Request request = {{id_, number}, {0}};
    EXPECT_TRUE(requests_.write(&request));
  }
  std::vector<std::string> answers() const {
    const std::scoped_lock held(lock_);
    return answers_;
  }
  /// Calls once and waits. @return what was answered
  std::string call() {
    EXPECT_TRUE(test::eventually([&] { return there(); }, std::chrono::seconds(10)));
    const std::size_t before = answers().size();
    send(++last_);
    if (!test::eventually([&] { return answers().size() > before; }, std::chrono::seconds(10))) return "";
    return answers().back().substr(std::to_string(last_).size() + 1);
  }

 private:
  using Request = std_srvs_srv_dds__Trigger_Request_1_;
  using Response = std_srvs_srv_dds__Trigger_Response_1_;

  dds_entity_t at_;
  std::uint64_t id_;
  std::int64_t last_ = 100;
  mutable std::mutex lock_;
  std::vector<std::string> answers_;
  RawWriter requests_;
  RawReader replies_;
};

}  // namespace sightline::dds
