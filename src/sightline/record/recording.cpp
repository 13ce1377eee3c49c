#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>

#include "sightline/base.hpp"
#include "sightline/base/now.hpp"
#include "sightline/base/sentence.hpp"
#include "sightline/judge/localization_summary.hpp"
#include "sightline/judge/planned_view.hpp"
#include "sightline/log.hpp"
#include "sightline/loop.hpp"
#include "sightline/readers/cdr.hpp"
#include "sightline/record/camera_log.hpp"
#include "sightline/record/localization_log.hpp"
#include "sightline/record/period_order.hpp"
#include "sightline/world.hpp"

namespace sightline {
namespace {

using nlohmann::json;

template <class... Args>
[[noreturn]] void throw_unreadable(fmt::format_string<Args...> sentence, Args&&... args) {
  throw std::runtime_error(fmt::format(sentence, std::forward<Args>(args)...));
}

// null represents a number that was not finite.
double or_no_value(const json& value) { return value.is_null() ? no_value : value.get<double>(); }

Vec3<double> point(std::span<const double> list) { return {list[0], list[1], list[2]}; }

void read_team(const json& team, Recording& run) {
  for (const json& entry : team.at("bodies")) {
    Recording::Body body;
    body.name = entry.at("name");
    body.robot = entry.at("robot");
    body.is_agent = entry.at("kind") == "agent";
    if (body.is_agent) {
      body.inputs = entry.at("inputs").get<std::vector<std::string>>();
      body.u_min = entry.at("limits").at("u_min").at(0).get<std::vector<double>>();
      body.u_max = entry.at("limits").at("u_max").at(0).get<std::vector<double>>();
      body.u.resize(body.u_min.size());
    }
    if (const auto tags = entry.find("tags"); tags != entry.end()) {
      body.tags = Tags{.size = tags->at("size"),
                       .faces = tags->at("faces"),
                       .distance = tags->at("distance"),
                       .height = tags->at("height")};
    }
    run.bodies.push_back(std::move(body));
  }
  for (const json& entry : team.at("pairs")) {
    const MountFrame frame =
        entry.value("frame", "level") == mount_frames[1] ? MountFrame::body : MountFrame::level;
    const json& arm = entry.at("offset");
    const Recording::Pair pair{
        entry.at("observer"),
        entry.at("target"),
        {.pitch = entry.at("pitch"),
         .offset = arm.is_array() ? LeverArm(arm.at(0), arm.at(1), arm.at(2)) : LeverArm(arm),
         .frame = frame,
         .yaw = entry.value("yaw", 0.0),
         .roll = entry.value("roll", 0.0)},
        or_no_value(entry.at("alpha")),
        or_no_value(entry.at("d_min")),
        or_no_value(entry.at("d_max"))};
    if (pair.observer >= run.bodies.size() || pair.target >= run.bodies.size()) {
      throw_unreadable("a pair names body {}, expected one of {}", std::max(pair.observer, pair.target),
                       run.bodies.size());
    }
    run.pairs.push_back(pair);
  }
  for (const json& entry : team.value("swarms", json::array())) {
    const auto& robots = run.swarms.emplace_back(entry.get<std::vector<std::size_t>>());
    for (const std::size_t robot : robots) {
      if (robot >= run.bodies.size())
        throw_unreadable("a swarm names body {}, expected one of {}", robot, run.bodies.size());
    }
  }
  for (const json& entry : team.value("couplings", json::array())) {
    const Recording::Coupled coupled{entry.at("between").at(0), entry.at("between").at(1),
                                     entry.at("felt").at(0), entry.at("felt").at(1)};
    if (coupled.first >= run.bodies.size() || coupled.second >= run.bodies.size()) {
      throw_unreadable("a coupling names body {}, expected one of {}",
                       std::max(coupled.first, coupled.second), run.bodies.size());
    }
    run.couplings.push_back(coupled);
  }
  run.d_hard = team.value("d_hard", std::vector<double>{});
  run.floor = team.value("floor", no_value);
  run.ceiling = team.value("ceiling", no_value);
  for (const json& polygon : team.value("zones", json::array())) {
    auto& corners = run.zones.emplace_back();
    for (const json& corner : polygon)
      corners.push_back({corner.at(0).get<double>(), corner.at(1).get<double>()});
  }
  run.script = team.value("events", std::vector<std::string>{});
}

// Each step takes the shorter way around; NaN is skipped.
void unwrap(std::vector<double>& psi) {
  constexpr double turn = 2 * std::numbers::pi;
  double last = no_value;
  for (double& value : psi) {
    if (std::isnan(value)) continue;
    if (!std::isnan(last)) value -= turn * std::round((value - last) / turn);
    last = value;
  }
}

// Passes each message to the reader of its topic. State and solver messages begin a row. Optional
// messages after them are omitted for numbers that were not finite; their values stay NaN. Each row
// has exactly one of the messages that a period has once. A log with a missing or a second one is
// rejected.
class RowReader {
 public:
  RowReader(Recording& run, std::size_t controllers) : run_(run) {
    if (!run.bodies.empty()) first_state_ = "/" + run.bodies.front().name + "/state";
    for (Recording::Body& body : run.bodies) {
      const std::string topic = "/" + body.name + "/";
      places_[topic + "state"] = [this, &body](const McapMessage& m) { state(body, m); };
      places_[topic + "pose"] = [&body](const McapMessage& m) { pose(body, m); };
      places_[topic + "twist"] = [&body](const McapMessage& m) { twist(body, m); };
      places_[topic + "attitude"] = [&body](const McapMessage& m) { attitude(body, m); };
      places_[topic + "path"] = [&body](const McapMessage& m) { path(body, m); };
      places_[topic + "input"] = [this, &body](const McapMessage& m) { input(body, m); };
      places_[topic + "barrier"] = [this, &body](const McapMessage& m) { barrier(body, m); };
      places_[topic + "camera_info"] = [&body](const McapMessage& m) { camera(body, m); };
      places_[topic + "detection"] = [this, &body](const McapMessage& m) { detection(body, m); };
      places_[topic + "localization"] = [this, &body](const McapMessage& m) { localization(body, m); };
      places_[topic + "innovation"] = [this, &body](const McapMessage& m) { innovation(body, m); };
      places_[topic + "reference"] = [this, &body](const McapMessage& m) { reference(body, m); };
    }
    run.controllers.resize(controllers);
    for (std::size_t c = 0; c < controllers; ++c) {
      run.controllers[c].name = controllers > 1 ? fmt::format("controller{}", c) : "solver";
      const std::string topic = controllers > 1 ? "/" + run.controllers[c].name + "/solver" : "/solver";
      places_[topic] = [this, c](const McapMessage& m) { solver(c, m); };
      if (c == 0) first_solver_ = topic;
    }
    places_["/events"] = [this](const McapMessage& m) { event(m); };
    places_["/tuned"] = [this](const McapMessage& m) { tuned(m); };
  }

