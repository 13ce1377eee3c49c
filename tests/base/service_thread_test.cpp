#include <gtest/gtest.h>
#include <pthread.h>

#include <atomic>
#include <new>
#include <stdexcept>
#include <string>
#include <system_error>

#include "sightline/base.hpp"

namespace sightline {
namespace {

std::string reported;

/// While it lives, lines of failures go to `reported`.
struct ReportsToReported {
  ReportsToReported() {
    reported.clear();
    report_failures_to([](std::string_view line) noexcept { reported += line; });
  }
  ~ReportsToReported() { report_failures_to(nullptr); }
};

/// While it lives, the machine has no thread for this process: none has room for such a stack.
class NoThreads {
 public:
  NoThreads() {
    pthread_getattr_default_np(&before_);
    pthread_attr_t huge = before_;
    pthread_attr_setstacksize(&huge, std::size_t{1} << 50);
    pthread_setattr_default_np(&huge);
  }
  ~NoThreads() { pthread_setattr_default_np(&before_); }
  NoThreads(const NoThreads&) = delete;
  NoThreads& operator=(const NoThreads&) = delete;

 private:
  pthread_attr_t before_{};
};

TEST(ServiceThread, WhatItsFunctionThrowsEndsTheServiceAloneAndIsReportedOnce) {
  const ReportsToReported here;
  std::atomic<bool> stopped = false;
  ServiceThread thread("the page");
  thread.start([] { throw std::bad_alloc(); }, [&] { stopped = true; });
  thread.join();
  EXPECT_TRUE(thread.failed());
  EXPECT_TRUE(stopped);
  EXPECT_EQ(thread.failure(), "the page has ended: there is not enough memory");
  EXPECT_EQ(reported, "sightline: the page has ended: there is not enough memory\n");
}

TEST(ServiceThread, WhatIsNoExceptionAndWhatStoppingThrowsEndNothingElse) {
  const ReportsToReported here;
  ServiceThread thread("the log");
  thread.start([] { throw 7; }, [] { throw std::runtime_error("in vain"); });
  thread.join();
  EXPECT_EQ(thread.failure(), "the log has ended: an exception without words");
}

TEST(ServiceThread, WithoutAThreadOfTheMachineTheServiceIsStoppedAndReported) {
  const ReportsToReported here;
  bool ran = false, stopped = false;
  {
    const NoThreads none;
    ServiceThread thread("the page");
    thread.start([&] { ran = true; }, [&] { stopped = true; });
    EXPECT_TRUE(thread.failed());
    thread.join();
    EXPECT_FALSE(run_unattended([&] { ran = true; }));
    EXPECT_THROW(run_apart([&] { ran = true; }), std::system_error);
    ServiceThread needed("a solver's thread");
    EXPECT_THROW(needed.start_or_throw([]() noexcept {}), std::system_error);
  }
  EXPECT_FALSE(ran);
  EXPECT_TRUE(stopped);
  EXPECT_TRUE(reported.starts_with("sightline: the page has ended: ")) << reported;
}

TEST(ServiceThread, JoinsAtItsEnd) {
  std::atomic<int> done = 0;
  {
    const ServiceThread thread("a service", [&] { done = 1; });
  }
  EXPECT_EQ(done, 1);
}

TEST(RunApart, ThrowsWhatItsFunctionThrowsWhereItIsWaitedFor) {
  EXPECT_THROW(run_apart([] { throw std::length_error("too long"); }), std::length_error);
  int value = 0;
  run_apart([&] { value = 3; });
  EXPECT_EQ(value, 3);
}

}  // namespace
}  // namespace sightline
