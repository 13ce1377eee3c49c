#include "sightline/base/text_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "sightline/base/reason.hpp"

namespace sightline {

std::filesystem::path beside(const std::filesystem::path& file) { return file.native() + ".part"; }

TextFile::TextFile(std::filesystem::path path) : path_(std::move(path)), now_(beside(path_)) {
  // Create a new file instead of following an existing link or blocking on an existing pipe.
  ::unlink(now_.c_str());
  file_ = ::open(now_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (file_ < 0) fail("written");
}

void TextFile::write(std::string_view text) {
  while (file_ >= 0 && !text.empty()) {
    const ssize_t count = ::write(file_, text.data(), text.size());
    if (count >= 0) {
      text.remove_prefix(static_cast<std::size_t>(count));
    } else if (errno != EINTR) {
      fail("written");
    }
  }
}

void TextFile::settle() {
  if (!error_.empty()) return;
  if (std::rename(now_.c_str(), path_.c_str()) != 0) return fail("put in its place");
  now_ = path_;
}

void TextFile::close() {
  if (file_ >= 0 && ::close(std::exchange(file_, -1)) != 0) fail("closed");
}

void TextFile::fail(std::string_view what) {
  error_ = fmt::format("{} cannot be {}: {}", path_.native(), what, reason(errno));
  if (file_ >= 0) ::close(std::exchange(file_, -1));
  if (now_ != path_) ::unlink(now_.c_str());
}

void write_text(const std::filesystem::path& file, std::string_view text) {
  TextFile out(file);
  out.write(text);
  out.close();
  out.settle();
  if (!out.error().empty()) throw std::runtime_error(out.error());
}

}  // namespace sightline
