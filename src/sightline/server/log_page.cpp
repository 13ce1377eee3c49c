#include "sightline/server/log_page.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <charconv>
#include <chrono>
#include <cmath>
#include <functional>
#include <iterator>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>

#include "sightline/base.hpp"
#include "sightline/base/json_text.hpp"
#include "sightline/base/now.hpp"
#include "sightline/base/sentence.hpp"
#include "sightline/log.hpp"
#include "sightline/readers/cdr.hpp"
#include "sightline/record/localization_log.hpp"
#include "sightline/server/certificate_file.hpp"
#include "sightline/server/http.hpp"
#include "sightline/server/page_files.hpp"
#include "sightline/server/scene_json.hpp"

namespace sightline {
namespace {

constexpr auto between_looks = std::chrono::milliseconds(100);

/// Predicted positions of all robots, by the time of the prediction.
using LoggedPaths = std::map<double, std::vector<std::vector<Vec3<double>>>>;
/// Estimates of all robots by their time.
using LoggedEstimates = std::map<double, std::vector<PoseEstimate>>;

EventKind kind_named(std::string_view name) {
  for (int i = 0; i < event_kinds; ++i)
    if (to_string(static_cast<EventKind>(i)) == name) return static_cast<EventKind>(i);
  return EventKind::samples_dropped;
}

void check_team(const Recording& run, const Scenario& scenario, const std::filesystem::path& folder) {
  bool same = run.bodies.size() == size(scenario.team.bodies());
  for (std::size_t i = 0; same && i < run.bodies.size(); ++i)
    same = run.bodies[i].name == scenario.team.name(BodyId{static_cast<int>(i)});
  if (!same)
    throw std::runtime_error(
        fmt::format("{}: the log is of another team than its scenario", (folder / "run.mcap").string()));
}

/// Device and inode of a file.
using FileNumber = std::array<std::uint64_t, 2>;
FileNumber number_of_file(const std::filesystem::path& file) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) return {};
  return {status.st_dev, status.st_ino};
}

/// Constant over restarts of the server, so that the page detects the same log.
std::string session_of(const std::filesystem::path& log, const Scenario& scenario) {
  const FileNumber file = number_of_file(log);
  return fmt::format("{:x}.{:x}.{:x}", file[0], file[1], std::hash<std::string>()(scenario.text));
}

std::size_t count_in(std::string_view text, std::size_t otherwise) {
  std::size_t value = 0;
  return std::from_chars(text.data(), text.data() + text.size(), value).ec == std::errc() ? value : otherwise;
}

}  // namespace

std::string_view to_string(LogState state) {
  constexpr std::array<std::string_view, 3> words = {"growing", "finished", "broken"};
  return words[static_cast<std::size_t>(state)];
}

/// Reads a log in the order of its time.
class LogMoments::Player {
 public:
  Player(const std::filesystem::path& folder, const Scenario& scenario, std::size_t numbers)
      : folder_(folder),
        file_(number_of_file(folder / "run.mcap")),
        reader_(folder),
        run_(reader_.run()),
        numbers_(numbers),
        duration_(scenario.simulation.duration),
        scene_(scenario),
        script_(scenario.script.events.size()),
        present_(scenario),
        requested_(scene_.requested(present_)),
        levels_(run_.bodies.size(), to_string(FallbackLevel::valid)) {
    check_team(run_, scenario, folder);
    for (const Recording::Body& body : run_.bodies) {
      if (!body.is_agent) continue;
      const std::size_t robot = robots_++;
      path_topics_["/" + body.name + "/path"] = robot;
      estimate_topics_["/" + body.name + "/localization"] = robot;
    }
  }

  std::vector<std::string> read_on() {
    const bool written = is_written(folder_);  // before reading: otherwise the last rows of a
                                               // writer that ends meanwhile would be missed
    reader_.read_on([this](const McapMessage& message) { take(message); });
    state_ = run_.complete ? LogState::finished : written ? LogState::growing : LogState::broken;
    const bool grows = state_ == LogState::growing;
    std::size_t rows = reader_.rows();
    if (grows) rows = std::min(rows, run_.solve_us.size());
    if (stride_ == 0) {
      const double expected = grows ? std::ceil(duration_ / run_.period) : 0.0;
      stride_ = stride(std::max(static_cast<double>(rows), expected));
    }
    std::vector<std::string> moments;
    for (; grows ? row_ + stride_ <= rows : row_ < rows; row_ += stride_)
      moments.push_back(moment(row_, std::min(row_ + stride_, rows)));
    return moments;
  }

  LogState state() const { return state_; }
  bool replaced() const {
    const FileNumber now = number_of_file(folder_ / "run.mcap");
    return now != file_ && now != FileNumber{};
  }

