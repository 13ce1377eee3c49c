/// Simulated worlds: models, vehicles, cameras, telemetry.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sightline/base.hpp"
#include "sightline/events.hpp"
#include "sightline/sensors.hpp"
#include "sightline/solvers.hpp"
#include "sightline/vehicle.hpp"
#include "sightline/world.hpp"

namespace sightline {

// A fault of a controller that a scenario injects: updates that take too long.

/// Delays the controller: an update that begins in from <= t < until takes `delay` to finish. Until
/// then the previous plan stays in force and no other update begins.
struct LatePlan {
  double from = 0.0;
  double until = std::numeric_limits<double>::infinity();
  double delay = 0.1;  ///< [s], in [0, 10]

  /// @throws std::invalid_argument naming the field, its value and its range
  void check() const;
  /// Whether an update that begins at t is late.
  bool strikes(double t) const noexcept;
};

// The plant of the simulated world: the continuous models of all bodies, with disturbances.

/// Dynamics that replace the models of some robots of a plant: rigid bodies with rotors, or another
/// simulator. Nothing here allocates, locks or throws.
///
/// A step: steer() for each robot that is present, move() once for all, show() for each.
class RobotDynamics {
 public:
  virtual ~RobotDynamics() = default;
  /// Whether these dynamics move this robot; constant over time.
  virtual bool moves(BodyId robot) const noexcept = 0;
  /// From t [s] on the robot is in the state x of its model: at the start, and whenever it joins
  /// again.
  virtual void begin(BodyId robot, double t, const double* x) noexcept = 0;
  /// Sets the robot's inputs u and the acceleration in G [m/s^2] that wind, gusts and wakes give
  /// its model. Both are held over the next move().
  virtual void steer(BodyId robot, const double* u, const Vec3<double>& acceleration) noexcept = 0;
  /// Moves the steered robots on to t [s]; the others rest.
  virtual void move(double t) noexcept = 0;
  /// Writes the state x of the robot's model.
  virtual void show(BodyId robot, double* x) const noexcept = 0;
  /// Replaces the entries of the true state x that the robot measures itself, with their errors.
  virtual void sense(BodyId /*robot*/, double* /*x*/) const noexcept {}
};

struct PlantOptions {
  std::uint64_t seed = 1;
  Disturbances disturbances{};
  double period = 0.01;               ///< shortest step [s]; sizes the queue of delayed commands
  std::vector<BodyMotion> motions{};  ///< of targets and obstacles; others keep their velocity
  /// Speed limits of targets and obstacles that events move, in team order [m/s]; 0 or empty: no
  /// limit.
  std::vector<double> speed_max{};
  RobotDynamics* dynamics = nullptr;  ///< of the robots that it moves; must outlive the plant
  DownwashOptions downwash{};         ///< of vehicles; for `dynamics`
  /// Threads that share the work from `shared_from` bodies or `vehicles_shared_from` vehicles on.
  /// Null: the caller's thread only. The result does not depend on it.
  std::shared_ptr<ThreadPool> pool{};
  static constexpr int shared_from = 256, vehicles_shared_from = 16;
};

/// Integrates x' = f(x, u) of each body by classical Runge-Kutta steps with u held (zero-order
/// hold). After each step every heading is normalised. An undisturbed step is one Runge-Kutta step
/// of each model, bit for bit, unless a fast model needs shorter ones (part_of_fastest).
///
/// Wind, gusts and wakes are accelerations of the robots, held over a step. A delayed command that
/// comes into force within a step divides the step there. Targets and obstacles with a motion hold
/// its velocity over a step; after the step their state contains the velocity of the next one.
///
/// For robots that PlantOptions::dynamics moves, the plant applies commands, delays, disturbances
/// and presence. The dynamics integrate their motion.
class Plant {
 public:
  /// @param x0  states of all bodies, in team order (nx)
  /// @throws std::invalid_argument naming an invalid start or disturbance
  Plant(Team team, std::vector<double> x0, const PlantOptions& options = {});

  /// Advances by dt [s] under the inputs u (nu). Allocates nothing.
  /// @return false if a state is no longer finite, or if no step was made: for u of another size,
  /// or dt not in (0, 1e6] s
  bool step(std::span<const double> u, double dt) noexcept;

