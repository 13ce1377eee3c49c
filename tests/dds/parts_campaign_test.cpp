/// Parts of a fleet, each planned by a program of its own.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "bridges/dds/domain.hpp"
#include "tests/dds/fly.hpp"
#include "tests/dds/person.hpp"

namespace sightline::dds {
namespace {

using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;
namespace fs = std::filesystem;

class PartsFlown : public FlyTest {
 protected:
  /// The desk, whose vehicles are planned apart.
  fs::path desk_in_parts(const std::string& duration) const {
    const fs::path fleet = desk(duration);
    std::ofstream(fleet, std::ios::app) << "[partition]\nleft = [\"uav0\"]\nright = [\"uav1\"]\n";
    return fleet;
  }
  std::unique_ptr<test::Child> fly(const fs::path& fleet, const std::string& part,
                                   const std::string& name) const {
    return begin({"fly", fleet.string(), "--part", part, "-o", (folder / name).string()}, name);
  }
  /// How often a program printed it.
  long times(const std::string& name, const std::string& what) const {
    const std::string text = printed(name);
    long count = 0;
    for (auto at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++count;
    return count;
  }
};

TEST_F(PartsFlown, OneThatIsKilledJoinsAgainAndFliesOnceItsRobotHasLandedAndSomebodyStartsIt) {
  const fs::path fleet = desk_in_parts("60.0");
  const auto vehicles = begin({"vehicles", fleet.string()}, "vehicles");
  const auto left = fly(fleet, "left", "left");
  auto right = fly(fleet, "right", "right");
  const std::string flies = "part right: its messages arrive, its robots fly as they predict",
                    stands = "part right: its messages arrive, its robots do not fly its task";
  ASSERT_TRUE(prints("left.err", flies)) << printed("left.err") << printed("right.err");

  const auto second = fly(fleet, "right", "second");
  ASSERT_TRUE(test::eventually([&] { return second->ended(); }, std::chrono::seconds(20)));
  EXPECT_EQ(second->code(), 2);
  EXPECT_THAT(printed("second.err"), HasSubstr("partition.part = \"right\", which another program plans"));

  right->end(SIGKILL);
  ASSERT_TRUE(prints("left.err", "part right: its messages do not arrive")) << printed("left.err");
  const long stood = times("left.err", stands), flew = times("left.err", flies);
  const auto again = fly(fleet, "right", "again");
  EXPECT_TRUE(test::eventually([&] { return times("left.err", stands) > stood; }, std::chrono::seconds(20)))
      << "its robot is no cooperative neighbour: " << printed("left.err");

  Domain domain(test::own_network());
  Person person(domain, 5, "/sightline/right/start");
  const bool early = printed("again.err").find("lets them take off") == std::string::npos;
  const std::string answer = early ? person.call() : "no: ";
  EXPECT_THAT(answer, StartsWith("no: "));
  ASSERT_TRUE(test::eventually([&] {
    return printed("again.err").find("/sightline/right/start lets them take off") != std::string::npos;
  })) << printed("again.err")
      << printed("vehicles.err");
  EXPECT_THAT(printed("again.err"), HasSubstr("uav1: it is flying already, by another program"));
  std::this_thread::sleep_for(std::chrono::seconds(1));
  EXPECT_THAT(printed("again.err"), Not(HasSubstr("arming"))) << "nobody has called";
  EXPECT_THAT(person.call(), StartsWith("yes: "));
  EXPECT_TRUE(prints("again.err", "the task begins")) << printed("again.err");
  EXPECT_TRUE(test::eventually([&] { return times("left.err", flies) > flew; }, std::chrono::seconds(20)))
      << printed("left.err");

  for (const auto& flyer : {left.get(), again.get()}) {
    ::kill(flyer->pid(), SIGINT);
    EXPECT_TRUE(test::eventually([&] { return flyer->ended(); }, std::chrono::seconds(30)));
  }
  EXPECT_EQ(again->code(), 0) << printed("again.err");
  vehicles->end(SIGINT);
  EXPECT_THAT(printed("vehicles.out"), testing::ContainsRegex("uav1: [^\n]*failsafe 1\\."));
  EXPECT_THAT(printed("vehicles.out"), Not(testing::ContainsRegex("uav0: [^\n]*failsafe")));
}

TEST_F(PartsFlown, WithoutAPartOrByOneThatIsNotThereNothingIsFlown) {
  const fs::path fleet = desk_in_parts("10.0");
  const auto refusal = [&](const std::string& words) {
    const auto refused =
        test::sightline("fly " + fleet.string() + " " + words + " -o " + (folder / "out").string(), folder);
    EXPECT_EQ(refused.code, 2) << words;
    EXPECT_FALSE(fs::exists(folder / "out")) << words;
    return refused.err;
  };
  EXPECT_THAT(refusal(""), HasSubstr("--part is missing, expected one of left, right, or all"));
  EXPECT_THAT(refusal("--part middle"), HasSubstr("partition.part = \"middle\""));
  EXPECT_THAT(refusal("--part left --partition 'left: uav0'"), HasSubstr("uav1 is in none"));
  EXPECT_THAT(refusal("--part left --partition 'left: uav0 | left: uav1'"),
              HasSubstr("has part \"left\" twice"));
  EXPECT_THAT(refusal("--part left --partition 'left: uav0 | right: uav0,uav1'"),
              HasSubstr("a robot that no part has yet"));
  EXPECT_THAT(refusal("--part left --partition 'left: uav0 | right: uaw1'"),
              HasSubstr("the nearest is \"uav1\""));
}

}  // namespace
}  // namespace sightline::dds