 private:
  std::size_t stride(double rows) const {
    constexpr double said_of_a_body = 7;
    const double all = rows * static_cast<double>(run_.bodies.size()) * said_of_a_body;
    // No screen shows more than 60 moments a second.
    const double least = std::floor(1.0 / 60 / run_.period);
    return static_cast<std::size_t>(
        std::max({1.0, least, std::ceil(all / static_cast<double>(std::max<std::size_t>(numbers_, 1)))}));
  }

  void take(const McapMessage& message) {
    const double time = to_seconds(message.log_time);
    if (const auto topic = path_topics_.find(message.topic); topic != path_topics_.end()) {
      const auto path = decode_path(message.bytes);
      if (!path) return;
      auto& paths = paths_[time];
      paths.resize(robots_);
      for (const StampedPose& pose : *path) paths[topic->second].push_back({pose.p[0], pose.p[1], pose.p[2]});
    } else if (const auto of = estimate_topics_.find(message.topic); of != estimate_topics_.end()) {
      LogText text;
      text.read({reinterpret_cast<const char*>(message.bytes.data()), message.bytes.size()});
      auto& estimates = estimates_[time];
      estimates.resize(robots_);
      estimates[of->second] = estimate_of(text);
    }
  }

  std::string moment(std::size_t row, std::size_t until) {
    ShownState now;
    now.time = run_.time[row];
    const std::vector<TriggeredEvent> events = follow(now.time);
    now.requested = requested_;
    now.levels = levels_;
    for (const Recording::Body& body : run_.bodies) {
      const double psi = body.heading[row];
      Sight<double> seen;
      seen.p = body.p[row], seen.d = {std::cos(psi), std::sin(psi)};
      seen.v = body.v[row], seen.lean = body.lean[row];
      now.seen.emplace_back(seen);  // NaN for an absent body
      for (const auto& input : body.u) now.u.push_back(input[row]);
      if (row < body.barrier.size()) now.barrier.push_back(body.barrier[row] > 0 ? 1 : 0);
      if (row < body.reserve.size()) now.reserve.push_back(body.reserve[row]);
    }
    const Recording::Controller& solver = run_.controllers.front();
    now.status = solver.status[row];
    now.residual = solver.residual[row];
    now.iterations = solver.iterations[row];
    now.solve_us = no_value;
    for (std::size_t i = row; i < std::min(until, run_.solve_us.size()); ++i)
      now.solve_us = std::fmax(now.solve_us, run_.solve_us[i]);
    now.paths = newest(paths_, now.time);
    now.estimates = newest(estimates_, now.time);
    return scene_.moment(now, events);
  }

  /// The last entry that is not after the time; removes it and all earlier ones.
  template <class Reported>
  static Reported newest(std::map<double, Reported>& all, double time) {
    Reported last;
    const auto later = all.upper_bound(time + same_time);
    if (later != all.begin()) last = std::move(std::prev(later)->second);
    all.erase(all.begin(), later);
    return last;
  }

  std::vector<TriggeredEvent> follow(double time) {
    std::vector<TriggeredEvent> events;
    while (next_ < run_.events.size() && run_.events[next_].time <= time + same_time) {
      const Recording::Event& event = run_.events[next_];
      events.push_back(
          {static_cast<std::int64_t>(next_), event.time, scene_.describe(event.kind, event.value)});
      const EventKind kind = kind_named(event.kind);
      if (kind == EventKind::event_in_force && event.value >= 0 &&
          event.value < static_cast<double>(script_)) {
        reported_.time = time;
        reported_.event_count = 1;
        reported_.events[0] = {event.time, kind, event.controller, event.value};
        (void)present_.follow(reported_);
        requested_ = scene_.requested(present_);
      }
      const bool is_level = kind >= EventKind::valid && kind <= EventKind::grounded;
      if (is_level && event.value >= 0 && event.value < static_cast<double>(levels_.size()))
        levels_[static_cast<std::size_t>(event.value)] = to_string(kind);
      ++next_;
    }
    return events;
  }

  std::filesystem::path folder_;
  FileNumber file_;
  RecordingReader reader_;
  const Recording& run_;
  std::size_t numbers_;
  double duration_;  // duration of the scenario [s]
  SceneJson scene_;
  std::size_t script_;  // number of its events
  PresentTeam present_;
  std::vector<char> requested_;
  std::vector<std::string_view> levels_;                                           // of each body
  std::map<std::string, std::size_t, std::less<>> path_topics_, estimate_topics_;  // robots
  std::size_t robots_ = 0;
  LoggedPaths paths_;
  LoggedEstimates estimates_;
  LogState state_ = LogState::growing;
  Sample reported_;
  std::size_t next_ = 0;  // index of the next event
  std::size_t row_ = 0, stride_ = 0;
};