  void take(const McapMessage& message) {
    if (message.topic == first_state_) {
      end_period();
      period_ = period_of(message);
    }
    solved_ |= message.topic == first_solver_;
    if (run_.stride > 1 && !is_kept(message)) return;
    const auto place = places_.find(message.topic);
    if (place == places_.end()) return;
    const auto refuse = [&] {
      throw_unreadable("a message of {} is no JSON, or a value of it is missing or of another kind",
                       message.topic);
    };
    try {
      place->second(message);
    } catch (const json::exception&) {
      refuse();
    } catch (const LogText::Error&) {
      refuse();
    }
  }

  // A chunk that closed automatically may end within a period.
  std::size_t rows() const {
    std::size_t rows = std::min(run_.time.size(), run_.cost.size());
    for (const Recording::Body& body : run_.bodies) {
      rows = std::min(rows, body.p.size());
      for (const auto& row : body.u) rows = std::min(rows, row.size());
      if (!body.barrier.empty()) rows = std::min(rows, body.barrier.size());
    }
    for (const Recording::Controller& c : run_.controllers) rows = std::min(rows, c.status.size());
    return rows;
  }

  /// Ends the recording after all messages; a complete log must end with a complete period.
  void trim(bool has_end) {
    end_period();
    if (has_end) {
      drop_states();
      check_whole();
    }
    const std::size_t rows = this->rows();
    run_.time.resize(rows);
    run_.cost.resize(rows);
    for (Recording::Body& body : run_.bodies) {
      body.p.resize(rows);
      body.heading.resize(rows);
      body.v.resize(rows);
      body.lean.resize(rows);
      for (auto& row : body.u) row.resize(rows);
      if (!body.barrier.empty()) body.barrier.resize(rows), body.reserve.resize(rows);
      // A heading that is sometimes free cannot be drawn as a line.
      if (body.reference_heading.size() < body.reference_time.size()) body.reference_heading.clear();
      if (body.reference_p.size() < body.reference_time.size()) body.reference_p.clear();
      unwrap(body.heading);
      unwrap(body.reference_heading);
    }
    for (Recording::Controller& c : run_.controllers) {
      c.status.resize(rows);
      c.residual.resize(rows);
      c.iterations.resize(rows);
      if (!c.pairs.empty()) c.pairs.resize(rows);
    }
  }

