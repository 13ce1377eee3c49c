#include "bridges/dds/fleet_findings.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <iterator>
#include <limits>

#include "sightline/base.hpp"
#include "sightline/base/now.hpp"
#include "sightline/model/state_roles.hpp"
#include "sightline/safety/zone.hpp"
#include "sightline/scenario/read_safety.hpp"
#include "sightline/scenario/starts.hpp"

namespace sightline::dds {
namespace {

constexpr double times_fresh = 2.5;        // multiple of the pose interval
constexpr double late_most = 0.05;         // maximum latency if the scenario has no `fresh` limit [s]
constexpr double another_time = 1e5;       // a larger clock difference means unrelated clocks [s]
constexpr double references_apart = 2.0;   // maximum difference between satellite and configured origins [m]
constexpr double same_origin = 1e-6;       // [m]
constexpr double off_start_most = 3.0;     // along each axis, of a robot on the ground [m]
constexpr double below_start_most = 30.0;  // from the ground to its start [m]
constexpr std::int64_t poses_needed = 20;  // before the rate is judged

/// Rounds to 0.01; adding 0.0 turns -0.0 into 0.0.
double rounded(double x) { return std::round(100 * x) / 100 + 0.0; }

struct Placed {
  bool known = false;
  Vec3<double> p{};
};

const LadderTimes* times_of(const Scenario& scenario) {
  return scenario.safety && scenario.safety->supervisor ? &scenario.safety->supervisor->times : nullptr;
}

/// @param behind  its clock behind ours [s]
void examine_clock(double behind, double drift, FindingList& to) {
  if (std::abs(behind) > another_time)
    to.add(Aspect::clock, Light::red,
           "its stamps are {:.0f} s from our time: of its start, or of a simulation; set UXRCE_DDS_SYNCT = 1 "
           "of PX4, use_sim_time = false of ROS",
           std::abs(behind));
  else if (std::abs(drift) >= RemoteClock::drift_max)
    to.add(Aspect::clock, Light::red,
           "its clock and ours drift apart by {:g} ms a second or more, expected less",
           1e3 * std::abs(drift));
  else if (behind < -clocks_apart)
    to.add(Aspect::clock, Light::red,
           "its clock is {:.3f} s ahead of ours, expected {} s at most: have one of chrony or PTP set both",
           -behind, clocks_apart);
  else if (behind > clocks_apart)
    to.add(Aspect::clock, Light::red,
           "its clock is {:.3f} s behind ours, or no pose is faster on its way; expected {} s at most: have "
           "one of chrony or PTP set both",
           behind, clocks_apart);
  else
    to.add(Aspect::clock, Light::green, "within {:.1f} ms of ours, drifts by {:.2f} ms a second",
           1e3 * std::abs(behind), 1e3 * std::abs(drift));
}

void examine_latency(const Scenario& scenario, const ArrivalFigures& f, FindingList& to) {
  const LadderTimes* const times = times_of(scenario);
  const double most = times != nullptr ? times->fresh : late_most;
  to.add(Aspect::latency, f.late_p99 > most ? Light::red : Light::green,
         "from stamp to here {:.1f} ms, p99 {:.1f} ms beyond the fastest{}", 1e3 * f.late_median,
         1e3 * f.late_p99, f.late_p99 > most ? fmt::format(", expected {:g} ms at most", 1e3 * most) : "");
}

void examine_place(const Scenario& scenario, const Link& link, const Motion& robot, FindingList& to) {
  std::vector<std::string> beyond;
  const Vec3<double>& p = robot.p;
  const Vec3<double> off = p - sight_at_start(scenario, link.robot).p;
  const double ground = link.origin.p.z;
  if (std::max({std::abs(off.x), std::abs(off.y), off.z}) > off_start_most || off.z < -below_start_most)
    beyond.push_back(fmt::format("[{:.2f}, {:.2f}, {:.2f}] m from its start, expected {} m at most",
                                 rounded(off.x), rounded(off.y), rounded(off.z), off_start_most));
  if (is_absent_at_start(scenario, link.robot)) {
    const JoiningPlace place(scenario, link.robot);
    if (!place.holds(robot))
      beyond.push_back(
          fmt::format("turned from it by {:.2f} rad, expected {} m and {} rad at most of a robot that joins",
                      place.turned(robot), JoiningPlace::beside_most, JoiningPlace::turned_most));
  }
  if (p.z < ground - off_start_most) beyond.push_back(fmt::format("below the ground at {} m", ground));
  if (scenario.safety) {
    const double world = scenario.safety->world, ceiling = scenario.safety->barrier_options.ceiling;
    if (std::abs(p.x) > world || std::abs(p.y) > world)
      beyond.push_back(fmt::format("beyond world = {} m", world));
    if (p.z > ceiling) beyond.push_back(fmt::format("above ceiling = {} m", ceiling));
    const std::vector<Zone> zones = zones_to_land(scenario.safety->barrier_options.zones);
    for (std::size_t k = 0; k < zones.size(); ++k) {
      if (zone_reserve(zones[k], p) < 0 && !scenario.safety->start_outside)
        beyond.push_back(fmt::format("not {} safety.zone[{}]", to_string(zones[k].keep), k));
    }
  }
  to.add(Aspect::place, beyond.empty() ? Light::green : Light::red,
         "at [{:.2f}, {:.2f}, {:.2f}] m in G, {:.2f} m beside its start{}", rounded(p.x), rounded(p.y),
         rounded(p.z), norm(off.x, off.y),
         beyond.empty() ? (scenario.safety ? ", within the walls" : "")
                        : fmt::format(", {}: is its origin right?", fmt::join(beyond, " and ")));
}

/// The nearest pair that violates its minimum distance; without a violation, the nearest pair of
/// all.
class NearestPair {
 public:
  explicit NearestPair(const Scenario& scenario) : scenario_(scenario) {}

