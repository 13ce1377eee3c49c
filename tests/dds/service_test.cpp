#include "bridges/dds/topics/service.hpp"

#include <gtest/gtest.h>

#include <cstring>

#include "bridges/dds/domain.hpp"
#include "tests/dds/own_domain.hpp"
#include "tests/support/child.hpp"

extern "C" {
#include "crazyflie.h"
}

namespace sightline::dds {
namespace {

using TakeoffRequest = crazyflie_interfaces_srv_dds__Takeoff_Request_;
using TriggerResponse = std_srvs_srv_dds__Trigger_Response_;

bool accepts_trigger(const void* response) { return static_cast<const TriggerResponse*>(response)->success; }

class Service : public testing::Test {
 protected:
  bool find(ServiceCaller& caller) {
    return test::eventually([&] {
      caller.watch(writers.look());
      return caller.there();
    });
  }

  std::shared_ptr<Domain> domain = std::make_shared<Domain>(test::own_network());
  dds_entity_t other = domain->another_participant();
  WriterList writers{domain->participant()};
};

TEST_F(Service, ARequestArrivesAsItWasSentAndIsAnswered) {
  std::atomic<int> served{0};
  TakeoffRequest seen{};
  ServiceServer server(other, takeoff_service, "/cf1/takeoff", [&](const void* request, void*) {
    seen = *static_cast<const TakeoffRequest*>(request);
    ++served;
    return true;
  });
  ServiceCaller caller(domain->participant(), takeoff_service, "/cf1/takeoff");
  EXPECT_FALSE(caller.there());
  const TakeoffRequest request = {3, 0.5F, {2, 250'000'000}};
  EXPECT_FALSE(caller.call(&request));  // nobody is there yet
  ASSERT_TRUE(find(caller));
  EXPECT_EQ(caller.answer(), Answer::none);
  for (int k = 1; k < 4; ++k) {
    EXPECT_TRUE(caller.call(&request));
    EXPECT_TRUE(test::eventually([&] { return caller.answer() == Answer::accepted; }));
    EXPECT_EQ(served, k);
  }
  EXPECT_EQ(seen.group_mask, 3);
  EXPECT_EQ(seen.height, 0.5F);
  EXPECT_EQ(seen.duration.sec, 2);
  EXPECT_EQ(seen.duration.nanosec, 250'000'000U);
}

TEST_F(Service, ARefusalAnAnswerToAnotherAndNoneAreDistinguished) {
  enum { accept, refuse, say_nothing };
  std::atomic<int> how{refuse};
  ServiceServer server(other, trigger_service, "/land", [&](const void*, void* response) {
    static std::array<char, 4> message = {"no"};
    auto& reply = *static_cast<TriggerResponse*>(response);
    reply.success = how == accept;
    reply.message = message.data();
    return how != say_nothing;
  });
  ServiceCaller caller(domain->participant(), trigger_service, "/land", accepts_trigger),
      another(domain->participant(), trigger_service, "/land", accepts_trigger);
  ASSERT_TRUE(find(caller));
  ASSERT_TRUE(find(another));
  const std_srvs_srv_dds__Trigger_Request_ request{};
  ASSERT_TRUE(caller.call(&request));
  EXPECT_TRUE(test::eventually([&] { return caller.answer() == Answer::refused; }));
  EXPECT_EQ(another.answer(), Answer::none);
  how = say_nothing;
  ASSERT_TRUE(caller.call(&request));
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
  EXPECT_EQ(caller.answer(), Answer::none);  // the old one does not count
  how = accept;
  ASSERT_TRUE(another.call(&request));
  EXPECT_TRUE(test::eventually([&] { return another.answer() == Answer::accepted; }));
  EXPECT_EQ(caller.answer(), Answer::none);
}

TEST(Middleware, IsIdentifiedByTheFirstBytesOfAGuid) {
  dds_guid_t guid{};
  EXPECT_EQ(middleware_of(guid), Middleware::unknown);
  guid.v[0] = 0x01, guid.v[1] = 0x10;
  EXPECT_EQ(middleware_of(guid), Middleware::cyclone);
  guid.v[1] = 0x0f;
  EXPECT_EQ(middleware_of(guid), Middleware::fast);
  const Domain domain(test::own_network());
  dds_get_guid(domain.participant(), &guid);
  EXPECT_EQ(middleware_of(guid), Middleware::cyclone);
}

// What stands before a request changes neither the name nor the hash of its type.
TEST(ServiceType, TheHeaderIsNoPartOfTheType) {
  for (const ServiceType* type : {&takeoff_service, &land_service, &arm_service, &setpoints_stop_service,
                                  &empty_service, &trigger_service}) {
    for (const auto& [plain, called] : {std::pair{&type->request, &type->called_request},
                                        std::pair{&type->response, &type->called_response}}) {
      EXPECT_EQ(wire_type(plain->m_typename), wire_type(called->m_typename));
      EXPECT_EQ(type_hash(message_type(plain->m_typename)), type_hash(message_type(called->m_typename)));
      EXPECT_EQ(called->m_size, 16 + (plain->m_size + 7) / 8 * 8);
    }
  }
}

}  // namespace
}  // namespace sightline::dds
