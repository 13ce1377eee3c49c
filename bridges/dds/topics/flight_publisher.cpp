#include "bridges/dds/topics/flight_publisher.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <thread>
#include <vector>

#include "bridges/dds/topics/diagnostics.hpp"
#include "bridges/dds/topics/mailbox.hpp"
#include "bridges/dds/topics/ros_message.hpp"
#include "sightline/base.hpp"
#include "sightline/base/now.hpp"
#include "sightline/judge/event_description.hpp"
#include "sightline/loop.hpp"
#include "sightline/readers/cdr.hpp"
#include "sightline/report/scene.hpp"

namespace sightline::dds {
namespace {

constexpr std::chrono::milliseconds tick_time{20};
constexpr std::int64_t ticks_of_scene = 5, ticks_of_diagnostics = 50;
constexpr std::size_t samples_kept = 32;
constexpr std::size_t sentences_max = 1000;  // maximum number of queued sentences
constexpr int lines_a_second = 50;
constexpr std::uint32_t marker_lifetime = 500'000'000;  // [ns]
constexpr std::uint8_t log_info = 20, log_warn = 30, log_error = 40;
constexpr double fresh_by_default = 0.1;  // [s]

/// Published data of one period.
struct PublishedSample {
  double t = 0.0;            // [s]
  Nanoseconds shown_at = 0;  // monotonic clock
  std::vector<double> x, path;
  bool has_path = false;
  double path_time = 0.0, path_step = 0.0;  // [s]
  SolverRecord solver{};
  double update_us = 0.0;
  std::vector<FallbackLevel> levels;
  std::vector<PoseEstimate> estimates;  // per body
  int event_count = 0;
  std::vector<Event> events{};
};

PublishedSample sized_publication(const Scenario& scenario) {
  PublishedSample m;
  m.x = scenario.x0;
  m.path.resize(size(scenario.horizon.N + 1) * m.x.size());
  m.levels.resize(size(scenario.team.bodies()), FallbackLevel::valid);
  m.events.resize(64 + 4 * m.levels.size() + 4 * scenario.script.events.size());
  m.estimates.resize(size(scenario.team.bodies()));
  return m;
}

template <class T>
void copy_what_fits(const std::vector<T>& from, std::vector<T>& to) noexcept {
  std::copy_n(from.begin(), std::min(from.size(), to.size()), to.begin());
}

/// Writer of one published topic, with its message count.
template <class M>
struct Outlet {
  Outlet(dds_entity_t participant, const dds_topic_descriptor_t& type, const std::string& topic,
         Quality quality)
      : writer(participant, type, topic, quality) {}
  void write(const M& message) {
    if (writer(message)) ++written;
  }
  Writer<M> writer;
  std::int64_t written = 0;
};

}  // namespace

std::string topic_part(std::string_view robot) {
  std::string part(robot);
  std::replace(part.begin(), part.end(), '-', '_');
  if (part.empty() || (part[0] >= '0' && part[0] <= '9')) part.insert(part.begin(), '_');
  return part;
}

#define ROS_TYPE(name) name##_desc

class FlightPublisher::Thread {
 public:
  Thread(const Scenario& scenario, dds_entity_t participant, Counts counts);
  ~Thread() {
    done_ = true;
    thread_.join();
  }

  void run();
  void add_sentence(std::string_view sentence) {
    const std::scoped_lock lock(sentences_lock_);
    if (sentences_.size() < sentences_max) sentences_.emplace_back(sentence);
  }
  std::string describe() const;

  struct RobotTopics {
    RobotTopics(dds_entity_t participant, std::string robot, const std::string& begin, std::size_t at)
        : name(std::move(robot)),
          x(at),
          pose(participant, ROS_TYPE(geometry_msgs_msg_dds__PoseStamped_), begin + "/pose", of_shown),
          path(participant, ROS_TYPE(nav_msgs_msg_dds__Path_), begin + "/path", of_shown),
          frame(begin.substr(1)) {}
    std::string name;
    std::size_t x;  // state offset
    Mailbox<RobotShown> box{};
    RobotShown now{};
    Nanoseconds shown = 0;  // stamp of the last pose
    std::optional<LinkState> reported{};
    Outlet<geometry_msgs_msg_dds__PoseStamped_> pose;
    Outlet<nav_msgs_msg_dds__Path_> path;
    std::string frame;  // in /tf
    // Only for robots that are localized by vision, and for robots with a camera.
    std::optional<Outlet<geometry_msgs_msg_dds__PoseWithCovarianceStamped_>> estimate{};
    double estimated = 0.0;  // stamp of the last [s]
    std::optional<Outlet<sensor_msgs_msg_dds__CameraInfo_>> camera_info{};
    RobotCamera camera{};
  };
  std::vector<std::unique_ptr<RobotTopics>> robots_;
  SpscQueue<PublishedSample> samples_;

