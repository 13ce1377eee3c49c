/// Excites a multirotor in a scenario's world to identify its model, and keeps it near its start.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "sightline/analysis/identification/flown_motion.hpp"
#include "sightline/loop.hpp"
#include "sightline/scenario.hpp"
#include "sightline/world.hpp"

namespace sightline {

enum class ExcitationKind {
  steps,              ///< of each input, random in height and length, 0.2 to 1 s
  chirp,              ///< of all inputs, 0.15 to 2.5 Hz, each at another frequency
  three_two_one_one,  ///< one input after another: 0.9, 0.6, 0.3 and 0.3 s of alternating sign,
                      ///< then all of it with opposite sign
  bang_bang,          ///< each input at plus or minus its limit, 0.2 to 1.5 s
};
inline constexpr std::array<std::string_view, 4> excitation_names = {"steps", "chirp", "3211", "bang_bang"};

struct ExcitationOptions {
  ExcitationKind kind = ExcitationKind::steps;
  double seconds = 20.0;           ///< after `hover_seconds` of hover [s], 5 to 600
  std::uint64_t seed = 1;          ///< of the steps and of the world's random streams
  std::optional<double> height{};  ///< initial height [m]; none: the scenario's, but at least least_height
  double radius = 3.0;  ///< returns if the level distance to its start, predicted 1 s ahead, exceeds this [m]
  double climb = 1.0;   ///< the same for the height above or below the start, predicted 0.5 s ahead [m], > 0

  static constexpr double least_height = 2.0, hover_seconds = 1.0;
  /// @throws std::invalid_argument naming the option, its value and its range
  void check() const;
};

/// Inputs of an excitation as fractions of their limits, within [-1, 1].
class ExcitationSignal {
 public:
  explicit ExcitationSignal(const ExcitationOptions& options);
  /// Inputs at the time t [s] since the excitation began; t must not decrease.
  std::array<double, 4> at(double t);

 private:
  ExcitationOptions options_;
  RandomStream random_;
  std::array<double, 4> held_{}, until_{};
};

/// Excites the robot alone in the world of the scenario: all other bodies are absent, and no event
/// happens. Feedback of the measured position moves it back towards its start. If the predicted
/// position exceeds `radius` or `climb`, the robot flies back and the excitation waits.
/// @throws std::invalid_argument from the options and the world, and if the world ends: "uav
///   touched the ground at ..."
FlownMotion fly_excitation(const Scenario& scenario, AgentId robot, const ExcitationOptions& options = {});

/// The same for a robot that already flies in `world`, from its present position: a robot on a
/// link, in real time. It stays within floor, ceiling and world of [safety]; this requires room of
/// 0.75 m level and 0.3 m up and down.
/// @param stop  ends the excitation once it is true
/// @throws std::invalid_argument as above, if there is less room, if another body of the scenario
///   is within it, and if stopped
FlownMotion fly_excitation(const Scenario& scenario, AgentId robot, const ExcitationOptions& options,
                           World& world, Clock& clock, const std::atomic<bool>& stop);

}  // namespace sightline
