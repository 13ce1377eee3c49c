#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>
#include <zstd.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cerrno>
#include <concepts>
#include <cstdio>
#include <optional>
#include <system_error>
#include <utility>

#include "sightline/base/reason.hpp"
#include "sightline/log.hpp"

namespace sightline {

namespace {

using namespace mcap;
using Bytes = std::vector<std::byte>;

constexpr std::uint64_t chunk_limit = 4 << 20;     // longer chunks close automatically [B]
constexpr std::uint64_t message_limit = 64 << 20;  // [B]
constexpr int zstd_level = 1;

// Writing: little-endian numbers; strings and lists preceded by their lengths.

template <std::unsigned_integral T>
void store(std::byte* place, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i) place[i] = static_cast<std::byte>(value >> (8 * i));
}

template <std::unsigned_integral T>
T load(const std::byte* place) {
  T value = 0;
  for (std::size_t i = 0; i < sizeof(T); ++i) value |= static_cast<T>(static_cast<T>(place[i]) << (8 * i));
  return value;
}

template <std::unsigned_integral T>
void put(Bytes& to, T value) {
  to.resize(to.size() + sizeof(T));
  store(to.data() + to.size() - sizeof(T), value);
}

void put_bytes(Bytes& to, Span bytes) { to.insert(to.end(), bytes.begin(), bytes.end()); }

void put_string(Bytes& to, std::string_view text) {
  put(to, static_cast<std::uint32_t>(text.size()));
  put_bytes(to, std::as_bytes(std::span(text)));
}

void put_words(Bytes& to, const McapWords& words) {
  std::size_t length = 0;
  for (const auto& [key, value] : words) length += 8 + key.size() + value.size();
  put(to, static_cast<std::uint32_t>(length));
  for (const auto& [key, value] : words) {
    put_string(to, key);
    put_string(to, value);
  }
}

// Opens a record and returns its offset; close_record() sets its length.
std::size_t open_record(Bytes& to, RecordKind kind) {
  const std::size_t at = to.size();
  put(to, static_cast<std::uint8_t>(kind));
  put(to, std::uint64_t{0});
  return at;
}

void close_record(Bytes& to, std::size_t at) {
  store(to.data() + at + 1, static_cast<std::uint64_t>(to.size() - at - record_head));
}

}  // namespace

