/// The vehicles of a team, as the dynamics of its plant.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "sightline/world/plant.hpp"
#include "sightline/world/rotorcraft.hpp"
#include "sightline/world/vehicle.hpp"

namespace sightline {

/// What the vehicles of a team are told, and what they show. How they move in steps of rotorcraft_step, a world says by advance().
///
/// The vehicles' downwash, where there is one, moves the air around those below: it is found anew every `downwash_steps`, and held.
///
/// What is shown of a vehicle is the state of its planning model, as the rigid body has it:
///
///   p            of the centre of mass
///   d or psi     of the body's x axis, seen from above
///   v_f, v_s     velocity along d and to its left, level;   v_x, v_y   in G;   v_z   upward;   r   rate of psi
///   a_f, a_s     g times the tangent of the tilt, along d and to its left
///
/// Of these a vehicle with an IMU measures r, a_f and a_s itself, with the errors of that.
class Fleet : public RobotDynamics {
 public:
  /// @throws std::invalid_argument for a vehicle that cannot be, of a robot that cannot be one, or twice of one robot
  /// @param plant  that it is the dynamics of: its seed, its downwash and its crew
  Fleet(const Team& team, const std::vector<RobotVehicle>& vehicles, const PlantOptions& plant = {});

  bool moves(BodyId robot) const noexcept override { return rotorcraft(robot) != nullptr; }
  void begin(BodyId robot, double t, const double* x) noexcept override;
  void steer(BodyId robot, const double* u, const Vec3<double>& acceleration) noexcept override;
  void move(double t) noexcept override;
  void show(BodyId robot, double* x) const noexcept override;
  void sense(BodyId robot, double* x) const noexcept override;

  /// The vehicle that is that robot; none for any other body.
  const Rotorcraft* rotorcraft(BodyId robot) const noexcept;

 protected:
  struct Craft {
    BodyId robot;
    Rotorcraft flown;
    std::vector<std::size_t> shown;    ///< of each state, which number of those that a vehicle shows
    int inputs;                        ///< of the robot
    std::array<double, 4> commands{};  ///< those in force
    Vec3<double> wind{}, air{};        ///< velocity in G of the air, without and with downwash [m/s]
    bool steered = false;              ///< in this move; else it rests
  };

  /// Moves the vehicles that are steered by so many steps.
  virtual void advance(std::int64_t steps) noexcept = 0;
  /// Steps since the start of the world; of an advance() that is under way, at its beginning.
  std::int64_t tick() const noexcept { return tick_; }

  std::vector<Craft> crafts_;
  std::shared_ptr<ThreadPool> pool_;  ///< shares the vehicles

 private:
  static constexpr std::int64_t downwash_steps = 10;

  void blow() noexcept;

  double downwash_;
  std::vector<Jet> jets_;      // of the crafts
  std::vector<int> craft_of_;  // by body, -1 for none
  std::int64_t tick_ = 0;
};

}  // namespace sightline
