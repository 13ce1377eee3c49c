/// [campaign] of a scenario: the numbers that a campaign draws for each run, and the criteria of a
/// successful run.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace sightline {

/// Distribution of a number. With probability `fraction` it is `constant`, otherwise
///
///   uniform  between values[0] and values[1]
///   normal   of mean values[0] and standard deviation values[1]
///   choice   values[i] with probability fractions[i]
struct Distribution {
  enum class Kind { uniform, normal, choice };
  Kind kind = Kind::uniform;
  std::vector<double> values = {0.0, 0.0};
  std::vector<double> fractions{};  ///< of a choice; their sum is 1
  double constant = 0.0, fraction = 0.0;
};

/// Distribution of a robot's start, relative to another body.
struct StartDraw {
  std::string agent, around;
  Distribution range;                      ///< horizontal distance to `around` [m]
  Distribution bearing;                    ///< direction of `around` from the robot's nose, to the left [rad]
  Distribution height;                     ///< of the robot above `around` [m]
  std::optional<Distribution> heading{};   ///< of the robot [rad]; none: as in the scenario
  std::optional<Distribution> velocity{};  ///< forward and sideward, each drawn [m/s]; none: as in the
                                           ///< scenario
};

/// A number of the scenario by its key, "couple[0].weight".
struct NumberDraw {
  /// Another number that depends on the drawn one: times * drawn + plus.
  struct Linked {
    std::string key;
    double times = 1.0, plus = 0.0;
  };
  std::string key;
  Distribution distribution;
  std::vector<Linked> also{};
};

/// Values of Table 1, one for each run.
struct EvasionColumns {
  std::vector<double> min_obstacle{};  ///< least distance to the obstacle [m]
  std::vector<double> min_target{};    ///< least and
  std::vector<double> max_target{};    ///< greatest distance to the target [m]
  std::vector<double> max_angle{};     ///< greatest view angle while the obstacle is present [rad]
};

/// A robot that evades an obstacle while it observes a target, and the published values.
struct EvasionPlan {
  std::string agent, target, obstacle;
  double from = 0.0;        ///< the obstacle is present from this time on [s], >= 0
  double d_obstacle = 1.0;  ///< limit of the distance to the obstacle [m], > 0
  double d_min = 0.7;       ///< limits of the distance to the target [m], > 0
  double d_max = 2.0;
  double alpha = 0.5;          ///< limit of the view angle [rad], > 0
  EvasionColumns published{};  ///< empty: none
};

struct CampaignPlan {
  std::string text{};      ///< of the scenario that has this plan
  double duration = 25.0;  ///< of each run [s]
  double view_within =
      20.0;              ///< recovered: every observer has seen its target by this time, and sees it at the
                         ///< end [s]
  double d_hard = 0.0;   ///< limit of the distance of a robot to another body, if [safety] states none [m];
                         ///< 0: not judged
  double braking = 0.6;  ///< a run must keep d_hard if this deceleration could keep it from the start [m/s^2]
  bool start_outside = false;  ///< allows drawn starts beyond a wall, as Safety::start_outside
  std::vector<StartDraw> starts{};
  std::vector<NumberDraw> draws{};
  std::optional<EvasionPlan> evasion{};  ///< reported for the first runs
};

/// Names of the numbers that are drawn for a run, in order: "uav0.range", ..., then the keys of the
/// draws.
std::vector<std::string> drawn_names(const CampaignPlan& plan);

}  // namespace sightline