 private:
  // For a thinned recording: keeps events and the messages of its periods.
  bool is_kept(const McapMessage& message) const {
    if (message.topic == "/events" || message.topic == "/tuned" || message.topic.ends_with("/camera_info"))
      return true;
    if (message.topic.ends_with("/input")) run_.last = std::max(run_.last, to_seconds(message.log_time));
    return static_cast<std::size_t>(period_of(message)) % run_.stride == 0;
  }

  std::int64_t period_of(const McapMessage& message) const {
    return std::llround(to_seconds(message.log_time) / run_.period);
  }

  static std::string_view text_of(const McapMessage& message) {
    return {reinterpret_cast<const char*>(message.bytes.data()), message.bytes.size()};
  }
  /// The message's text, valid until the next one is read.
  const LogText& read(const McapMessage& message) {
    text_.read(text_of(message));
    return text_;
  }

  /// Checks that the completed period follows the previous one, not counting the reported missed
  /// periods.
  void end_period() {
    if (!std::exchange(solved_, false)) return;
    const std::int64_t last = std::max<std::int64_t>(order_.next() - 1, 0);
    if (!order_.follows(period_) && !run_.lost_after)
      run_.lost_after = run_.period * static_cast<double>(last);
  }

  /// Removes states without solver record: those of a missed period or after the last command.
  void drop_states() {
    if (run_.cost.size() >= run_.time.size()) return;
    run_.time.pop_back();
    const std::size_t rows = run_.time.size();
    for (Recording::Body& body : run_.bodies) {
      if (body.p.size() <= rows) continue;
      body.p.pop_back();
      body.heading.pop_back();
      body.v.pop_back();
      body.lean.pop_back();
    }
  }

  /// Checks that a message is the first of its kind in its period; its column has `rows` rows.
  void check_first(std::size_t rows, const McapMessage& message) const {
    if (rows >= run_.time.size())
      throw_unreadable("two messages of {} at {:.6g} s, expected one", message.topic,
                       to_seconds(message.log_time));
  }
  /// Checks that each column has a row for each period.
  void check_whole() const {
    const auto check = [this](std::size_t rows, std::string_view of, std::string_view what) {
      if (rows < run_.time.size())
        throw_unreadable("no message of /{}{} at {:.6g} s, expected one", of, what, run_.time[rows]);
    };
    for (const Recording::Body& body : run_.bodies) {
      check(body.p.size(), body.name, "/state");
      if (!body.u.empty()) check(body.u.front().size(), body.name, "/input");
      if (!body.barrier.empty()) check(body.barrier.size(), body.name, "/barrier");
    }
    for (const Recording::Controller& c : run_.controllers)
      check(c.status.size(), c.name, run_.controllers.size() > 1 ? "/solver" : "");
  }

