#include "sightline/server/flight_page.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <thread>
#include <utility>

#include "sightline/base.hpp"
#include "sightline/loop.hpp"
#include "sightline/record/log_topics.hpp"
#include "sightline/server/admission.hpp"
#include "sightline/server/certificate_file.hpp"
#include "sightline/server/foxglove_feed.hpp"
#include "sightline/server/page_files.hpp"
#include "sightline/server/scene_json.hpp"
#include "sightline/server/scene_topics.hpp"

namespace sightline {
namespace {

constexpr std::size_t samples_that_wait = 64;  // at 100 Hz twenty times the samples of one interval
constexpr std::size_t events_reported = 32;    // the latest events, sent with each state

PageFiles files_of_flight(const SceneJson& scene, const Tuning* tuning) {
  PageFiles files = page_files();
  files.emplace(certificate_path, no_certificate());
  files["/tune.json"] = {"application/json", R"({"tune":false})"};
  if (tuning != nullptr)
    for (auto& [path, file] : tuning->files()) files.insert_or_assign(path, std::move(file));
  files["/scene.json"] = {"application/json", scene.scene(random_token(), true)};
  return files;
}

}  // namespace

class FlightPage::Thread {
 public:
  Thread(const Scenario& scenario, const Sample& prototype, const ServeOptions& options, Tuning* tuning)
      : ring(samples_that_wait, prototype),
        scene_(scenario),
        present_(scenario),
        requested_(scene_.requested(present_)),
        feed_(scenario.name),
        topics_(scenario, prototype.solvers.size(), feed_),
        drawn_(scenario, feed_),
        tuning_(tuning),
        options_(options),
        server_(
            options, files_of_flight(scene_, tuning), &feed_,
            tuning == nullptr ? OnWatcherMessage()
                              : [tuning](std::string_view text) { tuning->receive(text); }),
        thread_("the page", [this] { run(); }) {}
  ~Thread() {
    done_ = true;
    thread_.join();
  }

  SpscQueue<Sample> ring;
  std::atomic<std::int64_t> dropped{0};
  const PageServer& server() const { return server_; }
  void put(std::string_view path, PageFile file) { server_.put(path, std::move(file)); }
  ServeOptions served() const {
    ServeOptions served = options_;
    served.port = server_.port();
    served.token = server_.token();
    return served;
  }

 private:
  void run() {
    auto next = std::chrono::steady_clock::now();
    while (!done_) {
      look();
      next = std::max(next + std::chrono::duration_cast<std::chrono::steady_clock::duration>(
                                 std::chrono::duration<double>(interval)),
                      std::chrono::steady_clock::now());
      std::this_thread::sleep_until(next);
    }
    look();
  }

  void look() {
    bool any = false;
    while (const Sample* sample = ring.front()) {
      take(*sample);
      ring.pop();
      any = true;
    }
    // Answers before files: a client that receives an acceptance then finds the change in the
    // files.
    const std::string answers = tuning_ != nullptr ? tuning_->reported() : std::string();
    const bool reported = reports_more() && !newest_.seen.empty();  // also while paused
    if (!any && !reported) return;
    if (any) send([&] { drawn_.add(newest_); });
    feed_.hand_over(nanoseconds(newest_.time));
    std::string moment = scene_.moment(newest_, events_);
    moment.insert(moment.rfind('}'), answers);
    server_.post(moment);
    newest_.paths.clear();
    newest_.solve_us = 0.0;
  }

  /// Whether there are new answers; if so, replaces the files of the tuning.
  bool reports_more() {
    if (tuning_ == nullptr) return false;
    tuning_->set_time(newest_.time);
    const std::uint64_t tuned = tuning_->version();
    if (std::exchange(reported_, tuned) == tuned) return false;
    for (auto& [path, file] : tuning_->files()) server_.put(path, std::move(file));
    return true;
  }

