/// Flies a multirotor through a scenario's world so that its model can be identified, and brings it back while it does.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "sightline/analysis/identification/flown_motion.hpp"
#include "sightline/run/clock.hpp"
#include "sightline/scenario/scenario.hpp"
#include "sightline/world/disturbance.hpp"

namespace sightline {

enum class ExcitationKind {
  steps,  ///< of each input, random in height and length, 0.2 to 1 s
  chirp,  ///< of all inputs, from 0.15 to 2.5 Hz, each at another frequency
  three_two_one_one,  ///< one input after another, 0.9, 0.6, 0.3 and 0.3 s one way and the other, and the same turned over
  bang_bang,  ///< of each input all or nothing, 0.2 to 1.5 s
};
inline constexpr std::array<std::string_view, 4> excitation_names = {"steps", "chirp", "3211", "bang_bang"};

struct ExcitationOptions {
  ExcitationKind kind = ExcitationKind::steps;
  double seconds = 20.0;           ///< after `hover_seconds` of hover, 5 to 600
  std::uint64_t seed = 1;          ///< of the steps, and of the world's chance
  std::optional<double> height{};  ///< where it begins [m]; none: the scenario's, but at least least_height
  double radius = 3.0;  ///< it turns back where it would be farther from its start, level, in a second [m]
  double climb = 1.0;   ///< or farther above or below it [m], > 0

  static constexpr double least_height = 2.0, hover_seconds = 1.0;
  /// @throws std::invalid_argument naming the option, its value and its range
  void check() const;
};

/// The inputs of an excitation as parts of their limits, within [-1, 1].
class ExcitationSignal {
 public:
  explicit ExcitationSignal(const ExcitationOptions& options);
  /// At t [s] since it began; t must not fall.
  std::array<double, 4> at(double t);

 private:
  ExcitationOptions options_;
  RandomStream random_;
  std::array<double, 4> held_{}, until_{};
};

/// Excites the robot in the world of the scenario, alone: all other bodies are absent, and no event happens. A feedback
/// of the measured position leads it back towards its start; where it would be outside of radius or climb within a
/// second, it flies back and the excitation waits.
/// @throws std::invalid_argument from the options, the world, and where the world ends: "uav touched the ground at ..."
FlownMotion fly_excitation(const Scenario& scenario, AgentId robot, const ExcitationOptions& options = {});

/// The same in a world in which the robot flies already, from where it is: a robot on a link, in real time. It stays within floor,
/// ceiling and world of [safety], where that leaves 0.5 m level and 0.2 m up and down.
/// @param stop  ends it once it is true
/// @throws std::invalid_argument as above, where there is less room, where another body of the scenario is within it, and when stopped
FlownMotion fly_excitation(const Scenario& scenario, AgentId robot, const ExcitationOptions& options,
                           World& world, Clock& clock, const std::atomic<bool>& stop);

}  // namespace sightline
