/// Interface between the loop and a solver: the mapping of bodies and inputs; and robots without a
/// solver.
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "sightline/loop.hpp"

namespace sightline {

/// A solver and its view of the world. Bodies are matched by name. A robot of the solver's team is
/// a robot of the world. An obstacle of the solver's team is an obstacle of the world, or a robot
/// that this solver does not steer. The solver receives such a robot as position and velocity, and
/// with its heading if the obstacle has one.
struct Controller {
  /// A body in the world and in the solver's Ocp.
  struct Member {
    BodyId body;         // in the world
    std::size_t nx, nu;  // numbers that are copied; nx = 0: a robot converted to a Body or PosedBody
    std::size_t ocp_nx;  // length in the solver's state
    std::size_t world_x, world_u;
    std::size_t ocp_x, ocp_u;
    const InputLimits* limits;  // nullptr: not steered by this solver
  };

  Solver* solver;
  std::vector<Member> members{};
  std::vector<double> states{};                  ///< input of the solver (its nx)
  std::vector<double> plan{};                    ///< previous plan, while there is no new one (its nu)
  std::vector<double> before{}, added{};         ///< AppliedInputs (its nu)
  std::vector<Vec2<double>> lean{};              ///< AppliedInputs::lean (its bodies)
  std::vector<double> u_ref{};                   ///< AppliedInputs::u_ref (its nu)
  std::vector<ViewUncertainty> uncertainties{};  ///< of its bodies
  Status status{};
  int left_out = 0;                          ///< pairs of swarms without room, as last reported; 0: none
  bool at_work = false;                      ///< a late update is in progress
  bool answered = false;                     ///< the solver ran in this period
  double requested_at = 0.0, done_at = 0.0;  ///< start of the last update, end of a late one [s]

  /// @param number  index of the controller, for error messages
  /// @throws std::invalid_argument if the world lacks a body of the solver's team, or has it with
  ///         another model
  Controller(const Team& world, Solver& given, std::size_t number);

  /// Collects the solver's state from the states and inputs of the world. The state of an invalid
  /// body is NaN, so the solver refuses it and keeps its last plan.
  void gather(const Team& world, const ValidStates& x, std::span<const double> u) noexcept;
  /// Passes the applied inputs of the world to the solver.
  void set_applied(const AppliedInputs& of_world) noexcept;
  /// Passes the view uncertainties of the world's bodies to the solver.
  void set_view_uncertainty(std::span<const ViewUncertainty> of_world) noexcept;
};

/// A robot that no solver steers: it brakes and stays, or sinks to the ground. Its command changes
/// slowly, so that the plans of robots that observe it need not jump.
struct UncontrolledRobot {
  BodyId body;
  std::size_t x, u, nx, nu;  // offsets and lengths in the world
  Model model;
  InputLimits limits;
  Brake brake;
  std::vector<double> wanted;
  double sink_speed;  ///< [m/s]

  static constexpr double landing_speed = 0.3, brake_time = 0.4, ground = 0.0;
  static constexpr double change_rate = 1.25;  ///< greatest change of an input, in half ranges [1/s]
  double most_change;                          // per period, in half ranges

  /// @param period  between two commands [s]
  UncontrolledRobot(const Team& world, BodyId robot, bool lands, double period);

  /// Writes the robot's input into that of the world. The limits are work space of at least nu
  /// numbers.
  /// @param added  offset to the inputs of the world (nu); the limits hold for the sum
  void steer(double t, const ValidStates& estimate, std::span<const double> added, std::span<double> u_min,
             std::span<double> u_max, std::span<double> u_world) noexcept;
};

/// The solver, the robots without a solver, and the membership of one team.
struct Phase {
  std::unique_ptr<Solver> solver;
  TeamPlanner* planner = nullptr;  // part of the solver
  std::optional<Controller> controller;
  std::vector<UncontrolledRobot> uncontrolled{};
  Membership membership{};
};

}  // namespace sightline
