#include "sightline/campaign/merge.hpp"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <future>
#include <stdexcept>
#include <utility>

#include "sightline/campaign/table.hpp"
#include "tests/support/command.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/small_campaign.hpp"

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr int shard_runs = 21;

/// Flies a shard, or the first `some` shard_runs of it.
fs::path flown_shard(const fs::path& file, const Shard& shard, int some = shard_runs,
                     std::uint64_t seed = 9) {
  const Scenario scenario = small_campaign();
  RunTable table(file, scenario, *scenario.campaign, seed, shard, shard_runs);
  const CampaignOptions options{
      .runs = shard_runs, .seed = seed, .threads = 2, .first = table.rows(), .shard = shard};
  int left = some;
  struct Enough {};
  try {
    fly_campaign(scenario, *scenario.campaign, options, [&](const RunDraw& run, const RunResult& result) {
      if (left-- == 0) throw Enough{};
      table.add(run, result);
    });
  } catch (const Enough&) {
  }
  table.finish();
  return file;
}

std::vector<fs::path> shard_files(const fs::path& folder, int of) {
  std::vector<fs::path> files;
  for (int i = 1; i <= of; ++i) files.push_back(flown_shard(folder / fmt::format("{}.sqlite", i), {i, of}));
  return files;
}

std::string merge_refusal(const std::vector<fs::path>& files, const fs::path& whole) {
  const std::string refusal = refusal_of([&] { merge_shards(files, whole); });
  EXPECT_TRUE(refusal.empty() || !fs::exists(whole)) << "nothing is written";
  return refusal;
}

TEST(MergeShards, HasTheBytesOfOneProcessInAnyOrderOfShards) {
  const fs::path folder = test::fresh_folder();
  const std::string whole = test::read_file(flown_shard(folder / "whole.sqlite", {}));
  for (const int of : {2, 3, 12}) {
    std::vector<fs::path> files = shard_files(folder, of);
    merge_shards(files, folder / "merged.sqlite");
    EXPECT_TRUE(test::read_file(folder / "merged.sqlite") == whole) << of;
    std::swap(files.front(), files.back());
    merge_shards(files, folder / "merged.sqlite");
    EXPECT_TRUE(test::read_file(folder / "merged.sqlite") == whole) << of << ", again";
    for (const fs::path& file : files) fs::remove(file);
  }
  const CampaignWords words = campaign_words(folder / "merged.sqlite");
  EXPECT_EQ(words.runs, shard_runs);
  EXPECT_EQ(words.seed, 9U);
  EXPECT_EQ(words.scenario, "cooperative_localization");
}

TEST(MergeShards, AShardThatWasStoppedGoesOnToTheSameBytes) {
  const fs::path folder = test::fresh_folder();
  const std::string whole = test::read_file(flown_shard(folder / "whole.sqlite", {2, 3}));
  for (const int some : {1, 3, 6}) {
    fs::remove(folder / "a.sqlite");
    (void)flown_shard(folder / "a.sqlite", {2, 3}, some);
    EXPECT_TRUE(test::read_file(flown_shard(folder / "a.sqlite", {2, 3})) == whole) << some;
  }
}

TEST(MergeShards, SaysByNameWhatIsMissingDamagedForeignTwiceOrNotWhole) {
  const fs::path folder = test::fresh_folder(), to = folder / "merged.sqlite";
  const std::vector<fs::path> files = shard_files(folder, 3);
  EXPECT_EQ(merge_refusal({files[0], files[2]}, to), "of 3 shards 2 is missing");
  EXPECT_THAT(merge_refusal({files[0], folder / "nowhere.sqlite"}, to),
              testing::HasSubstr("nowhere.sqlite: is missing"));
  EXPECT_THAT(merge_refusal({files[0], files[1], files[1]}, to), testing::HasSubstr("both hold shard 2/3"));
  EXPECT_THAT(merge_refusal({files[0], files[1], flown_shard(folder / "whole.sqlite", {})}, to),
              testing::HasSubstr("was not flown by --shard"));
  EXPECT_THAT(
      merge_refusal({files[0], files[1], flown_shard(folder / "other.sqlite", {3, 3}, shard_runs, 10)}, to),
      testing::AllOf(testing::HasSubstr("other.sqlite: "), testing::HasSubstr("another seed")));
  EXPECT_THAT(merge_refusal({files[0], files[1], flown_shard(folder / "half.sqlite", {3, 3}, 4)}, to),
              testing::HasSubstr("half.sqlite: holds 4 of the 7 runs of shard 3/3"));
  std::string bytes = test::read_file(files[2]);
  for (std::size_t page = 4096; page < bytes.size(); page += 4096) bytes[page] = '\x5a';  // headers
  std::ofstream(folder / "damaged.sqlite", std::ios::binary) << bytes;
  EXPECT_THAT(merge_refusal({files[0], files[1], folder / "damaged.sqlite"}, to),
              testing::HasSubstr("damaged.sqlite: holds no sound shard"));
}

TEST(MergeShards, AByteThatChangedAnywhereIsSeen) {
  const fs::path folder = test::fresh_folder(), to = folder / "merged.sqlite";
  const std::vector<fs::path> files = shard_files(folder, 2);
  const std::string bytes = test::read_file(files[1]);
  for (std::size_t place = 5; place < bytes.size(); place += bytes.size() / 40) {
    std::string spoilt = bytes;
    spoilt[place] = static_cast<char>(spoilt[place] ^ 0x10);
    std::ofstream(folder / "spoilt.sqlite", std::ios::binary) << spoilt;
    EXPECT_THAT(merge_refusal({files[0], folder / "spoilt.sqlite"}, to),
                testing::HasSubstr("spoilt.sqlite: holds"))
        << place;
  }
}

TEST(MergeShards, SeveralAtOnceDoNotMeet) {
  const fs::path folder = test::fresh_folder();
  const std::vector<fs::path> files = shard_files(folder, 2);
  std::vector<std::future<void>> merges;
  for (int i = 0; i < 8; ++i)
    merges.push_back(std::async(
        std::launch::async, [&, i] { merge_shards(files, folder / fmt::format("merged_{}.sqlite", i)); }));
  for (std::future<void>& one : merges) EXPECT_NO_THROW(one.get());
}

TEST(MergeShards, ATableThatIsThereIsNotReplacedByAnotherCampaign) {
  const fs::path folder = test::fresh_folder();
  const std::vector<fs::path> files = shard_files(folder, 2);
  const std::string before = test::read_file(files[0]);
  EXPECT_THROW(merge_shards(files, files[0]), std::invalid_argument) << "a shard";
  const fs::path other = flown_shard(folder / "other.sqlite", {}, shard_runs, 77);
  EXPECT_THROW(merge_shards(files, other), std::invalid_argument);
  EXPECT_TRUE(test::read_file(files[0]) == before);
}

}  // namespace
}  // namespace sightline
