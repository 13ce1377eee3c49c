#include "sightline/run/realtime.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>

#include <thread>

namespace sightline {
namespace {

TEST(Realtime, AThreadHasWhatItIsToldItHas) {
  std::thread([] {
    const bool may = may_be_realtime(control_priority);
    const Realtime got = become_realtime(control_priority);
    int policy = 0;
    sched_param parameters{};
    ASSERT_EQ(::pthread_getschedparam(::pthread_self(), &policy, &parameters), 0);
    EXPECT_EQ(got.first_come, policy == SCHED_FIFO);
    EXPECT_EQ(got.first_come, may);
    EXPECT_EQ(parameters.sched_priority, got.first_come ? control_priority : 0);
    ::munlockall();
  }).join();
  int policy = 0;
  sched_param parameters{};
  ASSERT_EQ(::pthread_getschedparam(::pthread_self(), &policy, &parameters), 0);
  EXPECT_NE(policy, SCHED_FIFO);  // nobody else
}

TEST(Realtime, WhatIsNotHadIsSaidWithWhatAllowsIt) {
  using testing::HasSubstr;
  EXPECT_EQ((Realtime{true, true}.sentence()), "real time: SCHED_FIFO, memory locked");
  EXPECT_THAT((Realtime{false, true}.sentence()), HasSubstr("ulimit -r"));
  EXPECT_THAT((Realtime{true, false}.sentence()), HasSubstr("ulimit -l"));
}

}  // namespace
}  // namespace sightline
