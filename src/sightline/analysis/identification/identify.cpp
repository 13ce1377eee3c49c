#include "sightline/analysis/identification/identify.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "sightline/base.hpp"

namespace sightline {
namespace {

constexpr double seconds_min = 5.0, judged_min = 2.0, worse = 1.03;

/// Greatest distance from the first measured pose [m, rad].
double way(const FlownMotion& motion) {
  const SeenMotion* first = nullptr;
  double most = 0.0;
  for (const SeenMotion& m : motion.measured) {
    if (!is_seen(m)) continue;
    if (first == nullptr) first = &m;
    most = std::max({most, norm(m.p - first->p), std::abs(m.psi - first->psi)});
  }
  return most;
}

void check(const FlownMotion& motion) {
  if (motion.seconds() < seconds_min - 1e-9)
    throw_invalid("{}: {:.3g} s of flight, expected at least {} s", motion.robot, motion.seconds(),
                  seconds_min);
  const auto seen = std::count_if(motion.measured.begin(), motion.measured.end(), is_seen);
  if (2 * static_cast<std::size_t>(seen) < motion.size())
    throw_invalid("{} was seen in {} of {} periods, expected at least half of them", motion.robot, seen,
                  motion.size());
  const std::array<bool, 4> moved = inputs_moved(motion, {0, motion.size()});
  constexpr double least_way = 0.1;
  if (std::none_of(moved.begin(), moved.end(), [](bool m) { return m; }))
    throw_invalid("the inputs of {} rested, expected some that move by more than a hundredth of their limits",
                  motion.robot);
  if (const double far = way(motion); far < least_way)
    throw_invalid("{} moved by {:.2g} m, expected at least {} m: is it on the ground?", motion.robot, far,
                  least_way);
}

std::string input_of(const FittedNumber& number) {
  return number.input < command_names.size() ? std::string(command_names[number.input]) : "u_f and u_s";
}

/// A sentence for each number that is not known.
std::vector<std::string> not_excited(const FittedModel& model) {
  std::vector<std::string> sentences;
  for (const FoundNumber& one : model.found) {
    if (one.known()) continue;
    const bool one_input = one.number.input < command_names.size();
    sentences.push_back(fmt::format("{} {} not moved enough to know {}", input_of(one.number),
                                    one_input ? "was" : "were", one.number.key));
    if (one.moved)
      sentences.back() += fmt::format(": {:.3g} {} is between {:.3g} and {:.3g}", one.value, one.number.unit,
                                      one.low(), one.high());
  }
  return sentences;
}

}  // namespace

Identification identify(const FlownMotion& motion, std::optional<ExcitationKind> kind) {
  check(motion);
  const auto judged =
      std::max(motion.size() / 4, static_cast<std::size_t>(std::lround(judged_min / motion.period)));
  const Stretch all{0, motion.size()}, first{0, motion.size() - judged}, rest{first.to, motion.size()};
  Identification found{.robot = motion.robot,
                       .model = motion.model,
                       .u_max = motion.u_max,
                       .seconds = motion.seconds(),
                       .held_out = motion.period * static_cast<double>(judged)};
  const bool acts_later = motion.is_between_periods();
  for (const ModelStructure& structure : model_structures(motion.commands)) {
    if (acts_later && !structure.delay) continue;
    const FittedModel fitted = fit_model(motion, first, structure);
    found.candidates.push_back({structure, prediction_error(motion, rest, structure, fitted.numbers)});
  }
  const auto error_of = [&](std::size_t i) { return found.candidates[i].error.whole(); };
  // The Coriolis term has no number of its own. A robot under tilt commands has it unless another
  // structure predicts better.
  const auto rank = [&](std::size_t i) {
    const ModelStructure& s = found.candidates[i].structure;
    return 2 * fitted_numbers(s).size() + (s.coriolis == (s.commands == Commands::tilt) ? 0 : 1);
  };
  double least = error_of(0);
  for (std::size_t i = 1; i < found.candidates.size(); ++i) least = std::min(least, error_of(i));
  bool any = false;
  for (std::size_t i = 0; i < found.candidates.size(); ++i) {
    if (error_of(i) > worse * least) continue;
    if (!any || rank(i) < rank(found.chosen)) found.chosen = i;
    any = true;
  }
  const ModelStructure& best = found.candidates[found.chosen].structure;
  found.best = fit_model(motion, all, best);
  if (best.lags && best.commands == Commands::tilt) found.lumped = fit_lumped(motion, all, found.best);
  found.missing = not_excited(found.best);
  if (kind == ExcitationKind::three_two_one_one)
    found.missing.emplace_back(
        "a 3-2-1-1 alone is too little: it moves one input at a time, fly random steps or a chirp");
  return found;
}

}  // namespace sightline