  void state(Recording::Body& body, const McapMessage& message) {
    if (&body == &run_.bodies.front()) {
      drop_states();
      check_whole();
      const double time = read(message).number("time");
      if (!(time > last_time_))
        throw_unreadable("a message of {} at {:.6g} s after one at {:.6g} s, expected a later one",
                         message.topic, time, last_time_);
      run_.time.push_back(last_time_ = time);
    }
    check_first(body.p.size(), message);
    body.p.push_back({no_value, no_value, no_value});
    body.heading.push_back(no_value);
    body.v.push_back({no_value, no_value, no_value});
    body.lean.push_back({0.0, 0.0});
  }
  static void pose(Recording::Body& body, const McapMessage& message) {
    const auto pose = decode_pose(message.bytes);
    if (!pose || body.p.empty()) throw_unreadable("a message of {} is no pose of a state", message.topic);
    body.p.back() = {pose->p[0], pose->p[1], pose->p[2]};
    body.heading.back() = std::atan2(pose->d[1], pose->d[0]);
  }
  static void twist(Recording::Body& body, const McapMessage& message) {
    const auto twist = decode_twist(message.bytes);
    if (!twist || body.v.empty()) throw_unreadable("a message of {} is no twist of a state", message.topic);
    body.v.back() = {twist->linear[0], twist->linear[1], twist->linear[2]};
  }
  static void attitude(Recording::Body& body, const McapMessage& message) {
    const auto attitude = decode_attitude(message.bytes);
    if (!attitude || body.lean.empty())
      throw_unreadable("a message of {} is no attitude of a state", message.topic);
    const auto& [x, y, z, w] = attitude->q;
    body.lean.back() = lean(rotation({w, x, y, z}));
    body.leans = true;
  }
  /// Keeps the planned pose at PlannedAhead::ahead later, interpolated between two stages.
  static void path(Recording::Body& body, const McapMessage& message) {
    const auto path = decode_path(message.bytes);
    if (!path) throw_unreadable("a message of {} is no path", message.topic);
    constexpr double nanosecond = 1e-9;  // [s]
    const auto time_of = [&](const StampedPose& pose) { return nanosecond * static_cast<double>(pose.time); };
    const double then = nanosecond * static_cast<double>(message.log_time) + PlannedAhead::ahead;
    const auto later = std::upper_bound(path->begin(), path->end(), then + same_time,
                                        [&](double t, const StampedPose& pose) { return t < time_of(pose); });
    if (later == path->begin() || later == path->end()) return;
    const StampedPose &a = *(later - 1), &b = *later;
    const double w = (then - time_of(a)) / (time_of(b) - time_of(a));
    const auto between = [w](double from, double to) { return from + w * (to - from); };
    Sight<double> planned;
    planned.p = {between(a.p[0], b.p[0]), between(a.p[1], b.p[1]), between(a.p[2], b.p[2])};
    planned.d = {between(a.d[0], b.d[0]), between(a.d[1], b.d[1])};
    planned.lean = {between(a.lean[0], b.lean[0]), between(a.lean[1], b.lean[1])};
    body.planned_time.push_back(then);
    body.planned.push_back(planned);
  }
  void input(Recording::Body& body, const McapMessage& message) {
    const std::span<const double> values = read(message).numbers("u");
    if (values.size() != body.u.size()) {
      throw_unreadable("{} holds {} inputs, expected {}", message.topic, values.size(), body.u.size());
    }
    if (!body.u.empty()) check_first(body.u.front().size(), message);
    for (std::size_t i = 0; i < body.u.size(); ++i) body.u[i].push_back(values[i]);
  }
  void barrier(Recording::Body& body, const McapMessage& message) {
    const LogText& values = read(message);
    check_first(body.barrier.size(), message);
    body.barrier.push_back(values.truth("active") ? 1.0 : 0.0);
    body.reserve.push_back(values.number("reserve"));
  }
  void reference(Recording::Body& body, const McapMessage& message) {
    const LogText& values = read(message);
    body.reference_time.push_back(values.number("time"));
    if (values.has("p")) body.reference_p.push_back(point(values.numbers("p", 3)));
    if (values.has("d")) {
      const std::span<const double> d = values.numbers("d", 2);
      body.reference_heading.push_back(std::atan2(d[1], d[0]));
    }
  }
  static void camera(Recording::Body& body, const McapMessage& message) {
    body.camera = decode_camera_info(message.bytes);
    if (!body.camera) throw_unreadable("a message of {} is no camera", message.topic);
  }
  void detection(Recording::Body& body, const McapMessage& message) {
    const LogText& values = read(message);
    const std::string_view target = values.word("target");
    const auto seen = std::find_if(run_.bodies.begin(), run_.bodies.end(),
                                   [&](const Recording::Body& one) { return one.name == target; });
    if (seen == run_.bodies.end())
      throw_unreadable("{} names {}, expected a body of the team", message.topic, target);
    const std::span<const double> q = values.numbers("q", 4);
    body.sighted.push_back({values.number("stamp"),
                            static_cast<std::size_t>(seen - run_.bodies.begin()),
                            point(values.numbers("p", 3)),
                            {q[0], q[1], q[2], q[3]}});
  }
  void localization(Recording::Body& body, const McapMessage& message) {
    if (body.p.empty()) throw_unreadable("a message of {} comes before any state", message.topic);
    const LogText& text = read(message);
    const PoseEstimate estimate = estimate_of(text);
    const PoseError error = error_of(estimate, body.p.back(), body.heading.back());
    body.localization.time.push_back(text.number("time"));
    body.localization.error.push_back(norm(error.p));
    body.localization.sigma.push_back(estimate.position_sigma());
    body.localization.nees.push_back(error.nees);
  }
  void innovation(Recording::Body& body, const McapMessage& message) {
    const LogText& values = read(message);
    if (values.number("dimension") == 0) return;
    Recording::Localization& of = body.localization;
    const bool refused = values.word("verdict") == to_string(FitVerdict::rejected);
    (refused ? of.refused_time : of.estimated_time).push_back(values.number("stamp"));
    (refused ? of.refused : of.estimated).push_back(values.number("squared"));
  }
  void solver(std::size_t index, const McapMessage& message) {
    const LogText& values = read(message);
    Recording::Controller& controller = run_.controllers[index];
    check_first(controller.status.size(), message);
    controller.status.emplace_back(values.word("status"));
    controller.residual.push_back(values.number("residual"));
    controller.iterations.push_back(values.whole("iterations"));
    if (values.has("pairs")) controller.pairs.push_back(values.number("pairs"));
    if (index == 0) run_.cost.push_back(values.number("cost"));
  }
  void tuned(const McapMessage& message) { run_.script.push_back(json::parse(text_of(message)).at("name")); }
  void event(const McapMessage& message) {
    constexpr std::size_t thinned_most = 10'000;
    const json values = json::parse(text_of(message));
    if (values.at("kind") == to_string(EventKind::missed_period))
      order_.miss(std::llround(or_no_value(values.at("time")) / run_.period),
                  values.at("value").get<std::int64_t>());
    if (run_.stride > 1 && run_.events.size() >= thinned_most) return;
    run_.events.push_back({or_no_value(values.at("time")), values.at("kind"), values.at("controller"),
                           or_no_value(values.at("value"))});
  }