 private:
  void tick(std::int64_t number);
  void take(const PublishedSample& moment);
  void take_event(const Event& event);
  void send_poses();
  void send_estimate(std::size_t robot);
  void send_cameras();
  void send_paths();
  void send_markers();
  void send_diagnostics();
  void line(std::uint8_t level, const std::string& text);
  void end_second();
  std::optional<Sight<double>> sight_of(int body) const;
  Nanoseconds to_realtime(Nanoseconds monotonic) const { return monotonic + realtime_ahead_; }
  std_msgs_msg_dds__Header_ header(Nanoseconds monotonic, RosStrings& strings) const {
    return {stamp_of(to_realtime(monotonic)), strings(std::string(frame_of_G))};
  }

  Team team_;
  std::string node_, solver_;
  std::vector<double> no_input_;
  double fresh_ = fresh_by_default;
  Scene scene_;
  Counts counts_;

  PublishedSample last_;
  bool path_waits_ = false;
  Nanoseconds realtime_ahead_ = 0;
  LoopShown loop_;
  int lines_ = 0, lines_left_out_ = 0;
  std::int64_t lines_second_ = 0;

  Outlet<visualization_msgs_msg_dds__MarkerArray_> markers_;
  Outlet<tf2_msgs_msg_dds__TFMessage_> transforms_;
  Outlet<diagnostic_msgs_msg_dds__DiagnosticArray_> diagnostics_;
  Outlet<rcl_interfaces_msg_dds__Log_> log_;

