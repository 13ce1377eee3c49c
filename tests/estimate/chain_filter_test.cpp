#include <gtest/gtest.h>

#include "sightline/estimate/heading_filter.hpp"
#include "sightline/estimate/out_of_sequence_filter.hpp"
#include "sightline/estimator.hpp"
#include "tests/support/filter_derivatives.hpp"
#include "tests/support/synthetic_flight.hpp"

/// Robots in a row: the first is an anchor, whose pose motion capture knows; each other one follows
/// and sees the one before it.
namespace sightline::test {
namespace {

/// A picture that has arrived: who saw, and what. Of the body that is seen nothing is filled in.
struct SeenRobot {
  int observer = 0, target = 0;
  Measurement z{};
};

class SyntheticChain {
 public:
  static constexpr double dt = SyntheticSensors::dt;

  /// @param edges  (observer, target), the anchor is 0; by default each sees the one before it
  SyntheticChain(const SyntheticOptions& options, int robots, std::vector<std::pair<int, int>> edges = {})
      : robots_(robots),
        edges_(std::move(edges)),
        radio_(options.seed, StreamId::position_noise, 99),
        camera_rate_(options.camera_rate) {
    RandomStream draw(options.seed, StreamId::draw, 0);
    for (int i = 0; i < 3 * robots; ++i) {
      phases_.push_back(2 * std::numbers::pi * draw.uniform());
      rates_.push_back(0.15 + 0.3 * draw.uniform());
    }
    if (edges_.empty())
      for (int i = 1; i < robots; ++i) edges_.emplace_back(i, i - 1);
    for (int i = 0; i < robots; ++i) sensors_.emplace_back(options, i);
  }

  double now() const { return static_cast<double>(k_) * dt; }
  int robots() const { return robots_; }
  TruePose truth(int i) const { return truth(i, now()); }
  TruePose truth(int i, double t) const {
    TruePose q = moving([&](double s) { return place(i, s); }, t);
    const Vec3<double> ahead = place(i - 1, t) - q.p;
    q.psi = i == 0 ? wrap(0.2 * t) : std::atan2(ahead.y, ahead.x);
    q.roll = 0.05 * std::sin(1.3 * t + i), q.pitch = 0.05 * std::cos(1.1 * t + 2 * i);
    return q;
  }

  /// One period: the motion of each robot in it, and the pictures that have arrived at its end.
  void advance(std::vector<MotionSample>& motion, std::vector<SeenRobot>& arrived) {
    const double t = now(), next = t + dt;
    motion.clear(), arrived.clear();
    for (int i = 0; i < robots_; ++i)
      motion.push_back(sensors_[static_cast<std::size_t>(i)].motion(t, truth(i, t), truth(i, next)));
    ++k_;
    for (; next_picture_ < next - 1e-9; next_picture_ += 1 / camera_rate_) {
      for (const auto& [i, j] : edges_) {
        const auto picture = sensors_[static_cast<std::size_t>(i)].expose(
            next_picture_, truth(i, next_picture_), truth(j, next_picture_));
        if (picture) flying_.emplace_back(picture->first, SeenRobot{i, j, picture->second});
      }
    }
    std::erase_if(flying_, [&](const auto& one) {
      if (one.first > next) return false;
      arrived.push_back(one.second);
      arrived.back().z.source = one.second.target;
      return true;
    });
  }
  /// What motion capture says of the anchor now.
  BroadcastPose anchor() { return broadcast_of(now(), truth(0), 0.2, radio_); }

 private:
  Vec3<double> place(int i, double t) const {
    const auto swing = [&](int n) {
      const auto at = static_cast<std::size_t>(n);
      return std::sin(rates_[at] * t + phases_[at]);
    };
    Vec3<double> p = {0.8 * swing(0), 0.8 * swing(1), 1 + 0.2 * swing(2)};
    for (int k = 1; k <= i; ++k) {
      const double angle = phases_[3 * static_cast<std::size_t>(k)] + 0.5 * swing(3 * k);
      p = p + Vec3<double>{1.4 * std::cos(angle), 1.4 * std::sin(angle), 0.4 + 0.2 * swing(3 * k + 1)};
    }
    return p;
  }