  /// Absent bodies rest where they are and disturb no other. Initially all are present. A robot
  /// that joins starts again in its initial state. A target or obstacle starts at its initial
  /// position, with its current velocity.
  void set_presence(std::span<const Presence> presence) noexcept;

  /// Applies changes by events: moves of bodies, another wind. Allocates nothing.
  void surround(const Surroundings& around) noexcept;

  const Team& team() const { return team_; }
  std::span<const double> x() const noexcept { return std::span(z_).first(nx_); }
  /// States as x(), with the entries that robots measure themselves replaced by those measurements.
  std::span<const double> sensed() noexcept;
  double time() const noexcept { return time_; }

 private:
  struct Part {
    Model model;
    std::size_t x, u;  // offsets
    int robot;         // index among the robots, or -1
    bool there = true;
    bool moved = false;           // by PlantOptions::dynamics
    std::vector<int> slipping{};  // states whose rate wheel slip reduces
  };
  struct YawLag {
    std::size_t input, state;
  };
  /// Consecutive bodies that one thread integrates together: first index and count of parts, states
  /// and lags.
  struct Bunch {
    std::size_t part, parts, x, nx, lag, lags;
  };
  static constexpr std::size_t scratch_rows =
      1 + RungeKuttaScratch::rows_needed;  // the states, and the scratch of a Runge-Kutta step

  void set_accelerations() noexcept;
  void set_wind() noexcept;
  void move_by_dynamics(double t) noexcept;
  void integrate(std::span<const double> u, double from, double s) noexcept;
  void integrate(const Bunch& bunch, std::span<const double> u, double s) noexcept;
  void divide();

  Team team_;
  Disturbances disturbances_;
  std::size_t nx_;
  std::vector<Part> parts_;
  std::vector<YawLag> lags_;
  std::vector<Bunch> bunches_;
  std::vector<double> z_;  // states of all bodies, then the lagging yaw inputs
  // Longest integration step, as a fraction of the time constant of the fastest robot model.
  static constexpr double part_of_fastest = 0.5;
  double longest_ = std::numeric_limits<double>::infinity();  // integration step [s]
  std::vector<double> start_, sensed_;
  std::vector<double> u_, scratch_;
  InputDelay delay_;
  std::optional<Gusts> gusts_;
  std::optional<Wakes> wakes_;
  Motions motions_;
  RobotDynamics* dynamics_;
  std::shared_ptr<ThreadPool> pool_;
  double steered_for_;                          // step that the velocities of motions_ are set for [s]
  std::vector<Vec3<double>> p_, acceleration_;  // of the robots
  bool pushed_;
  Surroundings::Wind wind_{};   // set by an event
  Vec3<double> wind_before_{};  // before that event [m/s^2]
  bool wind_moves_ = false;
  double time_ = 0.0;
};

// Decorator that adds sensors to a world, and the queue of measurements in transit.

/// Base of worlds that add sensors to a world with known true states. Everything except those
/// measurements comes from the inner world.
class SensingWorld : public World {
 public:
  const Team& team() const noexcept override { return world_->team(); }
  std::span<const double> start() const noexcept override { return world_->start(); }
  MeasuredMost measured_max() const noexcept override { return world_->measured_max(); }
  void set_presence(std::span<const Presence> presence) noexcept override { world_->set_presence(presence); }
  void surround(const Surroundings& around) noexcept override { world_->surround(around); }
  Measured measure(double t) noexcept override { return world_->measure(t); }
  bool apply(double t, std::span<const double> estimated, const Command& u, double period,
             std::int64_t periods) noexcept override;
  std::span<const double> truth() const noexcept override { return world_->truth(); }
  std::string ended() const override { return world_->ended(); }

  /// The inner world.
  World& seen() noexcept { return *world_; }

 protected:
  explicit SensingWorld(std::unique_ptr<World> world);

  /// Pose and velocity of a body in the stacked state x, under the inputs applied last.
  Sight<double> sight_of(BodyId body, std::span<const double> x) const noexcept;
  /// Attitude, body to G: from the inner world if it reports one, else from the tilt of the model.
  /// Upright if the model has no tilt.
  Quaternion attitude_of(BodyId body, const Sight<double>& sight, const Measured& now) const noexcept;