  std::mutex sentences_lock_;
  std::vector<std::string> sentences_;
  std::atomic<std::int64_t> written_{0}, ran_{0}, worked_{0};  // [1], [ns], [ns]
  std::atomic<bool> done_{false};
  ServiceThread thread_{"the topics of the flight"};  // last member: uses all others
};

FlightPublisher::Thread::Thread(const Scenario& scenario, dds_entity_t participant, Counts counts)
    : samples_(samples_kept, sized_publication(scenario)),
      team_(scenario.team),
      node_(fleet_of(scenario).network.node),
      solver_(scenario.solver.name),
      no_input_(size(team_.nu())),
      scene_(scenario),
      counts_(std::move(counts)),
      last_(sized_publication(scenario)),
      markers_(participant, ROS_TYPE(visualization_msgs_msg_dds__MarkerArray_), node_ + "/markers", of_shown),
      transforms_(participant, ROS_TYPE(tf2_msgs_msg_dds__TFMessage_), "/tf", of_transforms),
      diagnostics_(participant, ROS_TYPE(diagnostic_msgs_msg_dds__DiagnosticArray_), "/diagnostics",
                   of_shown),
      log_(participant, ROS_TYPE(rcl_interfaces_msg_dds__Log_), "/rosout", of_log_lines) {
  if (scenario.safety && scenario.safety->supervisor) fresh_ = scenario.safety->supervisor->times.fresh;
  for (const Link& link : fleet_of(scenario).links) {
    const std::string name(team_.name(link.robot)), begin = node_ + "/" + topic_part(name);
    for (const auto& other : robots_)
      if (other->frame == begin.substr(1))
        throw std::invalid_argument(
            fmt::format("agent.{} = topics {}, as of {}, expected a name that differs in more than - and _",
                        name, begin, other->name));
    if (link.poses.source == PoseSource::tf && link.poses.name == begin.substr(1))
      throw std::invalid_argument(fmt::format(
          "agent.{}.link.pose_name = \"{}\", the frame that this program itself sends, expected another one",
          name, link.poses.name));
    RobotTopics& its = *robots_.emplace_back(
        std::make_unique<RobotTopics>(participant, name, begin, size(team_.state_offset(link.robot))));
    if (link.poses.estimated())
      its.estimate.emplace(participant, ROS_TYPE(geometry_msgs_msg_dds__PoseWithCovarianceStamped_),
                           begin + "/estimate", of_shown);
    if (const RobotCamera* camera = scenario.vision.camera_of(link.robot)) {
      its.camera = *camera;
      its.camera_info.emplace(participant, ROS_TYPE(sensor_msgs_msg_dds__CameraInfo_), begin + "/camera_info",
                              of_shown);
    }
  }
  thread_.start([this] { run(); });
}

void FlightPublisher::Thread::run() {
  const Nanoseconds began = monotonic_now();
  auto next = std::chrono::steady_clock::now();
  for (std::int64_t number = 0; !done_; ++number) {
    tick(number);
    worked_ = thread_time();
    ran_ = monotonic_now() - began;
    next = std::max(next + tick_time, std::chrono::steady_clock::now());
    std::this_thread::sleep_until(next);
  }
  tick(0);
}

void FlightPublisher::Thread::tick(std::int64_t number) {
  realtime_ahead_ = realtime_now() - monotonic_now();
  end_second();
  while (const PublishedSample* sample = samples_.front()) {
    take(*sample);
    samples_.pop();
  }
  for (auto& robot : robots_) {
    if (!robot->box.look(robot->now) || robot->reported == robot->now.state) continue;
    robot->reported = robot->now.state;
    const bool requested = robot->now.reason == LinkReason::as_requested;
    line(requested ? log_info : log_error,
         fmt::format("{}: {}{}{}", robot->name, to_string(robot->now.state), requested ? "" : ", ",
                     requested ? "" : to_string(robot->now.reason)));
  }
  {
    const std::scoped_lock lock(sentences_lock_);
    for (const std::string& sentence : sentences_) line(log_warn, sentence);
    sentences_.clear();
  }
  send_poses();
  for (std::size_t i = 0; i < robots_.size(); ++i) send_estimate(i);
  if (number % ticks_of_scene == 0) {
    send_paths();
    send_markers();
  }
  if (number % ticks_of_diagnostics == 0) {
    send_diagnostics();
    send_cameras();
  }
  std::int64_t written = markers_.written + transforms_.written + diagnostics_.written + log_.written;
  for (const auto& robot : robots_) {
    written += robot->pose.written + robot->path.written;
    if (robot->estimate) written += robot->estimate->written;
    if (robot->camera_info) written += robot->camera_info->written;
  }
  written_ = written;
}

void FlightPublisher::Thread::take(const PublishedSample& moment) {
  path_waits_ = path_waits_ || moment.has_path;
  if (moment.has_path) {
    last_.path = moment.path;
    last_.path_time = moment.path_time, last_.path_step = moment.path_step;
  }
  last_.t = moment.t, last_.shown_at = moment.shown_at;
  last_.x = moment.x, last_.levels = moment.levels, last_.estimates = moment.estimates;
  loop_.begun = true;
  loop_.last = moment.solver;
  loop_.solve_us_most = std::max(loop_.solve_us_most, moment.solver.solve_us);
  loop_.update_us_most = std::max(loop_.update_us_most, moment.update_us);
  ++loop_.periods;
  for (int i = 0; i < moment.event_count; ++i) take_event(moment.events[size(i)]);
}

void FlightPublisher::Thread::take_event(const Event& event) {
  if (event.kind == EventKind::missed_period) {
    loop_.missed += std::llround(event.value);
    line(log_warn, fmt::format("{} periods missed", event.value));
    return;
  }
  if (event.kind == EventKind::solver_status) {
    const auto status = static_cast<Status>(std::clamp(std::llround(event.value), 0LL, status_count - 1LL));
    if (!gives_plan(status)) line(log_error, fmt::format("solver: {}", to_string(status)));
    return;
  }
  const EventNames names = {.of_body = [&](int body) { return std::string(team_.name(BodyId{body})); },
                            .of_event = [](int number) { return fmt::format("{}", number); }};
  const bool mends = event.kind == EventKind::valid || event.kind == EventKind::predicted;
  const bool bad = event.kind == EventKind::barrier_conflict || event.kind == EventKind::input_refused;
  line(mends ? log_info : bad ? log_error : log_warn, event_words(to_string(event.kind), event.value, names));
}

void FlightPublisher::Thread::line(std::uint8_t level, const std::string& text) {
  if (lines_ >= lines_a_second) {
    ++lines_left_out_;
    return;
  }
  ++lines_;
  RosStrings strings;
  log_.write({stamp_of(realtime_now()), level, strings(node_.substr(1)), strings(text), strings(""),
              strings(""), 0});
}

void FlightPublisher::Thread::end_second() {
  const std::int64_t second = monotonic_now() / one_second;
  if (second == lines_second_) return;
  lines_second_ = second;
  lines_ = 0;
  if (const int more = std::exchange(lines_left_out_, 0); more > 0)
    line(log_warn, fmt::format("{} lines more in the second before", more));
}

void FlightPublisher::Thread::send_poses() {
  RosStrings strings;
  std::vector<geometry_msgs_msg_dds__TransformStamped_> transforms;
  for (auto& robot : robots_) {
    const SeenMotion& last = robot->now.last;
    if (!robot->now.seen || last.stamp == robot->shown) continue;
    robot->shown = last.stamp;
    const Vec3<double>& p = last.motion.p;
    const geometry_msgs_msg_dds__PoseStamped_ pose = {header(last.stamp, strings),
                                                      ros_pose(p, last.motion.q)};
    robot->pose.write(pose);
    transforms.push_back({pose.header, strings(robot->frame), {{p.x, p.y, p.z}, pose.pose.orientation}});
  }
  if (transforms.empty()) return;
  tf2_msgs_msg_dds__TFMessage_ message{};
  set_sequence(message.transforms, transforms);
  transforms_.write(message);
}

/// The attitude is upright; roll and pitch are not estimated, so their variances are 0.
void FlightPublisher::Thread::send_estimate(std::size_t robot) {
  RobotTopics& its = *robots_[robot];
  const PoseEstimate& now = last_.estimates[robot];
  if (!its.estimate || !now.known || now.stamp == its.estimated) return;
  its.estimated = now.stamp;
  constexpr std::array<std::size_t, 4> row = {0, 1, 2, 5};  // x, y, z, rotation about z
  const SinCos<double> heading = sincos(now.psi);
  RosStrings strings;
  geometry_msgs_msg_dds__PoseWithCovarianceStamped_ message{};
  message.header = header(last_.shown_at + to_nanoseconds(now.stamp - last_.t), strings);
  message.pose.pose = ros_pose(now.p, upright({heading.cos, heading.sin}));
  for (std::size_t i = 0; i < row.size(); ++i)
    for (std::size_t j = 0; j < row.size(); ++j)
      message.pose.covariance[6 * row[i] + row[j]] = now.P(static_cast<int>(i), static_cast<int>(j));
  its.estimate->write(message);
}

void FlightPublisher::Thread::send_cameras() {
  for (auto& robot : robots_) {
    if (!robot->camera_info) continue;
    RosStrings strings;
    std::vector<double> distortion = distortion_coefficients(robot->camera.camera);
    auto message = camera_info(robot->camera.camera, strings, distortion);
    message.header = {stamp_of(realtime_now()), strings(robot->camera.frame)};
    robot->camera_info->write(message);
  }
}

void FlightPublisher::Thread::send_paths() {
  if (!std::exchange(path_waits_, false)) return;
  const std::size_t nx = last_.x.size(), stages = last_.path.size() / nx;
  const Nanoseconds begin = last_.shown_at + to_nanoseconds(last_.path_time - last_.t);
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    const Model& model = team_.model(BodyId{static_cast<int>(i)});
    RosStrings strings;
    std::vector<geometry_msgs_msg_dds__PoseStamped_> poses;
    for (std::size_t k = 0; k < stages; ++k) {
      const double* x = &last_.path[k * nx + robots_[i]->x];
      const Sight<double> seen = model.sight(x, no_input_.data());
      const double sum = seen.p.x + seen.p.y + seen.p.z + seen.d.x + seen.d.y;
      if (!std::isfinite(sum) || (seen.d.x == 0 && seen.d.y == 0)) break;
      poses.push_back({header(begin + to_nanoseconds(last_.path_step * static_cast<double>(k)), strings),
                       ros_pose(seen.p, upright(seen.d))});
    }
    nav_msgs_msg_dds__Path_ path = {header(begin, strings), {}};
    set_sequence(path.poses, poses);
    robots_[i]->path.write(path);
  }
}

