/// Large teams of any graph: robots of mixed models near places of a grid, strongly coupled with
/// some of those nearby.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "sightline/model.hpp"
#include "sightline/potentials.hpp"
#include "sightline/robots.hpp"
#include "sightline/team.hpp"
#include "tests/support/random.hpp"

namespace sightline::test {

struct GraphTeam {
  Team team;
  std::vector<double> x0;
};

/// Each robot observes, or keeps apart from, one to three of those before it; one or both feel it.
/// @param robots  at least 2
inline GraphTeam random_graph(Random& random, int robots) {
  GraphTeam made;
  std::vector<AgentId> ids;
  const int columns = static_cast<int>(std::ceil(std::sqrt(robots)));
  const bool mixed = random() % 2 == 0, mutual = random() % 4 == 0;
  const double strength = uniform(random, 0.5, 8.0);
  const auto place = [&](const auto& model, const auto& options, const Vec3<double>& p) {
    const double heading = uniform(random, -3.0, 3.0);
    const auto x = model.at_rest({p, {std::cos(heading), std::sin(heading)}});
    made.x0.insert(made.x0.end(), x.begin(), x.end());
    ids.push_back(made.team.add(model, options));
  };
  for (int i = 0; i < robots; ++i) {
    const int column = i % columns, row = i / columns;
    const Vec3<double> at = {1.5 * column, 1.5 * row, 1.0};
    const Vec3<double> p = at + random_point(random, 0.3);
    const Circle follow{
        .centre = at, .radius = uniform(random, 0.0, 0.5), .rate = uniform(random, -0.4, 0.4)};
    if (mixed && random() % 3 == 0) {
      AgentOptions<VelocityMultirotor> options{.x_ref = follow};
      options.Q[0] = options.Q[1] = 0.5, options.Q[2] = 1.0;
      place(VelocityMultirotor{}, options, p);
    } else {
      AgentOptions<Multirotor> options{.x_ref = follow};
      options.Q = {0.5, 0.5, 1.0, 0, 0, 0.1, 0.1};
      place(Multirotor{}, options, p);
    }
  }
  for (int i = 1; i < robots; ++i) {
    const int others = 1 + static_cast<int>(random() % 3);
    for (int n = 0; n < others; ++n) {
      const int back = 1 + static_cast<int>(random() % static_cast<unsigned>(std::min(i, columns + 1)));
      const AgentId a = ids[static_cast<std::size_t>(i)], b = ids[static_cast<std::size_t>(i - back)];
      std::vector<AgentId> who = {a, b};
      if (!mutual && random() % 3 != 0) who = {random() % 4 == 0 ? b : a};
      made.team.couple(strength * TooNear{.d_min = 1.0, .kappa = 10.0}, Between{a, b}, who);
      if (random() % 2 == 0) made.team.couple(0.5 * strength * Bearing{}, Between{a, b}, who);
      if (random() % 4 == 0) made.team.couple(0.1 * RelativeVelocity{.v_0 = 1.0}, Between{a, b}, who);
    }
  }
  return made;
}

}  // namespace sightline::test
