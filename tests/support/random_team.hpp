/// Teams, states and inputs of any kind: the ground of property tests over the optimal control
/// problem.
#pragma once

#include <array>
#include <vector>

#include "sightline/potentials.hpp"
#include "sightline/robots.hpp"
#include "sightline/team.hpp"
#include "tests/support/random.hpp"
#include "tests/support/robots.hpp"

namespace sightline {

/// A potential of velocities and time, so of inputs too: a multirotor's climb is its command.
struct ChangingPace {
  static constexpr std::string_view name = "changing_pace";

  template <class S>
  S operator()(const Sight<S>& a, const Sight<S>& b, const S& time) const {
    const Vec3<S> v = a.v - b.v;
    return (2.0 + sin(time)) * logistic(dot(v, v) - 0.5 * dot(a.p - b.p, v));
  }
};

/// Who feels the couplings of a random team.
enum class Feeling {
  everyone,  ///< all robots of each coupling: the problem is the optimum of one function
  anyone,    ///< some robots, drawn
};

/// Which robots a random team is of, and how many of its pairs are coupled.
enum class RandomRobots {
  multirotors,  ///< both models of the library; nearly all pairs
  any_size,     ///< those and others, of 4 to 12 states, also ground robots; a drawn share of the pairs
};

inline Reference random_reference(Random& random) {
  const Vec3<double> p = random_point(random, 1.0);
  switch (random() % 3) {
    case 0:
      return Circle{.centre = p, .radius = uniform(random, 0, 2), .rate = uniform(random, -2, 2)};
    case 1:
      return Waypoints{.times = {0.0, 1.3}, .p = {p, random_point(random, 2.0)}, .heading = {0.3, -1.0}};
    default:
      return Steps{.times = {0.0, 0.61}, .p = {p, random_point(random, 2.0)}};
  }
}

template <RobotModel M>
AgentId add_random_agent(Team& team, const M& model, Random& random) {
  AgentOptions<M> o{.Q = uniform_array<M::nx>(random, 0, 2),
                    .R = uniform_array<M::nu>(random, 0.2, 2),
                    .Q_f = uniform_array<M::nx>(random, 0, 2),
                    .x_ref = random_reference(random),
                    .u_ref = uniform_array<M::nu>(random, -0.3, 0.3),
                    .u_min = uniform_array<M::nu>(random, -1.5, -0.5),
                    .u_max = uniform_array<M::nu>(random, 0.5, 1.5)};
  const AgentId agent = team.add(model, o);
  if (random() % 2 == 0)
    team.constrain(uniform(random, 0.1, 1) * AltitudeBand{.z_min = 0.2, .z_max = 1.5}, agent);
  if (random() % 2 == 0) team.constrain(uniform(random, 0.1, 1) * Geofence{{-1, -1, 0}, {1, 1, 2}}, agent);
  return agent;
}

/// A robot of a model that is drawn.
inline AgentId add_random_agent(Team& team, RandomRobots fleet, Random& random) {
  switch (random() % (fleet == RandomRobots::multirotors ? 2 : 9)) {
    case 0:
      return add_random_agent(team, Multirotor{}, random);
    case 1:
      return add_random_agent(team, AngleMultirotor{}, random);
    case 2:
      return add_random_agent(team, test::Unicycle{}, random);
    case 3:
      return add_random_agent(team, OmniRover{}, random);
    case 4:
      return add_random_agent(team, Unicycle{}, random);
    case 5:
      return add_random_agent(team, PointMass{}, random);
    case 6:
      return add_random_agent(team, VelocityMultirotor{}, random);
    case 7:
      return add_random_agent(team, LaggedMultirotor<Lags::plane>::ar_drone(), random);
    default:
      return add_random_agent(team, test::Quadrotor{}, random);
  }
}

/// Robots of several models, obstacles among them, and each potential drawn for any two bodies.
inline Team random_team(Random& random, int agents, Feeling feeling,
                        RandomRobots fleet = RandomRobots::multirotors) {
  Team team;
  for (int i = 0; i < agents; ++i) {
    if (random() % 3 == 0) team.add(Obstacle{});
    add_random_agent(team, fleet, random);
  }
  const double coupled = fleet == RandomRobots::multirotors ? 1.0 : uniform(random, 0.2, 1.0);
  for (int a = 0; a < team.bodies(); ++a) {
    for (int b = 0; b < team.bodies(); ++b) {
      const Between between{{a}, {b}};
      std::vector<AgentId> robots, who;
      for (const BodyId body : {between.first, between.second}) {
        if (team.is_agent(body)) robots.push_back(AgentId{body});
      }
      if (a == b || robots.empty()) continue;
      if (coupled < 1.0 && uniform(random, 0, 1) > coupled) continue;
      const std::array<Weighted, 4> terms = {
          uniform(random, 0.1, 1) * SensorCone{}, uniform(random, 0.1, 1) * KeepOut{},
          uniform(random, 0.1, 1) * Cohesion{.d_max = 1.0}, uniform(random, 0.1, 1) * ChangingPace{}};
      for (const Weighted& term : terms) {
        if (random() % 3 != 0) continue;
        who = robots;
        if (feeling == Feeling::anyone && robots.size() == 2 && random() % 2 == 0)
          who = {robots[random() % 2]};
        team.couple(term, between, who);
      }
    }
  }
  return team;
}

/// States of all bodies: poses within `reach` [m], any heading, near rest.
inline std::vector<double> random_states(Random& random, const Team& team, double reach) {
  std::vector<double> x(static_cast<std::size_t>(team.nx()));
  for (int i = 0; i < team.bodies(); ++i) {
    const Model& model = team.model(BodyId{i});
    double* const state = x.data() + team.state_offset(BodyId{i});
    model.at_rest(random_pose(random, reach), state);
    for (int j = model.nx() - 2; j < model.nx(); ++j) state[j] += uniform(random, -0.5, 0.5);
  }
  return x;
}

inline std::vector<double> random_numbers(Random& random, int n, double size) {
  std::vector<double> v(static_cast<std::size_t>(n));
  for (double& number : v) number = uniform(random, -size, size);
  return v;
}

}  // namespace sightline
