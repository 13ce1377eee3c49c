#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <string>
#include <utility>
#include <vector>

#include "sightline/safety/view_filter.hpp"
#include "tests/support/campaign.hpp"
#include "tests/support/view_flight.hpp"

namespace sightline {
namespace {

using test::cone_limits;
using test::ViewCampaign;
using test::ViewFlightOptions;

ViewFilter filter_of(const ViewBounds& bounds, const std::vector<Potential>& limits) {
  const ViewTask task = test::view_task(Multirotor{}, bounds, limits);
  return {Multirotor{}, certify_view(task, ViewSection(view_region(limits, task.motion)))};
}

ViewCampaign fly(const std::string& what, const ViewBounds& bounds, const std::vector<Potential>& limits,
                 int flights, const ViewFlightOptions& options = {}) {
  const ViewCampaign all = test::view_campaign(filter_of(bounds, limits), limits, flights, options);
  std::printf("%-34s flights %d, lost %d, uncertified %d, least reserve %.2e m, acts in %.3f, change %.4f\n",
              what.c_str(), all.flights, all.lost, all.uncertified, all.least, all.active, all.changed);
  return all;
}

void expect_kept(const ViewCampaign& all, bool exact = true) {
  EXPECT_EQ(all.lost, 0);
  EXPECT_EQ(all.uncertified, 0);
  EXPECT_TRUE(!exact || all.least >= -2e-6) << all.least;
}

struct KeptView {
  const char* what;
  ViewBounds bounds;
  std::vector<Potential> limits;
  int flights = 3000, part = 60;
  bool exact = true;
};
std::vector<KeptView> kept_views() {
  const std::vector<Potential> cone = cone_limits();
  const Region ellipse =
      Region(all_of({"x > 0 m", "sqrt(y * y + 3 * z * z) < 0.5 * x"})).seen_from(SensorMount{});
  return {{"0.5 m/s", {}, cone, 20000, 100},
          {"0.9 m/s", {.speed = 0.9}, cone, 3000, 30},
          {"0.96 m/s", {.speed = 0.96}, cone},
          {"pyramid, 0.5 m/s", {}, test::pyramid_limits()},
          {"text, 0.5 m/s", {}, test::view_limits(ellipse)},
          {"leaning camera, 0.5 m/s", {}, cone_limits(0.5, MountFrame::body)},
          {"velocity measured, 1.5 m/s", {.speed = 1.5, .acceleration = 0.3}, cone},
          {"errors of 2 cm, 0.5 m/s", {.error = 0.02}, cone, 3000, 60, false},
          {"0.1 s old, 0.5 m/s", {.age = 0.1}, cone, 3000, 60, false}};
}

/// By the place among kept_views().
class KeptViewCampaign : public testing::TestWithParam<int> {};

TEST_P(KeptViewCampaign, NoTargetWithinItsBoundsIsLost) {
  const KeptView of = kept_views()[static_cast<std::size_t>(GetParam())];
  expect_kept(fly(of.what, of.bounds, of.limits, runs(of.flights, of.part)), of.exact);
}

INSTANTIATE_TEST_SUITE_P(Views, KeptViewCampaign, testing::Range(0, 9));

TEST(ViewFilterCampaign, WithoutTheFilterOrTheBoundTargetsAreLost) {
  const int flights = runs(3000, 50);
  EXPECT_GT(fly("without the filter", {}, cone_limits(), flights, {.filtered = false}).lost, flights / 3);
  const ViewCampaign faster = fly("at 0.8 m/s instead of 0.5", {}, cone_limits(), flights, {.faster = 1.6});
  EXPECT_GT(faster.lost, flights / 10);
  EXPECT_EQ(faster.unannounced, 0);
}

// Forty searches of a hundred flights each; in the short form two.
TEST(ViewFilterCampaign, NoSearchFindsAMotionThatEscapes) {
  const auto search = [](const ViewBounds& bounds, const std::vector<Potential>& limits, bool filtered) {
    const int searches = runs(40, 20);
    const test::ViewSearch all =
        test::search_escapes(filter_of(bounds, limits), limits, searches, 100, {.filtered = filtered}, 5);
    std::printf("search, %.2f m/s, filter %d: flights %d, searches %d, lost %d, worst violation %.2e\n",
                bounds.speed, filtered, all.flights, searches, all.lost, all.worst);
    EXPECT_EQ(filtered, all.worst < 0);
    return std::pair(all.lost, searches);
  };
  EXPECT_EQ(search({}, cone_limits(), true).first, 0);
  EXPECT_EQ(search({.speed = 0.96}, cone_limits(), true).first, 0);
  EXPECT_EQ(search({}, test::pyramid_limits(), true).first, 0);
  EXPECT_EQ(search({}, cone_limits(0.5, MountFrame::body), true).first, 0);
  EXPECT_EQ(search({.speed = 1.5, .acceleration = 0.3}, cone_limits(), true).first, 0);
  const auto [lost, searches] = search({.speed = 0.9}, cone_limits(), false);
  EXPECT_GE(2 * lost, searches);
}

void expect_no_way_out(const ViewBounds& bounds, const std::vector<Potential>& limits, int states) {
  const ViewFilter filter = filter_of(bounds, limits);
  const test::ViewStep all = test::one_step(Multirotor{}, filter.certificate(), states, 11);
  std::printf("one period, %.2f m/s, yaw %.2f: %d states, outside %d, least %.2e m\n", bounds.speed,
              test::yaw_of(filter.certificate()), all.states, all.outside, all.least);
  EXPECT_EQ(all.outside, 0);
  EXPECT_EQ(all.uncertified, 0);
}

TEST(ViewFilterCampaign, NoPeriodFromTheBoundaryLeavesTheSet) {
  for (const ViewBounds& bounds :
       {ViewBounds{}, ViewBounds{.speed = 0.97}, ViewBounds{.speed = 1.5, .acceleration = 0.3}})
    expect_no_way_out(bounds, cone_limits(), runs(1'000'000, 200));
}

/// By the yaw of a sensor that looks aside or back [rad].
class AsideViewCampaign : public testing::TestWithParam<double> {};

TEST_P(AsideViewCampaign, NoTargetWithinItsBoundsIsLost) {
  const double yaw = GetParam();
  const auto limits = test::aside_limits(yaw, yaw < 0 ? MountFrame::body : MountFrame::level);
  expect_kept(fly(fmt::format("yaw {}, 0.5 m/s", yaw), {}, limits, runs(1000, 33)));
}

TEST_P(AsideViewCampaign, NoPeriodFromTheBoundaryLeavesTheSet) {
  for (const ViewBounds& bounds :
       {ViewBounds{.speed = 0.8}, ViewBounds{.wind = 0.1}, ViewBounds{.speed = 0.9, .acceleration = 0.3}})
    expect_no_way_out(bounds, test::aside_limits(GetParam()), runs(100'000, 100));
}

INSTANTIATE_TEST_SUITE_P(Yaws, AsideViewCampaign, testing::Values(1.5708, -1.5708, 3.1416, 0.7, -2.0));

}  // namespace
}  // namespace sightline
