#include "bridges/dds/topics/transform_chain.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace sightline::dds {
namespace {

using Taken = TransformChain::Taken;

Quaternion turned_by(double angle) { return upright({std::cos(angle), std::sin(angle)}); }

FrameTransform transform(std::string_view parent, std::string_view child, const Vec3<double>& p,
                         double angle = 0.0, Nanoseconds stamp = 1, std::uint64_t writer = 1) {
  return {parent, child, p, turned_by(angle), stamp, writer};
}

// world <- map, at rest, a quarter turn; map <- odom, seldom; odom <- base, often; base <- marker,
// at rest.
TEST(TransformChain, ABodyIsWhereTheChainOfItsParentsLeads) {
  TransformChain chain("marker", "world");
  EXPECT_EQ(chain.ends_at(), "marker");
  chain.take_static(transform("world", "/map", {10, 0, 0}, std::numbers::pi / 2));
  chain.take_static(transform("base", "marker", {0, 0, 0.1}));
  EXPECT_EQ(chain.ends_at(), "base");
  EXPECT_EQ(chain.take(transform("odom", "base", {1, 0, 0}, 0.0, 50)), Taken::moved);
  EXPECT_EQ(chain.ends_at(), "odom");
  EXPECT_FALSE(chain.pose());
  EXPECT_EQ(chain.take(transform("map", "odom", {0, 2, 0}, 0.0, 70)), Taken::none);
  ASSERT_TRUE(chain.pose());
  EXPECT_EQ(chain.ends_at(), "");
  // (1, 2, 0.1) in map.
  EXPECT_NEAR(chain.pose()->p.x, 8.0, 1e-12);
  EXPECT_NEAR(chain.pose()->p.y, 1.0, 1e-12);
  EXPECT_NEAR(chain.pose()->p.z, 0.1, 1e-12);
  EXPECT_NEAR(std::abs(chain.pose()->q.w), std::sqrt(0.5), 1e-12);
  EXPECT_EQ(chain.pose()->stamp, 50);
  EXPECT_EQ(chain.take(transform("odom", "base", {2, 0, 0}, 0.0, 60)), Taken::moved);
  EXPECT_NEAR(chain.pose()->p.y, 2.0, 1e-12);
  EXPECT_EQ(chain.pose()->stamp, 60);
}

TEST(TransformChain, FramesOfOthersAndSecondWritersMoveNothing) {
  TransformChain chain("base", "world");
  EXPECT_EQ(chain.take(transform("world", "other", {1, 0, 0})), Taken::none);
  EXPECT_EQ(chain.take(transform("world", "base", {1, 0, 0}, 0.0, 1, 7)), Taken::moved);
  EXPECT_EQ(chain.take(transform("world", "base", {9, 0, 0}, 0.0, 2, 8)), Taken::second_writer);
  EXPECT_EQ(chain.pose()->p.x, 1.0);
}

TEST(TransformChain, ABodyGoesOverToAnotherParent) {
  TransformChain chain("base", "world");
  (void)chain.take(transform("cart", "base", {1, 0, 0}));
  (void)chain.take(transform("world", "cart", {5, 0, 0}));
  EXPECT_EQ(chain.pose()->p.x, 6.0);
  (void)chain.take(transform("world", "base", {2, 0, 0}, 0.0, 2));
  EXPECT_EQ(chain.pose()->p.x, 2.0);
}

TEST(TransformChain, ACircleOfParentsAndAChainThatIsTooLongLeadNowhere) {
  TransformChain circle("a", "world");
  (void)circle.take(transform("b", "a", {}));
  (void)circle.take(transform("a", "b", {}));
  EXPECT_FALSE(circle.pose());

  TransformChain deep("f0", "world");
  for (int i = 0; i < 40; ++i)
    (void)deep.take(transform(i == 39 ? "world" : "f" + std::to_string(i + 1), "f" + std::to_string(i), {}));
  EXPECT_FALSE(deep.pose());
  for (int i = 0; i < 1000; ++i) deep.take_static(transform("x", "y" + std::to_string(i), {}));
  EXPECT_FALSE(deep.pose());
}

TEST(TransformChain, ATurnThatIsNoneMakesNoPose) {
  TransformChain chain("base", "world");
  (void)chain.take({"world", "base", {1, 0, 0}, {std::nan(""), 0, 0, 0}, 1, 1});
  ASSERT_TRUE(chain.pose());
  EXPECT_EQ(chain.pose()->q, no_attitude);
  EXPECT_TRUE(std::isnan(chain.pose()->p.x));
}

}  // namespace
}  // namespace sightline::dds