 private:
  std::unique_ptr<World> world_;
  std::vector<double> applied_;  // inputs, on which the tilt of a model depends
};

/// Queue of items that were measured or sent and have not arrived. Allocates only in its
/// constructor.
///
/// @tparam T  has `arrival` [s]
template <class T>
class UnderWay {
 public:
  UnderWay() = default;
  explicit UnderWay(std::size_t most) : waiting_(most), arrived_(most) {}

  std::size_t capacity() const noexcept { return waiting_.size(); }
  /// Drops the item if the queue is full.
  void send(const T& one) noexcept {
    if (count_ < waiting_.size()) waiting_[count_++] = one;
  }
  template <class Predicate>
  void drop_if(Predicate of_it) noexcept {
    const auto end = waiting_.begin() + static_cast<std::ptrdiff_t>(count_);
    count_ = static_cast<std::size_t>(std::remove_if(waiting_.begin(), end, of_it) - waiting_.begin());
  }
  /// Items that arrive by t [s], in the order of arrival and then of sending; valid until the next
  /// call.
  std::span<const T> take(double t) noexcept {
    std::size_t count = 0, kept = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      T& to = waiting_[i].arrival <= t + same_time ? arrived_[count++] : waiting_[kept++];
      to = waiting_[i];
    }
    count_ = kept;
    // Insertion sort is stable and does not allocate.
    for (std::size_t i = 1; i < count; ++i) {
      for (std::size_t k = i; k > 0 && arrived_[k].arrival < arrived_[k - 1].arrival; --k)
        std::swap(arrived_[k], arrived_[k - 1]);
    }
    return std::span(arrived_).first(count);
  }

 private:
  std::vector<T> waiting_, arrived_;  // the first count_ of waiting_ are pending
  std::size_t count_ = 0;
};

// Adds telemetry to a world: robots report their motion, and bodies broadcast their poses.

/// Radio over which bodies with known poses broadcast them.
struct Radio {
  static constexpr std::string_view name = "radio";

  double rate = 100.0;
  std::array<double, 2> latency = {0.0, 0.0};
  double dropout = 0.0;
  double position_sigma = 0.01;
  double heading_sigma = 0.01;
  double velocity_sigma = 0.03;
  double correlation_time = 0.0;

  static constexpr auto parameters() {
    using R = Radio;
    return Parameters{
        parameter("rate", &R::rate, "Hz", {0.1, 1000, "0.1 to 1000"},
                  "messages; each is sent at the first period that it is due at"),
        parameter("latency", &R::latency, "s", {0, 1, "0 to 1"},
                  "from sending to arrival: drawn evenly between the two"),
        parameter("dropout", &R::dropout, "", {0, 1, "0 to 1"}, "part of the messages that is lost"),
        parameter("position_sigma", &R::position_sigma, "m", above_zero, "of the position, each axis"),
        parameter("heading_sigma", &R::heading_sigma, "rad", above_zero, "of the heading"),
        parameter("velocity_sigma", &R::velocity_sigma, "m/s", from_zero, "of the velocity, each axis"),
        parameter("correlation_time", &R::correlation_time, "s", from_zero,
                  "of the errors of a body's messages; 0: white")};
  }

  bool operator==(const Radio&) const = default;
  /// @throws std::invalid_argument naming a number out of its range
  void check() const;
};

/// A robot that reports its motion.
struct MovingRobot {
  BodyId robot{};
  FilterOptions errors{};  ///< of its autopilot's sensors
};

struct TelemetryOptions {
  std::uint64_t seed = 1;
  std::vector<MovingRobot> robots{};
  std::vector<BodyId> broadcasters{};  ///< bodies that broadcast their poses
  Radio radio{};
};

/// Decorator that adds telemetry to any world that provides the true states. In each measure() a
/// robot's autopilot reports its motion since the previous call (MotionSensor). A broadcasting body
/// sends its measured pose, plus the errors of the radio, at the first period at which a message is
/// due. The message arrives at the first measure() after its latency.
///
/// An absent body sends nothing, and its pending messages are dropped when it leaves.
class TelemetryWorld final : public SensingWorld {
 public:
  /// @throws std::invalid_argument for options out of range, and for a world that already provides
  /// telemetry
  TelemetryWorld(std::unique_ptr<World> world, const TelemetryOptions& options);

