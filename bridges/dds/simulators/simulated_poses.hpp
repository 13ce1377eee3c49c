/// Simulator of motion capture and other external pose sources for robots, targets and obstacles.
#pragma once

#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bridges/dds/links/robot_state.hpp"
#include "bridges/dds/topics/channel.hpp"
#include "bridges/dds/topics/conversion.hpp"
#include "sightline/scenario.hpp"
#include "sightline/world.hpp"

namespace sightline::dds {

/// Targets and obstacles move as in the scenario. Bodies on /tf are published in their own frame
/// "NAME_start", which /tf_static places in G.
class SimulatedPoses {
 public:
  SimulatedPoses(dds_entity_t participant, const Scenario& scenario);
  ~SimulatedPoses();

  /// Advances by a period [s] and publishes all poses.
  /// @param robots  in link order
  void step(double period, std::span<const Motion> robots);
  /// States of the team; those of targets and obstacles are current.
  std::span<const double> states() const { return x_; }
  /// Published bodies, one line; empty: none.
  std::string counts() const;

 private:
  struct Seen {
    std::string name;   // name in the scenario
    int robot = -1;     // link index; -1: not a robot
    std::size_t x = 0;  // state offset of a body other than a robot
    PosesFrom from;
    Motion start{};  // in G
  };
  struct Ends;

  Motion motion_of(const Seen& seen, std::span<const Motion> robots) const;
  void send(std::span<const Motion> robots);

  std::vector<Seen> seen_;
  std::vector<RobotState> models_;   // of the robots, because a body may follow one
  std::vector<std::size_t> places_;  // state offsets of the robots
  std::vector<double> x_, u_;
  Motions motions_;
  double time_ = 0.0;
  std::int64_t sent_ = 0;
  std::unique_ptr<Ends> ends_;
};

}  // namespace sightline::dds
