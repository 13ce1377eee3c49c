#include "sightline/scenario/reach.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <string_view>
#include <variant>

#include "sightline/formula.hpp"
#include "sightline/model/state_roles.hpp"

namespace sightline {
namespace {

constexpr std::array<std::string_view, sight_size> sight_names = {"p_x", "p_y", "p_z", "d_x",    "d_y",
                                                                  "v_x", "v_y", "v_z", "lean_f", "lean_s"};

/// Which of the first `n` inputs of a graph a formula depends on.
std::vector<bool> inputs_of(Graph& graph, const Symbol& formula, int n) {
  std::vector<Term> of;
  for (int i = 0; i < n; ++i) of.push_back(graph.input(i));
  std::vector<bool> depends;
  for (const Term t : gradient(graph, formula.in(graph), of)) depends.push_back(!graph.is_zero(t));
  return depends;
}

/// Reach of each robot, computed once.
class Reach {
 public:
  explicit Reach(const Team& team) : team_(team) {}

  /// Whether a robot changes any of the entries of its sight that a potential depends on; `seen`
  /// begins with the robot's own entries.
  bool changes(AgentId agent, const bool* seen) {
    auto [found, is_new] = reach_.try_emplace(agent.index);
    if (is_new) found->second = reach_of(team_.model(agent));
    for (std::size_t i = 0; i < sight_size; ++i) {
      if (seen[i] && found->second[i]) return true;
    }
    return false;
  }

