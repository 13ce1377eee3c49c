/// A recording of bounded size, however long the flight was: what figures are drawn from.
#pragma once

#include <cstddef>
#include <filesystem>

#include "sightline/record/recording.hpp"

namespace sightline {

/// 10 min at 100 Hz: shorter flights are not thinned.
inline constexpr std::size_t thinned_rows_max = 60'000;

/// As read_recording(), of more than `rows_max` periods with each Recording::stride-th alone. Those are four fifths of `rows_max` at most,
/// so that a flight that is thinned takes no more memory than one that just is not. Of times to solve a row has the longest of its
/// stride; of events the first 10 000 are there.
/// @throws as read_recording()
Recording read_thinned_recording(const std::filesystem::path& folder,
                                 std::size_t rows_max = thinned_rows_max);

}  // namespace sightline
