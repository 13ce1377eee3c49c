#include "sightline/base/nearest.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace sightline {
namespace {

using Names = std::vector<std::string_view>;

TEST(Nearest, TheDistanceCountsLettersAndSwappedNeighbours) {
  EXPECT_EQ(edit_distance("", "abc"), 3U);
  EXPECT_EQ(edit_distance("check", "chekc"), 1U);
  EXPECT_EQ(edit_distance("d_mn", "d_min"), 1U);
  EXPECT_EQ(edit_distance("kitten", "sitting"), 3U);
  EXPECT_EQ(edit_distance("abcd", "badc"), 2U);
}

TEST(Nearest, ANameThatIsLikeNoneNamesNone) {
  const Names camera = {"width", "height", "focal_length", "rate", "latency", "dropout", "noise", "range"};
  EXPECT_EQ(nearest("distortion", camera), std::nullopt);
  EXPECT_EQ(nearest("tag_family", camera), std::nullopt);
  EXPECT_EQ(nearest("x", Names{"y"}), std::nullopt);
  EXPECT_EQ(nearest("", camera), std::nullopt);
  EXPECT_EQ(nearest("rate", Names{}), std::nullopt);
  EXPECT_EQ(nearest("agent.uav0.limit", Names{"agent.uav0.hull", "agent.uav0.start"}), std::nullopt)
      << "the parts that both begin with make them no likelier";
  EXPECT_EQ(nearest("agent.uav0.strat", Names{"agent.uav0.hull", "agent.uav0.start"}), "agent.uav0.start");
}

TEST(Nearest, AHintIsTheNearestNameOrTheNamesThatThereAre) {
  EXPECT_EQ(hint("d_mn", Names{"d_max", "d_min"}), ", the nearest is \"d_min\"");
  EXPECT_EQ(hint("distance", Names{"d_max", "d_min"}), ": d_max, d_min");
  EXPECT_EQ(hint("distance", Names{}), "");
  EXPECT_EQ(hint("distance", Names(hint_names + 2, "k")), ": k, k, k, k, k, k, k, k, k, k, k, k and 2 more");
}

/// Keys as the documents write them.
std::set<std::string> documented_keys() {
  std::set<std::string> keys;
  static const std::regex quoted("`([a-zA-Z_][a-zA-Z0-9_]{2,})`");
  for (const auto& entry : std::filesystem::directory_iterator(SIGHTLINE_SOURCE_DIR "/docs")) {
    if (entry.path().extension() != ".md") continue;
    std::ostringstream text;
    text << std::ifstream(entry.path()).rdbuf();
    const std::string page = text.str();
    for (std::sregex_iterator at(page.begin(), page.end(), quoted), end; at != end; ++at)
      keys.insert((*at)[1]);
  }
  return keys;
}

// Of all keys there are: a letter that slipped is found, and a key is taken for another only where
// the two look alike.
TEST(Nearest, EachKeyOfTheDocumentsIsFoundByASlipAndIsNoHintForAnother) {
  const std::set<std::string> keys = documented_keys();
  EXPECT_GT(keys.size(), 300U);
  const Names known(keys.begin(), keys.end());
  std::size_t hints = 0, pairs = 0;
  for (const std::string& key : keys) {
    for (std::size_t i = 0; i + 1 < key.size(); ++i) {
      std::string swapped = key, shorter = key;
      std::swap(swapped[i], swapped[i + 1]);
      shorter.erase(i, 1);
      for (const std::string& slip : {swapped, shorter}) {
        const auto found = nearest(slip, known);
        ASSERT_TRUE(found) << slip;
        EXPECT_LE(edit_distance(slip, *found), 1U) << slip << " " << *found;
      }
    }
    for (const std::string_view other : known) {
      if (other == key) continue;
      ++pairs;
      if (!nearest(key, Names{other})) continue;
      ++hints;
      EXPECT_LE(3 * edit_distance(key, other), std::max(key.size(), other.size())) << key << " " << other;
    }
  }
  EXPECT_LT(hints, pairs / 100) << "of keys chosen at random hardly any two look alike";
}

}  // namespace
}  // namespace sightline
