/// A solver as the loop sees it: which bodies of the world its team means, and what it is given. And robots that
/// no solver steers.
#pragma once

#include <cstddef>
#include <vector>

#include "sightline/run/valid_states.hpp"
#include "sightline/safety/brake.hpp"
#include "sightline/solver/solver.hpp"

namespace sightline {

/// Bodies are matched by name: what the solver's team calls a robot is a robot of the world, and what it calls an
/// obstacle may be one of the world's obstacles, or a robot that it does not steer and sees as position and
/// velocity, with its heading where the obstacle has one.
struct Controller {
  /// A body as the world and as the solver's Ocp know it.
  struct Member {
    BodyId body;         // of the world
    std::size_t nx, nu;  // copied as they are; nx = 0: a robot seen as a Body or PosedBody
    std::size_t ocp_nx;  // of the solver's state
    std::size_t world_x, world_u;
    std::size_t ocp_x, ocp_u;
    const InputLimits* limits;  // nullptr: not steered by this solver
  };

  Solver* solver;
  std::vector<Member> members{};
  std::vector<double> states{};                  ///< what the solver is given (its nx)
  std::vector<double> plan{};                    ///< inputs of a plan that is late or goes on (its nu)
  std::vector<double> before{}, added{};         ///< AppliedInputs (its nu)
  std::vector<Vec2<double>> lean{};              ///< the same (its bodies)
  std::vector<double> u_ref{};                   ///< the same (its nu)
  std::vector<ViewUncertainty> uncertainties{};  ///< of its bodies
  Status status{};
  int left_out = 0;                          ///< pairs of swarms, as told last; 0: none are
  bool at_work = false;                      ///< on a late update
  bool answered = false;                     ///< in this period
  double requested_at = 0.0, done_at = 0.0;  ///< begin of the last update, end of a late one [s]

  /// @param number  for the refusals
  /// @throws std::invalid_argument where the world has not what the solver's team knows, or as another model
  Controller(const Team& world, Solver& given, std::size_t number);

  /// What the solver is given, from the states and inputs of the world. A body that is not valid has no numbers, so that the
  /// solver refuses the state and goes on with its last plan.
  void gather(const Team& world, const ValidStates& x, std::span<const double> u) noexcept;
  /// Tells it the applied inputs of the world.
  void set_applied(const AppliedInputs& of_world) noexcept;
  /// Tells it how sure the robots of the world are of what they look at.
  void set_view_uncertainty(std::span<const ViewUncertainty> of_world) noexcept;
};

/// A robot that no solver steers: it brakes and stays, or sinks to the ground. Its command moves by a little each
/// period, so that those that see it fly by need not jump either.
struct UncontrolledRobot {
  BodyId body;
  std::size_t x, u, nx, nu;  // offsets and lengths in the world
  Model model;
  InputLimits limits;
  Brake brake;
  std::vector<double> wanted;
  double sink_speed;  ///< [m/s]

  static constexpr double landing_speed = 0.3, brake_time = 0.4, ground = 0.0;
  static constexpr double change_rate = 1.25;  ///< of an input at most, of the half of its range [1/s]
  double most_change;                          // of an input a period, of the half of its range

  /// @param period  between two commands [s]
  UncontrolledRobot(const Team& world, BodyId robot, bool lands, double period);

  /// Writes its input into those of the world; the limits are work space of nu at least.
  /// @param added  to the inputs of the world afterwards: limits hold for the sum
  void steer(double t, const ValidStates& estimate, std::span<const double> added, std::span<double> u_min,
             std::span<double> u_max, std::span<double> u_world) noexcept;
};

}  // namespace sightline
