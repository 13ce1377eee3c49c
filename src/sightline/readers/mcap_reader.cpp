#include <fcntl.h>
#include <fmt/format.h>
#include <lz4frame.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <cerrno>
#include <concepts>
#include <memory>
#include <system_error>
#include <utility>

#include "sightline/base/reason.hpp"
#include "sightline/mcap.hpp"

namespace sightline {

std::uint32_t mcap::crc32_of(std::uint32_t crc, Span bytes) {
  if (bytes.empty()) return crc;  // zlib returns its initial value for a null address
  return static_cast<std::uint32_t>(crc32_z(crc, reinterpret_cast<const Bytef*>(bytes.data()), bytes.size()));
}

namespace {

using namespace mcap;

constexpr std::uint64_t window_bytes = 64 << 10;                         // smallest read from the file
constexpr std::size_t schema_name_max = 4096, schema_encoding_max = 64;  // [B]

// Reads without passing the end; after a short read every value is zero and good() is false.
class Cursor {
 public:
  explicit Cursor(Span bytes) : rest_(bytes) {}

  Span take(std::uint64_t count) {
    if (count > rest_.size()) {
      good_ = false;
      rest_ = {};
      return {};
    }
    const Span taken = rest_.first(count);
    rest_ = rest_.subspan(count);
    return taken;
  }

  template <std::unsigned_integral T>
  T number() {
    T value = 0;
    const Span bytes = take(sizeof(T));
    for (std::size_t i = 0; i < bytes.size(); ++i)
      value |= static_cast<T>(static_cast<T>(bytes[i]) << (8 * i));
    return value;
  }

  std::string_view string() {
    const Span bytes = take(number<std::uint32_t>());
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
  }

  McapWords words() {
    McapWords words;
    Cursor list(take(number<std::uint32_t>()));
    while (list.good() && !list.rest_.empty()) {
      const std::string_view key = list.string();
      words.insert_or_assign(std::string(key), std::string(list.string()));
    }
    good_ = good_ && list.good();
    return words;
  }

  bool good() const { return good_; }
  bool finished() const { return good_ && rest_.empty(); }  // all bytes read, none missing

 private:
  Span rest_;
  bool good_ = true;
};

// Writers that compute no CRC write 0.
bool is_crc(std::uint32_t reported, std::uint32_t crc) { return reported == 0 || reported == crc; }

// Whether the frame is sound, and as long as `to`, which it fills.
bool unpacked_zstd(Span frame, std::span<std::byte> to) {
  const std::size_t got = ZSTD_decompress(to.data(), to.size(), frame.data(), frame.size());
  return ZSTD_isError(got) == 0 && got == to.size();
}

bool unpacked_lz4(Span frame, std::span<std::byte> to) {
  LZ4F_dctx* made = nullptr;
  if (LZ4F_isError(LZ4F_createDecompressionContext(&made, LZ4F_VERSION)) != 0) return false;
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> context(
      made, LZ4F_freeDecompressionContext);
  for (std::size_t due = 1; due > 0;) {
    std::size_t out = to.size(), in = frame.size();
    due = LZ4F_decompress(context.get(), to.data(), &out, frame.data(), &in, nullptr);
    if (LZ4F_isError(due) != 0 || (due > 0 && in == 0 && out == 0)) return false;
    to = to.subspan(out), frame = frame.subspan(in);
  }
  return to.empty() && frame.empty();
}

// Also accepts the beginning of the magic, for a truncated file.
bool is_magic(Span bytes) {
  return bytes.size() <= magic.size() &&
         std::ranges::equal(bytes, std::as_bytes(std::span(magic)).first(bytes.size()));
}

}  // namespace

McapReader::McapReader(const std::filesystem::path& path) : path_(path.string()) {
  file_ = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);  // opening a FIFO must not block
  struct stat status {};
  if (file_ < 0 || ::fstat(file_, &status) != 0) {
    error_ = fmt::format("{}: cannot be read: {}", path_, reason(errno));
    return;
  }
  if (!S_ISREG(status.st_mode)) {
    error_ = fmt::format("{}: is not a regular file, expected an MCAP log", path_);
    ::close(std::exchange(file_, -1));
    return;
  }
  size_ = static_cast<std::uint64_t>(status.st_size);

