#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

#include "sightline/scenario/built_in_solvers.hpp"
#include "sightline/scenario/read_part.hpp"

namespace sightline {
namespace {

using BesideKeys = std::span<const std::string_view>;

SolverPart continuation(std::string_view name) {
  const auto read = [name](const ParameterSource& from, BesideKeys beside, const Horizon& horizon) {
    const auto o = read_part<ContinuationOptions>(from, beside);
    if (!(o.zeta * horizon.dt < 2)) {
      from.throw_invalid(
          fmt::format("zeta = {}, expected less than 2 / horizon.period = {} 1/s, beyond which it oscillates",
                      o.zeta, 2 / horizon.dt));
    }
    return SolverChoice{std::string(name), o};
  };
  return {std::string(name), {}, read};
}

SolverPart newton_riccati() {
  return {"newton_riccati",
          {.changing_teams = true, .keep_apart = true, .uncertain_views = true, .input_rates = true},
          [](const ParameterSource& from, BesideKeys beside, const Horizon&) {
            return SolverChoice{"newton_riccati", read_part<NewtonRiccatiOptions>(from, beside)};
          }};
}

}  // namespace

void add_built_in(SolverList& solvers) {
  solvers.add(newton_riccati()).add(continuation("cmscgmres")).add(continuation("cgmres"));
}

SolverList& SolverList::add(SolverPart part) {
  check_part_name("solver", part.name, {}, names());
  if (!part.read)
    throw_invalid("the solver \"{}\" has no function, expected one that reads its options", part.name);
  solvers_.push_back(std::move(part));
  return *this;
}

std::vector<std::string_view> SolverList::names() const {
  std::vector<std::string_view> all;
  for (const SolverPart& solver : solvers_) all.push_back(solver.name);
  return all;
}

const SolverPart& SolverList::named(std::string_view name) const {
  const auto found = std::find_if(solvers_.begin(), solvers_.end(),
                                  [&](const SolverPart& solver) { return solver.name == name; });
  if (found == solvers_.end())
    throw_invalid("solver = {}, expected one of {}", one_line(name), fmt::join(names(), ", "));
  return *found;
}

std::string SolverList::names_that(bool SolverAbilities::*can) const {
  std::string able;
  for (const SolverPart& solver : solvers_)
    if (solver.can.*can) able += fmt::format("{}{}", able.empty() ? "" : " or ", solver.name);
  return able;
}

SolverChoice read_solver(const TomlTable& solver, const Horizon& horizon) {
  const SolverList& solvers = solver.registry().solvers;
  const std::vector<std::string_view> known = solvers.names();
  const std::string_view name = solver.has("name") ? solver.word("name", known) : known.front();
  constexpr std::array<std::string_view, 1> beside = {"name"};
  return solvers.named(name).read(TableSource(solver), beside, horizon);
}

std::vector<std::string_view> solver_names(const Registry& registry) { return registry.solvers.names(); }

SolverChoice solver_named(std::string_view name, const Registry& registry) {
  static const TomlDocument defaults{};
  const TomlTable nothing(defaults);
  return registry.solvers.named(name).read(TableSource(nothing), {}, Horizon{});
}

std::unique_ptr<Solver> make_solver(const SolverChoice& choice, const Team& team, const Horizon& horizon) {
  struct Make {
    std::string_view name;
    const Team& team;
    const Horizon& horizon;
    std::unique_ptr<Solver> operator()(const ContinuationOptions& o) const {
      if (name == "cgmres") return std::make_unique<Cgmres>(team, horizon, o);
      return std::make_unique<Cmscgmres>(team, horizon, o);
    }
    std::unique_ptr<Solver> operator()(const NewtonRiccatiOptions& o) const {
      return std::make_unique<NewtonRiccati>(team, horizon, o);
    }
    std::unique_ptr<Solver> operator()(const MakeTeamSolver& make) const { return make(team, horizon); }
  };
  return std::visit(Make{choice.name, team, horizon}, choice.options);
}

}  // namespace sightline
