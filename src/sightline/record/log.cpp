#include "sightline/record/log.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <exception>
#include <iterator>
#include <limits>
#include <optional>
#include <span>
#include <system_error>
#include <utility>
#include <vector>

#include "sightline/base/index.hpp"
#include "sightline/base/same_time.hpp"
#include "sightline/base/version.hpp"
#include "sightline/record/camera_log.hpp"
#include "sightline/record/cdr.hpp"
#include "sightline/record/localization_log.hpp"
#include "sightline/record/log_text.hpp"
#include "sightline/record/recorded_flight.hpp"
#include "sightline/record/team_json.hpp"
#include "sightline/record/text_file.hpp"

namespace sightline {
namespace {

constexpr double chunk_time = 0.1;  // [s]
constexpr std::string_view frame = frame_of_G;

// d x d' about z [rad/s]; 0 for a body without a heading.
double turn_rate(const Model& model, const StateRoles& roles, const double* x, const double* u) {
  if (!roles.has_heading()) return 0.0;
  std::vector<double> rate(size(model.nx()));
  model.f(x, u, rate.data());
  if (roles.angle >= 0) return rate[size(roles.angle)];
  const std::size_t d_x = size(roles.direction[0]), d_y = size(roles.direction[1]);
  return x[d_x] * rate[d_y] - x[d_y] * rate[d_x];
}

const std::filesystem::path& prepared(const std::filesystem::path& folder) {
  std::error_code ignored;  // the files that cannot be opened tell
  std::filesystem::create_directories(folder, ignored);
  std::filesystem::remove(beside(folder / "run.mcap"), ignored);
  return folder;
}

// What an earlier run left of what this one writes at its end, or not at all.
void remove_results(const std::filesystem::path& folder) {
  std::error_code ignored;
  for (const char* name : {"summary.json", "report.html", "partition.json", "whole/summary.json"})
    std::filesystem::remove(folder / name, ignored);
  for (const std::string_view solver : solver_names())  // of comparisons
    std::filesystem::remove(folder / solver / "summary.json", ignored);
}

}  // namespace

class Log::Files {
 public:
  Files(const Scenario& scenario, const std::filesystem::path& folder, std::size_t controllers,
        std::function<void(double)> written, const McapWords& flown);

  void take(const Sample& sample) noexcept;
  void end() noexcept;

  const Summary& summary() const { return summary_; }
  std::string error() const;
  bool begun() const { return begun_; }

 private:
  struct BodyChannels {
    BodyId body;
    StateRoles roles;
    McapChannel state, pose, twist;
    std::optional<McapChannel> measured{}, input{}, path{}, reference{}, barrier{}, attitude{};
    std::size_t robot = 0;  // its place among the robots
  };

  void begin();
  void add(const Sample& sample);
  void tell(double time) noexcept;
  void open_body(BodyId body, bool is_measured, bool has_barrier);
  McapChannel open(SchemaId schema, const std::string& topic, std::string_view encoding) {
    return {mcap_.channel(schema, topic, encoding, {})};
  }
  void send_bytes(McapChannel& channel, double time) {
    mcap_.message(channel.id, channel.sequence++, nanoseconds(time), bytes_);
  }

  void add_body(BodyChannels& channels, const Sample& sample);
  void open_attitudes(const Scenario& scenario);
  void add_attitude(BodyChannels& channels, const Sample& sample);
  void add_pose(McapChannel& channel, const Model& model, const double* x, double time);
  void add_agent(BodyChannels& channels, const Sample& sample);
  void add_path(BodyChannels& channels, const Sample& sample);
  void add_reference(BodyChannels& channels, double time);
  void add_barrier(BodyChannels& channels, const Sample& sample);
  void add_records(const Sample& sample);
  void add_timing(const Sample& sample);

  Team team_;
  double period_;  // [s]
  std::function<void(double)> written_;
  Summary summary_;
  std::filesystem::path folder_;
  McapWriter mcap_;
  std::optional<MeasurementLog> measurements_;
  std::optional<LocalizationLog> localization_;
  std::optional<CameraLog> cameras_;
  TextFile timing_;