  Span bytes;
  if (!fetch(0, std::min<std::uint64_t>(size_, magic.size()), bytes)) return;
  if (!is_magic(bytes)) {
    fail(0, "the file does not begin as MCAP logs do");
    ::close(std::exchange(file_, -1));
    return;
  }
  if (!look_at_end()) return;

  // Scan the record heads for metadata and for the end of the log.
  std::uint64_t position = magic.size();
  for (Record record; next(position, record);) {
    if (record.kind == footer) {
      finish(position);
      return;
    }
    if (record.kind != header && record.kind != metadata_record) continue;
    if (!fetch(record.at + record_head, record.length, bytes) || !read_words(record, bytes)) return;
  }
}

McapReader::~McapReader() {
  if (file_ >= 0) ::close(file_);
}

bool McapReader::visit(const std::function<void(const McapMessage&)>& visitor) {
  schemas_.clear();
  channels_.clear();
  position_ = 0;
  in_summary_ = footed_ = false;
  return walk(visitor);
}

bool McapReader::read_on(const std::function<void(const McapMessage&)>& visitor) {
  struct stat status {};
  if (!ok() || file_ < 0) return ok();
  if (::fstat(file_, &status) != 0 || static_cast<std::uint64_t>(status.st_size) < position_) {
    fail(position_, "the file became shorter while it was read");
    return false;
  }
  size_ = static_cast<std::uint64_t>(status.st_size);
  window_.clear();
  truncated_ = false;
  return look_at_end() && walk(visitor);
}

// Sets sealed_ if the closing magic is present.
bool McapReader::look_at_end() {
  sealed_ = false;
  if (size_ <= magic.size() + record_head) return true;
  Span bytes;
  if (!fetch(size_ - magic.size(), magic.size(), bytes)) return false;
  sealed_ = is_magic(bytes);
  return true;
}

// Passes all complete records from position_ on to the visitor.
bool McapReader::walk(const std::function<void(const McapMessage&)>& visitor) {
  if (file_ < 0 || size_ < magic.size()) return ok();
  if (footed_) return finish(position_) && ok();
  Span bytes;
  if (position_ == 0) {
    if (!fetch(0, magic.size(), bytes)) return false;
    crc_ = crc32_of(0, bytes);
    position_ = magic.size();
  }
  for (Record record; next(position_, record);) {
    if (!fetch(record.at, record_head + record.length, bytes)) return false;
    const Span content = bytes.subspan(record_head);
    if (record.kind == data_end && !in_summary_) {
      if (record.length != 4 || !is_crc(Cursor(content).number<std::uint32_t>(), crc_)) {
        fail(record.at, "the data end here does not match the CRC of the data before it");
        return false;
      }
      in_summary_ = true;
      crc_ = 0;
      continue;
    }
    if (record.kind == footer) {
      const bool whole = in_summary_ && record.length == 20;
      if (!whole || !is_crc(Cursor(content.last(4)).number<std::uint32_t>(),
                            crc32_of(crc_, bytes.first(bytes.size() - 4)))) {
        fail(record.at, "the footer here does not match the CRC of the summary before it");
        return false;
      }
      footed_ = true;
      return finish(position_) && ok();
    }
    crc_ = crc32_of(crc_, bytes);
    if (in_summary_) continue;
    const bool sound = record.kind == chunk_record ? read_chunk(record, content, visitor)
                                                   : read_record(record.at, record.kind, content, visitor);
    if (!sound) return false;
  }
  return ok();
}

std::vector<McapReader::Topic> McapReader::topics() {
  schemas_.clear();
  channels_.clear();
  Span bytes;
  std::uint64_t position = magic.size(), texts = 0;
  for (Record record; file_ >= 0 && next(position, record) && record.kind != data_end;) {
    if (record.kind != schema_record && record.kind != channel_record) continue;
    if (!fetch(record.at + record_head, record.length, bytes)) break;
    const auto id = record.length >= 2 ? Cursor(bytes).number<std::uint16_t>() : std::uint16_t{0};
    if (!read_record(record.at, record.kind, bytes, nullptr)) break;
    if (record.kind == channel_record) texts += channels_[id].schema_text.size();
    if (texts > record_limit) {
      fail(record.at, fmt::format("channels whose schemas have more than {} bytes", record_limit));
      break;
    }
  }
  std::vector<Topic> list;
  for (const auto& [id, topic] : channels_) list.push_back(topic);
  return list;
}

