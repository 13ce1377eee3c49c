#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "sightline/base.hpp"
#include "sightline/events.hpp"

namespace sightline {
namespace {

void check_once(std::string_view shape, const std::vector<BodyId>& bodies) {
  for (auto body = bodies.begin(); body != bodies.end(); ++body) {
    if (std::find(bodies.begin(), body, *body) == body) continue;
    throw std::invalid_argument(
        fmt::format("body {} stands twice in the {}, expected each body once", body->index, shape));
  }
}

}  // namespace

std::vector<Between> chain(const std::vector<BodyId>& bodies) {
  check_once("chain", bodies);
  std::vector<Between> pairs;
  for (std::size_t i = 1; i < bodies.size(); ++i) pairs.push_back({bodies[i], bodies[i - 1]});
  return pairs;
}

std::vector<Between> ring(const std::vector<BodyId>& bodies) {
  check_once("ring", bodies);
  std::vector<Between> pairs = chain(bodies);
  if (bodies.size() > 1) pairs.push_back({bodies.front(), bodies.back()});
  return pairs;
}

std::vector<Between> star(BodyId centre, const std::vector<BodyId>& observers) {
  std::vector<BodyId> all = {centre};
  all.insert(all.end(), observers.begin(), observers.end());
  check_once("star", all);
  std::vector<Between> pairs;
  for (const BodyId observer : observers) pairs.push_back({observer, centre});
  return pairs;
}

std::vector<Between> all_pairs(const std::vector<BodyId>& bodies) {
  check_once("pairs", bodies);
  std::vector<Between> pairs;
  for (auto first = bodies.begin(); first != bodies.end(); ++first) {
    for (auto second = first + 1; second != bodies.end(); ++second) pairs.push_back({*first, *second});
  }
  return pairs;
}

std::vector<AgentId> feeling(const Team& team, Between pair, FeltBy felt_by) {
  std::vector<AgentId> agents;
  if (team.is_agent(pair.first)) agents.push_back(AgentId{pair.first});
  if (felt_by == FeltBy::both && team.is_agent(pair.second)) agents.push_back(AgentId{pair.second});
  return agents;
}

void couple(Team& team, const TermsOf& terms_of, std::span<const Between> pairs, FeltBy felt_by) {
  for (const Between pair : pairs) {
    for (const Weighted& term : terms_of(pair)) team.couple(term, pair, feeling(team, pair, felt_by));
  }
}

void relay(Team& team, Script& script, const TermsOf& terms_of, const std::vector<AgentId>& observers,
           BodyId target, const RelayOptions& options) {
  if (options.name.empty()) throw std::invalid_argument("a relay has no name, expected one for its stages");
  std::vector<BodyId> all(observers.begin(), observers.end());
  all.push_back(target);
  check_once("relay", all);
  const auto stage_of = [&](AgentId robot) { return fmt::format("{}:{}", options.name, team.name(robot)); };
  const auto couplings_of = [&](AgentId robot) {
    std::vector<Coupling> couplings;
    for (const Weighted& term : terms_of({robot, target})) {
      couplings.push_back({.term = term,
                           .between = {robot, target},
                           .felt_by = {robot},
                           .name = fmt::format("{} {}", stage_of(robot), couplings.size())});
    }
    return couplings;
  };
  script.begins.push_back(stage_of(observers.front()));
  for (Coupling& coupling : couplings_of(observers.front())) team.couple(std::move(coupling));
  for (const AgentId on_duty : observers) {
    for (const AgentId next : observers) {
      if (next == on_duty) continue;
      TeamEvent event{
          .name = fmt::format("{}: {} takes over from {}", options.name, team.name(next), team.name(on_duty)),
          .trigger = Condition{.measure = NearerThan{on_duty, next, target},
                               .threshold = options.margin,
                               .dwell = options.dwell},
          .stage = stage_of(on_duty),
          .enter = stage_of(next),
          .ramp = options.ramp};
      for (Coupling& coupling : couplings_of(on_duty)) event.actions.push_back(RemoveTerm{coupling.name});
      for (Coupling& coupling : couplings_of(next)) event.actions.push_back(AddCoupling{std::move(coupling)});
      script.events.push_back(std::move(event));
    }
  }
}

void best(Team& team, Script& script, const TermsOf& terms_of, ViewChoice choice, double ramp) {
  if (choice.name.empty()) throw_invalid("a choice of observers has no name, expected one for its couplings");
  choice.check(team);
  for (const ViewChoice& other : script.choices) {
    if (other.name == choice.name)
      throw_invalid("two choices of observers are called {}, expected two names", other.name);
    for (const AgentId observer : choice.observers) {
      if (std::find(other.observers.begin(), other.observers.end(), observer) == other.observers.end())
        continue;
      throw_invalid("\"{}\" observes in {} already, expected a robot that turns by one choice alone",
                    team.name(observer), other.name);
    }
  }
  for (std::size_t i = 0; i < choice.observers.size(); ++i) {
    const AgentId observer = choice.observers[i];
    HandOver change{.observer = observer};
    const auto name_of = [&](std::size_t term) {
      return fmt::format("{}:{} {}", choice.name, team.name(observer), term);
    };
    const auto add_event = [&](int target, const std::string& towards) {
      script.events.push_back(
          {.name = fmt::format("{}: {} turns to {}", choice.name, team.name(observer), towards),
           .trigger = Condition{.measure = TurnedTo{script.choices.size(), i, target, observer},
                                .threshold = 0.5,
                                .hysteresis = 0.25},
           .actions = {change},
           .repeat = true,
           .ramp = ramp});
    };
    for (std::size_t j = 0; j < choice.targets.size(); ++j) {
      const BodyId target = choice.targets[j];
      if (target == observer) continue;
      change.couplings.clear();
      for (const Weighted& term : terms_of({observer, target})) {
        change.couplings.push_back({.term = term,
                                    .between = {observer, target},
                                    .felt_by = {observer},
                                    .name = name_of(change.couplings.size())});
      }
      change.names.clear();
      for (const Coupling& coupling : change.couplings) change.names.push_back(coupling.name);
      if (choice.first[i] == static_cast<int>(j)) {
        for (const Coupling& coupling : change.couplings) team.couple(coupling);
      }
      add_event(static_cast<int>(j), std::string(team.name(target)));
    }
    change.couplings.clear();
    add_event(ViewChoice::nobody, "nobody");
  }
  script.choices.push_back(std::move(choice));
}

void couple(Team& team, const std::vector<Weighted>& terms, std::span<const Between> pairs, FeltBy felt_by) {
  const TermsOf same = [&](Between) { return terms; };
  couple(team, same, pairs, felt_by);
}

}  // namespace sightline
