/// The team's bodies in MuJoCo: vehicles that it moves, points that follow the plant, and who touches whom.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sightline/mujoco.hpp"
#include "worlds/mujoco/engine.hpp"

namespace sightline {

class MujocoWorld::Bodies final : public Fleet {
 public:
  /// Contact of two bodies, or of a vehicle and what is no body of the team (b: index -1).
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
  /// Where a body that is no vehicle is from now on, and its velocity in G.
  void place(BodyId body, const Vec3<double>& p, const Vec3<double>& v) noexcept;
  void set_there(BodyId body, bool there) noexcept;
  /// @throws std::invalid_argument for a vehicle that stands in the ground or in what else there is
  void check_start(const Team& team);

  const std::optional<Met>& met() const noexcept { return met_; }
  bool failed() const noexcept { return failed_; }
  /// Why MuJoCo could not go on.
  std::string failure() const;

 private:
  struct Body {
    int id = 0;             // of MuJoCo
    int q = 0, dof = 0;     // of a vehicle's free joint
    int mocap = -1;         // of any other
    Vec3<double> p{}, v{};  // of such, when it was placed
    bool fresh = true;      // it has come since contacts were last looked at
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
  std::vector<int> owner_;                 // body of each geom, -1 for what is none of the team
  std::vector<std::pair<int, int>> bits_;  // contype and conaffinity of each geom
  std::vector<Overlap> overlaps_;          // who touched at the start or on joining, and still does
  std::optional<Met> met_;
  std::int64_t placed_at_ = 0;
  bool failed_ = false;
  std::int64_t failed_at_ = 0;
  std::array<char, 512> failure_{};
};

}  // namespace sightline
