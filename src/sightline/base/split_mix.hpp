/// SplitMix64 (Steele, Lea and Flood 2014): numbers from a seed, equal on every machine.
#pragma once

#include <cstdint>

namespace sightline {

/// Difference of two successive states; odd, so that the generator visits all states.
inline constexpr std::uint64_t split_mix_step = 0x9e3779b97f4a7c15;

/// The number of a state; each of its bits depends on all bits of the state.
constexpr std::uint64_t split_mix(std::uint64_t state) noexcept {
  state = (state ^ (state >> 30)) * 0xbf58476d1ce4e5b9;
  state = (state ^ (state >> 27)) * 0x94d049bb133111eb;
  return state ^ (state >> 31);
}

/// Advances the state and returns its number.
constexpr std::uint64_t next_split_mix(std::uint64_t& state) noexcept {
  return split_mix(state += split_mix_step);
}

}  // namespace sightline