/// State of a body: a robot's newest motion; otherwise the loop's estimate.
std::optional<Sight<double>> FlightPublisher::Thread::sight_of(int body) const {
  if (size(body) < robots_.size()) {
    const RobotShown& now = robots_[size(body)]->now;
    if (!now.seen) return std::nullopt;
    const Rotation R = rotation(now.last.motion.q);
    return Sight<double>{{now.last.motion.p, heading(R)}, now.last.motion.v, lean(R)};
  }
  const Sight<double> seen =
      team_.model(BodyId{body}).sight(&last_.x[size(team_.state_offset(BodyId{body}))], no_input_.data());
  return std::isfinite(seen.p.x + seen.p.y + seen.p.z) ? std::optional(seen) : std::nullopt;
}

void FlightPublisher::Thread::send_markers() {
  std::vector<std::optional<Sight<double>>> bodies;
  for (int i = 0; i < team_.bodies(); ++i) bodies.push_back(sight_of(i));
  const std::vector<Drawn> drawn = scene_.draw(bodies, last_.t);
  if (drawn.empty()) return;
  RosStrings strings;
  std::vector<visualization_msgs_msg_dds__Marker_> markers;
  std::vector<std::vector<geometry_msgs_msg_dds__Point_>> points(drawn.size());
  for (std::size_t i = 0; i < drawn.size(); ++i) {
    const Drawn& d = drawn[i];
    for (const Vec3<double>& p : d.points) points[i].push_back({p.x, p.y, p.z});
    visualization_msgs_msg_dds__Marker_& m = markers.emplace_back();
    m.header = header(monotonic_now(), strings);
    m.ns = strings(std::string(d.group));
    m.id = d.id;
    m.type = d.form;
    m.pose = ros_pose(d.p, d.q);
    m.scale = {d.size.x, d.size.y, d.size.z};
    m.color = {d.colour.r, d.colour.g, d.colour.b, d.colour.a};
    m.lifetime = {0, marker_lifetime};
    set_sequence(m.points, points[i]);
    m.text = strings(d.words);
    m.texture_resource = m.mesh_resource = m.mesh_file.filename = strings("");
    m.texture.header = {{}, strings("")};
    m.texture.format = strings("");
  }
  visualization_msgs_msg_dds__MarkerArray_ message{};
  set_sequence(message.markers, markers);
  markers_.write(message);
}

