#include "bridges/dds/topics/seen_bodies.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "bridges/dds/fleet_findings.hpp"
#include "bridges/dds/topics/seen_poses.hpp"
#include "sightline/base.hpp"
#include "sightline/base/now.hpp"

namespace sightline::dds {
namespace {

constexpr Nanoseconds body_old = 500'000'000;  // limit of the pose age before a flight

}  // namespace

SeenBodies::SeenBodies(const Scenario& scenario, dds_entity_t participant) {
  const Team& team = scenario.team;
  for (const BodyLink& link : fleet_of(scenario).bodies) {
    const auto uncooperative =
        std::find_if(scenario.uncooperative.begin(), scenario.uncooperative.end(),
                     [&](const UncooperativeBody& body) { return body.body == link.body; });
    bodies_.push_back({std::string(team.name(link.body)), size(link.body.index),
                       size(team.state_offset(link.body)), link.poses, uncooperative->velocity,
                       link.robot ? nullptr : std::make_unique<PoseSubscriber>()});
    if (link.robot) {
      // The robot's own motion is used, whatever its model; another part plans it.
      bodies_.back().robot = made_end({{participant, PublishMode::off},
                                       *link.robot,
                                       team.name(link.body),
                                       team.model(link.body),
                                       fleet_of(scenario).network});
      continue;
    }
    read_seen_poses(*bodies_.back().poses, participant, link.poses, Attitude::ignored);
  }
}

void SeenBodies::measure(Nanoseconds origin, std::span<double> measured, std::span<double> stamps) noexcept {
  for (Body& body : bodies_) {
    SeenMotion seen;
    stamps[body.index] = -std::numeric_limits<double>::infinity();
    if (!(body.robot ? body.robot->look(seen) : body.poses->look(seen))) continue;
    const Vec3<double>& p = seen.motion.p;
    const Vec3<double> v = body.velocity == SeenVelocity::measured ? seen.motion.v : Vec3<double>{};
    std::copy_n(std::array{p.x, p.y, p.z, v.x, v.y, v.z}.begin(), 6, &measured[body.x]);
    stamps[body.index] = to_seconds(seen.stamp - origin);
  }
}

bool SeenBodies::are_seen(Nanoseconds now) noexcept {
  return std::all_of(bodies_.begin(), bodies_.end(), [&](const Body& body) {
    PoseSubscriber& poses = body.subscriber();
    return poses.is_fresh(now, body_old) && !poses.of_second_writer() && !poses.in_other_frames();
  });
}

void SeenBodies::examine(const Scenario& scenario, std::vector<Finding>& to) const {
  const Nanoseconds now = monotonic_now();
  for (const Body& body : bodies_) {
    FindingList found(body.name);
    const PoseSubscriber& poses = body.subscriber();
    poses.examine("the frame that is G", other_frames_than(body.from), found);
    examine_rate(scenario, body.from, poses.arrivals().figures(now, 0), found);
    for (Finding& finding : found.take()) to.push_back(std::move(finding));
  }
}

void SeenBodies::counts(std::vector<std::string>& to) const {
  for (const Body& body : bodies_) to.push_back(fmt::format("{}: {}", body.name, body.subscriber().counts()));
}

}  // namespace sightline::dds