 private:
  const Team& team_;
  std::map<int, std::array<bool, sight_size>> reach_;
};

/// "p_x, p_y of target".
std::string what_it_sees(const bool* seen, std::string_view name) {
  std::vector<std::string_view> list;
  for (std::size_t i = 0; i < sight_size; ++i) {
    if (seen[i]) list.push_back(sight_names[i]);
  }
  return list.empty() ? "" : fmt::format("{} of {}", fmt::join(list, ", "), name);
}

std::string beyond(std::string_view who, std::string_view sees, std::string_view feeling,
                   std::string_view maneuver) {
  return fmt::format("{} depends on {}, which {} cannot change: it will not be kept; {}", who,
                     sees.empty() ? "no pose and no velocity" : sees, feeling, maneuver);
}

}  // namespace

std::array<bool, sight_size> reach_of(const Model& model) {
  Graph graph;
  const int nx = model.nx(), nu = model.nu();
  const auto states = static_cast<std::size_t>(nx);
  const std::vector<Symbol> z = variables(graph, 0, nx + nu);
  const std::span<const Symbol> all = z;
  std::vector<Symbol> rate(states);
  model.f(all.first(states), all.subspan(states), rate);
  std::vector<std::vector<bool>> moved_by;
  for (const Symbol& r : rate) moved_by.push_back(inputs_of(graph, r, nx + nu));

  std::vector<bool> reached(z.size(), false);
  std::fill(reached.begin() + nx, reached.end(), true);
  const auto depends_on_reached = [&](const std::vector<bool>& on) {
    for (std::size_t i = 0; i < on.size(); ++i) {
      if (on[i] && reached[i]) return true;
    }
    return false;
  };
  for (std::size_t n = 0; n < states; ++n) {
    for (std::size_t k = 0; k < states; ++k) reached[k] = reached[k] || depends_on_reached(moved_by[k]);
  }
  std::array<Symbol, sight_size> shown;
  write_sight(model.sight(all.first(states), all.subspan(states)), shown);
  std::array<bool, sight_size> reach{};
  for (std::size_t i = 0; i < sight_size; ++i) {
    reach[i] = depends_on_reached(inputs_of(graph, shown[i], nx + nu));
  }
  return reach;
}

std::array<bool, 2 * sight_size> seen_by(const Potential& potential) {
  Graph graph;
  constexpr int n = 2 * sight_size;
  const std::vector<Symbol> z = variables(graph, 0, n + 1);
  const Symbol l = potential(sight_from<Symbol>(z.data()), sight_from<Symbol>(z.data() + sight_size), z[n]);
  const std::vector<bool> depends = inputs_of(graph, l, n);
  std::array<bool, n> seen{};
  std::copy(depends.begin(), depends.end(), seen.begin());
  return seen;
}

std::vector<Coupling> stated_couplings(const ScenarioSpec& scenario) {
  std::vector<Coupling> all = scenario.team.couplings();
  for (const TeamEvent& event : scenario.script.events) {
    for (const Action& action : event.actions) {
      if (const auto* add = std::get_if<AddCoupling>(&action)) all.push_back(add->coupling);
      if (const auto* turn = std::get_if<HandOver>(&action))
        all.insert(all.end(), turn->couplings.begin(), turn->couplings.end());
    }
  }
  return all;
}

std::vector<std::string> limits_beyond_influence(const Scenario& scenario) {
  const Team& team = scenario.team;
  Reach influence(team);
  std::vector<std::string> sentences;
  const std::vector<Coupling> couplings = stated_couplings(scenario);
  for (std::size_t i = 0; i < couplings.size(); ++i) {
    const Coupling& c = couplings[i];
    const auto seen = seen_by(c.term.potential);
    const bool *first = seen.data(), *second = seen.data() + sight_size;
    const auto end = [&](BodyId body) { return body == c.between.first ? first : second; };
    if (std::any_of(c.felt_by.begin(), c.felt_by.end(),
                    [&](AgentId agent) { return influence.changes(agent, end(agent)); }))
      continue;
    const std::string a = what_it_sees(first, team.name(c.between.first)),
                      b = what_it_sees(second, team.name(c.between.second));
    std::vector<std::string_view> feeling, others;
    for (const AgentId agent : c.felt_by) feeling.push_back(team.name(agent));
    for (const BodyId body : {c.between.first, c.between.second}) {
      const bool felt = std::find(c.felt_by.begin(), c.felt_by.end(), body) != c.felt_by.end();
      if (!felt && team.is_agent(body) && influence.changes(AgentId{body}, end(body)))
        others.push_back(team.name(body));
    }
    const std::string who = i < team.couplings().size()
                                ? fmt::format("couple[{}] {}", i, c.term.potential.name())
                                : fmt::format("{} of an event", c.term.potential.name());
    sentences.push_back(
        beyond(who, fmt::format("{}{}{}", a, a.empty() || b.empty() ? "" : " and ", b),
               fmt::format("{}", fmt::join(feeling, ", ")),
               others.empty() ? "leave it out"
                              : fmt::format("let {} feel it: felt_by = [\"{}\"]", others[0], others[0])));
  }
  const auto& constraints = team.constraints();
  for (std::size_t i = 0; i < constraints.size(); ++i) {
    const Constraint& c = constraints[i];
    const auto seen = seen_by(c.term.potential);
    if (influence.changes(c.agent, seen.data())) continue;
    sentences.push_back(beyond(fmt::format("constrain[{}] {}", i, c.term.potential.name()),
                               what_it_sees(seen.data(), team.name(c.agent)), team.name(c.agent),
                               "leave it out"));
  }
  return sentences;
}

std::vector<std::string> robots_beyond_noise(const Scenario& scenario) {
  const Team& team = scenario.team;
  const Noise& noise = scenario.simulation.disturbances.noise;
  const Odometry& odometry = scenario.simulation.disturbances.odometry;
  const bool walks = odometry.position_bias > 0 || odometry.position_walk > 0,
             turns = odometry.heading_bias > 0 || odometry.heading_walk > 0,
             slips = odometry.velocity_bias > 0 || odometry.velocity_walk > 0 || odometry.velocity_scale > 0;
  const auto& faults = scenario.simulation.faults;
  std::vector<std::string> sentences;
  for (int i = 0; i < team.bodies(); ++i) {
    const BodyId body{i};
    if (!team.is_agent(body)) continue;
    const bool jumps = std::any_of(faults.begin(), faults.end(), [&](const Fault& fault) {
      return fault.kind == FaultKind::jump && (fault.body.index < 0 || fault.body == body);
    });
    if (!jumps && noise.position == 0 && noise.heading == 0 && noise.velocity == 0 && odometry == Odometry{})
      continue;
    const StateRoles roles = roles_of(team.model(body));
    const auto add = [&](bool lacks, std::string_view what, std::string_view unreached) {
      if (!lacks) return;
      sentences.push_back(fmt::format("no state of {} ({}) is {}: {} does not reach it", team.name(body),
                                      team.model(body).name(), what, unreached));
    };
    add(noise.position > 0 && !roles.has_position(), "a position [m]", "noise.position");
    add(jumps && !roles.has_position(), "a position [m]", "a jump");
    add(noise.heading > 0 && team.model(body).turns() && !roles.has_heading(), "its heading",
        "noise.heading");
    add(noise.velocity > 0 && roles.velocities.empty(), "a velocity [m/s]", "noise.velocity");
    add(walks && !roles.has_position(), "a position [m]", "the odometry's position error");
    add(turns && team.model(body).turns() && !roles.has_heading(), "its heading",
        "the odometry's heading error");
    add(slips && roles.velocities.empty(), "a velocity [m/s]", "the odometry's velocity error");
  }
  return sentences;
}

}  // namespace sightline