McapWriter::McapWriter(const std::filesystem::path& path, std::string_view profile, std::string_view library)
    : path_(path.string()), zstd_(ZSTD_createCCtx(), ZSTD_freeCCtx) {
  do {
    file_ = ::open(path_.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  } while (file_ < 0 && errno == EINTR);
  if (file_ < 0) fail("cannot be opened for writing", errno);

  put_bytes(out_, std::as_bytes(std::span(magic)));
  const std::size_t record = open_record(out_, header);
  put_string(out_, profile);
  put_string(out_, library);
  close_record(out_, record);
  write(out_);
}

McapWriter::~McapWriter() {
  try {
    close();
  } catch (...) {  // out of memory: leave the log of a killed run, which is readable
    abandon();
  }
}

SchemaId McapWriter::schema(std::string_view name, std::string_view encoding, std::string_view text) {
  const auto id = static_cast<std::uint16_t>(++schemas_);  // 0 means "no schema" in the format
  out_.clear();
  const std::size_t record = open_record(out_, schema_record);
  put(out_, id);
  put_string(out_, name);
  put_string(out_, encoding);
  put_string(out_, text);
  close_record(out_, record);
  put_bytes(schema_records_, out_);
  write(out_);
  return SchemaId{id};
}

ChannelId McapWriter::channel(SchemaId schema, std::string_view topic, std::string_view message_encoding,
                              const McapWords& metadata) {
  const auto id = static_cast<std::uint16_t>(channels_.size());
  channels_.emplace_back();
  out_.clear();
  const std::size_t record = open_record(out_, channel_record);
  put(out_, id);
  put(out_, static_cast<std::uint16_t>(schema));
  put_string(out_, topic);
  put_string(out_, message_encoding);
  put_words(out_, metadata);
  close_record(out_, record);
  put_bytes(channel_records_, out_);
  write(out_);
  return ChannelId{id};
}

void McapWriter::message(ChannelId channel, std::uint32_t sequence, std::uint64_t log_time, Span bytes) {
  if (file_ < 0) return;
  if (bytes.size() > message_limit) return fail("has no room for a message past 64 MiB", EMSGSIZE);
  const std::uint16_t id = static_cast<std::uint16_t>(channel);
  assert(id < channels_.size() && "a message goes to a channel of this log");

  // Time range of the chunk.
  chunk_first_ = chunk_messages_ == 0 ? log_time : std::min(chunk_first_, log_time);
  chunk_last_ = chunk_messages_ == 0 ? log_time : std::max(chunk_last_, log_time);
  ++chunk_messages_;

  channels_[id].entries.push_back({log_time, chunk_.size()});
  const std::size_t record = open_record(chunk_, message_record);
  put(chunk_, id);
  put(chunk_, sequence);
  put(chunk_, log_time);
  put(chunk_, log_time);
  put_bytes(chunk_, bytes);
  close_record(chunk_, record);
  if (chunk_.size() > chunk_limit) flush();
}

void McapWriter::flush() {
  if (file_ < 0 || chunk_messages_ == 0) return;

  // The chunk record, with its content compressed in place after the head.
  out_.clear();
  const std::size_t record = open_record(out_, chunk_record);
  put(out_, chunk_first_);
  put(out_, chunk_last_);
  put(out_, std::uint64_t{chunk_.size()});
  put(out_, crc32_of(0, chunk_));
  put_string(out_, "zstd");
  const std::size_t length_at = out_.size();
  put(out_, std::uint64_t{0});
  const std::size_t begin = out_.size();
  out_.resize(begin + ZSTD_compressBound(chunk_.size()));
  const std::size_t compressed = ZSTD_compressCCtx(zstd_.get(), out_.data() + begin, out_.size() - begin,
                                                   chunk_.data(), chunk_.size(), zstd_level);
  if (ZSTD_isError(compressed) != 0) return fail("has a chunk that zstd cannot compress", ENOMEM);
  out_.resize(begin + compressed);
  store(out_.data() + length_at, std::uint64_t{compressed});
  close_record(out_, record);

  // Message index: offsets of each channel's messages.
  for (std::size_t id = 0; id < channels_.size(); ++id) {
    const std::vector<Entry>& entries = channels_[id].entries;
    if (entries.empty()) continue;
    const std::size_t list = open_record(out_, message_index);
    put(out_, static_cast<std::uint16_t>(id));
    put(out_, static_cast<std::uint32_t>(16 * entries.size()));
    for (const Entry& entry : entries) {
      put(out_, entry.log_time);
      put(out_, entry.offset);
    }
    close_record(out_, list);
  }
  write(out_);

  // The next chunk starts empty; the buffers keep their capacity.
  first_ = messages_ == 0 ? chunk_first_ : std::min(first_, chunk_first_);
  last_ = messages_ == 0 ? chunk_last_ : std::max(last_, chunk_last_);
  messages_ += chunk_messages_;
  ++chunks_;
  for (Channel& channel : channels_) {
    channel.messages += channel.entries.size();
    channel.entries.clear();
  }
  chunk_.clear();
  chunk_messages_ = 0;
}

void McapWriter::metadata(std::string_view name, const McapWords& words) {
  if (file_ < 0) return;
  out_.clear();
  const std::size_t record = open_record(out_, metadata_record);
  put_string(out_, name);
  put_words(out_, words);
  close_record(out_, record);

  const std::size_t index = open_record(metadata_indexes_, metadata_index);
  put(metadata_indexes_, position_);
  put(metadata_indexes_, std::uint64_t{out_.size()});
  put_string(metadata_indexes_, name);
  close_record(metadata_indexes_, index);
  ++metadata_count_;
  write(out_);
}

void McapWriter::settle(const std::filesystem::path& path) {
  if (file_ < 0) return;
  if (std::rename(path_.c_str(), path.c_str()) != 0) return fail("cannot be put in its place", errno);
  path_ = path.string();
}

void McapWriter::close() {
  flush();
  if (file_ < 0) return;
  write_summary();
  if (file_ < 0) return;
  const int closed = ::close(std::exchange(file_, -1));
  if (closed != 0 && errno != EINTR) fail("cannot be closed", errno);
}

// Writes the offsets of each chunk and of its message indexes. They are read back from the file and
// written in pieces, because in memory they would grow with the flight time.
void McapWriter::write_chunk_indexes(std::uint64_t data_end_at) {
  constexpr std::size_t chunk_head = record_head + 44;  // up to the compressed records
  constexpr std::size_t piece = 64 << 10;               // [B]
  std::array<std::byte, chunk_head> head;
  Bytes all;
  std::optional<std::size_t> open;  // offset of the open chunk index in `all`
  std::size_t offsets_at = 0;
  std::uint64_t lists = 0, compressed = 0, uncompressed = 0;  // [B]
  const auto close_index = [&] {
    if (!open) return;
    store(all.data() + offsets_at, static_cast<std::uint32_t>(all.size() - offsets_at - 4));
    put(all, lists);
    put_string(all, "zstd");
    put(all, compressed);
    put(all, uncompressed);
    close_record(all, *open);
    open.reset();
    if (all.size() < piece) return;
    write(all);
    all.clear();
  };
  for (std::uint64_t at = magic.size(), length = 0; at < data_end_at; at += length) {
    if (!read_back(at, std::span(head).first(std::min<std::uint64_t>(head.size(), data_end_at - at)))) return;
    length = record_head + load<std::uint64_t>(&head[1]);
    const auto kind = static_cast<RecordKind>(head[0]);
    if (kind == message_index && open) {
      put(all, load<std::uint16_t>(&head[record_head]));
      put(all, at);
      lists += length;
    }
    if (kind != chunk_record) continue;
    close_index();
    open = open_record(all, chunk_index);
    put(all, load<std::uint64_t>(&head[record_head]));      // first time
    put(all, load<std::uint64_t>(&head[record_head + 8]));  // last time
    put(all, at);
    put(all, length);
    offsets_at = all.size();
    put(all, std::uint32_t{0});
    lists = 0;
    uncompressed = load<std::uint64_t>(&head[record_head + 16]);
    compressed = length - chunk_head;
  }
  close_index();
  write(all);
}

bool McapWriter::read_back(std::uint64_t at, std::span<std::byte> bytes) {
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t count =
        ::pread(file_, bytes.data() + done, bytes.size() - done, static_cast<off_t>(at + done));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return fail("cannot be read back", count < 0 ? errno : EIO), false;
    done += static_cast<std::size_t>(count);
  }
  return true;
}

