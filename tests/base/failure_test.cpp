#include <gtest/gtest.h>

#include <new>
#include <stdexcept>
#include <string>

#include "sightline/base.hpp"

namespace sightline {
namespace {

std::string reported;

void keep(std::string_view line) noexcept { reported += line; }

struct ReportHere {
  ReportHere() {
    reported.clear();
    report_failures_to(keep);
  }
  ~ReportHere() { report_failures_to(nullptr); }
};

template <class Thrown>
void record_in(Failure& failure, const Thrown& thrown) {
  try {
    throw thrown;
  } catch (...) {
    failure.record("the page");
  }
}

TEST(Failure, IsReportedOnceWithWhatWasThrownFirst) {
  const ReportHere here;
  Failure failure;
  EXPECT_FALSE(failure.occurred());
  EXPECT_EQ(failure.sentence(), "");
  record_in(failure, std::bad_alloc());
  record_in(failure, std::runtime_error("another"));
  EXPECT_TRUE(failure.occurred());
  EXPECT_EQ(failure.sentence(), "the page has ended: there is not enough memory");
  EXPECT_EQ(reported, "sightline: the page has ended: there is not enough memory\n");
}

TEST(Failure, ALongSentenceOfSeveralLinesBecomesOneLineOfBoundedLength) {
  const ReportHere here;
  Failure failure;
  record_in(failure, std::runtime_error("a\nb" + std::string(10'000, 'c')));
  EXPECT_EQ(failure.sentence().size(), Failure::length_max);
  EXPECT_TRUE(failure.sentence().starts_with("the page has ended: a bccc"));
  EXPECT_EQ(std::count(reported.begin(), reported.end(), '\n'), 1);
}

}  // namespace
}  // namespace sightline
