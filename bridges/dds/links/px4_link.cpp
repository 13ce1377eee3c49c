#include "bridges/dds/links/px4_link.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "bridges/dds/topics/seen_poses.hpp"
#include "sightline/base/now.hpp"

extern "C" {
#include "px4.h"
}

namespace sightline::dds {
namespace {

constexpr Nanoseconds odometry_old = one_second, status_old = 5 * one_second / 2;
constexpr Nanoseconds newcomers_wait = 50'000'000;
constexpr Nanoseconds beat_every = 35'000'000;  // PX4 requires at least 2 Hz
constexpr double turn_most = 0.2;               // limit of the heading difference from external poses [rad]
constexpr double least_height = 0.3;            // minimum height above the origin to count as in the air [m]
constexpr double near_height = 0.1;             // below height_, where the climb is over [m]
constexpr double stray_most = 3.0;  // from its take-off, sideways or downwards, before the task [m]
constexpr double rise_gain = 1.5, rise_most = 1.0;  // [1/s], [m/s]
constexpr std::uint8_t ack_accepted = 0, ack_in_progress = 5;
// In the order of the result of an acknowledgement, and of Request.
constexpr std::array<std::string_view, 7> ack_results = {
    "accepted", "temporarily rejected", "denied", "unsupported", "failed", "in progress", "cancelled"};
constexpr std::array<std::string_view, 8> request_names = {
    "nothing", "arm", "take off", "offboard", "hold", "take an origin", "land", "stop its motors"};
constexpr std::uint8_t our_system = 200, our_component = 191;  // component ID of a companion computer
// Without a stamp PX4 takes a message as of its reception. It converts stamps by the offset of its
// client, which follows a step of the agent's clock only after seconds, and ends offboard by old ones.
constexpr std::uint64_t at_reception = 0;
constexpr float px4_nan = std::numeric_limits<float>::quiet_NaN();
// The current position, and the configured altitude.
constexpr std::array<float, 3> px4_unset = {px4_nan, px4_nan, px4_nan};

Vec3<double> vec3_of(const float* v) { return {v[0], v[1], v[2]}; }

/// Reader of one of the vehicle's messages.
/// @param taking  returns the callback for messages of the given layout
template <class Taking>
std::unique_ptr<RawReader> px4_reader(dds_entity_t participant, const Px4Link& link, const Px4Layout& layout,
                                      std::string_view message, Quality quality, Writers writers,
                                      const Taking& taking) {
  const int release = px4_first + static_cast<int>(link.release);
  return std::make_unique<RawReader>(participant, layout.descriptor(),
                                     px4_topic(link.name_space, Px4Side::out, message, release), quality,
                                     layout.size(), writers, taking(layout));
}

}  // namespace

/// Readers and writers with the layouts of the release, and the sent messages whose layout differs
/// between releases.
struct Px4LinkEnd::Ends {
  explicit Ends(int release)
      : mode_layout("OffboardControlMode", release),
        command_layout("VehicleCommand", release),
        mode(mode_layout),
        order(command_layout) {}

