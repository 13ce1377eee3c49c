/// Recording of bounded size for figures, for flights of any length.
#pragma once

#include <cstddef>
#include <filesystem>

#include "sightline/log.hpp"

namespace sightline {

/// 10 min at 100 Hz: shorter flights are not thinned.
inline constexpr std::size_t thinned_rows_max = 60'000;

/// Same as read_recording(), but keeps only each Recording::stride-th period if there are more than
/// `rows_max`. Then at most four fifths of `rows_max` rows remain, so a thinned flight uses no more
/// memory than the longest one that is not thinned. A row has the longest solve time of its stride.
/// Only the first 10 000 events are kept.
/// @throws as read_recording()
Recording read_thinned_recording(const std::filesystem::path& folder,
                                 std::size_t rows_max = thinned_rows_max);

}  // namespace sightline
