#include "sightline/record/localization_log.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "sightline/readers/cdr.hpp"
#include "tests/support/replayed_flight.hpp"

namespace sightline {
namespace {

/// A short flight of scenarios/localize.toml in its log.
test::ReplayedFlight localized(double duration, const std::vector<std::string>& set = {}) {
  SimulatedClock clock;
  return {read_scenario(SIGHTLINE_SOURCE_DIR "/scenarios/localize.toml", built_in_registry(), set), duration,
          clock};
}

TEST(LocalizationLog, AReplayRunsTheEstimatorAgainAndItsEstimatesAreTheSameBitForBit) {
  for (const std::string filter : {"heading", "attitude"}) {
    const auto log =
        localized(8.0, {"estimate.filter=\"" + filter + "\"", "estimate.broadcast.latency=[0.01, 0.05]",
                        "agent.uav0.camera.outliers=0.1", "estimate.compass_noise=0.1"});
    RecordedFlight flight = log.flight();
    const CommandComparison compared = test::replayed(log.scenario, flight);
    EXPECT_EQ(compared.updates(), 800);
    EXPECT_EQ(compared.differing(), 0);
    EXPECT_GT(compared.estimates(), 700);
    EXPECT_EQ(compared.differing_estimates(), 0);
    EXPECT_FALSE(compared.first_estimate());
  }
}

TEST(LocalizationLog, ABitOfADetectionThatFlipsIsFoundInTheUpdateThatTookIt) {
  const auto log = localized(4.0);
  RecordedFlight flight = log.flight();
  std::int64_t update = -1;
  for (std::size_t k = 200; k < flight.periods().size() && update < 0; ++k) {
    if (flight.periods()[k].detections.empty()) continue;
    double& x = const_cast<RecordedPeriod&>(flight.periods()[k]).detections[0].p.x;
    x = std::nextafter(x, 10.0);
    update = static_cast<std::int64_t>(k);
  }
  ASSERT_GT(update, 0);
  const CommandComparison compared = test::replayed(log.scenario, flight);
  ASSERT_TRUE(compared.first_estimate());
  EXPECT_EQ(compared.first_estimate()->update, update);
  EXPECT_EQ(compared.first_estimate()->robot, "uav0");
  EXPECT_GT(compared.differing(), 0);
}

TEST(LocalizationLog, ItsTopicsSayWhatTheSampleDid) {
  const auto log = localized(3.0);
  McapReader mcap(log.file());
  ASSERT_TRUE(mcap.ok());
  std::map<std::string, int> count;
  std::optional<PoseEstimate> last;
  LogText text;
  mcap.visit([&](const McapMessage& message) {
    ++count[std::string(message.topic)];
    if (message.topic == "/uav0/localization") {
      text.read({reinterpret_cast<const char*>(message.bytes.data()), message.bytes.size()});
      last = estimate_of(text);
    }
    if (message.topic != "/uav0/estimate") return;
    const auto estimate = decode_estimate(message.bytes);
    ASSERT_TRUE(estimate && last);
    EXPECT_EQ(estimate->first.p[0], last->p.x);
    EXPECT_NEAR(std::atan2(estimate->first.d[1], estimate->first.d[0]), last->psi, 1e-9);
    EXPECT_EQ(estimate->second[0], last->P(0, 0));
    EXPECT_EQ(estimate->second[5], last->P(0, 3));
    EXPECT_EQ(estimate->second[35], last->P(3, 3));
    EXPECT_EQ(estimate->second[21], 0.0) << "of roll nothing is said";
  });
  EXPECT_EQ(count["/uav0/motion"], 299);
  EXPECT_EQ(count["/uav1/broadcast"], 300);
  EXPECT_GT(count["/uav0/estimate"], 250);
  EXPECT_EQ(count["/uav0/estimate"], count["/uav0/localization"]);
  EXPECT_GT(count["/uav0/detection"], 70);
  EXPECT_GT(count["/uav0/innovation"], 70);
  EXPECT_LE(count["/uav0/innovation"], count["/uav0/detection"]);
  EXPECT_EQ(count["/uav0/broadcast"], 0);
}

TEST(LocalizationLog, TheRosTypeHasItsDefinitionWithAllItRestsOn) {
  const RosSchema schema = estimate_schema();
  EXPECT_EQ(schema.name, "geometry_msgs/msg/PoseWithCovarianceStamped");
  for (const char* part : {"geometry_msgs/PoseWithCovariance pose", "float64[36] covariance",
                           "MSG: geometry_msgs/Pose\n", "MSG: std_msgs/Header\n"})
    EXPECT_THAT(schema.text, testing::HasSubstr(part));
}

}  // namespace
}  // namespace sightline