void McapReader::fail(std::uint64_t at, std::string_view what) {
  if (error_.empty()) error_ = fmt::format("{}: byte {}: {}", path_, at, what);
}

// Bytes [at, at + count) of the file, valid until the next call.
bool McapReader::fetch(std::uint64_t at, std::uint64_t count, Span& bytes) {
  const bool held =
      at >= window_at_ && at - window_at_ <= window_.size() && count <= window_.size() - (at - window_at_);
  if (!held) {
    window_at_ = at;
    window_.resize(std::min(std::max(count, window_bytes), size_ - at));
    for (std::size_t done = 0; done < window_.size();) {
      const ssize_t got =
          ::pread(file_, window_.data() + done, window_.size() - done, static_cast<off_t>(at + done));
      if (got < 0 && errno == EINTR) continue;
      if (got <= 0) {
        fail(at, got < 0 ? "cannot be read: " + reason(errno)
                         : std::string("the file became shorter while it was read"));
        window_.clear();
        return false;
      }
      done += static_cast<std::size_t>(got);
    }
  }
  bytes = Span(window_).subspan(at - window_at_, count);
  return true;
}

// Reads the head of the record at `position` if the record is complete.
bool McapReader::next(std::uint64_t& position, Record& record) {
  const std::uint64_t rest = position < size_ ? size_ - position : 0;
  if (rest < record_head) {
    end_of_records(position, "the file ends without a footer");
    return false;
  }
  Span head;
  if (!fetch(position, record_head, head)) return false;
  Cursor cursor(head);
  record = {cursor.number<std::uint8_t>(), position, cursor.number<std::uint64_t>()};
  if (record.kind < header || record.kind > data_end) {
    fail(position, fmt::format("a record of kind {:#04x}, expected one of 0x01 to 0x0f", record.kind));
    return false;
  }
  if (record.length > rest - record_head) {
    end_of_records(position,
                   fmt::format("a record of {} bytes where {} are left", record.length, rest - record_head));
    return false;
  }
  if (record.length > record_limit) {
    fail(position, fmt::format("a record of {} bytes, expected at most {}", record.length, record_limit));
    return false;
  }
  position += record_head + record.length;
  return true;
}

// A truncated log has no closing magic. With the magic, an incomplete record is a fault.
void McapReader::end_of_records(std::uint64_t position, std::string_view what) {
  if (sealed_) return fail(position, what);
  truncated_ = true;
}

// Only the closing magic may follow the footer.
bool McapReader::finish(std::uint64_t position) {
  const std::uint64_t rest = size_ - position;
  Span bytes;
  if (!fetch(position, std::min<std::uint64_t>(rest, magic.size()), bytes)) return false;
  if (rest > magic.size() || !is_magic(bytes)) {
    fail(position, "the file does not end as MCAP logs do");
    return false;
  }
  truncated_ = rest < magic.size();
  return true;
}

// Reads the header or metadata.
bool McapReader::read_words(const Record& record, Span content) {
  Cursor cursor(content);
  const std::string_view name = cursor.string();
  if (record.kind == header) {
    profile_ = name;
    library_ = cursor.string();
  } else {
    metadata_.insert_or_assign(std::string(name), cursor.words());
  }
  if (!cursor.finished()) fail(record.at, "a header or metadata record that contradicts its own lengths");
  return cursor.finished();
}