  Recording& run_;
  std::string first_state_, first_solver_;                       // topics
  double last_time_ = -std::numeric_limits<double>::infinity();  // of the first body's states
  std::int64_t period_ = 0;                                      // period being read
  PeriodOrder order_;                                            // of the earlier periods
  bool solved_ = false;
  LogText text_;
  std::map<std::string, std::function<void(const McapMessage&)>, std::less<>> places_;
};

// Opens only regular files, because a pipe could block.
std::ifstream opened(const std::filesystem::path& path) {
  std::error_code ignored;
  std::ifstream file;
  if (std::filesystem::is_regular_file(path, ignored)) file.open(path, std::ios::binary);
  if (!file.is_open()) file.setstate(std::ios::failbit);
  return file;
}

// Solve times [us], sum of all controllers. Reads only complete rows, because the last row may be
// truncated or not yet written.
class TimingReader {
 public:
  /// Keeps the longest time of each `stride` rows.
  TimingReader(const std::filesystem::path& path, std::size_t controllers, std::size_t stride)
      : path_(path.string()), controllers_(controllers), stride_(stride), file_(opened(path)) {
    if (!file_) throw_unreadable("{} cannot be read, expected the measured times of a run", path_);
  }

  void read_on(std::vector<double>& solve_us) {
    std::string line;
    for (;;) {
      const auto before = file_.tellg();
      if (!std::getline(file_, line) || file_.eof()) {
        file_.clear();
        file_.seekg(before);
        return;
      }
      if (!std::exchange(headed_, true)) continue;
      if (rows_++ % stride_ == 0)
        solve_us.push_back(sum_of(line));
      else
        solve_us.back() = std::max(solve_us.back(), sum_of(line));
    }
  }

 private:
  double sum_of(const std::string& line) const {
    const std::size_t columns = 2 + controllers_ + 3;
    std::vector<double> row;
    const char* const end = line.data() + line.size();
    for (const char* at = line.data(); at < end; ++at) {
      const auto [next, fault] = std::from_chars(at, end, row.emplace_back());
      if (fault != std::errc() || (next != end && *next != ',')) row.clear();
      if (row.empty()) break;
      at = next;
    }
    if (row.size() != columns)
      throw_unreadable("{}: \"{}\", expected {} numbers with commas between them", path_, line, columns);
    return std::accumulate(row.begin() + 2, row.begin() + 2 + static_cast<std::ptrdiff_t>(controllers_), 0.0);
  }

