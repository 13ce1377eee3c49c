#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>

#include "sightline/scenario/read_part.hpp"

namespace sightline {
namespace {

ContinuationOptions read_continuation(const TomlTable& at, const Horizon& horizon) {
  ContinuationOptions o;
  read_keys(at, {"name"}, o);
  if (!(o.zeta * horizon.dt < 2)) {
    at.throw_invalid("zeta", fmt::format("less than 2 / horizon.period = {} 1/s, beyond which it oscillates",
                                         2 / horizon.dt));
  }
  return o;
}

SolverChoice read_cmscgmres(const TomlTable& at, const Horizon& horizon) {
  return {"cmscgmres", read_continuation(at, horizon)};
}
SolverChoice read_cgmres(const TomlTable& at, const Horizon& horizon) {
  return {"cgmres", read_continuation(at, horizon)};
}

SolverChoice read_newton_riccati(const TomlTable& at, const Horizon&) {
  NewtonRiccatiOptions o;
  read_keys(at, {"name"}, o);
  return {"newton_riccati", o};
}

struct SolverEntry {
  SolverChoice (*read)(const TomlTable& at, const Horizon& horizon);
  SolverAbilities can{};
};
constexpr std::array solvers = {
    Named<SolverEntry>{
        "newton_riccati",
        {read_newton_riccati,
         {.changing_teams = true, .keep_apart = true, .uncertain_views = true, .input_rates = true}}},
    Named<SolverEntry>{"cmscgmres", {read_cmscgmres}},
    Named<SolverEntry>{"cgmres", {read_cgmres}},
};

/// The entry of that name.
SolverEntry entry_of(std::string_view name) {
  const auto known = names(solvers);
  if (std::find(known.begin(), known.end(), name) == known.end()) {
    throw std::invalid_argument(
        fmt::format("solver = {}, expected one of {}", one_line(name), fmt::join(known, ", ")));
  }
  return find(solvers, name);
}

}  // namespace

SolverChoice read_solver(const TomlTable& solver, const Horizon& horizon) {
  const std::string_view name =
      solver.has("name") ? solver.word("name", names(solvers)) : solvers.front().name;
  return find(solvers, name).read(solver, horizon);
}

std::vector<std::string_view> solver_names() {
  const auto known = names(solvers);
  return {known.begin(), known.end()};
}

SolverAbilities abilities_of(std::string_view solver) { return entry_of(solver).can; }

std::string solvers_that(bool SolverAbilities::*can) {
  std::string able;
  for (const Named<SolverEntry>& solver : solvers)
    if (solver.read.can.*can) able += fmt::format("{}{}", able.empty() ? "" : " or ", solver.name);
  return able;
}

SolverChoice solver_named(std::string_view name) {
  static const TomlDocument defaults{};
  return entry_of(name).read(TomlTable(defaults), Horizon{});
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
  };
  return std::visit(Make{choice.name, team, horizon}, choice.options);
}

}  // namespace sightline
