/// The team's bodies in MuJoCo: vehicles that it moves, points that follow the plant, and contacts
/// between bodies.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sightline/mujoco.hpp"
#include "sightline/world/fleet.hpp"
#include "worlds/mujoco/engine.hpp"

namespace sightline {

class MujocoWorld::Bodies final : public Fleet {
 public:
  /// Contact of two bodies, or of a vehicle with a geom outside the team (b: index -1).
  struct Met {
    BodyId a{}, b{};
    std::int64_t tick = 0;
    double speed = 0.0;  ///< of the vehicle [m/s]
    std::string_view surface{};
  };

  /// @throws std::invalid_argument as MujocoWorld
  Bodies(const Team& team, const std::vector<RobotVehicle>& vehicles, const PlantOptions& plant,
         const std::optional<ModelFile>& surroundings);

  void begin(BodyId robot, double t, const double* x) noexcept override;
  /// Sets the present position and velocity in G of a body that is no vehicle.
  void place(BodyId body, const Vec3<double>& p, const Vec3<double>& v) noexcept;
  void set_there(BodyId body, bool there) noexcept;
  /// @throws std::invalid_argument for a vehicle that starts within the ground or the surroundings
  void check_start(const Team& team);

  const std::optional<Met>& met() const noexcept { return met_; }
  bool failed() const noexcept { return failed_; }
  /// The reason why MuJoCo could not continue.
  std::string failure() const;

 private:
  struct Body {
    int id = 0;             // MuJoCo's body id
    int q = 0, dof = 0;     // of a vehicle's free joint
    int mocap = -1;         // index of any other body
    Vec3<double> p{}, v{};  // of such a body when placed
    bool fresh = true;      // joined since the last check of contacts
  };
  struct Overlap {
    int a, b;
    bool seen;
  };

  void advance(std::int64_t steps) noexcept override;
  void write(const Craft& craft) noexcept;
  void read(Craft& craft) noexcept;
  void look_at_contacts(std::int64_t tick) noexcept;
  bool excused(int a, int b) noexcept;
  void fail(const char* why, std::int64_t tick) noexcept;
  std::string_view surface(int geom) const noexcept;

  mujoco::ModelPointer model_;
  mujoco::DataPointer data_;
  std::vector<Body> bodies_;
  std::vector<int> owner_;                 // body of each geom, -1 if not of the team
  std::vector<std::pair<int, int>> bits_;  // contype and conaffinity of each geom
  std::vector<Overlap> overlaps_;          // pairs that touched at the start or on joining, and still do
  std::optional<Met> met_;
  std::int64_t placed_at_ = 0;
  bool failed_ = false;
  std::int64_t failed_at_ = 0;
  std::array<char, 512> failure_{};
};

}  // namespace sightline