  /// Keeps the newest values, but the longest solve time since the last state.
  void take(const Sample& sample) {
    if (present_.follow(sample)) requested_ = scene_.requested(present_);
    send([&] { (void)topics_.add(sample, present_, present_.cost(sample)); });
    const Team& team = scene_.team();
    newest_.time = sample.time;
    newest_.seen.assign(size(team.bodies()), std::nullopt);
    for (int i = 0; i < team.bodies(); ++i) {
      const bool there = size(i) >= sample.presence.size() || sample.presence[size(i)] != Presence::absent;
      if (there) newest_.seen[size(i)] = true_sight(team, BodyId{i}, sample);
    }
    newest_.u = sample.u;
    newest_.requested = requested_;
    double solve_us = 0.0;  // of all controllers together, as in a log
    for (const SolverRecord& solver : sample.solvers) solve_us += solver.solve_us;
    newest_.solve_us = std::max(newest_.solve_us, solve_us);
    if (!sample.solvers.empty()) {
      const SolverRecord& solver = sample.solvers.front();
      newest_.status = to_string(solver.status);
      newest_.residual = solver.residual;
      newest_.iterations = solver.iterations;
    }
    newest_.levels.clear();
    for (const FallbackLevel level : sample.levels) newest_.levels.push_back(to_string(level));
    newest_.barrier.clear();
    newest_.reserve.clear();
    for (const BarrierRecord& one : sample.barriers) {
      newest_.barrier.push_back(one.active ? 1 : 0);
      newest_.reserve.push_back(one.reserve);
    }
    newest_.truth_known = sample.truth_known;
    newest_.estimates.clear();
    for (int i = 0; i < team.bodies() && size(i) < sample.estimates.size(); ++i)
      if (team.is_agent(BodyId{i})) newest_.estimates.push_back(sample.estimates[size(i)]);
    if (sample.has_path) take_paths(sample);
    for (int i = 0; i < sample.event_count; ++i) {
      const Event& event = sample.events[size(i)];
      events_.push_back({occurred_++, event.time, scene_.describe(to_string(event.kind), event.value)});
    }
    if (events_.size() > events_reported)
      events_.erase(events_.begin(), events_.end() - static_cast<std::ptrdiff_t>(events_reported));
  }

  /// An exception ends the topics, not the flight.
  template <class Send>
  void send(Send&& topics) {
    if (unreported_ || !feed_.is_requested()) return;
    try {
      topics();
    } catch (const std::exception&) {
      unreported_ = true;
    }
  }

  void take_paths(const Sample& sample) {
    const Team& team = scene_.team();
    newest_.paths.clear();
    const std::size_t nx = size(team.nx());
    for (int i = 0; i < team.bodies() && team.is_agent(BodyId{i}); ++i) {
      const Model& model = team.model(BodyId{i});
      const std::vector<double> u(model.inputs().size());
      auto& path = newest_.paths.emplace_back();
      if (!newest_.seen[size(i)]) continue;
      for (std::size_t k = 0; (k + 1) * nx <= sample.path.size(); ++k)
        path.push_back(model.sight(&sample.path[k * nx + size(team.state_offset(BodyId{i}))], u.data()).p);
    }
  }

  SceneJson scene_;
  PresentTeam present_;
  std::vector<char> requested_;
  ShownState newest_;
  std::vector<TriggeredEvent> events_;
  std::int64_t occurred_ = 0;
  FoxgloveFeed feed_;
  LogTopics topics_;
  SceneTopics drawn_;
  bool unreported_ = false;
  Tuning* tuning_;
  std::uint64_t reported_ = 0;  // of tuning_
  ServeOptions options_;
  PageServer server_;
  std::atomic<bool> done_{false};
  ServiceThread thread_;  // last: it uses all other members
};

FlightPage::FlightPage(const Scenario& scenario, const Sample& prototype, const ServeOptions& options,
                       Tuning* tuning)
    : thread_(std::make_unique<Thread>(scenario, prototype, options, tuning)) {}
FlightPage::~FlightPage() = default;

void FlightPage::show(const Sample& sample) noexcept {
  Sample* const item = thread_->ring.claim();
  if (item == nullptr) {
    thread_->dropped.fetch_add(1, std::memory_order_relaxed);
    return;
  }
  *item = sample;  // vectors of equal size: nothing is allocated
  thread_->ring.publish();
}

void FlightPage::put(std::string_view path, PageFile file) { thread_->put(path, std::move(file)); }

const std::string& FlightPage::url() const { return thread_->server().url(); }
ServeOptions FlightPage::served() const { return thread_->served(); }
ServeCounts FlightPage::counts() const { return thread_->server().counts(); }
std::int64_t FlightPage::dropped() const noexcept { return thread_->dropped.load(std::memory_order_relaxed); }

}  // namespace sightline