void McapWriter::write_summary() {
  const std::uint64_t data_end_at = position_;
  out_.clear();
  const std::size_t end = open_record(out_, data_end);
  put(out_, crc_);
  close_record(out_, end);
  write(out_);
  if (file_ < 0) return;

  // The summary: one group of records per kind, then the offset of each group.
  const std::uint64_t summary_at = sound_ = position_;
  crc_ = 0;  // of the summary from here on
  Bytes counts;
  const std::size_t record = open_record(counts, statistics);
  put(counts, messages_);
  put(counts, schemas_);
  put(counts, static_cast<std::uint32_t>(channels_.size()));
  put(counts, std::uint32_t{0});  // attachments
  put(counts, metadata_count_);
  put(counts, chunks_);
  put(counts, first_);
  put(counts, last_);
  put(counts, static_cast<std::uint32_t>(10 * channels_.size()));
  for (std::size_t id = 0; id < channels_.size(); ++id) {
    put(counts, static_cast<std::uint16_t>(id));
    put(counts, channels_[id].messages);
  }
  close_record(counts, record);

  Bytes offsets;
  const auto group = [&](RecordKind kind, const auto& write_records) {
    const std::uint64_t at = position_;
    write_records();
    if (position_ == at) return;
    const std::size_t offset = open_record(offsets, summary_offset);
    put(offsets, static_cast<std::uint8_t>(kind));
    put(offsets, at);
    put(offsets, position_ - at);
    close_record(offsets, offset);
  };
  group(schema_record, [&] { write(schema_records_); });
  group(channel_record, [&] { write(channel_records_); });
  group(statistics, [&] { write(counts); });
  group(chunk_index, [&] { write_chunk_indexes(data_end_at); });
  group(metadata_index, [&] { write(metadata_indexes_); });
  const std::uint64_t offsets_at = position_;
  write(offsets);

  // The footer's CRC covers the summary and the footer up to the CRC itself.
  out_.clear();
  const std::size_t foot = open_record(out_, footer);
  put(out_, summary_at);
  put(out_, offsets_at);
  put(out_, std::uint32_t{0});
  close_record(out_, foot);
  out_.resize(out_.size() - 4);
  put(out_, crc32_of(crc_, out_));
  put_bytes(out_, std::as_bytes(std::span(magic)));
  write(out_);
}

void McapWriter::write(const Bytes& bytes) {
  if (file_ < 0) return;
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t count = ::write(file_, bytes.data() + done, bytes.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return fail("cannot be written", count < 0 ? errno : EIO);
    done += static_cast<std::size_t>(count);
  }
  position_ += bytes.size();
  crc_ = crc32_of(crc_, bytes);
}

void McapWriter::fail(std::string_view what, int error_number) {
  error_ = fmt::format("{}: {} at byte {}: {}", path_, what, position_, reason(error_number));
  abandon();
}

void McapWriter::abandon() noexcept {
  if (file_ < 0) return;
  position_ = std::min(position_, sound_);
  [[maybe_unused]] const int cut = ::ftruncate(file_, static_cast<off_t>(position_));  // best effort
  ::close(std::exchange(file_, -1));
}

}  // namespace sightline