void FlightPublisher::Thread::send_diagnostics() {
  std::vector<Diagnosis> all;
  for (std::size_t i = 0; i < robots_.size(); ++i) {
    const RobotShown& now = robots_[i]->now;
    const double age = to_seconds(monotonic_now() - now.last.stamp);
    all.push_back(diagnose_link(robots_[i]->name, now, age, fresh_, last_.levels[i], counts_(i)));
  }
  all.push_back(
      diagnose_solver(solver_, std::exchange(loop_, LoopShown{.begun = loop_.begun, .last = loop_.last})));

  RosStrings strings;
  std::vector<diagnostic_msgs_msg_dds__DiagnosticStatus_> statuses;
  std::vector<std::vector<diagnostic_msgs_msg_dds__KeyValue_>> values(all.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (const auto& [key, value] : all[i].values) values[i].push_back({strings(key), strings(value)});
    auto& status = statuses.emplace_back();
    status.level = static_cast<std::uint8_t>(all[i].level);
    status.name = strings(all[i].name);
    status.message = strings(all[i].message);
    status.hardware_id = strings(all[i].hardware);
    set_sequence(status.values, values[i]);
  }
  diagnostic_msgs_msg_dds__DiagnosticArray_ message{};
  message.header = {stamp_of(realtime_now()), strings("")};
  set_sequence(message.status, statuses);
  diagnostics_.write(message);
}

std::string FlightPublisher::Thread::describe() const {
  const double part = static_cast<double>(worked_) / static_cast<double>(std::max<std::int64_t>(ran_, 1));
  return fmt::format("{} messages for others, {:.1f} % of a core", written_.load(), 100.0 * part);
}

FlightPublisher::FlightPublisher(const Scenario& scenario, dds_entity_t participant, Counts counts)
    : thread_(std::make_unique<Thread>(scenario, participant, std::move(counts))) {}
FlightPublisher::~FlightPublisher() = default;

void FlightPublisher::show(std::size_t robot, const RobotShown& shown) noexcept {
  thread_->robots_[robot]->box.put(shown);
}

void FlightPublisher::show(const Sample& sample) noexcept {
  PublishedSample* const m = thread_->samples_.claim();
  if (m == nullptr) return;
  m->t = sample.time;
  m->shown_at = monotonic_now();
  copy_what_fits(sample.x, m->x);
  m->has_path = sample.has_path && sample.path.size() == m->path.size();
  if (m->has_path) copy_what_fits(sample.path, m->path);
  m->path_time = sample.path_time, m->path_step = sample.path_step;
  if (!sample.solvers.empty()) m->solver = sample.solvers.front();
  m->update_us = sample.update_us;
  copy_what_fits(sample.levels, m->levels);
  copy_what_fits(sample.estimates, m->estimates);
  m->event_count = std::min(sample.event_count, static_cast<int>(m->events.size()));
  std::copy_n(sample.events.begin(), m->event_count, m->events.begin());
  thread_->samples_.publish();
}

void FlightPublisher::add_sentence(std::string_view sentence) { thread_->add_sentence(sentence); }
std::string FlightPublisher::counts() const { return thread_->describe(); }

}  // namespace sightline::dds
