#include "sightline/record/packed_text.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <cerrno>
#include <memory>
#include <stdexcept>
#include <system_error>

#include "sightline/base/reason.hpp"

namespace sightline {

std::string read_packed_text(const std::filesystem::path& file) {
  const auto refuse = [&](const std::string& why) {
    throw std::invalid_argument(
        fmt::format("{}: {}, expected a text file, plain or packed by gzip", file.native(), why));
  };
  std::error_code error;
  const auto kind = std::filesystem::status(file, error);
  if (!std::filesystem::is_regular_file(kind))
    refuse(!std::filesystem::exists(kind) ? "not there" : "no regular file");
  const std::unique_ptr<gzFile_s, int (*)(gzFile)> in(gzopen(file.c_str(), "rbe"), gzclose);
  if (!in) refuse(fmt::format("cannot be read ({})", reason(errno)));
  std::string text;
  constexpr std::size_t part = std::size_t{1} << 20;
  for (;;) {
    const std::size_t size = text.size();
    text.resize(size + part);
    const int count = gzread(in.get(), text.data() + size, part);
    int fault = Z_OK;
    if (count >= 0) (void)gzerror(in.get(), &fault);
    if (count < 0 || fault != Z_OK) refuse("damaged");
    text.resize(size + static_cast<std::size_t>(count));
    if (text.size() > packed_text_max) refuse(fmt::format("more than {} bytes", packed_text_max));
    if (count == 0) return text;
  }
}

}  // namespace sightline
