#include "cli/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <mutex>

#include "cli/output.hpp"
#include "sightline/base.hpp"

namespace sightline::cli {
namespace {

using WallClock = std::chrono::steady_clock;
constexpr std::chrono::milliseconds interval{100};
constexpr std::chrono::seconds farewell{1};  // time limit of the last line

bool on_a_terminal() { return ::isatty(STDERR_FILENO) == 1; }

double since(WallClock::time_point begin) {
  return std::chrono::duration<double>(WallClock::now() - begin).count();
}

}  // namespace

/// State that outlives the owner if the thread is blocked.
struct ProgressThread::Shared {
  std::function<std::string(bool last)> line;
  std::mutex mutex;
  std::condition_variable changed;
  bool requested_to_end = false, ended = false;

  void run() noexcept {
    std::unique_lock lock(mutex);
    for (bool last = false; !last;) {
      last = changed.wait_for(lock, interval, [&] { return requested_to_end; });
      lock.unlock();
      try {
        offer_message(line(last));
      } catch (...) {  // no memory for a line: a later one may succeed
      }
      lock.lock();
    }
    ended = true;
    changed.notify_all();
  }
};

ProgressThread::ProgressThread(std::function<std::string(bool last)> line)
    : shared_(std::make_shared<Shared>()) {
  shared_->line = std::move(line);
  if (!run_unattended([shared = shared_] { shared->run(); }))
    shared_->ended = true;  // no thread: no progress lines
}

void ProgressThread::end() {
  std::unique_lock lock(shared_->mutex);
  shared_->requested_to_end = true;
  shared_->changed.notify_all();
  shared_->changed.wait_for(lock, farewell, [&] { return shared_->ended; });
}

struct Progress::Flight {
  double duration;
  WallClock::time_point begin = WallClock::now();
  std::atomic<double> simulated{-1.0};
  double shown = -1.0;

  std::string line(bool last) {
    const double now = simulated;
    std::string text;
    if (now != shown) {
      shown = now;
      const double elapsed = since(begin), speed = elapsed > 0 ? now / elapsed : 0.0;
      text = fmt::format("\r{:3.0f} %  {:.2f} s of {:.2f} s  {:.1f} x real time  {:.0f} s left   ",
                         100.0 * now / duration, now, duration, speed,
                         speed > 0 ? (duration - now) / speed : 0.0);
    }
    return last && shown >= 0 ? text + "\n" : text;
  }
};

Progress::Progress(double duration) {
  if (!on_a_terminal()) return;
  flight_ = std::make_shared<Flight>();
  flight_->duration = duration;
  thread_ = std::make_unique<ProgressThread>([flight = flight_](bool last) { return flight->line(last); });
}

void Progress::show(double simulated) noexcept {
  if (flight_) flight_->simulated = simulated;
}

void Progress::end() { thread_.reset(); }

struct CampaignProgress::Runs {
  std::string name;
  int all, first;
  bool terminal = on_a_terminal();
  WallClock::time_point begin = WallClock::now();
  std::atomic<int> done, recovered;
  int shown = first;

  std::string line(bool last) {
    const int now = done;
    const auto tenth = [&](int runs) { return 10LL * runs / all; };
    if (now == shown || (!terminal && tenth(now) == tenth(shown))) return last && terminal ? "\n" : "";
    shown = now;
    return fmt::format("{}{}: {} of {} runs, {} recovered, {:.0f} s left{}", terminal ? "\r" : "", name, now,
                       all, recovered.load(), since(begin) * (all - now) / std::max(1, now - first),
                       !terminal || last ? "\n" : "   ");
  }
};

CampaignProgress::CampaignProgress(std::string name, int runs, int done, int recovered)
    : runs_(new Runs{
          .name = std::move(name), .all = runs, .first = done, .done = done, .recovered = recovered}),
      thread_(std::make_unique<ProgressThread>([runs = runs_](bool last) { return runs->line(last); })) {}

void CampaignProgress::show(int done, int recovered) noexcept {
  runs_->recovered = recovered;
  runs_->done = done;
}

}  // namespace sightline::cli
