/// Search of a robot that is localized by vision and does not observe its target.
///
///   phase   condition                                     command
///   none    accepted sighting within `predict`            the plan
///   stand   no estimate, or sightings contradict it,      no motion: the body stays in view until
///           but a body is in view; also at the start      the filter starts or restarts
///   turn    as `stand`, with no body in view              no motion, a turn of `rate`, at first
///                                                         back against the last turn
///   sweep   no accepted sighting for longer than          up to `back_off` farther away, facing the
///           `predict`                                     target's estimate; from `sweep_from` on
///                                                         over 2 standard deviations to either side
///   round   as `sweep`, after `turn_after` of sweeping    the same place, a turn of `rate`
///
/// The target's motion remains known from its broadcasts. The search runs after the supervisor: a
/// robot on level `hold` turns in place, and one that lands is not changed. The barrier runs after
/// the search and uses the true estimate.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string_view>
#include <vector>

#include "sightline/base/parameter.hpp"
#include "sightline/ocp/active_team.hpp"
#include "sightline/safety/brake.hpp"
#include "sightline/safety/ladder.hpp"

namespace sightline {

struct SearchOptions {
  static constexpr std::string_view name = "search";

  double predict = 3.0;
  double back_off = 0.7;
  double sweep_from = 0.2;
  double rate = 1.0;
  double turn_after = 8.0;

  static constexpr auto parameters() {
    using O = SearchOptions;
    return std::tuple{
        parameter("predict", &O::predict, "s", above_zero,
                  "without a view that the plan goes on, by the estimate and the target's broadcasts"),
        parameter("back_off", &O::back_off, "m", from_zero,
                  "farther from the target than it saw it, at most, where that is nearer than five standard "
                  "deviations of its "
                  "position"),
        parameter("sweep_from", &O::sweep_from, "rad", above_zero,
                  "standard deviation of the target's direction from which on the view sweeps"),
        parameter("rate", &O::rate, "rad/s", Bounds{0.05, 10.0, "0.05 to 10"}, "of a search's turn"),
        parameter("turn_after", &O::turn_after, "s", above_zero, "of sweeping; then it turns right round")};
  }
  bool operator==(const SearchOptions&) const = default;
  /// @throws std::invalid_argument naming a number out of its range
  void check() const { check_parameters(*this); }
};

/// State of one robot's view.
struct View {
  static constexpr double never = -std::numeric_limits<double>::infinity();

  BodyId robot{}, target{};     ///< `target` is the body that it sighted last
  bool localized = false;       ///< its pose has an estimate
  double position_sigma = 0.0;  ///< standard deviation of its position [m]
  double bearing_sigma =
      0.0;                  ///< standard deviation of the target's direction, as estimated by the robot [rad]
  double accepted = never;  ///< stamp of the last sighting that its filter accepted [s]
  double sighted = never;   ///< stamp of the last sighting, accepted or not [s]
};

enum class SearchPhase : std::uint8_t { none, stand, turn, sweep, round };

/// Checks what the constructor of a Search checks.
void validate(const Team& team, std::span<const BodyId> robots, const SearchOptions& options);

/// Searches of all robots that are localized by vision. Throws and allocates only during
/// construction; never locks or prints.
class Search {
 public:
  /// Sightings that the filter refuses for longer than this are no outliers [s].
  static constexpr double contradicted_after = 0.2;
  /// For this time after the last sighting the target may still be in view [s].
  static constexpr double in_view = 0.3;
  static constexpr double fastest = 0.6;   ///< greatest speed towards the search position [m/s]
  static constexpr double approach = 1.0;  ///< time constant of this motion [s]

  /// @param robots  robots that are localized by vision
  /// @throws std::invalid_argument for options out of their range, and for a robot that cannot turn
  ///         in place
  Search(const Team& team, std::span<const BodyId> robots, const SearchOptions& options);
  Search(const Search&) = delete;  // its robots point into its team
  Search& operator=(const Search&) = delete;

  /// Takes the robots' views at t [s], in any order.
  /// @param x  estimated states of all bodies (nx)
  void look(double t, std::span<const View> views, std::span<const double> x) noexcept;
  /// Replaces the inputs of robots that search.
  /// @param x  states at which the commands take effect (nx)
  /// @param levels  of all bodies
  /// @param added  offset to the inputs (nu); the limits hold for the sum
  void command(double t, std::span<const double> x, std::span<const FallbackLevel> levels,
               std::span<const double> added, std::span<double> u) noexcept;
  /// Takes presence and limits from another membership.
  void follow(const Membership& now) noexcept;

  int robots() const noexcept { return static_cast<int>(robots_.size()); }
  BodyId robot(int i) const noexcept { return robots_[static_cast<std::size_t>(i)].body; }
  /// Phase of the i-th robot at the last look().
  SearchPhase phase(int i) const noexcept { return robots_[static_cast<std::size_t>(i)].phase; }

 private:
  struct Robot {
    BodyId body;
    std::size_t x, u, nx, nu;  // offsets and lengths
    Brake brake;
    const InputLimits* limits;
    std::vector<double> u_min, u_max;
    View view{};
    SearchPhase phase = SearchPhase::none;
    double since = View::never;                // time of the first view [s]
    double begun = 0.0;                        // start of the phase, or of the sweep to either side [s]
    double from = 1.0;                         // sense of the turn, 1 or -1
    double time = View::never, heading = 0.0;  // at the last look() [s], [rad]
    double turned = 0.0;                       // recent turn, to the left [rad]
    double distance_seen = 0.0;                // to the target at the last accepted sighting [m]
    Vec3<double> away{};                       // unit vector from the target to the search position
    bool contradicted = false, is_there = true;
  };
  static void follow_turn(Robot& robot, double t, double heading) noexcept;
  SearchPhase next(const Robot& robot, double t) const noexcept;
  Sight<double> sight(BodyId body, std::span<const double> x) const noexcept;
  double turn_rate(const Robot& robot, double t, const Sight<double>& own,
                   const Vec3<double>& target) const noexcept;

  Team team_;
  SearchOptions options_;
  std::vector<Robot> robots_;
  std::vector<double> u_rest_;
};

}  // namespace sightline