  void look(BodyId a, const Vec3<double>& pa, BodyId b, const Vec3<double>& pb) {
    const double d = norm(pa - pb), least = hard_distance(scenario_, a, b).value_or(0.0);
    const bool bad = d < least;
    if (bad > bad_ || (bad == bad_ && d - least < margin_)) {
      bad_ = bad, margin_ = d - least;
      text_ = fmt::format("{} and {} are {:.2f} m apart, d_hard = {} m", scenario_.team.name(a),
                          scenario_.team.name(b), d, least);
    }
  }
  bool bad() const { return bad_; }
  const std::string& text() const { return text_; }

 private:
  const Scenario& scenario_;
  bool bad_ = false;
  double margin_ = std::numeric_limits<double>::infinity();
  std::string text_;
};

bool is_same_origin(const ExaminedRobot& a, const ExaminedRobot& b) {
  return a.link->has_local_frame() && a.link->kind_name() == b.link->kind_name() &&
         norm(a.link->origin.p - b.link->origin.p) < same_origin;
}

void examine_distances(const Scenario& scenario, std::span<const ExaminedRobot> robots,
                       std::span<const Placed> placed, FindingList& to) {
  if (std::none_of(placed.begin(), placed.end(), [](const Placed& one) { return one.known; })) return;
  NearestPair nearest(scenario);
  std::vector<std::string> shared;
  for (std::size_t i = 0; i < robots.size(); ++i) {
    if (!placed[i].known) continue;
    for (std::size_t j = i + 1; j < robots.size(); ++j) {
      if (!placed[j].known) continue;
      nearest.look(robots[i].link->robot, placed[i].p, robots[j].link->robot, placed[j].p);
      if (is_same_origin(robots[i], robots[j]) && norm(placed[i].p - placed[j].p) < same_origin + 0.1)
        shared.push_back(fmt::format("{} and {}", robots[i].name, robots[j].name));
    }
    for (const UncooperativeBody& other : scenario.uncooperative) {
      nearest.look(robots[i].link->robot, placed[i].p, other.body, sight_at_start(scenario, other.body).p);
    }
  }
  if (!nearest.text().empty())
    to.add(Aspect::distance, nearest.bad() ? Light::red : Light::green, "{}{}", nearest.text(),
           nearest.bad() ? "" : ": none is nearer to its own");
  if (!shared.empty())
    to.add(Aspect::origins, Light::red,
           "{} say one origin and one place: the origin of each is where its own estimator started",
           fmt::join(shared, ", "));
}

// Compares the vehicles' geodetic references with the configured origins.
void examine_origins(std::span<const ExaminedRobot> robots, FindingList& to) {
  const ExaminedRobot* first = nullptr;
  int compared = 0;
  for (const ExaminedRobot& robot : robots) {
    const std::optional<GeoPoint> reference = robot.end->reference();
    if (!reference) continue;
    if (first == nullptr) {
      first = &robot;
      continue;
    }
    const Vec3<double> enu = east_north_up(*reference, *first->end->reference());
    const double heading = first->link->origin.heading;
    const Vec2<double> measured =
        rotate<double>(Vec2<double>{std::cos(heading), std::sin(heading)}, Vec2<double>{enu.x, enu.y});
    const Vec3<double> stated = robot.link->origin.p - first->link->origin.p;
    const double apart = norm(measured.x - stated.x, measured.y - stated.y);
    ++compared;
    if (apart > references_apart)
      to.add(Aspect::origins, Light::red,
             "{} began [{:.1f}, {:.1f}] m from {} by satellite, by their origins [{:.1f}, {:.1f}] m",
             robot.name, measured.x, measured.y, first->name, stated.x, stated.y);
  }
  if (compared > 0)
    to.add_green(Aspect::origins, "{} origins agree with where the vehicles began by satellite",
                 compared + 1);
}

}  // namespace

void examine_rate(const Scenario& scenario, const PosesFrom& from, const ArrivalFigures& f, FindingList& to) {
  if (f.count < poses_needed) {
    if (f.count > 0 && from.by_others())
      to.add(Aspect::rate, Light::unknown, "{} poses, too few to judge their rate", f.count);
    return;
  }
  const LadderTimes* const times = times_of(scenario);
  const double needed = times_fresh / f.rate;
  const bool rare = times != nullptr && needed > times->fresh * 1.02;  // 2 % for rounding
  const bool absent = times != nullptr && from.by_others() && f.gap_longest > times->slow_after;
  to.add(Aspect::rate, rare || absent ? Light::red : Light::green,
         "{:.0f} poses a second, the longest gap {:.3f} s, the last {:.3f} s old{}{}", f.rate, f.gap_longest,
         f.age,
         rare ? fmt::format("; levels flap unless safety.supervisor.fresh = {} s is {:.3f} s or more",
                            times->fresh, needed)
              : "",
         absent ? fmt::format("; a gap beyond safety.supervisor.slow_after = {} s scales commands: let more "
                              "cameras see it",
                              times->slow_after)
                : "");
}

JoiningPlace::JoiningPlace(const Scenario& scenario, BodyId robot)
    : start_(sight_at_start(scenario, robot)),
      has_heading_(roles_of(scenario.team.model(robot)).has_heading()) {}

double JoiningPlace::beside(const Motion& robot) const noexcept {
  return norm(robot.p.x - start_.p.x, robot.p.y - start_.p.y);
}

double JoiningPlace::turned(const Motion& robot) const noexcept {
  if (!has_heading_) return 0.0;
  const Vec2<double> d = rotate<double>({start_.d.x, -start_.d.y}, heading(rotation(robot.q)));
  return std::abs(std::atan2(d.y, d.x));
}

std::vector<Finding> examine_fleet(const Scenario& scenario, std::span<const ExaminedRobot> robots,
                                   const Surroundings& around) {
  const Nanoseconds now = monotonic_now();
  std::vector<Finding> all;
  std::vector<Placed> placed(robots.size());
  for (std::size_t i = 0; i < robots.size(); ++i) {
    FindingList list(robots[i].name);
    robots[i].end->examine(around, list);
    const ArrivalFigures f = robots[i].end->subscriber().arrivals().figures(now, realtime_now() - now);
    examine_rate(scenario, robots[i].link->poses, f, list);
    if (f.count >= poses_needed) {
      const PoseSubscriber& poses = robots[i].end->subscriber();
      const double offset = to_seconds(poses.clock_offset() + realtime_now() - now);
      examine_clock(offset - robots[i].end->stamps_behind(), poses.clock_drift(), list);
      examine_latency(scenario, f, list);
    }
    SeenMotion seen;
    if (robots[i].link->poses.estimated()) {
      robots[i].tags->examine(robots[i].link->robot, around, list);
    } else if (robots[i].end->look(seen)) {
      placed[i] = {true, seen.motion.p};
      examine_place(scenario, *robots[i].link, seen.motion, list);
    }
    std::vector<Finding> findings = list.take();
    std::move(findings.begin(), findings.end(), std::back_inserter(all));
  }
  FindingList fleet("");
  examine_distances(scenario, robots, placed, fleet);
  examine_origins(robots, fleet);
  std::vector<Finding> findings = fleet.take();
  std::move(findings.begin(), findings.end(), std::back_inserter(all));
  return all;
}

}  // namespace sightline::dds
