/// Actions `add = { couple = {...} }`, `add = { constrain = {...} }`, with tables as of [[couple]]
/// and [[constrain]].
#pragma once

#include <fmt/format.h>

#include <array>
#include <stdexcept>
#include <string>
#include <string_view>

#include "sightline/ocp/event/team_change.hpp"

namespace sightline {

namespace detail {
/// Adds a term that fades in.
/// @param add  adds the term to a trial team, which may reject it
template <class Term, class Add>
std::string enter(const TeamChange& change, const Term& given, std::vector<Term>& terms, Add&& add) {
  if (change.now.has_term(given.name)) {
    return fmt::format("\"{}\" is there already, expected a name that is free", given.name);
  }
  Term term = given;
  term.name.clear();
  try {
    Team trial = change.now.all;
    add(trial, term);
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  term.name = given.name;
  term.ramp = change.fading_in();
  terms.push_back(std::move(term));
  return {};
}
}  // namespace detail

struct AddCoupling {
  static constexpr std::string_view key = "add";
  static constexpr std::array<std::string_view, 1> kinds = {"couple"};

  Coupling coupling;

  std::string apply(const TeamChange& change) const {
    return detail::enter(change, coupling, change.now.couplings,
                         [](Team& trial, Coupling c) { trial.couple(std::move(c)); });
  }
  std::string subject(const Team& /*all*/) const { return term_subject(coupling.name); }
  std::string describe(const Team& all) const {
    return fmt::format("add {} {} between {} and {}", coupling.term.weight, coupling.term.potential.name(),
                       all.name(coupling.between.first), all.name(coupling.between.second));
  }

  template <class Text>
  static AddCoupling read(const Text& add, std::string_view kind) {
    return {add.coupling(kind)};
  }
};

struct AddConstraint {
  static constexpr std::string_view key = "add";
  static constexpr std::array<std::string_view, 1> kinds = {"constrain"};

  Constraint constraint;

  std::string apply(const TeamChange& change) const {
    return detail::enter(change, constraint, change.now.constraints,
                         [](Team& trial, Constraint c) { trial.constrain(std::move(c)); });
  }
  std::string subject(const Team& /*all*/) const { return term_subject(constraint.name); }
  std::string describe(const Team& all) const {
    return fmt::format("add {} {} of {}", constraint.term.weight, constraint.term.potential.name(),
                       all.name(constraint.agent));
  }

  template <class Text>
  static AddConstraint read(const Text& add, std::string_view kind) {
    return {add.constraint(kind)};
  }
};

}  // namespace sightline