  MeasuredMost measured_max() const noexcept override;
  void set_presence(std::span<const Presence> presence) noexcept override;
  Measured measure(double t) noexcept override;

 private:
  struct Robot {
    BodyId body{};
    MotionSensor sensor;
    bool there = true, moves = false;  // moves: p and R are those of the last measure()
    Vec3<double> p{};
    Mat<3, 3> R = identity<3>();
  };
  struct Sender {
    BodyId body{};
    bool there = true;
    std::int64_t next = 0;         // number of the next message, due at next / rate
    std::optional<double> last{};  // stamp of the last message
    RandomStream chance;
    GaussMarkov<7> errors;  // of position, velocity and heading
  };
  struct Message {
    double arrival = 0.0;
    BodyBroadcast what{};
  };

  void move(Robot& robot, double t, const Measured& now) noexcept;
  void send(Sender& sender, double t, const Measured& now) noexcept;
  void deliver(double t) noexcept;

  Radio radio_;
  std::vector<Robot> robots_;
  std::vector<Sender> senders_;
  std::vector<RobotMotion> motions_;
  UnderWay<Message> messages_;
  std::vector<BodyBroadcast> arrived_;
  double last_ = 0.0;  // time of the last measure() [s]
};

// The simulated world of the models: a plant and a sensor.

class ModelWorld final : public World {
 public:
  /// @param x0  states of all bodies, in team order (nx)
  /// @throws std::invalid_argument as Plant and Sensor
  ModelWorld(Team team, std::vector<double> x0, const PlantOptions& plant = {},
             const SensorOptions& sensor = {});

  const Team& team() const noexcept override { return plant_.team(); }
  std::span<const double> start() const noexcept override { return start_; }
  void set_presence(std::span<const Presence> presence) noexcept override;
  void surround(const Surroundings& around) noexcept override;
  Measured measure(double t) noexcept override;
  bool apply(double t, std::span<const double> estimated, const Command& u, double period,
             std::int64_t periods) noexcept override;
  std::span<const double> truth() const noexcept override { return plant_.x(); }
  /// True states of all bodies (nx).
  std::span<const double> x() const noexcept { return plant_.x(); }

 private:
  Plant plant_;
  Sensor sensor_;
  std::vector<double> start_;  // x0 as given, before normalisation: a replay needs the same
  std::vector<Presence> presence_;
};

// Common base of the worlds of vehicles: their fleet, and the contacts that end a run, with the
// message.

class Fleet;
class Rotorcraft;

/// Checks the vehicles of a team in a world of that kind.
/// @param x0  states of all bodies, in team order (nx)
/// @throws std::invalid_argument for a vehicle that starts below the ground, or without drag under
///         wind; for a period that is not a whole number of milliseconds
void validate(std::string_view kind, const Team& team, std::span<const double> x0,
              const std::vector<RobotVehicle>& vehicles, const PlantOptions& plant);

/// A ModelWorld whose vehicles a Fleet moves. Targets, obstacles and robots that are not vehicles
/// move as in a ModelWorld. Delays, noise, faults and presence are also as there. Wind, gusts and
/// wakes act as moving air. An acceleration a becomes air at the velocity Vehicle::air(a), whose
/// drag accelerates the hovering vehicle by a. In flight the drag acts on the velocity relative to
/// that air, and to the downwash of other vehicles. Commands come into force at
/// whole milliseconds.
///
/// The world ends if a vehicle touches the ground at more than landing_speed_max, or touches
/// another body.
class VehicleWorld : public World {
 public:
  ~VehicleWorld() override;

  const Team& team() const noexcept override { return world_->team(); }
  std::span<const double> start() const noexcept override { return world_->start(); }
  void set_presence(std::span<const Presence> presence) noexcept override;
  void surround(const Surroundings& around) noexcept override;
  Measured measure(double t) noexcept override;
  bool apply(double t, std::span<const double> estimated, const Command& u, double period,
             std::int64_t periods) noexcept override;
  std::span<const double> truth() const noexcept override { return world_->truth(); }
  std::string ended() const override;