  std::string path_;
  std::size_t controllers_, stride_, rows_ = 0;
  std::ifstream file_;
  bool headed_ = false;
};

std::vector<double> read_timing(const std::filesystem::path& path, std::size_t stride) {
  std::vector<double> solve_us;
  TimingReader(path, 1, stride).read_on(solve_us);
  return solve_us;
}

// Subfolders of the run with a summary of the same scenario and seed.
std::vector<Recording::Comparison> read_comparisons(const std::filesystem::path& folder,
                                                    const Recording& run) {
  std::vector<Recording::Comparison> comparisons;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    std::ifstream file = opened(entry.path() / "summary.json");
    if (!file) continue;
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    const json summary = json::parse(text, nullptr, false);
    if (summary.is_discarded() || summary.value("scenario", "") != run.name ||
        summary.value("seed", 0ULL) != run.seed)
      continue;
    comparisons.push_back(
        {text, summary.value("solver", ""), read_timing(entry.path() / "timing.csv", run.stride)});
  }
  std::sort(comparisons.begin(), comparisons.end(),
            [](const auto& a, const auto& b) { return a.solver < b.solver; });
  return comparisons;
}

template <class Number>
Number number_of(const McapWords& words, const char* key) {
  const std::string& text = words.at(key);
  Number value{};
  if (std::from_chars(text.data(), text.data() + text.size(), value).ec != std::errc()) {
    throw_unreadable("{} = \"{}\", expected a number", key, text);
  }
  return value;
}

}  // namespace

class RecordingReader::Files {
 public:
  Files(const std::filesystem::path& of, std::size_t stride)
      : folder(of), path((of / "run.mcap").string()), log(path) {
    run.stride = stride;
    if (!log.ok()) throw_unreadable("{}", log.error());
    const auto found = log.metadata().find("sightline");
    if (found == log.metadata().end())
      throw_unreadable("{} is no log of a run, expected the words \"sightline\"", path);
    const McapWords& words = found->second;
    try {
      run.name = words.at("name");
      run.scenario = words.at("scenario");
      run.version = words.at("version");
      run.compiler = words.at("compiler");
      run.solver = words.at("solver");
      run.seed = number_of<std::uint64_t>(words, "seed");
      run.period = number_of<double>(words, "period");
      read_team(json::parse(words.at("team")), run);
      reader.emplace(run, number_of<std::size_t>(words, "controllers"));
    } catch (const std::exception& e) {
      throw_unreadable("{} is no sound log of a run: {}", path, sentence_of(e));
    }
  }

  void read_on(const std::function<void(const McapMessage&)>& visitor) {
    soundly([&] {
      log.read_on([&](const McapMessage& message) {
        reader->take(message);
        if (visitor) visitor(message);
      });
    });
    if (!log.ok()) throw_unreadable("{}", log.error());
    run.complete = !log.truncated();
    if (!timing) timing.emplace(folder / "timing.csv", run.controllers.size(), run.stride);
    timing->read_on(run.solve_us);
  }

  /// Call after all messages were read.
  void trim() {
    soundly([&] { reader->trim(!log.truncated()); });
  }

  std::filesystem::path folder;
  std::string path;
  McapReader log;
  Recording run;
  std::optional<RowReader> reader;
  std::optional<TimingReader> timing;

 private:
  template <class Read>
  void soundly(Read&& read) const {
    try {
      read();
    } catch (const std::exception& e) {
      throw_unreadable("{} is no sound log of a run: {}", path, sentence_of(e));
    }
  }
};

RecordingReader::RecordingReader(const std::filesystem::path& folder, std::size_t stride)
    : files_(std::make_unique<Files>(folder, stride)) {}
RecordingReader::~RecordingReader() = default;

void RecordingReader::read_on(const std::function<void(const McapMessage&)>& visitor) {
  files_->read_on(visitor);
}
const Recording& RecordingReader::run() const { return files_->run; }
std::size_t RecordingReader::rows() const { return files_->reader->rows(); }

Recording read_recording(const std::filesystem::path& folder,
                         const std::function<void(const McapMessage&)>& visitor, std::size_t stride) {
  RecordingReader reader(folder, stride);
  reader.read_on(visitor);
  reader.files_->trim();
  Recording run = std::move(reader.files_->run);
  run.comparisons = read_comparisons(folder, run);
  return run;
}

}  // namespace sightline
