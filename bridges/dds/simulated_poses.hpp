/// Stands in for motion capture and for whoever else says where robots, targets and obstacles of a fleet are.
#pragma once

#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "bridges/dds/channel.hpp"
#include "bridges/dds/conversion.hpp"
#include "bridges/dds/robot_state.hpp"
#include "sightline/scenario/scenario.hpp"
#include "sightline/world/motion.hpp"

namespace sightline::dds {

/// Targets and obstacles move as the scenario says. Bodies on /tf are said in a frame of their own, "NAME_start", which lies in
/// G by /tf_static.
class SimulatedPoses {
 public:
  SimulatedPoses(dds_entity_t participant, const Scenario& scenario);
  ~SimulatedPoses();

  /// Moves on by a period [s], and says where all are.
  /// @param robots  in the order of the links
  void step(double period, std::span<const Motion> robots);
  /// Of the team; those of targets and obstacles are as they move.
  std::span<const double> states() const { return x_; }
  /// Those that it speaks of, a line; empty: none.
  std::string counts() const;

 private:
  struct Seen {
    std::string name;   // of the scenario
    int robot = -1;     // the link that it is; -1: none
    std::size_t x = 0;  // where the state of another body begins
    PosesFrom from;
    Motion start{};  // in G
  };
  struct Ends;

  Motion motion_of(const Seen& seen, std::span<const Motion> robots) const;
  void send(std::span<const Motion> robots);

  std::vector<Seen> seen_;
  std::vector<RobotState> models_;   // of the robots, where a body may follow one
  std::vector<std::size_t> places_;  // of their states
  std::vector<double> x_, u_;
  Motions motions_;
  double time_ = 0.0;
  std::int64_t sent_ = 0;
  std::unique_ptr<Ends> ends_;
};

}  // namespace sightline::dds