  /// The vehicle of this robot; nullptr for any other body.
  const Rotorcraft* rotorcraft(BodyId robot) const;

 protected:
  /// The contact that ended the world.
  struct Touch {
    BodyId a{}, b{};                          ///< a is a vehicle; b with index -1: not a body of the team
    double t = 0.0, speed = 0.0;              ///< time [s], speed [m/s]
    std::string_view surface = "the ground";  ///< name of b if it is not of the team; must outlive the world
  };

  /// @param kind   of the world, for error messages
  /// @param x0     states of all bodies, in team order (nx)
  /// @param fleet  built for this team and these vehicles
  /// @throws std::invalid_argument as ModelWorld and validate()
  VehicleWorld(std::string_view kind, const Team& team, std::vector<double> x0,
               const std::vector<RobotVehicle>& vehicles, std::unique_ptr<Fleet> fleet, PlantOptions plant,
               const SensorOptions& sensor);

  /// Called before the bodies move on from t [s].
  virtual void before(double /*t*/) noexcept {}
  /// The first contact at t [s], if any.
  virtual std::optional<Touch> touch(double t) noexcept = 0;
  /// Called when an absent body joins; left(), when a present body leaves.
  virtual void came(BodyId /*body*/) noexcept {}
  virtual void left(BodyId /*body*/) noexcept {}

  Fleet& fleet() const noexcept { return *fleet_; }
  bool there(BodyId body) const noexcept;
  /// Pose of a body in G, and its velocity under zero inputs.
  Sight<double> sight(BodyId body) const noexcept;

 private:
  std::unique_ptr<Fleet> fleet_;
  std::unique_ptr<ModelWorld> world_;
  std::vector<Presence> presence_;
  std::vector<double> rest_;  // zero inputs (nu), for sight()
  std::vector<Quaternion> attitudes_;
  std::optional<Touch> touch_;
};

// Adds cameras to a world: detections of tagged bodies, next to the measured states.

/// Decorator that adds cameras to any world that provides the true states. A picture is taken at
/// the first measure() at which it is due, so its stamp is a whole number of periods. Its
/// detections arrive at the first measure() after the latency. A picture shows the true states.
/// Attitudes are those that the world reports. For other robots they follow from the model, and are
/// upright if the model has no tilt.
///
/// An absent body neither detects nor is detected. Its pending detections are dropped when it
/// leaves.
class CameraWorld final : public SensingWorld {
 public:
  /// @param source  built for the same options and team
  /// @throws std::invalid_argument for a camera or tags out of range, and for a world that already
  /// provides detections
  CameraWorld(std::unique_ptr<World> world, CameraOptions options, std::unique_ptr<DetectionSource> source);

  MeasuredMost measured_max() const noexcept override {
    MeasuredMost most = SensingWorld::measured_max();
    most.detections = detections_.capacity();
    return most;
  }
  void set_presence(std::span<const Presence> presence) noexcept override;
  Measured measure(double t) noexcept override;

 private:
  struct Shutter {
    std::int64_t next = 0;  // number of the next picture, due at next / rate
    RandomStream chance;
  };

  void place_bodies(const Measured& now) noexcept;
  void take_picture(std::size_t camera, double t) noexcept;

  CameraOptions options_;
  std::unique_ptr<DetectionSource> source_;
  std::vector<Shutter> shutters_;
  std::vector<ExposedBody> bodies_;
  std::optional<double> last_{};  // time of the last measure() [s]
  std::vector<Detection> found_;  // in one picture
  UnderWay<Detection> detections_;
};

// The simulated world of vehicles: robots that tilt, under flight controllers, in moving air.

/// World whose vehicles are sightline's own rigid bodies, above the ground plane z = 0.
///
/// For contacts a vehicle is an upright cylinder of its radius and height; other bodies are points.
/// Contacts are checked at the end of each period. Two bodies that overlap at the start, or on
/// joining, can touch only after they have separated.
class RotorWorld final : public VehicleWorld {
 public:
  /// @param x0  states of all bodies, in team order (nx)
  /// @throws std::invalid_argument as VehicleWorld and Fleet
  RotorWorld(const Team& team, std::vector<double> x0, const std::vector<RobotVehicle>& vehicles,
             const PlantOptions& plant = {}, const SensorOptions& sensor = {});

