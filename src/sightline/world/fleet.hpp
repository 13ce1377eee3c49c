/// The vehicles of a team, as the dynamics of its plant.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sightline/world/plant.hpp"
#include "sightline/world/rotorcraft.hpp"
#include "sightline/world/vehicle.hpp"

namespace sightline {

/// What the vehicles of a team are told, and what they show. How they move in steps of rotorcraft_step, a world says by advance().
///
/// What is shown of a vehicle is the state of its planning model, as the rigid body has it:
///
///   p            of the centre of mass
///   d or psi     of the body's x axis, seen from above
///   v_f, v_s     velocity along d and to its left, level;   v_x, v_y   in G;   v_z   upward;   r   rate of psi
class Fleet : public RobotDynamics {
 public:
  /// @throws std::invalid_argument for a vehicle that cannot be, of a robot that cannot be one, or twice of one robot
  Fleet(const Team& team, const std::vector<RobotVehicle>& vehicles);

  bool moves(BodyId robot) const noexcept override { return rotorcraft(robot) != nullptr; }
  void begin(BodyId robot, double t, const double* x) noexcept override;
  void steer(BodyId robot, const double* u, const Vec3<double>& acceleration) noexcept override;
  void move(double t) noexcept override;
  void show(BodyId robot, double* x) const noexcept override;

  /// The vehicle that is that robot; none for any other body.
  const Rotorcraft* rotorcraft(BodyId robot) const noexcept;

 protected:
  struct Craft {
    BodyId robot;
    Rotorcraft flown;
    std::vector<std::size_t> shown;    ///< of each state, which number of those that a vehicle shows
    int inputs;                        ///< of the robot
    std::array<double, 4> commands{};  ///< those in force
    Vec3<double> air{};                ///< its velocity in G [m/s]
    bool steered = false;              ///< in this move; else it rests
  };

  /// Moves the vehicles that are steered by so many steps.
  virtual void advance(std::int64_t steps) noexcept = 0;
  /// Steps since the start of the world; of a move that is under way, at its beginning.
  std::int64_t tick() const noexcept { return tick_; }

  std::vector<Craft> crafts_;

 private:
  std::vector<int> craft_of_;  // by body, -1 for none
  std::int64_t tick_ = 0;
};

}  // namespace sightline