  Px4Layout mode_layout, command_layout;
  Px4Message mode, order;
  std::unique_ptr<RawReader> status, position, alignment, landed, battery, ack, inertial;
  std::unique_ptr<RawWriter> heartbeat, setpoint, command;
};

Px4LinkEnd::Px4LinkEnd(Port participant, const Link& link, Stamps stamps, double height, Inertial inertial)
    : px4_(std::get<Px4Link>(link.kind)),
      from_(link.poses),
      origin_(link.origin),
      release_(px4_first + static_cast<int>(px4_.release)),
      stamps_(stamps),
      height_(height),
      odometry_(link.origin),
      inertial_(inertial == Inertial::read ? std::make_unique<InertialSamples>() : nullptr),
      aside_(std::make_unique<Px4Diagnostics>(participant, px4_)),
      ends_(std::make_unique<Ends>(release_)) {
  const auto writer = [&](std::string_view message) {
    return std::make_unique<RawWriter>(participant, Px4Layout(message, release_).descriptor(),
                                       px4_topic(px4_.name_space, Px4Side::in, message, release_),
                                       of_sensors);
  };
  read_state(participant);
  read_poses(participant);
  if (inertial_) read_inertial(participant);
  ends_->setpoint = writer("TrajectorySetpoint");
  ends_->heartbeat = writer("OffboardControlMode");
  ends_->command = writer("VehicleCommand");
}

Px4LinkEnd::~Px4LinkEnd() = default;

void Px4LinkEnd::read_state(dds_entity_t participant) {
  const auto read = [&](std::string_view message, Quality quality, const auto& taking) {
    return px4_reader(participant, px4_, Px4Layout(message, release_), message, quality, Writers::all,
                      taking);
  };
  using Byte = std::uint8_t;
  ends_->status = read("VehicleStatus", of_sensors, [this](const Px4Layout& in) {
    return [this, arming = in.place("arming_state"), nav = in.place("nav_state"),
            system = in.place("system_id"), failsafe = in.place("failsafe"),
            preflight = in.place("pre_flight_checks_pass")](const void* m, const Arrival& a) {
      says_offboard_ = read_at<Byte>(m, nav) == static_cast<Byte>(NavState::offboard);
      status_.put({a.monotonic, read_at<Byte>(m, arming), read_at<Byte>(m, nav), read_at<Byte>(m, system),
                   read_at<bool>(m, failsafe), read_at<bool>(m, preflight)});
    };
  });
  ends_->ack = read("VehicleCommandAck", {.depth = 8}, [this](const Px4Layout& in) {
    return [this, command = in.place("command"), result = in.place("result"),
            system = in.place("target_system")](const void* m, const Arrival& a) {
      ack_.put({a.monotonic, read_at<std::uint32_t>(m, command), read_at<Byte>(m, result),
                read_at<Byte>(m, system)});
    };
  });
  ends_->position = read("VehicleLocalPosition", of_sensors, [this](const Px4Layout& in) {
    return [this, valid = in.place("xy_valid"), xy = in.place("xy_global"), z = in.place("z_global"),
            lat = in.place("ref_lat"), lon = in.place("ref_lon"),
            alt = in.place("ref_alt")](const void* m, const Arrival& a) {
      Position position{a.monotonic};
      for (std::size_t i = 0; i < valid_names.size(); ++i)
        position.valid[i] = read_at<bool>(m, valid + i);  // adjacent fields
      position.global = read_at<bool>(m, xy) && read_at<bool>(m, z);
      position.reference = {read_at<double>(m, lat), read_at<double>(m, lon), read_at<float>(m, alt)};
      position_.put(position);
    };
  });
  // Accepts any size: only the beginning is read, which all releases share.
  const Px4Layout flags("EstimatorStatusFlags", release_);
  ends_->alignment = std::make_unique<RawReader>(
      participant, flags.descriptor(),
      px4_topic(px4_.name_space, Px4Side::out, "EstimatorStatusFlags", release_), of_sensors, std::nullopt,
      Writers::all,
      [this, tilt = flags.place("cs_tilt_align"), heading = flags.place("cs_yaw_align")](const void* m,
                                                                                         const Arrival& a) {
        alignment_.put({a.monotonic, read_at<bool>(m, tilt), read_at<bool>(m, heading)});
      });
  ends_->battery = read("BatteryStatus", of_sensors, [this](const Px4Layout& in) {
    return
        [this, remaining = in.place("remaining"), voltage = in.place("voltage_v"),
         warning = in.place("warning"), connected = in.place("connected")](const void* m, const Arrival& a) {
          battery_.put({a.monotonic, read_at<float>(m, remaining), read_at<float>(m, voltage),
                        read_at<Byte>(m, warning), read_at<bool>(m, connected)});
        };
  });
  ends_->landed = read("VehicleLandDetected", of_sensors, [this](const Px4Layout& in) {
    return [this, landed = in.place("landed")](const void* m, const Arrival& a) {
      landed_.put({a.monotonic, read_at<bool>(m, landed)});
    };
  });
}

void Px4LinkEnd::read_poses(dds_entity_t participant) {
  if (from_.estimated()) odometry_.keep_each(kept_motions);
  odometry_.read_by(px4_reader(participant, px4_, Px4Layout("VehicleOdometry", release_), "VehicleOdometry",
                               of_sensors, Writers::first, [this](const Px4Layout&) {
                                 return [this](const void* m, const Arrival& a) { on_odometry(m, a); };
                               }));
  if (!from_.by_others()) return;
  seen_ = std::make_unique<PoseSubscriber>();
  read_seen_poses(*seen_, participant, from_, Attitude::needed);
}

void Px4LinkEnd::read_inertial(dds_entity_t participant) {
  const auto take = [this](const void* message, const Arrival& arrival) {
    const auto& m = *static_cast<const px4_msgs_msg_dds__SensorCombined_*>(message);
    if (m.timestamp > last_microsecond || m.accelerometer_timestamp_relative == px4_no_acceleration) return;
    inertial_->put({of_microseconds(m.timestamp), body_turned_over(vec3_of(m.gyro_rad)),
                    body_turned_over(vec3_of(m.accelerometer_m_s2))},
                   arrival.monotonic);
  };
  // Several may arrive before the receive thread reads them: none replaces another.
  ends_->inertial = px4_reader(participant, px4_, Px4Layout("SensorCombined", release_), "SensorCombined",
                               {.depth = 8}, Writers::first, [&](const Px4Layout&) { return take; });
}

void Px4LinkEnd::on_odometry(const void* message, const Arrival& arrival) {
  const auto& m = *static_cast<const px4_msgs_msg_dds__VehicleOdometry_*>(message);
  if (m.pose_frame != px4_frame_ned ||
      (m.velocity_frame != px4_frame_ned && m.velocity_frame != px4_velocity_body)) {
    odometry_.take_other_frame();
    return;
  }
  const Quaternion q = normalised({m.q[0], m.q[1], m.q[2], m.q[3]});
  Motion local = {turned_over(vec3_of(m.position)),
                  q == no_attitude ? q : turned_over(q),
                  {},
                  -double{m.angular_velocity[2]}};
  const Vec3<double> v = vec3_of(m.velocity);
  local.v = m.velocity_frame == px4_frame_ned ? turned_over(v) : rotation(local.q).to_G(body_turned_over(v));
  if (m.timestamp_sample > last_microsecond) {
    odometry_.take_other_time();
    return;
  }
  const Nanoseconds sampled = of_microseconds(m.timestamp_sample);
  if (!odometry_.accepts(local, sampled, arrival.monotonic)) return;
  own_.put({local.p, m.timestamp_sample});
  anchor_.follow(local, m.reset_counter, odometry_.stamp());
  odometry_.put(local);
}

bool Px4LinkEnd::look(SeenMotion& seen) noexcept {
  (void)own_.look(answered_);
  const bool there = poses().look(seen);
  answered_at_ = seen.motion.p;
  return there;
}

bool Px4LinkEnd::has_valid_estimate() const noexcept {
  return last_position_.good() && last_alignment_.tilt && last_alignment_.heading;
}

LinkReason Px4LinkEnd::unfit(const Vec3<double>& p) const noexcept {
  if (last_battery_.warning >= px4_battery_critical) return LinkReason::battery_low;
  if (last_position_.arrived > 0 && !has_valid_estimate()) return LinkReason::estimator_invalid;
  const bool jumped = from_.source == PoseSource::odometry && anchor_.moved() > px4_.reset_max,
             strayed =
                 rises_ && (norm(p.x - left_.x, p.y - left_.y) > stray_most || p.z < left_.z - stray_most);
  return jumped || strayed ? LinkReason::moved : LinkReason::as_requested;
}

bool Px4LinkEnd::is_seen_well() noexcept {
  return !seen_ ||
         (!seen_->of_second_writer() && !seen_->in_other_frames() &&
          odometry_.is_fresh(monotonic_now(), odometry_old) && std::abs(turned_from_seen()) < turn_most);
}

LinkFacts Px4LinkEnd::facts(Nanoseconds now) noexcept {
  (void)status_.look(last_status_);
  (void)position_.look(last_position_);
  (void)alignment_.look(last_alignment_);
  (void)landed_.look(last_landed_);
  (void)battery_.look(last_battery_);
  (void)ack_.look(last_ack_);
  const Status& s = last_status_;
  const bool says_landed = now - last_landed_.arrived < status_old;
  LinkFacts facts;
  const bool fresh = poses().is_fresh(now, odometry_old);
  const Nanoseconds silent = now - poses().arrivals().last();
  facts.there = silent < odometry_old && now - s.arrived < status_old;
  facts.armed = s.arming == px4_armed;
  facts.landed = says_landed ? last_landed_.landed : !facts.armed;
  facts.checked = s.preflight && fresh && has_valid_estimate() &&
                  last_battery_.warning < px4_battery_critical && facts.landed && received_ &&
                  !odometry_.of_second_writer() && is_seen_well() &&
                  (px4_.target_system == 0 || px4_.target_system == s.system);
  facts.unplaced = !s.preflight && has_valid_estimate() && aside_ && aside_->lacks_origin();
  facts.contested = rivals_ > 0;
  facts.restarted = speakers_ >= 0 && ends_->status->writers_came() > speakers_;
  facts.failsafe = s.failsafe;
  facts.mode = is_in(NavState::offboard)                           ? AutopilotMode::offboard
               : is_in(NavState::takeoff) || is_in(NavState::hold) ? AutopilotMode::takeoff
               : is_in(NavState::land)                             ? AutopilotMode::land
                                                                   : AutopilotMode::other;
  const Vec3<double> p = poses().newest().motion.p;
  const double height = p.z;
  // After the last pose its stamp is old sooner than its arrival.
  facts.unfit = facts.there && !fresh && silent < odometry_old / 2 ? LinkReason::stamps_stuck : unfit(p);
  const bool high = height - origin_.p.z > least_height;
  facts.risen = height > height_ - near_height;
  facts.airborne =
      (is_in(NavState::hold) || is_in(NavState::offboard)) && high && !(says_landed && last_landed_.landed);
  facts.answered = last_ack_.arrived > requested_at_ && last_ack_.system == our_system &&
                   last_ack_.command == static_cast<std::uint32_t>(requested_by_);
  facts.refused = facts.answered && last_ack_.result != ack_accepted && last_ack_.result != ack_in_progress;
  if (facts.answered && last_ack_.arrived > replied_at_)
    replied_ = requested_, replied_at_ = last_ack_.arrived;
  return facts;
}

std::string Px4LinkEnd::reply() {
  if (replied_ == Request::none) return {};
  const std::size_t result = last_ack_.result;
  return fmt::format("the request to {} is {}{}",
                     request_names[static_cast<std::size_t>(std::exchange(replied_, Request::none))],
                     result < ack_results.size() ? ack_results[result] : "answered by an unknown result",
                     result == ack_accepted || result == ack_in_progress ? "" : failing());
}

std::string Px4LinkEnd::failing() const {
  return aside_ ? aside_->failing(is_in(NavState::offboard) ? px4_offboard_flag : "") : "";
}

/// Heading of its estimator minus the externally observed one, anticlockwise [rad]; 0 if one of
/// them is missing.
double Px4LinkEnd::turned_from_seen() noexcept {
  SeenMotion own, seen;
  if (!seen_ || !seen_->look(seen) || !odometry_.look(own)) return 0.0;
  const Vec2<double> a = heading(rotation(seen.motion.q)), b = heading(rotation(own.motion.q));
  return std::atan2(a.x * b.y - a.y * b.x, a.x * b.x + a.y * b.y);
}

void Px4LinkEnd::command(Px4Command which, const std::array<float, 3>& params) noexcept {
  requested_by_ = which;
  const float rest = std::isnan(params[0]) ? px4_nan : 0.0F;
  Px4Message& c = ends_->order;
  c.set("timestamp", at_reception);
  c.set("param1", params[0]), c.set("param2", params[1]), c.set("param3", params[2]);
  for (const std::string_view param : {"param4", "param7"}) c.set(param, rest);
  for (const std::string_view param : {"param5", "param6"}) c.set(param, double{rest});
  c.set("command", static_cast<std::uint32_t>(which));
  c.set("target_system", last_status_.system);
  c.set("target_component", std::uint8_t{1});
  c.set("source_system", our_system);
  c.set("source_component", our_component);  // low byte, if the field has two
  c.set("from_external", true);
  (void)ends_->command->write(c.data());
}

TrajectoryPoint Px4LinkEnd::in_own_frame(const TrajectoryPoint& to) const noexcept {
  const auto way = [&](const Vec3<double>& in_team) {
    return in_local({{}, origin_.heading}, Motion{.p = in_team}).p;
  };
  return {.p = answered_.p + way(to.p - answered_at_), .v = way(to.v), .a = way(to.a)};
}

void Px4LinkEnd::send(const LinkOutput& output, const Command& c, Nanoseconds now) noexcept {
  if (output.heartbeat && now - beat_at_ >= beat_every) {
    beat_at_ = now;
    ends_->mode.set("timestamp", at_reception);
    ends_->mode.set("position", true);
    (void)ends_->heartbeat->write(ends_->mode.data());
  }
  // A new reader may be the vehicle itself after a restart; its status shows that only a moment
  // later.
  const bool known = now - ends_->setpoint->reader_came() > newcomers_wait;
  if (output.setpoint != Setpoint::none && known) {
    px4_msgs_msg_dds__TrajectorySetpoint_ s{};
    s.timestamp = at_reception;
    for (std::size_t k = 0; k < 3; ++k) s.position[k] = s.jerk[k] = px4_nan;
    s.yaw = px4_nan;
    if (output.setpoint == Setpoint::task) {
      rises_ = false;
      const TrajectoryPoint to = in_own_frame(c.lead);
      const auto set = [](float* place, const Vec3<double>& enu) {
        const Vec3<double> ned = turned_over(enu);
        place[0] = static_cast<float>(ned.x), place[1] = static_cast<float>(ned.y),
        place[2] = static_cast<float>(ned.z);
      };
      set(s.position, to.p), set(s.velocity, to.v), set(s.acceleration, to.a);
      s.position[2] = px4_nan;  // the models climb at once, and a vehicle would make up for its lag
      s.yawspeed = static_cast<float>(-c.r);
    } else if (output.setpoint == Setpoint::climb) {
      const double below = height_ - poses().newest().motion.p.z;
      s.velocity[2] = static_cast<float>(-std::clamp(rise_gain * below, 0.0, rise_most));
    }
    if (output.setpoint != Setpoint::zero && stamps_ == Stamps::of_poses) s.timestamp = answered_.sampled;
    // A newer status may report another mode since the period began.
    if (says_offboard_) {
      ++sent_;
      (void)ends_->setpoint->write(&s);
    } else {
      ++held_back_;
    }
  }
  const bool repeated = output.request == Request::none || output.request == requested_;
  if (!repeated) requested_ = output.request, requested_at_ = now;
  switch (output.request) {
    case Request::none:
      break;
    case Request::arm:
      if (!repeated) speakers_ = ends_->status->writers_came(), left_ = poses().newest().motion.p;
      anchor_.hold();
      rises_ = true;
      command(Px4Command::arm_disarm, {1.0F});
      break;
    case Request::take_off:
      command(Px4Command::takeoff, px4_unset);
      break;
    case Request::offboard:
      command(Px4Command::set_mode, {px4_custom_mode, px4_mode_offboard});
      break;
    case Request::hold:
      command(Px4Command::set_mode, {px4_custom_mode, px4_mode_auto, px4_auto_loiter});
      break;
    case Request::origin:
      command(Px4Command::set_origin, {});  // 0 N, 0 E: its local frame alone is used
      break;
    case Request::land:
      command(Px4Command::land, px4_unset);
      break;
    case Request::emergency:
      command(Px4Command::arm_disarm, {0.0F, px4_force});
      break;
  }
}

void Px4LinkEnd::watch(std::span<const SeenWriter> writers) {
  received_ =
      ends_->setpoint->matched() > 0 && ends_->heartbeat->matched() > 0 && ends_->command->matched() > 0;
  rivals_ = ends_->setpoint->rivals(writers) + ends_->heartbeat->rivals(writers);
}

void Px4LinkEnd::examine_topics(const Surroundings& around, FindingList& to) const {
  const std::array<const RawReader*, 4> readers = {&odometry_.reader(), ends_->status.get(),
                                                   ends_->position.get(), ends_->ack.get()};
  for (const RawReader* reader : readers) {
    const ReaderCounts& n = reader->counts();
    if (n.too_long + n.too_short > 0)
      to.add(Aspect::release, Light::red, "{}: {} messages of {} bytes, which PX4 1.{} does not have",
             reader->topic(), n.too_long + n.too_short, n.wrong_size.load(), release_);
  }
  for (const RawReader* reader : std::span(readers).first<3>())
    if (reader->counts().received == 0)
      to.add(Aspect::topics, Light::red, "{}: no message of PX4 1.{}, {}", reader->topic(), release_,
             why_nothing_comes(*reader, around));
  for (const RawWriter* writer : {ends_->setpoint.get(), ends_->heartbeat.get(), ends_->command.get()})
    if (!writer->received(around.readers))
      to.add(Aspect::topics, Light::red, "{}: {}", writer->topic(), why_stale(*writer, around));
  to.add_green(Aspect::topics,
               "odometry, status and local position arrive, it receives commands and set-points");
}

void Px4LinkEnd::examine_writers(const Surroundings& around, FindingList& to) const {
  for (const RawWriter* writer : {ends_->setpoint.get(), ends_->heartbeat.get()})
    if (writer->rivals(around.writers) > 0)
      to.add(Aspect::writers, Light::red, "{}: another program writes {}", writer->topic(),
             writer == ends_->setpoint.get() ? "set-points" : "heartbeats: another flyer");
  to.add_green(Aspect::writers, "no other program publishes in its place or steers it");
}

void Px4LinkEnd::examine_estimator(FindingList& to) const {
  Position position;
  if (!position_.look(position)) return;
  std::vector<std::string_view> invalid;
  for (std::size_t i = 0; i < valid_names.size(); ++i)
    if (!position.valid[i]) invalid.push_back(valid_names[i]);
  if (!invalid.empty())
    to.add(Aspect::estimator, Light::red, "its estimator is not valid: {}", fmt::join(invalid, ", "));
  Alignment alignment;
  const bool says = alignment_.look(alignment);
  if (!alignment.tilt)
    to.add(Aspect::estimator, Light::red,
           "its estimator has not found yet what is level: let it stand still");
  if (!alignment.heading)
    to.add(Aspect::estimator, Light::red,
           "its estimator has no heading yet: it wants a compass, or the poses of motion capture");
  to.add_green(Aspect::estimator, "valid: position and velocity, level and upright{}",
               says ? "; it knows what is level, and its heading" : "");
}

std::optional<GeoPoint> Px4LinkEnd::reference() const {
  Position position;
  if (!position_.look(position) || !position.global) return std::nullopt;
  return position.reference;
}

void Px4LinkEnd::examine_state(FindingList& to) {
  examine_estimator(to);
  const LinkFacts f = facts(monotonic_now());
  const Status& s = last_status_;
  if (s.arrived == 0) return;
  if (px4_.target_system != 0 && px4_.target_system != s.system)
    to.add(Aspect::system, Light::red, "it is system {}, expected {}", s.system, px4_.target_system);
  to.add_green(Aspect::system, "system {}", s.system);
  if (!s.preflight)
    to.add(Aspect::checks, Light::red, "its own checks before a flight do not pass{}", failing());
  if (s.failsafe) to.add(Aspect::checks, Light::red, "its failsafe acts{}", failing());
  to.add_green(Aspect::checks, "its own checks before a flight pass");
  if (f.armed) to.add(Aspect::state, Light::red, "it is armed already");
  if (!f.landed) to.add(Aspect::state, Light::red, "it is not on the ground");
  to.add_green(Aspect::state, "disarmed, on the ground");
}

void Px4LinkEnd::examine(const Surroundings& around, FindingList& to) {
  if (!aside_) return;
  if (inertial_)
    examine_inertial(*inertial_, *ends_->inertial, "they ceased, or have no acceleration", around, to);
  examine_topics(around, to);
  odometry_.examine("NED, counted from its origin", "frames that are not NED", to);
  if (seen_) {
    seen_->examine("the frame that is G", other_frames_than(from_), to);
    if (const double turn = turned_from_seen(); std::abs(turn) > turn_most)
      to.add(Aspect::frames, Light::red,
             "its estimator's heading is {:.2f} rad from the one that is seen, expected {} at most: "
             "origin.heading, or what it is fed",
             turn, turn_most);
  }
  examine_writers(around, to);
  examine_state(to);
  aside_->examine(around, last_battery_, to);
}

std::string Px4LinkEnd::counts() const {
  std::int64_t wrong = 0;
  for (const RawReader* reader :
       std::array<const RawReader*, 6>{&odometry_.reader(), ends_->status.get(), ends_->position.get(),
                                       ends_->ack.get(), ends_->landed.get(), ends_->battery.get()})
    wrong += reader->counts().too_long + reader->counts().too_short;
  std::string words = fmt::format("{}, {} messages of other sizes, {} set-points sent", poses().counts(),
                                  wrong, sent_.load());
  if (inertial_)
    words += fmt::format(", {} measurements of its IMU, {} not finite",
                         ends_->inertial->counts().received.load(), inertial_->not_finite());
  if (held_back_ > 0)
    words += fmt::format(", {} held back: it reported another mode in that period", held_back_.load());
  if (anchor_.jumps() > 0)
    words += fmt::format(", {} jumps of its estimator by {:.2f} m in sum", anchor_.jumps(), anchor_.moved());
  return words;
}

}  // namespace sightline::dds

std::unique_ptr<sightline::dds::LinkEnd> sightline::Px4Link::end(const dds::EndSetup& setup) const {
  const bool loopback = setup.network.interfaces == std::vector<std::string>{"lo"};
  return std::make_unique<dds::Px4LinkEnd>(setup.at, setup.link,
                                           loopback ? dds::Stamps::of_poses : dds::Stamps::none, setup.height,
                                           setup.inertial ? dds::Inertial::read : dds::Inertial::unread);
}
