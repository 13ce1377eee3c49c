/// State of links and solver as ROS 2 diagnostics.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "bridges/dds/topics/flight_publisher.hpp"

namespace sightline::dds {

/// Values as in diagnostic_msgs/DiagnosticStatus.
enum class Health : std::uint8_t { ok, warn, error, stale };

struct Diagnosis {
  Health level = Health::ok;
  std::string name{}, message{}, hardware{};
  std::vector<std::pair<std::string, std::string>> values{};
};

/// Loop statistics since the last diagnosis.
struct LoopShown {
  bool begun = false;
  SolverRecord last{};
  double solve_us_most = 0.0, update_us_most = 0.0;
  std::int64_t periods = 0, missed = 0;
};

/// @param name    of the robot
/// @param age     of the newest pose [s]
/// @param fresh   an older pose gives a warning [s]
/// @param level   the supervisor's fallback level for this robot
/// @param counts  message counts of the link, as text
Diagnosis diagnose_link(std::string_view name, const RobotShown& shown, double age, double fresh,
                        FallbackLevel level, const std::string& counts);
Diagnosis diagnose_solver(std::string_view solver, const LoopShown& loop);

}  // namespace sightline::dds
