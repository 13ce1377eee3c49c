/// SplitMix64 (Steele, Lea and Flood 2014): numbers that follow from a seed, the same on every machine.
#pragma once

#include <cstdint>

namespace sightline {

/// Between two states of the generator; odd, so that it comes to all of them.
inline constexpr std::uint64_t split_mix_step = 0x9e3779b97f4a7c15;

/// The number of a state: all its bits depend on all of the state's.
constexpr std::uint64_t split_mix(std::uint64_t state) noexcept {
  state = (state ^ (state >> 30)) * 0xbf58476d1ce4e5b9;
  state = (state ^ (state >> 27)) * 0x94d049bb133111eb;
  return state ^ (state >> 31);
}

/// Takes a step, and gives its number.
constexpr std::uint64_t next_split_mix(std::uint64_t& state) noexcept {
  return split_mix(state += split_mix_step);
}

}  // namespace sightline
