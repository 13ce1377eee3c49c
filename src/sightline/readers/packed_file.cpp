#include "sightline/readers/packed_file.hpp"

#include <fmt/format.h>
#include <zlib.h>
#include <zstd.h>

#include <algorithm>
#include <cerrno>
#include <memory>
#include <string_view>
#include <system_error>

#include "sightline/base.hpp"
#include "sightline/base/reason.hpp"

namespace sightline {
namespace {

constexpr std::string_view zstd_magic = "\x28\xb5\x2f\xfd";
constexpr std::size_t growth = std::size_t{1} << 20;       // [bytes]
constexpr std::size_t zstd_head = std::size_t{256} << 10;  // holds the first block [bytes]

[[noreturn]] void refuse_packed(const std::string& file, std::string_view why) {
  throw_invalid("{}: {}, expected a file that is plain or packed by gzip or zstd", file, why);
}

std::string too_long() { return fmt::format("more than {} bytes", packed_file_max); }

using OpenFile = std::unique_ptr<gzFile_s, int (*)(gzFile)>;
using OpenFrame = std::unique_ptr<ZSTD_DStream, std::size_t (*)(ZSTD_DStream*)>;

/// Reads the next bytes, at most `size`, unpacked from gzip. @return false if they are damaged
bool read_next(const OpenFile& in, std::string& bytes, std::size_t size) {
  const std::size_t before = bytes.size();
  bytes.resize(before + size);
  const int count = gzread(in.get(), bytes.data() + before, static_cast<unsigned>(size));
  int fault = Z_OK;
  if (count >= 0) (void)gzerror(in.get(), &fault);
  bytes.resize(before + static_cast<std::size_t>(std::max(count, 0)));
  return count >= 0 && fault == Z_OK;
}

}  // namespace

FileHead read_head(const std::filesystem::path& file, std::size_t size) {
  const OpenFile in(gzopen(file.c_str(), "rbe"), gzclose);
  FileHead head;
  if (!in) return head;
  (void)read_next(in, head.bytes, size);
  if (gzdirect(in.get()) == 0) head.packed_by = "gzip";
  if (!head.bytes.starts_with(zstd_magic)) return head;
  // A block of zstd is unpacked as a whole, and is longer than the head.
  (void)read_next(in, head.bytes, zstd_head);
  const OpenFrame frame(ZSTD_createDStream(), ZSTD_freeDStream);
  FileHead inside{std::string(size, '\0'), "zstd"};
  ZSTD_outBuffer out{inside.bytes.data(), size, 0};
  ZSTD_inBuffer from{head.bytes.data(), head.bytes.size(), 0};
  while (out.pos < size && from.pos < from.size)
    if (ZSTD_isError(ZSTD_decompressStream(frame.get(), &out, &from)) != 0) break;
  inside.bytes.resize(out.pos);
  return inside;
}

std::string unpacked(std::string bytes, const std::string& file) {
  if (!bytes.starts_with(zstd_magic)) return bytes;
  const OpenFrame frame(ZSTD_createDStream(), ZSTD_freeDStream);
  std::string text;
  ZSTD_inBuffer in{bytes.data(), bytes.size(), 0};
  for (std::size_t rest = 1; in.pos < in.size || rest > 0;) {
    const std::size_t size = text.size();
    text.resize(size + growth);
    ZSTD_outBuffer out{text.data() + size, growth, 0};
    rest = ZSTD_decompressStream(frame.get(), &out, &in);
    text.resize(size + out.pos);
    if (text.size() > packed_file_max) refuse_packed(file, too_long());
    // A frame that is cut has no more to give although more is due.
    if (ZSTD_isError(rest) != 0 || (rest > 0 && out.pos == 0 && in.pos == in.size))
      refuse_packed(file, "damaged");
  }
  return text;
}

std::string read_packed_file(const std::filesystem::path& file) {
  std::error_code error;
  const auto kind = std::filesystem::status(file, error);
  if (!std::filesystem::is_regular_file(kind))
    refuse_packed(file.native(), !std::filesystem::exists(kind) ? "not there" : "no regular file");
  const OpenFile in(gzopen(file.c_str(), "rbe"), gzclose);
  if (!in) refuse_packed(file.native(), fmt::format("cannot be read ({})", reason(errno)));
  std::string bytes;
  for (;;) {
    const std::size_t before = bytes.size();
    if (!read_next(in, bytes, growth)) refuse_packed(file.native(), "damaged");
    if (bytes.size() > packed_file_max) refuse_packed(file.native(), too_long());
    if (bytes.size() == before) return unpacked(std::move(bytes), file.native());
  }
}

}  // namespace sightline
