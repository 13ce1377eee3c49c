/// report.html: one page about a run, from the run's files only.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/record/recording.hpp"
#include "sightline/report/figures.hpp"

namespace sightline {

/// Figures of a run, after Figs 4, 6, 19, 20 and 24 of the paper: distance and view angle of each
/// pair, least distances, paths from above and from the side, positions, headings, inputs, the
/// solver's record and the computation time. A curve has at most 2000 points.
std::vector<Drawing> drawings_of(const Recording& recording);

/// The page with all its figures; it loads no other file.
/// @param summary  text of summary.json; empty: missing, as for a run that was killed
/// @param partition  text of partition.json, of a partitioned team; ignored if it is of another run
/// @throws std::runtime_error with a sentence if the summary is invalid
std::string report_html(const Recording& recording, std::string_view summary,
                        std::string_view partition = {});

/// Writes report.html into a run's folder, from run.mcap, timing.csv and summary.json.
/// @throws std::runtime_error with a sentence for a file that cannot be read or written
void write_report(const std::filesystem::path& folder);

}  // namespace sightline
