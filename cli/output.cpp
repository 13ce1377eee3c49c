#include "cli/output.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>

#include "sightline/base/reason.hpp"
#include "sightline/base/sentence.hpp"

namespace sightline::cli {
namespace {

using WallClock = std::chrono::steady_clock;
constexpr std::size_t piece = 4096;  // a pipe reported as writable takes this many bytes at once [B]

/// Writes to one of the standard streams with a bounded waiting time.
class Stream {
 public:
  explicit Stream(int file) : file_(file) {
    struct stat status {};
    const int mode = ::fcntl(file, F_GETFL) & O_ACCMODE;
    if (::fstat(file, &status) != 0 || mode == O_RDONLY) return;
    is_socket_ = S_ISSOCK(status.st_mode);
    // Other processes share the stream and may need blocking writes. A pipe or a device therefore
    // gets a separate file description that does not block. A regular file keeps its position and
    // its end.
    if (S_ISFIFO(status.st_mode) || S_ISCHR(status.st_mode)) {
      const std::string name = fmt::format("/proc/self/fd/{}", file);
      const int own = ::open(name.c_str(), O_WRONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
      if (own >= 0) file_ = own;
    }
  }

  /// @return 0, or the errno of the failure; ETIMEDOUT if no reader took the text in time
  int write(std::string_view text, bool wait) noexcept {
    while (!text.empty()) {
      if (const int fault = await(wait); fault != 0) return fault;
      const std::size_t size = std::min(text.size(), piece);
      const ssize_t count = is_socket_ ? ::send(file_, text.data(), size, MSG_DONTWAIT | MSG_NOSIGNAL)
                                       : ::write(file_, text.data(), size);
      if (count > 0) text.remove_prefix(static_cast<std::size_t>(count));
      if (count < 0 && errno != EINTR && errno != EAGAIN) return errno;
    }
    return 0;
  }

  void wait_at_most(WallClock::duration time) { left_ = time.count(); }

 private:
  static constexpr std::chrono::milliseconds look{100};

  int await(bool wait) noexcept {
    for (;;) {
      pollfd room = {file_, POLLOUT, 0};
      const auto begin = WallClock::now();
      const auto most = wait ? std::clamp<WallClock::duration>(WallClock::duration(left_), {}, look)
                             : WallClock::duration(0);
      const auto ms = std::chrono::ceil<std::chrono::milliseconds>(most);
      const int ready = ::poll(&room, 1, static_cast<int>(ms.count()));
      if (ready > 0 || (ready < 0 && errno != EINTR)) return 0;  // the write reports the error
      if (!wait) return ETIMEDOUT;
      const auto took = (WallClock::now() - begin).count();
      if (left_ != WallClock::duration::max().count()) left_ -= took;
      if (left_ <= 0) return ETIMEDOUT;
    }
  }

  int file_;
  bool is_socket_ = false;
  // Shared by all threads that write.
  std::atomic<WallClock::rep> left_ = WallClock::duration::max().count();
};

/// Both streams and the state of the results.
struct Streams {
  Stream results{STDOUT_FILENO}, messages{STDERR_FILENO};
  std::atomic<int> lost = 0;  // errno of a failed write of results

  Streams() { messages.wait_at_most(patience); }
};

Streams& streams() {
  static Streams all;
  return all;
}

/// Writes in one piece if it fits, so that lines of several threads do not mix; without heap
/// allocation.
void write_sentence(std::string_view sentence, void (*write)(std::string_view) noexcept) noexcept {
  constexpr std::string_view begin = "sightline: ";
  std::array<char, 1024> line{};
  if (begin.size() + sentence.size() + 1 > line.size()) {
    write(begin);
    write(sentence);
    return write("\n");
  }
  char* const text = std::copy(begin.begin(), begin.end(), line.data());
  char* const end = std::copy(sentence.begin(), sentence.end(), text);
  *end = '\n';
  write({line.data(), static_cast<std::size_t>(end - line.data()) + 1});
}

}  // namespace

void open_streams() {
  for (int file = STDIN_FILENO; file <= STDERR_FILENO; ++file) {
    if (::fcntl(file, F_GETFD) >= 0) continue;
    // The kernel assigns the lowest free number. Read-only, so that a write there fails and the
    // loss is reported.
    [[maybe_unused]] const int opened = ::open("/dev/null", O_RDONLY);
  }
  for (const int signal : {SIGPIPE, SIGXFSZ, SIGTTOU}) ::signal(signal, SIG_IGN);
}

void outlive_the_terminal() {
  ::signal(SIGHUP, SIG_IGN);
  if (::isatty(STDOUT_FILENO) == 1) streams().results.wait_at_most(patience);
}

void write_result(std::string_view text) noexcept {
  Streams& all = streams();
  if (all.lost == 0) all.lost = all.results.write(text, true);
}

void write_message(std::string_view text) noexcept { (void)streams().messages.write(text, true); }

void offer_message(std::string_view text) noexcept { (void)streams().messages.write(text, false); }

void print_sentence(std::string_view sentence) noexcept { write_sentence(sentence, write_message); }
void offer_sentence(std::string_view sentence) noexcept { write_sentence(sentence, offer_message); }

int refusing(const std::function<int()>& body) {
  try {
    return body();
  } catch (const std::exception& error) {
    print_message("{}\n", sentence_of(error));
    return 2;
  }
}

int finish(int code) {
  const int lost = streams().lost;
  if (lost == 0) return code;
  print_sentence(fmt::format("stdout: {}, the results could not be shown there", reason(lost)));
  return code == 0 ? 1 : code;
}

}  // namespace sightline::cli
