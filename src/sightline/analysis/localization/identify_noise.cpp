#include "sightline/analysis/localization/identify_noise.hpp"

#include <algorithm>
#include <array>

#include "sightline/base.hpp"

namespace sightline {
namespace {

constexpr int runs_max = 240;
constexpr double first_factor = 1.6, last_factor = 1.1;

struct NoiseNumber {
  std::string_view key, unit;
  double TeamNoise::*member;
};

/// The numbers that a recording shows something of.
std::vector<NoiseNumber> numbers_of(const TeamRecording& recording, const TeamNoise& noise) {
  const auto shows = [&](Sighted missing) {
    return std::any_of(recording.sightings.begin(), recording.sightings.end(),
                       [&](const TeamSighting& z) { return z.of != missing; });
  };
  const bool ranges = shows(Sighted::bearing), bearings = shows(Sighted::range);
  std::vector<NoiseNumber> numbers;
  const auto add = [&](const auto& p) {
    if constexpr (std::is_same_v<std::remove_cvref_t<decltype(noise.*p.member)>, double>) {
      const bool constant =
          std::find(robot_constants.begin(), robot_constants.end(), p.key) != robot_constants.end();
      const bool shown = p.key.starts_with("range")     ? ranges
                         : p.key.starts_with("bearing") ? bearings
                                                        : p.key != "odometry_gap";  // of the recorder
      if (!constant && shown && noise.*p.member > 0) numbers.push_back({p.key, p.unit, p.member});
    }
  };
  each_parameter<TeamNoise>(add);
  return numbers;
}

}  // namespace

IdentifiedNoise identify_noise(const TeamRecording& recording, const TeamRun& run, int threads) {
  IdentifiedNoise found{.noise = run.noise};
  found.cost = found.cost_before = localize_team(recording, run).cost;
  found.runs = 1;
  const std::vector<NoiseNumber> numbers = numbers_of(recording, run.noise);
  ThreadPool pool(threads);
  for (double factor = first_factor; factor > last_factor;) {
    bool better = false;
    for (const NoiseNumber& one : numbers) {
      if (found.runs >= runs_max) break;
      std::array<TeamNoise, 2> tried = {found.noise, found.noise};
      tried[0].*one.member *= factor, tried[1].*one.member /= factor;
      std::array<double, 2> cost{};
      pool.share(2, [&](int part, int) {
        TeamRun other = run;
        other.noise = tried[static_cast<std::size_t>(part)];
        cost[static_cast<std::size_t>(part)] = localize_team(recording, other).cost;
      });
      found.runs += 2;
      const std::size_t best = cost[1] < cost[0] ? 1 : 0;
      if (cost[best] < found.cost) found.cost = cost[best], found.noise = tried[best], better = true;
    }
    if (!better || found.runs >= runs_max) factor = sqrt(factor);
  }
  for (const NoiseNumber& one : numbers)
    found.numbers.push_back({one.key, one.unit, run.noise.*one.member, found.noise.*one.member});
  return found;
}

}  // namespace sightline
