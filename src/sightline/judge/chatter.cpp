#include "sightline/judge/chatter.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace sightline {
namespace {

constexpr std::int64_t window = 50;  // periods
constexpr int reversals_min = 45;    // of these periods
constexpr double jump_min = 0.01;    // of the range
constexpr std::uint64_t window_mask = (std::uint64_t{1} << window) - 1;

}  // namespace

void Chatter::add(std::size_t input, double time, double u, double range) noexcept {
  Input& in = inputs_[input];
  const double step = in.periods > 0 ? u - in.u : 0.0, least = jump_min * range;
  const bool reversal = step * in.step < 0 && std::abs(step) >= least && std::abs(in.step) >= least;
  in.u = u;
  in.step = step;
  ++in.periods;
  in.reversals = (in.reversals << 1 | (reversal ? 1U : 0U)) & window_mask;
  if (std::popcount(in.reversals) < reversals_min) return;
  if (in.chattered == 0) in.from = time;
  in.chattered += std::min(window, in.periods - in.counted_to);
  in.counted_to = in.periods;
  if (!reversal) return;
  in.sum += std::abs(step);
  ++in.jumps;
}

std::vector<Chatter::Found> Chatter::found() const {
  std::vector<Found> found;
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    const Input& in = inputs_[i];
    if (in.chattered == 0) continue;
    found.push_back({i, in.from, static_cast<double>(in.chattered) / static_cast<double>(in.periods),
                     in.sum / static_cast<double>(in.jumps)});
  }
  return found;
}

double Chatter::worst_share() const {
  double worst = 0.0;
  for (const Found& found : found()) worst = std::max(worst, found.share);
  return worst;
}

}  // namespace sightline
