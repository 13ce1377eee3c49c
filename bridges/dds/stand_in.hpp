/// What stands in for the vehicles of a fleet, at the far ends of their links.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "bridges/dds/domain.hpp"
#include "sightline/scenario/bridge.hpp"

namespace sightline::dds {

/// One robot of its own: it moves, and speaks as its link's kind does.
class StandIn {
 public:
  static constexpr double period = 0.01;  // [s]

  virtual ~StandIn() = default;
  /// Moves on by a period, and says what it says at that number of periods.
  virtual void step(std::int64_t number) = 0;
  /// What it was told and did, in words.
  virtual std::string counts() const = 0;
};

/// @throws std::invalid_argument for a kind that nothing stands in for
std::unique_ptr<StandIn> made_stand_in(dds_entity_t participant, const Scenario& scenario, const Link& link);

/// Those of all links, stepped by one thread.
class DdsStandIns final : public StandIns {
 public:
  DdsStandIns(const Scenario& scenario, std::shared_ptr<Domain> domain);

  void run(double duration, const Interrupts& interrupts, const TellPerson& tell) override;
  std::vector<std::string> counts() const override;
  StandIn& of(std::size_t robot) { return *stand_ins_[robot]; }

 private:
  std::shared_ptr<Domain> domain_;
  std::vector<std::string> names_;
  std::vector<std::unique_ptr<StandIn>> stand_ins_;
};

}  // namespace sightline::dds