bool McapReader::read_chunk(const Record& record, Span content,
                            const std::function<void(const McapMessage&)>& visitor) {
  Cursor cursor(content);
  cursor.take(16);  // first and last time
  const auto length = cursor.number<std::uint64_t>();
  const auto crc = cursor.number<std::uint32_t>();
  const std::string_view compression = cursor.string();
  const Span compressed = cursor.take(cursor.number<std::uint64_t>());
  if (!cursor.finished() || length > record_limit) {
    fail(record.at, "a chunk that contradicts its own lengths");
    return false;
  }
  if (compression != "zstd" && compression != "lz4" && !compression.empty()) {
    fail(record.at, "a chunk compressed by an unknown method, expected zstd, lz4 or none");
    return false;
  }
  if (compression.empty()) {
    if (compressed.size() == length && is_crc(crc, crc32_of(0, compressed)))
      return read_records(record.at, compressed, visitor);
    fail(record.at, "a chunk that does not match its CRC");
    return false;
  }
  chunk_.resize(length);
  if (!(compression == "lz4" ? unpacked_lz4(compressed, chunk_) : unpacked_zstd(compressed, chunk_))) {
    fail(record.at, fmt::format("a chunk whose {} frame is damaged", compression));
    return false;
  }
  if (!is_crc(crc, crc32_of(0, chunk_))) {
    fail(record.at, "a chunk that does not match its CRC");
    return false;
  }
  return read_records(record.at, chunk_, visitor);
}

bool McapReader::read_records(std::uint64_t at, Span records,
                              const std::function<void(const McapMessage&)>& visitor) {
  Cursor cursor(records);
  while (!cursor.finished()) {
    const auto kind = cursor.number<std::uint8_t>();
    const Span content = cursor.take(cursor.number<std::uint64_t>());
    if (!cursor.good()) fail(at, "a chunk whose last record is not whole");
    if (!cursor.good() || !read_record(at, kind, content, visitor)) return false;
  }
  return true;
}

bool McapReader::read_record(std::uint64_t at, std::uint8_t kind, Span content,
                             const std::function<void(const McapMessage&)>& visitor) {
  Cursor cursor(content);
  if (kind == schema_record) {
    const auto id = cursor.number<std::uint16_t>();
    Schema& schema = schemas_[id];
    schema.name = cursor.string();
    schema.encoding = cursor.string();
    schema.text = cursor.string();
    // Each channel has a copy of both.
    const auto fits = [&](std::string_view what, const std::string& text, std::size_t most) {
      if (text.size() <= most) return true;
      fail(at, fmt::format("a schema with {} of {} bytes, expected at most {}", what, text.size(), most));
      return false;
    };
    if (!fits("a name", schema.name, schema_name_max) ||
        !fits("an encoding", schema.encoding, schema_encoding_max))
      return false;
  } else if (kind == channel_record) {
    const auto id = cursor.number<std::uint16_t>();
    const auto schema_id = cursor.number<std::uint16_t>();
    const auto schema = schemas_.find(schema_id);
    if (schema == schemas_.end() && schema_id != 0) {  // 0: the channel has none
      fail(at, fmt::format("channel {} follows a schema that is not there", id));
      return false;
    }
    const std::string_view topic = cursor.string(), encoding = cursor.string();
    Topic& of = channels_[id] = {std::string(topic), std::string(encoding), {}, {}, {}};
    if (schema != schemas_.end()) {
      of.schema = schema->second.name, of.schema_encoding = schema->second.encoding;
      // Of messages the name is enough, and many channels may share a long text.
      if (!visitor) of.schema_text = schema->second.text;
    }
    cursor.words();
  } else if (kind == message_record) {
    const auto id = cursor.number<std::uint16_t>();
    const auto channel = channels_.find(id);
    if (channel == channels_.end()) {
      fail(at, fmt::format("a message on channel {}, which is not there", id));
      return false;
    }
    McapMessage message;
    message.topic = channel->second.topic;
    message.schema = channel->second.schema;
    message.encoding = channel->second.encoding;
    message.sequence = cursor.number<std::uint32_t>();
    message.log_time = cursor.number<std::uint64_t>();
    cursor.number<std::uint64_t>();  // time of publication
    if (cursor.good()) {
      message.bytes = content.last(content.size() - 22);
      visitor(message);
      return true;
    }
  } else if (kind == message_index) {
    cursor.number<std::uint16_t>();
    cursor.take(cursor.number<std::uint32_t>());
  } else {
    return true;  // the constructor reads header and metadata
  }
  if (!cursor.finished())
    fail(at, fmt::format("a record of kind {:#04x} that contradicts its own lengths", kind));
  return cursor.finished();
}

}  // namespace sightline