  int robots_;
  std::vector<std::pair<int, int>> edges_;
  RandomStream radio_;
  double camera_rate_;
  std::vector<double> phases_, rates_;
  std::vector<SyntheticSensors> sensors_;
  std::int64_t k_ = 0;
  double next_picture_ = 0.0;
  std::vector<std::pair<double, SeenRobot>> flying_;
};

/// Flies a chain whose robots tell each other their estimates at 100 Hz, 20 to 30 ms late, each
/// with a filter of its own. Result i is of robot i; that of the anchor stays empty.
/// @param other_error  how an observer takes the error of a robot that is localized itself
std::vector<Consistency> fly_chain(SyntheticOptions options, int robots, OtherError other_error, int flights,
                                   double duration, const std::vector<std::pair<int, int>>& edges = {},
                                   double from = 5.0) {
  std::vector<Consistency> result(static_cast<std::size_t>(robots));
  std::vector<MotionSample> motion;
  std::vector<SeenRobot> arrived;
  for (int run = 0; run < flights; ++run) {
    options.seed = 100 + static_cast<std::uint64_t>(run);
    SyntheticChain chain(options, robots, edges);
    RandomStream radio(options.seed, StreamId::fault, 0);
    std::vector<std::unique_ptr<PoseFilter>> filters;
    std::vector<BroadcastTrack> tracks;
    for (int i = 0; i < robots; ++i) {
      filters.push_back(make_pose_filter(
          {.filter = i > 1 || robots == 1 || !edges.empty() ? FilterKind::chain : FilterKind::heading},
          options.mount));
      // Errors that last are not fresh with each message, whatever the rate.
      tracks.emplace_back(BroadcastOptions{.sighting_rate = i == 0 ? options.camera_rate : 1e-3});
    }
    std::vector<std::tuple<double, std::size_t, BroadcastPose>> messages;
    while (chain.now() < duration) {
      chain.advance(motion, arrived);
      for (std::size_t i = 1; i < filters.size(); ++i) filters[i]->advance(motion[i]);
      messages.emplace_back(chain.now() + 0.02 + 0.01 * radio.uniform(), 0, chain.anchor());
      for (std::size_t i = 1; i < filters.size(); ++i) {
        const PoseEstimate e = filters[i]->estimate();
        if (!e.known) continue;
        messages.emplace_back(
            chain.now() + 0.02 + 0.01 * radio.uniform(), i,
            BroadcastPose{
                .stamp = e.stamp, .p = e.p, .v = e.v, .psi = e.psi, .yaw_rate = e.yaw_rate, .P = e.P});
      }
      std::erase_if(messages, [&](const auto& m) {
        if (std::get<0>(m) > chain.now()) return false;
        tracks[std::get<1>(m)].take(std::get<2>(m));
        return true;
      });
      for (SeenRobot& seen : arrived) {
        const auto pose = tracks[static_cast<std::size_t>(seen.target)].at(seen.z.stamp);
        if (!pose) continue;
        seen.z.p_other = pose->p, seen.z.psi_other = pose->psi, seen.z.P_other = pose->P;
        seen.z.other_error = seen.target == 0 ? OtherError::fresh : other_error;
        filters[static_cast<std::size_t>(seen.observer)]->take(seen.z);
      }
      if (chain.now() < from) continue;
      for (std::size_t i = 1; i < filters.size(); ++i) {
        const PoseEstimate e = filters[i]->estimate();
        if (!e.known) ++result[i].unknown;
        if (e.known) result[i].add(e, chain.truth(static_cast<int>(i)));
      }
    }
  }
  return result;
}

}  // namespace
}  // namespace sightline::test

namespace sightline {
namespace {

using test::Consistency;
using test::fly_chain;

TEST(ChainFilter, RobotsThatTellEachOtherTheirEstimatesDoNotCountThemTwice) {
  const std::vector<Consistency> lasting = fly_chain({}, 5, OtherError::lasting, 16, 25.0),
                                 fresh = fly_chain({}, 5, OtherError::fresh, 16, 25.0);
  for (std::size_t i = 1; i < lasting.size(); ++i) {
    EXPECT_GT(lasting[i].anees(), 2.8) << i;
    EXPECT_LT(lasting[i].anees(), 5.2) << i;
  }
  EXPECT_GT(fresh[4].anees(), 15.0) << "errors that last, taken for fresh ones, are averaged away";
}

TEST(ChainFilter, IntersectionIsTrueInACircleAndFarLessSure) {
  const std::vector<std::pair<int, int>> circle = {{1, 0}, {2, 1}, {1, 2}};
  const std::vector<Consistency> flown = fly_chain({}, 3, OtherError::unknown, 8, 20.0, circle);
  EXPECT_LT(flown[1].anees(), 4.6);
  EXPECT_LT(flown[2].anees(), 4.6);
  EXPECT_LT(flown[1].rmse(), 0.03);
}

TEST(ChainFilter, TheCovarianceGoesOnAsTheStateDoesAndInnovationsAsHSays) {
  constexpr SensorMount mount{.pitch = 0.4, .offset = 0.17, .frame = MountFrame::body};
  const ChainFilter filter({}, mount);
  Random random(1);
  const auto s = test::random_state(filter, random);
  const MotionSample u = test::random_motion(random);
  Measurement z = test::random_sighting(random);
  z.other_error = OtherError::lasting;
  const Innovation<4, ChainFilter::n> of = filter.innovation(s, z, u);
  constexpr double h = 1e-6;
  for (int i = 0; i < ChainFilter::n; ++i) {
    const auto before = filter.innovation(test::moved(filter, s, i, -h), z, u);
    const auto after = filter.innovation(test::moved(filter, s, i, h), z, u);
    for (int a = 0; a < 4; ++a)
      EXPECT_NEAR(-wrap(after.y(a, 0) - before.y(a, 0)) / (2 * h), of.H(a, i), 1e-6) << a << " by " << i;
  }
  EXPECT_LT(of.R(0, 0), filter.innovation(s, test::random_sighting(random), u).R(0, 0) + 1.0);
  // The error of the other is as likely as it tells, after a while.
  auto later = s;
  filter.receive(later, z);
  for (int k = 0; k < 2000; ++k) filter.advance(later, u, 0.01);
  EXPECT_LE(test::greatest(block<4, 4>(later.P, 10, 10) - z.P_other), 1e-6);
}

}  // namespace
}  // namespace sightline