 private:
  /// Two bodies that can touch; a is a vehicle.
  struct Pair {
    BodyId a, b;
    double radii, height;  ///< contact if the horizontal and the vertical distance are both below these [m]
    bool apart = false;    ///< they have been separated
  };

  std::optional<Touch> touch(double t) noexcept override;
  void came(BodyId body) noexcept override;
  Vec3<double> position(BodyId body) const noexcept;

  std::vector<Pair> pairs_;
};

// A closed loop and its derivatives, backwards in time.
//
// The loop is that of the models: x_{k+1} = F(x_k, u_{k-d}), F the Runge-Kutta step of a period with
// normalised headings, and u_k the first inputs of the optimum at x_k; before the first the
// constants u* are in force. For any cost J of the states x_0 .. x_K and inputs u_0 .. u_{K-1},
//
//   lambda_k = J_x(k) + F_x' lambda_{k+1} + (du_k/dx_k)' g_k,   g_k = J_u(k) + F_u' lambda_{k+d+1}
//   dJ/dtheta = sum of (du_k/dtheta)' g_k
//
// with the products from InputGradient. Noise, disturbances and filters take part only as follow()
// describes.

class LoopGradient {
 public:
  /// @param delay  of the commands, in periods, >= 0
  /// @throws std::invalid_argument for a delay < 0
  explicit LoopGradient(const Ocp& ocp, int delay = 0);

  /// Flies K periods from x0 (nx) at t = 0. Allocates.
  /// @throws std::invalid_argument for periods < 1 or another length of x0
  /// @return false if a state is not finite or a heading (0, 0)
  bool fly(std::span<const double> x0, int periods);
  /// Takes the states of a flight in another world, from t = 0: x_{k+1} = F(x_k, u_{k-d}) + w_k.
  /// The deviations w_k are constants; u_k is the optimum at x_k. Allocates.
  /// @param x  (K+1 x nx)
  /// @throws std::invalid_argument for another length than of at least two states
  void follow(std::span<const double> x);
  /// Of the last flight, k = 0 .. K (nx), and k = 0 .. K - 1 (nu).
  std::span<const double> x(int k) const { return periods_[at(k)].x; }
  std::span<const double> u(int k) const { return periods_[at(k)].u; }

  /// Derivatives of J over the last flight that fly() completed, or of follow(). An update without a derivative
  /// (InputGradient) counts as one with constant inputs.
  /// @param by_x  J_x  (K+1 x nx)
  /// @param by_u  J_u  (K x nu); empty: 0
  /// @return number of updates without a derivative
  int differentiate(std::span<const double> by_x, std::span<const double> by_u = {});

  /// By InputGradient::parameters(), and by x0 with normalised headings (nx).
  std::span<const double> by_parameters() const { return by_parameters_; }
  std::span<const double> by_start() const { return by_start_; }
  const std::vector<InputGradient::Parameter>& parameters() const { return gradient_.parameters(); }

 private:
  /// The step of a body's model with its derivatives.
  struct Step {
    Model model;
    std::size_t x, u;  // offsets
    int heading;       // first state of its heading vector; -1: none
    Program program;   // inputs x, u; outputs F, then F_x and F_u, row by row
    std::vector<double> out{};

    /// Derivatives by the normalised state to those by F: the heading's length does not count.
    void denormalise(double* by_state) const;
  };
  /// State and plan of one period, and the derivative of J by its inputs.
  struct Period {
    std::vector<double> x, u, plan, by_u;
  };

  void plan(int k);
  void evaluate(Step& step, const Period& from, std::span<const double> u) const;
  std::span<const double> applied(int k) const;

  int delay_;
  double dt_;
  NewtonRiccati solver_;
  InputGradient gradient_;
  std::vector<Step> steps_;
  std::vector<double> resting_;
  std::vector<Period> periods_;  // K + 1; the last has a state alone
  std::vector<double> by_parameters_, by_start_;
};

}  // namespace sightline
