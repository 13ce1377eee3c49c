#include <gtest/gtest.h>
#include <sys/resource.h>

#include <array>
#include <csignal>
#include <cstring>
#include <fstream>
#include <iterator>
#include <random>

#include "sightline/log.hpp"
#include "tests/support/folder.hpp"

namespace sightline {
namespace {

using test::place;
using Bytes = std::vector<std::byte>;

struct Message {
  std::string topic, schema, encoding;
  std::uint32_t sequence = 0;
  std::uint64_t log_time = 0;
  Bytes bytes;
  bool operator==(const Message&) const = default;
};

Bytes load(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  const auto bytes = std::as_bytes(std::span(text));
  return {bytes.begin(), bytes.end()};
}

void save(const std::filesystem::path& path, std::span<const std::byte> bytes) {
  std::ofstream(path, std::ios::binary)
      .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

// Random messages on three channels, `chunks` chunks of up to nine each.
struct RandomLog {
  std::vector<Message> messages;
  std::vector<std::uint64_t> ends;     // length of the file after each chunk [B]
  std::vector<std::size_t> read_then;  // messages it holds by then
};

RandomLog write_log(const std::filesystem::path& path, int chunks, unsigned seed = 1) {
  std::mt19937_64 random(seed);
  RandomLog log;
  McapWriter writer(path, "ros2", "sightline test");
  writer.metadata("run", {{"seed", "1"}, {"scenario", "[horizon]\nduration = 1.0\n"}});
  const SchemaId pose = writer.schema("Pose", "ros2msg", "float64 x\n");
  const SchemaId record = writer.schema("Record", "jsonschema", "{}");
  const std::array<Message, 3> kinds{{{"/uav0/pose", "Pose", "cdr", 0, 0, {}},
                                      {"/solver", "Record", "json", 0, 0, {}},
                                      {"/uav1/pose", "Pose", "cdr", 0, 0, {}}}};
  const std::array channels{writer.channel(pose, "/uav0/pose", "cdr", {{"frame", "map"}}),
                            writer.channel(record, "/solver", "json", {}),
                            writer.channel(pose, "/uav1/pose", "cdr", {})};
  std::uint32_t sequence = 0;
  for (int chunk = 0; chunk < chunks; ++chunk) {
    for (std::size_t count = 1 + random() % 9; count > 0; --count) {
      const std::size_t kind = random() % kinds.size();
      Message message = kinds[kind];
      message.sequence = ++sequence;
      message.log_time = 1000 * sequence;
      message.bytes.resize(random() % 80);
      for (std::byte& byte : message.bytes) byte = static_cast<std::byte>(random());
      writer.message(channels[kind], message.sequence, message.log_time, message.bytes);
      log.messages.push_back(std::move(message));
    }
    writer.flush();
    log.ends.push_back(writer.bytes_written());
    log.read_then.push_back(log.messages.size());
  }
  writer.metadata("end", {{"updates", std::to_string(sequence)}});
  writer.close();
  EXPECT_TRUE(writer.ok()) << writer.error();
  return log;
}

Message copied(const McapMessage& m) {
  return {std::string(m.topic),
          std::string(m.schema),
          std::string(m.encoding),
          m.sequence,
          m.log_time,
          Bytes(m.bytes.begin(), m.bytes.end())};
}

std::vector<Message> read_log(McapReader& reader) {
  std::vector<Message> messages;
  reader.visit([&](const McapMessage& m) { messages.push_back(copied(m)); });
  return messages;
}

bool begins_with(const std::vector<Message>& all, const std::vector<Message>& some) {
  return some.size() <= all.size() && std::equal(some.begin(), some.end(), all.begin());
}

TEST(Mcap, WhatIsWrittenIsReadBackInOrder) {
  for (int chunks = 0; chunks < 12; ++chunks) {
    const auto path = place("order.mcap");
    const RandomLog log = write_log(path, chunks, static_cast<unsigned>(chunks));
    McapReader reader(path);
    EXPECT_TRUE(read_log(reader) == log.messages) << chunks << " chunks";
    EXPECT_TRUE(reader.ok()) << reader.error();
    EXPECT_FALSE(reader.truncated());
    EXPECT_EQ(reader.profile(), "ros2");
    EXPECT_EQ(reader.library(), "sightline test");
    ASSERT_EQ(reader.metadata().size(), 2U);
    EXPECT_EQ(reader.metadata().at("run").at("scenario"), "[horizon]\nduration = 1.0\n");
    EXPECT_EQ(reader.metadata().at("end").at("updates"), std::to_string(log.messages.size()));
  }
}

TEST(Mcap, TheSameMessagesGiveTheSameBytes) {
  write_log(place("one.mcap"), 20);
  write_log(place("two.mcap"), 20);
  EXPECT_TRUE(load(place("one.mcap")) == load(place("two.mcap")));
  EXPECT_FALSE(load(place("one.mcap")).empty());
}

// However the pieces fall: in the midst of a chunk, the end and the closing magic.
TEST(Mcap, ALogThatGrowsGivesEachMessageOnceAndInOrder) {
  const auto path = place("grown.mcap"), growing = place("growing.mcap");
  const RandomLog log = write_log(path, 6);
  const Bytes whole = load(path);
  std::mt19937 random(5);
  for (int trial = 0; trial < 8; ++trial) {
    // The last bytes one by one, once.
    std::size_t size = trial == 0 ? whole.size() - 400 : 8 + random() % whole.size() / 2;
    save(growing, std::span(whole).first(size));
    McapReader reader(growing);
    std::vector<Message> messages;
    const auto read_on = [&] {
      return reader.read_on([&](const McapMessage& m) { messages.push_back(copied(m)); });
    };
    while (size < whole.size()) {
      ASSERT_TRUE(read_on()) << reader.error() << ", cut at " << size;
      ASSERT_TRUE(reader.truncated());
      ASSERT_TRUE(begins_with(log.messages, messages)) << "cut at " << size;
      size = std::min(whole.size(), size + (trial == 0 ? 1 : 1 + random() % 400));
      save(growing, std::span(whole).first(size));
    }
    ASSERT_TRUE(read_on() && read_on()) << reader.error();
    EXPECT_FALSE(reader.truncated());
    EXPECT_TRUE(messages == log.messages);
    save(growing, std::span(whole).first(20));
    EXPECT_FALSE(read_on());
    EXPECT_NE(reader.error().find("became shorter"), std::string::npos);
  }
}

TEST(Mcap, AFileCutAnywhereOpensToItsLastWholeChunk) {
  const auto path = place("whole.mcap"), cut_path = place("cut.mcap");
  const RandomLog log = write_log(path, 6);
  const Bytes whole = load(path);
  for (std::size_t cut = 0; cut < whole.size(); ++cut) {
    save(cut_path, std::span(whole).first(cut));
    McapReader reader(cut_path);
    const std::vector<Message> messages = read_log(reader);
    ASSERT_TRUE(reader.ok()) << reader.error() << ", cut at " << cut;
    ASSERT_TRUE(reader.truncated()) << "cut at " << cut;
    ASSERT_TRUE(begins_with(log.messages, messages)) << "cut at " << cut;
    std::size_t least = 0;
    for (std::size_t k = 0; k < log.ends.size() && log.ends[k] <= cut; ++k) least = log.read_then[k];
    ASSERT_GE(messages.size(), least) << "cut at " << cut;
    if (!reader.metadata().empty()) {
      ASSERT_EQ(reader.metadata().at("run").size(), 2U);
    }
  }
}

TEST(Mcap, AFileStillOpenHoldsEveryFlushedChunk) {
  const auto path = place("open.mcap");
  McapWriter writer(path, "ros2", "");
  const ChannelId channel = writer.channel(writer.schema("S", "jsonschema", "{}"), "/s", "json", {});
  const Bytes bytes(10, std::byte{'7'});
  for (std::uint32_t k = 0; k < 50; ++k) {
    writer.message(channel, k, k, bytes);
    if (k % 5 != 4) continue;
    writer.flush();
    McapReader reader(path);
    EXPECT_EQ(read_log(reader).size(), k + 1);
    EXPECT_TRUE(reader.ok()) << reader.error();
    EXPECT_TRUE(reader.truncated());
  }
}

TEST(Mcap, EveryWrongByteIsFound) {
  const auto path = place("sound.mcap"), wrong_path = place("wrong.mcap");
  write_log(path, 3);
  const Bytes sound = load(path);
  std::mt19937_64 random(7);
  for (std::size_t at = 0; at < sound.size(); ++at) {
    Bytes wrong = sound;
    wrong[at] ^= static_cast<std::byte>(1 + random() % 255);
    save(wrong_path, wrong);
    McapReader reader(wrong_path);
    read_log(reader);
    ASSERT_FALSE(reader.ok() && !reader.truncated()) << "byte " << at;
    if (!reader.ok()) {
      ASSERT_NE(reader.error().find("wrong.mcap: "), std::string::npos);
    }
  }
}

TEST(Mcap, AFileWhoseWriterComputesNoCrcIsRead) {
  const auto path = place("no_crc.mcap");
  const RandomLog log = write_log(path, 3);
  Bytes bytes = load(path);
  constexpr std::size_t head = 9, magic = 8,
                        chunk_crc = 24;  // of a record, of a file, and where it is in a chunk
  const auto clear = [&](std::size_t at) {
    std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(at), 4, std::byte{0});
  };
  clear(bytes.size() - magic - 4);
  for (std::size_t at = magic; at < bytes.size() - magic;) {
    std::uint64_t length = 0;
    std::memcpy(&length, &bytes[at + 1], sizeof length);
    if (bytes[at] == std::byte{0x06}) clear(at + head + chunk_crc);
    if (bytes[at] == std::byte{0x0f}) clear(at + head);
    at += head + length;
  }
  save(path, bytes);
  McapReader reader(path);
  EXPECT_EQ(read_log(reader).size(), log.messages.size()) << reader.error();
  EXPECT_TRUE(reader.ok() && !reader.truncated());
}

TEST(Mcap, AWrongByteInAChunkHidesThatChunkAndNamesItsPlace) {
  const auto path = place("chunk.mcap");
  const RandomLog log = write_log(path, 4);
  Bytes bytes = load(path);
  bytes[log.ends[0] + 60] ^= std::byte{0x10};
  save(path, bytes);
  McapReader reader(path);
  EXPECT_EQ(read_log(reader).size(), log.read_then[0]);
  EXPECT_NE(reader.error().find("byte " + std::to_string(log.ends[0])), std::string::npos) << reader.error();
}

TEST(Mcap, CutsAndWrongBytesTogetherNeverGetPastTheReader) {
  const auto path = place("fuzz.mcap"), wrong_path = place("fuzzed.mcap");
  write_log(path, 8);
  const Bytes sound = load(path);
  std::mt19937_64 random(11);
  for (int k = 0; k < 5000; ++k) {
    Bytes wrong = sound;
    for (std::size_t flips = 1 + random() % 12; flips > 0; --flips)
      wrong[random() % wrong.size()] =
          static_cast<std::byte>(random() % 3 == 0 ? 0xFF * (random() % 2) : random());
    if (random() % 2 == 0) wrong.resize(random() % wrong.size());
    const bool same = wrong.size() == sound.size() && wrong == sound;
    save(wrong_path, wrong);
    McapReader reader(wrong_path);
    read_log(reader);
    ASSERT_TRUE(same || !reader.ok() || reader.truncated()) << "case " << k;
    ASSERT_LT(reader.error().size(), 4096U);
  }
}

TEST(Mcap, WhatIsNoLogIsRefusedInASentence) {
  save(place("text.mcap"), std::as_bytes(std::span(std::string_view("[horizon]\nduration = 1.0\n"))));
  for (const auto& path : {place("text.mcap"), place("missing.mcap"), place("")}) {
    McapReader reader(path);
    EXPECT_TRUE(read_log(reader).empty());
    EXPECT_FALSE(reader.ok());
    EXPECT_EQ(reader.error().rfind(path.string() + ": ", 0), 0U) << reader.error();
  }
}

TEST(Mcap, AFullDiskIsReportedOnceAndNothingThrows) {
  McapWriter writer("/dev/full", "ros2", "");
  const std::string first = writer.error();
  EXPECT_NE(first.find("/dev/full: "), std::string::npos);
  EXPECT_NE(first.find("No space left on device"), std::string::npos) << first;
  const ChannelId channel = writer.channel(writer.schema("S", "jsonschema", "{}"), "/s", "json", {});
  writer.message(channel, 0, 0, {});
  writer.flush();
  writer.metadata("m", {});
  writer.close();
  EXPECT_EQ(writer.error(), first);
}

TEST(Mcap, AFolderThatIsNotThereIsReportedNotThrown) {
  McapWriter writer(place("no/such/folder/run.mcap"), "ros2", "");
  EXPECT_NE(writer.error().find("cannot be opened for writing"), std::string::npos) << writer.error();
  EXPECT_NE(writer.error().find("No such file or directory"), std::string::npos) << writer.error();
}

// A limit on the length of files fails a write in its middle, as a disk does that fills up.
TEST(Mcap, ADiskThatFillsUpLeavesTheWholeChunks) {
  const auto path = place("full.mcap");
  write_log(path, 10);
  const auto length = std::filesystem::file_size(path);
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  for (rlim_t limit = 0; limit < length; limit += 13) {
    const rlimit small{limit, before.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &small);
    McapWriter writer(path, "ros2", "sightline test");
    const ChannelId channel = writer.channel(writer.schema("S", "jsonschema", "{}"), "/s", "json", {});
    std::uint32_t written = 0;
    for (std::uint32_t k = 0; k < 400 && writer.ok(); ++k) {
      writer.message(channel, k, k, Bytes(k % 40, static_cast<std::byte>(k)));
      writer.flush();
      if (writer.ok()) written = k + 1;
    }
    writer.close();
    ::setrlimit(RLIMIT_FSIZE, &before);
    ASSERT_NE(writer.error().find("File too large"), std::string::npos) << writer.error();
    ASSERT_EQ(std::filesystem::file_size(path), writer.bytes_written());
    McapReader reader(path);
    ASSERT_EQ(read_log(reader).size(), written) << "limit " << limit;
    ASSERT_TRUE(reader.ok()) << reader.error();
    ASSERT_TRUE(reader.truncated());
  }
  std::signal(SIGXFSZ, handler);
}

TEST(Mcap, ALongChunkClosesByItself) {
  const auto path = place("long.mcap");
  McapWriter writer(path, "ros2", "");
  const ChannelId channel = writer.channel(writer.schema("S", "jsonschema", "{}"), "/s", "json", {});
  const std::uint64_t before = writer.bytes_written();
  const Bytes bytes(1 << 20, std::byte{3});
  for (std::uint32_t k = 0; k < 20; ++k) writer.message(channel, k, k, bytes);
  EXPECT_GT(writer.bytes_written(), before);
  writer.close();
  McapReader reader(path);
  EXPECT_EQ(read_log(reader).size(), 20U);
  EXPECT_TRUE(reader.ok() && !reader.truncated()) << reader.error();
}

}  // namespace
}  // namespace sightline
