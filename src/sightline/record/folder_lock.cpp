#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <charconv>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>

#include "sightline/base/reason.hpp"
#include "sightline/base/text_file.hpp"
#include "sightline/log.hpp"

namespace sightline {
namespace {

namespace fs = std::filesystem;

/// Process that wrote the lock file, " (process 4711)"; empty if the file is empty.
std::string holder(int file) {
  char text[32];
  const ssize_t size = ::pread(file, text, sizeof text, 0);
  int pid = 0;
  if (size <= 0 || std::from_chars(text, text + size, pid).ec != std::errc()) return {};
  return fmt::format(" (process {})", pid);
}

/// True if the name still refers to the open file.
bool is_at(int file, const fs::path& name) {
  struct stat open {};
  struct stat named {};
  return ::fstat(file, &open) == 0 && ::stat(name.c_str(), &named) == 0 && open.st_dev == named.st_dev &&
         open.st_ino == named.st_ino;
}

/// Write lock on a whole file, owned by the open file description: held until that is closed, also
/// after a crash.
struct flock whole_file() {
  struct flock lock {};
  lock.l_type = F_WRLCK;
  lock.l_whence = SEEK_SET;
  return lock;
}

void expect_file(const fs::path& file) {
  std::error_code error;
  const fs::file_status status = fs::status(file, error);
  if (status.type() == fs::file_type::not_found || fs::is_regular_file(status)) return;
  throw std::invalid_argument(fmt::format("{}: {}, expected a regular file or none", file.native(),
                                          fs::is_directory(status) ? "a folder"
                                          : fs::is_fifo(status)    ? "a pipe"
                                          : error                  ? error.message()
                                                                   : "a device or a socket"));
}

}  // namespace

FolderLock::FolderLock(fs::path folder, std::initializer_list<std::string_view> files)
    : folder_(std::move(folder)), file_(folder_ / ".lock") {
  std::error_code error;
  fs::create_directories(folder_, error);
  if (error || !fs::is_directory(folder_)) {
    throw std::invalid_argument(fmt::format("{}: {}, expected a folder that can be made", folder_.native(),
                                            error ? error.message() : "not a folder"));
  }
  expect_file(file_);
  for (const std::string_view name : files) {
    expect_file(folder_ / name);
    expect_file(beside(folder_ / name));
  }
  lock();
}

void FolderLock::lock() {
  for (;;) {
    lock_ = ::open(file_.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NONBLOCK | O_NOCTTY, 0666);
    if (lock_ < 0) {
      throw std::invalid_argument(fmt::format("{}: cannot be written ({}), expected a folder that can",
                                              folder_.native(), reason(errno)));
    }
    struct flock all = whole_file();
    if (::fcntl(lock_, F_OFD_SETLK, &all) != 0) {
      const std::string sentence =
          errno == EAGAIN || errno == EACCES
              ? fmt::format(
                    "{}: another sightline{} writes into this folder, expected one at a time: wait for "
                    "it, or give another folder by -o",
                    folder_.native(), holder(lock_))
              : fmt::format("{}: cannot be locked ({}), expected a folder that can", folder_.native(),
                            reason(errno));
      ::close(lock_);
      throw std::invalid_argument(sentence);
    }
    if (is_at(lock_, file_)) break;  // else the previous holder has just removed the file
    ::close(lock_);
  }
  // On a full disk the file stays empty; the lock works nevertheless.
  const std::string pid = fmt::format("{}\n", ::getpid());
  [[maybe_unused]] const int cut = ::ftruncate(lock_, 0);
  [[maybe_unused]] const ssize_t written = ::pwrite(lock_, pid.data(), pid.size(), 0);
}

FolderLock::~FolderLock() {
  ::unlink(file_.c_str());
  ::close(lock_);
}

bool is_written(const fs::path& folder) {
  const int file = ::open((folder / ".lock").c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
  if (file < 0) return false;
  struct flock other = whole_file();  // query only: a reader must not block a writer
  const bool taken = ::fcntl(file, F_OFD_GETLK, &other) == 0 && other.l_type != F_UNLCK;
  ::close(file);
  return taken;
}

}  // namespace sightline