LogMoments::LogMoments(const std::filesystem::path& folder, const Scenario& scenario, std::size_t numbers)
    : player_(std::make_unique<Player>(folder, scenario, numbers)) {}
LogMoments::~LogMoments() = default;

std::vector<std::string> LogMoments::read_on() { return player_->read_on(); }
LogState LogMoments::state() const { return player_->state(); }
bool LogMoments::replaced() const { return player_->replaced(); }

class LogPage::Thread {
 public:
  Thread(std::filesystem::path folder, std::function<Scenario()> flown, const ServeOptions& options,
         FoxgloveFeed* topics)
      : folder_(std::move(folder)), flown_(std::move(flown)) {
    begin();
    look();
    server_.emplace(options, files(), topics);
    send();
    thread_.start([this] { run(); });
  }
  ~Thread() {
    done_ = true;
    thread_.join();
  }

  const PageServer& server() const { return *server_; }
  void put(std::string_view path, PageFile file) { server_->put(path, std::move(file)); }

 private:
  PageFiles files() {
    PageFiles files = page_files();
    files.emplace(certificate_path, no_certificate());
    files["/scene.json"] = {.type = "application/json", .body = {}, .made = [this](const HttpRequest&) {
                              const std::scoped_lock lock(shown_lock_);
                              return scene_;
                            }};
    files["/moments.json"] = {
        .type = "application/json", .body = {}, .made = [this](const HttpRequest& requested) {
          return moments(count_in(requested.parameter("from"), 0),
                         count_in(requested.parameter("most"), std::string::npos));
        }};
    return files;
  }

  std::string moments(std::size_t from, std::size_t most) const {
    const std::scoped_lock lock(shown_lock_);
    std::string list = "[";
    from = std::min(from, moments_.size());
    const std::size_t until = from + std::min(most, moments_.size() - from);
    for (std::size_t i = from; i < until; ++i) {
      if (i > from) list += ",\n";
      list += moments_[i];
    }
    return list + "]\n";
  }

  /// Starts with a new log.
  void begin() {
    const Scenario scenario = flown_();
    auto log = std::make_unique<LogMoments>(folder_, scenario);
    const std::string session = session_of(folder_ / "run.mcap", scenario);
    std::string scene = SceneJson(scenario).scene(session, false);
    const std::scoped_lock lock(shown_lock_);
    log_ = std::move(log);
    session_ = session;
    scene_ = std::move(scene);
    moments_.clear();
  }

  void look() {
    std::vector<std::string> more = log_->read_on();
    const std::scoped_lock lock(shown_lock_);
    moments_.insert(moments_.end(), std::make_move_iterator(more.begin()),
                    std::make_move_iterator(more.end()));
  }

  void send() {
    std::string now = json_text(nlohmann::json({{"session", session_},
                                                {"moments", moments_.size()},
                                                {"state", to_string(log_->state())},
                                                {"fault", fault_}}));
    if (now == reported_) return;
    reported_ = std::move(now);
    server_->post(reported_);
  }

  void run() {
    while (!done_) {
      std::this_thread::sleep_for(between_looks);
      try {
        if (log_->replaced()) begin();
        if (log_->state() == LogState::growing || moments_.empty()) look();
        fault_.clear();
      } catch (const std::exception& error) {
        fault_ = sentence_of(error);  // may be a log in creation: the next pass retries
      }
      send();
    }
  }

  std::filesystem::path folder_;
  std::function<Scenario()> flown_;
  std::unique_ptr<LogMoments> log_;
  mutable std::mutex shown_lock_;  // guards the data that the server's thread reads
  std::string session_, scene_;
  std::vector<std::string> moments_;
  std::string reported_, fault_;
  std::optional<PageServer> server_;
  std::atomic<bool> done_{false};
  ServiceThread thread_{"the page of the log"};  // last: it uses all other members
};

LogPage::LogPage(const std::filesystem::path& folder, std::function<Scenario()> flown,
                 const ServeOptions& options, FoxgloveFeed* topics)
    : thread_(std::make_unique<Thread>(folder, std::move(flown), options, topics)) {}
LogPage::~LogPage() = default;

void LogPage::put(std::string_view path, PageFile file) { thread_->put(path, std::move(file)); }

const std::string& LogPage::url() const { return thread_->server().url(); }
std::uint16_t LogPage::port() const { return thread_->server().port(); }
ServeCounts LogPage::counts() const { return thread_->server().counts(); }

}  // namespace sightline