  struct Schemas {
    SchemaId pose, twist, path, state, input, reference, solver, event, barrier;
    std::optional<SchemaId> attitude;
  } schemas_{};
  std::vector<BodyChannels> bodies_;
  std::size_t robots_ = 0;
  std::vector<McapChannel> solvers_;
  McapChannel events_;
  std::int64_t chunk_ = -1;  // number of the open chunk in simulated time
  double last_ = 0.0;        // time of the last sample [s]
  bool begun_ = false;

  // What was thrown, and after which time [s]: by judging, and by writing.
  struct Fault {
    std::exception_ptr what;
    double after = 0.0;
  } judging_, writing_;

  std::vector<std::byte> bytes_;
  LogMessage message_{mcap_};
  std::string rows_;
  std::vector<StampedPose> path_;
  std::vector<double> x_ref_, no_input_;
};

Log::Files::Files(const Scenario& scenario, const std::filesystem::path& folder, std::size_t controllers,
                  std::function<void(double)> written, const McapWords& flown)
    : team_(scenario.team),
      period_(scenario.horizon.dt),
      written_(std::move(written)),
      summary_(scenario, controllers),
      folder_(prepared(folder)),
      mcap_(beside(folder_ / "run.mcap"), "ros2", fmt::format("sightline {}", version)),
      timing_(folder_ / "timing.csv"),
      no_input_(size(team_.nu())) {
  McapWords words = {{"name", scenario.name},
                     {"scenario", scenario.text},
                     {"version", std::string(version)},
                     {"compiler", std::string(compiler)},
                     {"solver", scenario.solver.name},
                     {"seed", fmt::format("{}", scenario.simulation.seed)},
                     {"period", fmt::format("{}", period_)},
                     {"controllers", fmt::format("{}", controllers)},
                     {"team", team_json(scenario)}};
  words.insert(flown.begin(), flown.end());
  mcap_.metadata("sightline", words);
  if (!scenario.files.empty()) mcap_.metadata("files", scenario.files);
  const auto ros = [&](const RosSchema& schema) { return mcap_.schema(schema.name, "ros2msg", schema.text); };
  const auto json = [&](std::string_view name,
                        std::initializer_list<std::pair<const char*, std::string_view>> properties) {
    return mcap_.schema(name, "jsonschema", json_schema(properties));
  };
  schemas_.pose = ros(pose_schema());
  schemas_.twist = ros(twist_schema());
  schemas_.path = ros(path_schema());
  schemas_.state = json("sightline.State", {{"x", "numbers"}});
  schemas_.input = json("sightline.Input", {{"u", "numbers"}, {"raw", "numbers"}});
  schemas_.reference = json("sightline.Reference", {{"p", "numbers"}, {"d", "numbers"}});
  constexpr std::string_view record = "sightline.Solver";
  schemas_.solver =
      team_.swarms().empty()
          ? json(
                record,
                {{"status", "string"}, {"residual", "number"}, {"iterations", "integer"}, {"cost", "number"}})
          : json(record, {{"status", "string"},
                          {"residual", "number"},
                          {"iterations", "integer"},
                          {"pairs", "integer"},
                          {"cost", "number"}});
  schemas_.event =
      json("sightline.Event", {{"kind", "string"}, {"controller", "integer"}, {"value", "number"}});

  const bool has_barrier = scenario.safety && scenario.safety->barrier != BarrierMode::off;
  if (has_barrier) {
    schemas_.barrier =
        json("sightline.Barrier", {{"active", "boolean"}, {"conflict", "boolean"}, {"reserve", "number"}});
  }
  const bool is_measured = scenario.simulation.disturbances.spoil_measurements() ||
                           !scenario.simulation.faults.empty() ||
                           std::any_of(scenario.vehicles.begin(), scenario.vehicles.end(), has_imu);
  for (int i = 0; i < team_.bodies(); ++i) open_body(BodyId{i}, is_measured, has_barrier);
  open_attitudes(scenario);
  rows_ = "time,update_us";
  for (std::size_t c = 0; c < controllers; ++c) {
    const std::string name = controllers > 1 ? fmt::format("controller{}", c) : "";
    solvers_.push_back(open(schemas_.solver, name.empty() ? "/solver" : "/" + name + "/solver", "json"));
    rows_ += name.empty() ? ",solve_us" : ",solve_us." + name;
  }
  rows_ += ",allocations,iterations,missed\n";
  events_ = open(schemas_.event, "/events", "json");
  measurements_.emplace(team_, mcap_, goals_of(scenario.fleet));
  localization_.emplace(scenario, mcap_);
  cameras_.emplace(scenario, mcap_);
  begin();
}

// From here on the log opens: it takes the place of an earlier run's, whose results are no longer those of the log.
void Log::Files::begin() {
  timing_.write(std::exchange(rows_, {}));
  if (std::error_code ignored; !mcap_.ok() || !timing_.error().empty()) {
    for (const char* name : {"run.mcap", "timing.csv"})
      std::filesystem::remove(beside(folder_ / name), ignored);
    return;
  }
  remove_results(folder_);
  timing_.settle();
  mcap_.settle(folder_ / "run.mcap");
  begun_ = mcap_.ok();
}

void Log::Files::open_body(BodyId body, bool is_measured, bool has_barrier) {
  const std::string topic = fmt::format("/{}/", team_.name(body));
  BodyChannels channels{body, roles_of(team_.model(body)), open(schemas_.state, topic + "state", "json"),
                        open(schemas_.pose, topic + "pose", "cdr"),
                        open(schemas_.twist, topic + "twist", "cdr")};
  if (is_measured) channels.measured = open(schemas_.pose, topic + "measured", "cdr");
  if (team_.is_agent(body)) {
    channels.input = open(schemas_.input, topic + "input", "json");
    channels.path = open(schemas_.path, topic + "path", "cdr");
    if (has_barrier) channels.barrier = open(schemas_.barrier, topic + "barrier", "json");
    channels.robot = robots_++;
    const Agent& agent = team_.agent(body);
    if (tracks_position(agent, channels.roles) || tracks_heading(agent, channels.roles)) {
      channels.reference = open(schemas_.reference, topic + "reference", "json");
    }
  }
  bodies_.push_back(channels);
}

/// Of vehicles, and of robots with a camera that leans with them.
void Log::Files::open_attitudes(const Scenario& scenario) {
  const std::vector<bool> leans = leaning_bodies(scenario);
  for (BodyChannels& channels : bodies_) {
    if (!leans[size(channels.body.index)]) continue;
    if (!schemas_.attitude) {
      const RosSchema schema = attitude_schema();
      schemas_.attitude = mcap_.schema(schema.name, "ros2msg", schema.text);
    }
    channels.attitude =
        open(*schemas_.attitude, fmt::format("/{}/attitude", team_.name(channels.body)), "cdr");
  }
}

// Whatever a sample makes of judging and writing it, the next one is taken: a ring that nobody empties stops the flight.
void Log::Files::take(const Sample& sample) noexcept {
  try {
    if (!judging_.what) summary_.add(sample);
  } catch (...) {
    judging_ = {std::current_exception(), last_};
  }
  try {
    if (!writing_.what) add(sample);
  } catch (...) {
    writing_.what = std::current_exception();
  }
  last_ = sample.time;
}

void Log::Files::add(const Sample& sample) {
  const auto chunk = static_cast<std::int64_t>(std::floor(sample.time / chunk_time + same_time));
  for (BodyChannels& channels : bodies_) {
    add_body(channels, sample);
    if (!team_.is_agent(channels.body)) continue;
    add_agent(channels, sample);
    if (channels.reference && chunk != chunk_) add_reference(channels, sample.time);
  }
  measurements_->add(sample);
  localization_->add(sample);
  cameras_->add(sample.time);
  add_records(sample);
  add_timing(sample);
  if (chunk == chunk_) return;
  chunk_ = chunk;
  mcap_.flush();
  timing_.write(rows_);
  rows_.clear();
  writing_.after = sample.time;
  tell(sample.time);
}

void Log::Files::tell(double time) noexcept {
  if (!written_ || !mcap_.ok() || !timing_.error().empty()) return;
  try {
    written_(time);
  } catch (...) {
    written_ = nullptr;  // whoever looks on has gone
  }
}

void Log::Files::add_body(BodyChannels& channels, const Sample& sample) {
  const Model& model = team_.model(channels.body);
  const std::size_t nx = size(model.nx()), offset = size(team_.state_offset(channels.body));
  const double *x = sample.x.data() + offset, *u = sample.u.data() + team_.input_offset(channels.body);
  message_.begin(sample.time);
  message_.put("x", {x, nx});
  message_.send(channels.state, sample.time);
  if (sample.presence[size(channels.body.index)] == Presence::absent) return;
  add_pose(channels.pose, model, x, sample.time);
  if (channels.measured) add_pose(*channels.measured, model, sample.measured.data() + offset, sample.time);
  if (!all_finite({x, nx}) || !all_finite({u, size(model.nu())})) return;
  const Vec3<double> v = model.sight(x, u).v;
  encode_twist(bytes_, frame,
               {nanoseconds(sample.time), {v.x, v.y, v.z}, {0, 0, turn_rate(model, channels.roles, x, u)}});
  send_bytes(channels.twist, sample.time);
  if (channels.attitude) add_attitude(channels, sample);
}

void Log::Files::add_attitude(BodyChannels& channels, const Sample& sample) {
  const auto body = size(channels.body.index);
  Quaternion q = body < sample.attitudes.size() ? sample.attitudes[body] : no_attitude;
  if (q == no_attitude) {
    const Sight<double> seen = true_sight(team_, channels.body, sample);
    q = leaning(seen.d, seen.lean);
  }
  encode_attitude(bytes_, frame, {nanoseconds(sample.time), {q.x, q.y, q.z, q.w}});
  send_bytes(*channels.attitude, sample.time);
}

void Log::Files::add_pose(McapChannel& channel, const Model& model, const double* x, double time) {
  const Pose<double> pose = model.sight(x, no_input_.data());
  if (!all_finite({x, size(model.nx())}) || (pose.d.x == 0 && pose.d.y == 0)) return;
  encode_pose(bytes_, frame, {nanoseconds(time), {pose.p.x, pose.p.y, pose.p.z}, {pose.d.x, pose.d.y}});
  send_bytes(channel, time);
}

void Log::Files::add_agent(BodyChannels& channels, const Sample& sample) {
  const std::size_t nu = size(team_.model(channels.body).nu());
  const std::size_t offset = size(team_.input_offset(channels.body));
  message_.begin(sample.time);
  message_.put("u", std::span(sample.u).subspan(offset, nu));
  message_.put("raw", std::span(sample.raw_u).subspan(offset, nu));
  message_.send(*channels.input, sample.time);
  if (sample.has_path) add_path(channels, sample);
  if (channels.barrier && channels.robot < sample.barriers.size()) add_barrier(channels, sample);
}

void Log::Files::add_barrier(BodyChannels& channels, const Sample& sample) {
  const BarrierRecord& record = sample.barriers[channels.robot];
  message_.begin(sample.time);
  message_.put("active", record.active);
  message_.put("conflict", record.conflict);
  message_.put("reserve", record.reserve);
  message_.send(*channels.barrier, sample.time);
}

void Log::Files::add_path(BodyChannels& channels, const Sample& sample) {
  const Model& model = team_.model(channels.body);
  const bool leans = channels.attitude && !sample.path_u.empty();
  path_.clear();
  for (std::size_t i = 0; i < sample.path.size() / sample.x.size(); ++i) {
    const double* x = &sample.path[i * sample.x.size() + size(team_.state_offset(channels.body))];
    const double* u = leans ? &sample.path_u[i * sample.u.size() + size(team_.input_offset(channels.body))]
                            : no_input_.data();
    const Sight<double> seen = model.sight(x, u);
    if (!all_finite({x, size(model.nx())}) || (seen.d.x == 0 && seen.d.y == 0)) return;
    const double time = sample.path_time + sample.path_step * static_cast<double>(i);
    path_.push_back({nanoseconds(time), {seen.p.x, seen.p.y, seen.p.z}, {seen.d.x, seen.d.y}});
    if (leans) path_.back().lean = {seen.lean.x, seen.lean.y};
  }
  encode_path(bytes_, frame, nanoseconds(sample.time), path_);
  send_bytes(*channels.path, sample.time);
}

void Log::Files::add_reference(BodyChannels& channels, double time) {
  const StateRoles& roles = channels.roles;
  const Agent* const steered = summary_.agent(channels.body);
  if (steered == nullptr) return;
  const Agent& agent = *steered;
  x_ref_.resize(agent.Q.size());
  agent.x_ref(time, agent.model, x_ref_);
  const Pose<double> pose = agent.model.sight(x_ref_.data(), no_input_.data());
  message_.begin(time);
  if (tracks_position(agent, roles)) message_.put("p", std::array{pose.p.x, pose.p.y, pose.p.z});
  if (tracks_heading(agent, roles) && !(pose.d.x == 0 && pose.d.y == 0)) {
    message_.put("d", std::array{pose.d.x, pose.d.y});
  }
  message_.send(*channels.reference, time);
}

void Log::Files::add_records(const Sample& sample) {
  const double cost = judging_.what ? std::numeric_limits<double>::quiet_NaN() : summary_.stage_cost();
  for (std::size_t c = 0; c < solvers_.size(); ++c) {
    const SolverRecord& record = sample.solvers[c];
    message_.begin(sample.time);
    message_.put("status", to_string(record.status));
    message_.put("residual", record.residual);
    message_.put("iterations", record.iterations);
    if (!team_.swarms().empty()) message_.put("pairs", record.pairs);
    message_.put("cost", cost);
    message_.send(solvers_[c], sample.time);
  }
  for (int i = 0; i < sample.event_count; ++i) {
    const Event& event = sample.events[size(i)];
    message_.begin(event.time);
    message_.put("kind", to_string(event.kind));
    message_.put("controller", event.controller);
    message_.put("value", event.value);
    message_.send(events_, sample.time);
  }
}

void Log::Files::add_timing(const Sample& sample) {
  const auto row = std::back_inserter(rows_);
  fmt::format_to(row, "{},{:.3f}", sample.time, sample.update_us);
  std::int64_t allocations = 0, iterations = 0, missed = 0;
  for (const SolverRecord& record : sample.solvers) {
    fmt::format_to(row, ",{:.3f}", record.solve_us);
    allocations += record.allocations;
    iterations += record.iterations;
  }
  for (int i = 0; i < sample.event_count; ++i) {
    const Event& event = sample.events[size(i)];
    if (event.kind == EventKind::missed_period) missed += std::llround(event.value);
  }
  fmt::format_to(row, ",{},{},{}\n", allocations, iterations, missed);
}

void Log::Files::end() noexcept {
  try {
    if (!writing_.what) mcap_.close();
    timing_.write(rows_);
    timing_.close();
  } catch (...) {
    writing_.what = std::current_exception();
  }
  if (writing_.what) {
    mcap_.abandon();
  } else if (chunk_ >= 0) {
    tell(last_ + period_);
  }
}

std::string Log::Files::error() const {
  const auto words = [](const std::exception_ptr& what) -> std::string {
    try {
      std::rethrow_exception(what);
    } catch (const std::exception& error) {
      return error.what();
    } catch (...) {
    }
    return "an exception without words";
  };
  if (!mcap_.ok()) return mcap_.error();
  if (!timing_.error().empty()) return timing_.error();
  if (writing_.what)
    return fmt::format("{}: what came after {:.6g} s is lost: {}", (folder_ / "run.mcap").native(),
                       writing_.after, words(writing_.what));
  if (judging_.what)
    return fmt::format("{}: what came after {:.6g} s is not judged: {}", (folder_ / "summary.json").native(),
                       judging_.after, words(judging_.what));
  return {};
}

Log::Log(const Scenario& scenario, const std::filesystem::path& folder, const Controllers& controllers,
         Ring<Sample>& ring, std::function<void(double)> written, const McapWords& flown)
    : ring_(ring),
      files_(std::make_unique<Files>(scenario, folder, controllers.size(), std::move(written), flown)) {}

Log::~Log() {
  if (thread_.joinable()) ring_.close();
  finish();
}

void Log::start() {
  thread_ = std::thread([this] {
    while (const Sample* sample = ring_.wait()) {
      files_->take(*sample);
      ring_.pop();
    }
    files_->end();
  });
}

void Log::finish() {
  if (thread_.joinable()) thread_.join();
}

std::string Log::error() const { return files_->error(); }
bool Log::begun() const { return files_->begun(); }
const Summary& Log::summary() const { return files_->summary(); }

}  // namespace sightline
