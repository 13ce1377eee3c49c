/// What a robot does that is localized by view and does not see what it observes.
///
///   phase   while                                                what is applied
///   none    it is seen, or was less than `predict` ago           the plan
///   stand   there is no estimate, or sightings contradict it,    no motion: what it sees stays in view until the
///           but something is in view; at the start               filter begins, or begins anew
///   turn    the same, and nothing is in view                     no motion, a turn of `rate`, at first back from
///                                                                where it had turned
///   sweep   not seen for longer than `predict`                   up to `back_off` farther from it, looking where it
///                                                                should be, from `sweep_from` on over two standard
///                                                                deviations to either side
///   round   ... and swept for `turn_after`                       the same place, a turn of `rate`
///
/// The way of the target is known meanwhile: it tells it. The search stands behind the supervisor: a robot that holds
/// turns where it is, and one that lands is left alone. The barrier comes after it and sees the true estimate.
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

/// What is known of one robot's view.
struct View {
  static constexpr double never = -std::numeric_limits<double>::infinity();

  BodyId robot{}, target{};     ///< the target is the one that it saw last
  bool localized = false;       ///< there is an estimate of its pose
  double position_sigma = 0.0;  ///< standard deviation of its position [m]
  double bearing_sigma =
      0.0;  ///< standard deviation of the target's direction, as the robot takes it to be [rad]
  double accepted = never;  ///< stamp of the last sighting that its filter believed [s]
  double sighted = never;   ///< stamp of the last sighting, whatever became of it [s]
};

enum class SearchPhase : std::uint8_t { none, stand, turn, sweep, round };

/// Nothing throws, allocates, locks or prints once it is made.
class Search {
 public:
  /// Sightings that were refused for so long are no outliers [s].
  static constexpr double contradicted_after = 0.2;
  /// After the last sighting the target may still be in view [s].
  static constexpr double in_view = 0.3;
  static constexpr double fastest = 0.6;   ///< on the way to where it looks from [m/s]
  static constexpr double approach = 1.0;  ///< time constant of that way [s]

  /// @param robots  those that are localized by view
  /// @throws std::invalid_argument for options out of their range, and for a robot that cannot turn where it stands
  Search(const Team& team, std::span<const BodyId> robots, const SearchOptions& options);
  Search(const Search&) = delete;  // its robots point into its team
  Search& operator=(const Search&) = delete;

  /// The robots' views at t [s], in any order; x are the states of all bodies, as believed (nx).
  void look(double t, std::span<const View> views, std::span<const double> x) noexcept;
  /// Puts in place of the robots' inputs those of the search, where they search.
  /// @param x           states that the commands meet (nx)
  /// @param levels      of all bodies
  /// @param added       to the inputs afterwards (nu): limits hold for the sum
  void command(double t, std::span<const double> x, std::span<const FallbackLevel> levels,
               std::span<const double> added, std::span<double> u) noexcept;
  /// Who is there, and within which limits.
  void follow(const Membership& now) noexcept;

  int robots() const noexcept { return static_cast<int>(robots_.size()); }
  BodyId robot(int i) const noexcept { return robots_[static_cast<std::size_t>(i)].body; }
  /// Of the i-th robot, at the last look().
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
    double since = View::never;  // it is looked at [s]
    double begun = 0.0;  // time at which it began to sweep over more than where the target should be [s]
    double from = 1.0;   // sense of the turn, 1 or -1
    double time = View::never, heading = 0.0;  // of the last look [s], [rad]
    double turned = 0.0;                       // lately, to the left [rad]
    double distance_seen = 0.0;                // at the last one that was believed [m]
    Vec3<double> away{};                       // from the target to where it looks from, of length 1
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
