#include "sightline/readers/packed_file.hpp"

#include <fmt/format.h>
#include <zlib.h>
#include <zstd.h>

#include <cerrno>
#include <memory>
#include <string_view>
#include <system_error>

#include "sightline/base.hpp"
#include "sightline/base/reason.hpp"

namespace sightline {
namespace {

constexpr std::string_view zstd_magic = "\x28\xb5\x2f\xfd";
constexpr std::size_t growth = std::size_t{1} << 20;  // [bytes]

[[noreturn]] void refuse_packed(const std::string& file, std::string_view why) {
  throw_invalid("{}: {}, expected a file that is plain or packed by gzip or zstd", file, why);
}

std::string too_long() { return fmt::format("more than {} bytes", packed_file_max); }

}  // namespace

std::string unpacked(std::string bytes, const std::string& file) {
  if (!bytes.starts_with(zstd_magic)) return bytes;
  const std::unique_ptr<ZSTD_DStream, std::size_t (*)(ZSTD_DStream*)> stream(ZSTD_createDStream(),
                                                                             ZSTD_freeDStream);
  std::string text;
  ZSTD_inBuffer in{bytes.data(), bytes.size(), 0};
  for (std::size_t rest = 1; in.pos < in.size || rest > 0;) {
    const std::size_t size = text.size();
    text.resize(size + growth);
    ZSTD_outBuffer out{text.data() + size, growth, 0};
    rest = ZSTD_decompressStream(stream.get(), &out, &in);
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
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> in(gzopen(file.c_str(), "rbe"), gzclose);
  if (!in) refuse_packed(file.native(), fmt::format("cannot be read ({})", reason(errno)));
  std::string bytes;
  for (;;) {
    const std::size_t size = bytes.size();
    bytes.resize(size + growth);
    const int count = gzread(in.get(), bytes.data() + size, growth);
    int fault = Z_OK;
    if (count >= 0) (void)gzerror(in.get(), &fault);
    if (count < 0 || fault != Z_OK) refuse_packed(file.native(), "damaged");
    bytes.resize(size + static_cast<std::size_t>(count));
    if (bytes.size() > packed_file_max) refuse_packed(file.native(), too_long());
    if (count == 0) return unpacked(std::move(bytes), file.native());
  }
}

}  // namespace sightline
