/// The vehicles of a team, as the dynamics of its plant.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "sightline/model/state_roles.hpp"
#include "sightline/vehicle.hpp"
#include "sightline/world/rotorcraft.hpp"
#include "sightline/worlds.hpp"

namespace sightline {

/// Commands and states of a team's vehicles. A derived class moves them by advance(), in steps of
/// rotorcraft_step.
///
/// If enabled, the downwash of each vehicle moves the air around vehicles below it. It is evaluated
/// every `downwash_steps` and held in between.
///
/// show() writes the state of the vehicle's planning model, evaluated from the rigid body:
///
///   p            of the centre of mass
///   d or psi     horizontal direction of the body's x axis
///   v_f, v_s     horizontal velocity along d and to its left
///   v_x, v_y     horizontal velocity in G
///   v_z, r       upward velocity; rate of psi
///   a_f, a_s     g times the tangent of the tilt, along d and to its left
///
/// A vehicle with an IMU measures r, a_f and a_s itself, with the errors of that IMU.
class Fleet : public RobotDynamics {
 public:
  /// @throws std::invalid_argument for a vehicle out of range, for a robot that cannot be a
  /// vehicle, and for two vehicles of one robot
  /// @param plant  options of the plant that these dynamics serve: its seed, downwash and thread
  /// pool
  Fleet(const Team& team, const std::vector<RobotVehicle>& vehicles, const PlantOptions& plant = {});

  bool moves(BodyId robot) const noexcept override { return rotorcraft(robot) != nullptr; }
  void begin(BodyId robot, double t, const double* x) noexcept override;
  void steer(BodyId robot, const double* u, const Vec3<double>& acceleration) noexcept override;
  void move(double t) noexcept override;
  void show(BodyId robot, double* x) const noexcept override;
  void sense(BodyId robot, double* x) const noexcept override;

  /// The vehicle of this robot; nullptr for any other body.
  const Rotorcraft* rotorcraft(BodyId robot) const noexcept;

 protected:
  struct Craft {
    BodyId robot;
    Rotorcraft flown;
    StateRoles roles;                  ///< of the planning model
    int inputs;                        ///< number of the robot's inputs
    std::array<double, 4> commands{};  ///< the commands in force
    Vec3<double> wind{}, air{};        ///< air velocity in G, without and with downwash [m/s]
    bool steered = false;              ///< in this move(); else the vehicle rests
  };

  /// Moves the steered vehicles by this many steps.
  virtual void advance(std::int64_t steps) noexcept = 0;
  /// Steps since the start of the world; within advance(), the count at its beginning.
  std::int64_t tick() const noexcept { return tick_; }

  std::vector<Craft> crafts_;
  std::shared_ptr<ThreadPool> pool_;  ///< distributes the vehicles over threads

 private:
  static constexpr std::int64_t downwash_steps = 10;

  void blow() noexcept;

  double downwash_;
  std::vector<Jet> jets_;      // of crafts_
  std::vector<int> craft_of_;  // index into crafts_ by body, -1 for none
  std::int64_t tick_ = 0;
};

}  // namespace sightline
