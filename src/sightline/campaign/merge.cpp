#include "sightline/campaign/merge.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <fstream>
#include <iterator>
#include <map>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>
#include <variant>

#include "sightline/analysis.hpp"
#include "sightline/base.hpp"
#include "sightline/base/sentence.hpp"
#include "sightline/base/text_file.hpp"
#include "sightline/campaign/database.hpp"
#include "sightline/campaign/table.hpp"

namespace sightline {
namespace {

namespace fs = std::filesystem;

/// A table that passed its own checks.
struct ShardTable {
  fs::path file;
  AboutCampaign about{};  // without the shard
  std::string columns{};
  Shard shard{};
  int of_runs = 0;  // runs of the whole campaign
};

bool same_bytes(const fs::path& one, const fs::path& other) {
  std::ifstream a(one, std::ios::binary), b(other, std::ios::binary);
  using Bytes = std::istreambuf_iterator<char>;
  return a && b && std::equal(Bytes(a), {}, Bytes(b), {});
}

/// Whether a complete table has the bytes that follow from its rows.
/// @param scratch  path of temporary files, removed at the end
bool is_as_written(const fs::path& file, const fs::path& scratch) {
  const fs::path again = scratch.native() + ".clean";
  fs::copy_file(file, scratch, fs::copy_options::overwrite_existing);
  {
    Database database(scratch, Database::Open::as_it_is);
    write_clean(database, again);
  }
  const bool same = same_bytes(again, file);
  fs::remove(scratch);
  fs::remove(again);
  return same;
}

/// Value of a key in a table's description, whose content is untrusted.
template <class T>
const T& word_of(const AboutCampaign& about, std::string_view key) {
  const auto found = about.find(std::string(key));
  const T* const word = found == about.end() ? nullptr : std::get_if<T>(&found->second);
  if (word == nullptr) throw_invalid("its {} is missing or of another kind", key);
  return *word;
}

ShardTable read_shard(const fs::path& file, const fs::path& scratch) {
  if (!fs::is_regular_file(file))
    throw_invalid("{}: is missing, expected the table of a shard", file.native());
  ShardTable table{.file = file};
  std::int64_t rows = 0, misplaced = 0, last = 0;
  try {
    Database database(file, Database::Open::as_it_is);
    Database::Statement sound(database, "PRAGMA quick_check");
    if (!sound.step() || sound.text(0) != "ok") throw std::runtime_error("it is damaged");
    table.about = about_campaign(database);
    if (const auto shard = table.about.find(std::string(shard_key)); shard != table.about.end()) {
      const auto words = word_of<std::string>(table.about, shard_key);
      const auto of = std::min(words.find(" of "), words.size());
      table.shard = shard_of(words.substr(0, of));
      const char* const end = words.data() + words.size();
      const char* const number = std::min(words.data() + of + 4, end);
      if (std::from_chars(number, end, table.of_runs).ec != std::errc())
        throw_invalid("its shard is {}, expected I/N of RUNS", words);
      table.about.erase(shard);
    }
    Database::Statement made(database, "SELECT sql FROM sqlite_master WHERE name = 'runs'");
    if (made.step()) table.columns = made.text(0);
    Database::Statement count(
        database,
        fmt::format(
            "SELECT count(*), coalesce(sum(\"index\" % {} <> {}), 0), coalesce(max(\"index\"), -1) FROM runs",
            table.shard.of, table.shard.first()));
    count.step();
    rows = count.integer(0), misplaced = count.integer(1), last = count.integer(2);
    check_rows(database);
    if (const auto digest = table.about.find(std::string(digest_key)); digest != table.about.end()) {
      if (digest->second != Database::Value(rows_digest(database)))
        throw std::runtime_error("rows are not as they were written");
      table.about.erase(digest);
      if (!is_as_written(file, scratch)) throw std::runtime_error("bytes are not as they were written");
    }
  } catch (const std::exception& error) {
    throw_invalid("{}: holds no sound shard ({})", file.native(), sentence_of(error));
  }
  if (table.of_runs == 0)
    throw_invalid("{}: holds a campaign that was not flown by --shard, expected a shard", file.native());
  const int expected = table.shard.size(table.of_runs);
  if (rows != expected) {
    throw_invalid("{}: holds {} of the {} runs of shard {}: fly it to its end by --shard {} --resume",
                  file.native(), rows, expected, to_string(table.shard), to_string(table.shard));
  }
  if (misplaced > 0 || (rows > 0 && last != table.shard.run(expected - 1)))
    throw_invalid("{}: holds runs that are not of shard {}", file.native(), to_string(table.shard));
  return table;
}

/// @throws std::invalid_argument unless both tables are of one campaign
void check_same_campaign(const ShardTable& one, const ShardTable& other) {
  std::vector<std::string> others;
  for (const auto& [key, value] : one.about) {
    const auto found = other.about.find(key);
    if (found == other.about.end() || found->second != value) others.push_back(key);
  }
  if (one.about.size() != other.about.size() && others.empty()) others.emplace_back("plan");
  if (one.shard.of != other.shard.of || one.of_runs != other.of_runs)
    others.emplace_back("number of shards or runs");
  if (one.columns != other.columns) others.emplace_back("columns");
  if (others.empty()) return;
  throw_invalid("{}: holds a shard of another campaign than {}: another {}", other.file.native(),
                one.file.native(), fmt::join(others, ", "));
}

/// Reads all tables, by their first runs.
std::map<int, ShardTable> read_all(const std::vector<fs::path>& files, const fs::path& scratch) {
  std::map<int, ShardTable> tables;
  std::optional<ShardTable> one;
  for (const fs::path& file : files) {
    ShardTable table = read_shard(file, scratch);
    if (!one) one = table;
    check_same_campaign(*one, table);
    const auto [there, added] = tables.emplace(table.shard.first(), table);
    if (!added)
      throw_invalid("{} and {} both hold shard {}", there->second.file.native(), file.native(),
                    to_string(table.shard));
  }
  std::vector<std::string> missing;
  for (int i = 1; i <= one->shard.of; ++i)
    if (!tables.contains(i % one->shard.of)) missing.push_back(std::to_string(i));
  if (!missing.empty())
    throw_invalid("of {} shards {} {} missing", one->shard.of, fmt::join(missing, ", "),
                  missing.size() == 1 ? "is" : "are");
  return tables;
}

/// An existing file may only be replaced by a table of the same campaign.
void check_room(const ShardTable& one, const fs::path& whole) {
  if (!fs::exists(whole)) return;
  bool same = false;
  try {
    Database database(whole, Database::Open::as_it_is);
    auto about = about_campaign(database);
    about.erase(std::string(digest_key));
    same = about == one.about;
  } catch (const std::runtime_error&) {  // not a campaign
  }
  if (!same)
    throw_invalid(
        "{}: is there already and is not this campaign as a whole; give another folder by -o, or move the "
        "file away",
        whole.native());
}

}  // namespace

CampaignWords campaign_words(const fs::path& file) {
  if (!fs::is_regular_file(file))
    throw_invalid("{}: is missing, expected the table of a campaign", file.native());
  try {
    Database database(file, Database::Open::as_it_is);
    const auto about = about_campaign(database);
    const auto plan = about.find("plan");
    FileTexts files;
    for (const auto& [key, value] : about)
      if (key.starts_with(file_key))
        files.emplace(key.substr(file_key.size()), word_of<std::string>(about, key));
    Database::Statement count(database, "SELECT count(*), coalesce(sum(outcome = 'recovered'), 0) FROM runs");
    count.step();
    return {.scenario = word_of<std::string>(about, "scenario"),
            .text = word_of<std::string>(about, "text"),
            .files = std::move(files),
            .plan = plan == about.end() ? "" : word_of<std::string>(about, "plan"),
            .seed = static_cast<std::uint64_t>(word_of<std::int64_t>(about, "seed")),
            .runs = static_cast<int>(count.integer(0)),
            .recovered = static_cast<int>(count.integer(1))};
  } catch (const std::exception& error) {
    throw_invalid("{}: holds no campaign ({})", file.native(), sentence_of(error));
  }
}

void merge_shards(const std::vector<fs::path>& shards, const fs::path& whole) {
  if (shards.empty()) throw_invalid("no shard, expected one or more");
  const fs::path unfinished = beside(whole), clean = whole.native() + ".clean";
  const std::map<int, ShardTable> tables = read_all(shards, unfinished);
  const ShardTable& one = tables.begin()->second;
  check_room(one, whole);
  {
    Database made(unfinished, Database::Open::anew);
    create_tables(made, one.about, one.columns);
    for (const auto& [first, table] : tables) {
      {
        Database::Statement attach(made, "ATTACH DATABASE ? AS shard");
        attach.bind(0, std::string_view(table.file.native()));
        attach.step();
      }
      made.execute("INSERT INTO runs SELECT * FROM shard.runs; DETACH DATABASE shard");
    }
    write_digest(made);
    write_clean(made, clean);
  }
  fs::remove(unfinished);
  fs::rename(clean, whole);
}

}  // namespace sightline
