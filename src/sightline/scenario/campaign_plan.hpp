/// What a campaign draws for each of its runs, and what makes a run a good one: [campaign] of a scenario.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace sightline {

/// How a number is drawn. With the probability `share` it is `exactly` one value, otherwise
///
///   uniform  between values[0] and values[1]
///   normal   of mean values[0] and standard deviation values[1]
///   choice   values[i] with the probability shares[i]
struct Distribution {
  enum class Kind { uniform, normal, choice };
  Kind kind = Kind::uniform;
  std::vector<double> values = {0.0, 0.0};
  std::vector<double> fractions{};  ///< of a choice; they sum to 1
  double constant = 0.0, fraction = 0.0;
};

/// Where a robot starts, as it sees another body.
struct StartDraw {
  std::string agent, around;
  Distribution range;                      ///< horizontal distance of `around` [m]
  Distribution bearing;                    ///< of `around` off the robot's nose, to the left [rad]
  Distribution height;                     ///< of the robot above it [m]
  std::optional<Distribution> heading{};   ///< of the robot [rad]; none: as the scenario has it
  std::optional<Distribution> velocity{};  ///< forward and sideward, each drawn [m/s]; none: as it has it
};

/// A number of the scenario by its key, "couple[0].weight".
struct NumberDraw {
  /// Another number that follows from the drawn one: times * drawn + plus.
  struct Linked {
    std::string key;
    double times = 1.0, plus = 0.0;
  };
  std::string key;
  Distribution distribution;
  std::vector<Linked> also{};
};

/// Numbers of Table 1, one for each run.
struct EvasionColumns {
  std::vector<double> min_obstacle{};  ///< least distance to the obstacle [m]
  std::vector<double> min_target{};    ///< least and
  std::vector<double> max_target{};    ///< greatest distance to the target [m]
  std::vector<double> max_angle{};     ///< greatest view angle while the obstacle is there [rad]
};

/// Which robot evades which obstacle while it observes a target, and what was published of it.
struct EvasionPlan {
  std::string agent, target, obstacle;
  double from = 0.0;        ///< the obstacle is there from here on [s], >= 0
  double d_obstacle = 1.0;  ///< limit of the distance to the obstacle [m], > 0
  double d_min = 0.7;       ///< limits of the distance to the target [m], > 0
  double d_max = 2.0;
  double alpha = 0.5;          ///< limit of the view angle [rad], > 0
  EvasionColumns published{};  ///< empty: nothing was
};

struct CampaignPlan {
  std::string text{};      ///< of the scenario whose plan it is
  double duration = 25.0;  ///< of each run [s]
  double view_within =
      20.0;              ///< recovered: every observer has seen its target by then, and does at the end [s]
  double d_hard = 0.0;   ///< no robot may come nearer to another body, where [safety] asks for nothing [m];
                         ///< 0: that is not judged
  double braking = 0.6;  ///< a start from which this deceleration keeps d_hard must keep it [m/s^2]
  bool start_outside = false;  ///< starts that are drawn beyond a wall are meant, as Safety::start_outside
  std::vector<StartDraw> starts{};
  std::vector<NumberDraw> draws{};
  std::optional<EvasionPlan> evasion{};  ///< shown of the first runs
};

/// The numbers that are drawn for a run, in their order: "uav0.range", ..., then the keys of the draws.
std::vector<std::string> drawn_names(const CampaignPlan& plan);

}  // namespace sightline
