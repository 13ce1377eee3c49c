/// A team with one number changed, found by its name among InputGradient::parameters().
#pragma once

#include <string>
#include <vector>

#include "sightline/team.hpp"

namespace sightline {

inline Team changed_team(const Team& team, const std::string& parameter, double by) {
  const auto add_to = [&](std::vector<double>& values, const std::string& name) {
    for (std::size_t i = 0; i < values.size(); ++i)
      if (name + "[" + std::to_string(i) + "]" == parameter) values[i] += by;
  };
  const auto weighted = [&](Weighted term, const std::string& name) {
    if (name + ".weight" == parameter) term.weight += by;
    const auto numbers = term.potential.numbers();
    for (std::size_t i = 0; i < numbers.size(); ++i)
      if (name + "." + numbers[i].first == parameter)
        term.potential = term.potential.with_number(i, numbers[i].second + by);
    return term;
  };
  Team copy;
  for (int b = 0; b < team.bodies(); ++b) {
    const BodyId body{b};
    const std::string name(team.name(body));
    if (!team.is_agent(body)) {
      copy.add(Obstacle{.name = name, .has_heading = team.model(body).nx() > 6});
      continue;
    }
    Agent agent = team.agent(body);
    agent.name = name;
    add_to(agent.Q, name + ".Q"), add_to(agent.R, name + ".R"), add_to(agent.Q_f, name + ".Q_f");
    add_to(agent.u_ref, name + ".u_ref"), add_to(agent.R_rate, name + ".R_rate");
    std::vector<double> shift(agent.Q.size(), 0.0);
    add_to(shift, name + ".x_ref");
    agent.x_ref = Reference([from = agent.x_ref, model = agent.model, shift](double t) {
      std::vector<double> x(shift.size());
      from(t, model, x);
      for (std::size_t i = 0; i < x.size(); ++i) x[i] += shift[i];
      return x;
    });
    copy.add(agent);
  }
  for (std::size_t i = 0; i < team.couplings().size(); ++i) {
    Coupling coupling = team.couplings()[i];
    coupling.term = weighted(coupling.term, "couple[" + std::to_string(i) + "]");
    copy.couple(coupling);
  }
  for (std::size_t i = 0; i < team.constraints().size(); ++i) {
    Constraint constraint = team.constraints()[i];
    constraint.term = weighted(constraint.term, "constrain[" + std::to_string(i) + "]");
    copy.constrain(constraint);
  }
  for (const BarrierTerm& limit : team.barriers()) copy.constrain(limit.barrier, limit.agent);
  return copy;
}

}  // namespace sightline
