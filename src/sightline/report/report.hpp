/// report.html: one page that tells a run, made from the run's files alone.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "sightline/record/recording.hpp"
#include "sightline/report/figures.hpp"

namespace sightline {

/// What the figures of a run show, after Figs 4, 6, 19, 20 and 24 of the paper: distance and view angle of each
/// pair, the least distances, the paths from above and from the side, positions, headings, inputs, the solver's
/// record and the computation time.
/// A curve has at most 2000 points.
std::vector<Drawing> drawings_of(const Recording& recording);

/// The page, with all figures in it; it asks for no other file.
/// @param summary  text of summary.json; empty: there is none, as of a run that was killed
/// @param partition  text of partition.json, of a team that was flown in parts; left out where it is another run's
/// @throws std::runtime_error with a sentence where the summary is none, or gnuplot is missing
std::string report_html(const Recording& recording, std::string_view summary,
                        std::string_view partition = {});

/// Makes report.html of a run's folder from run.mcap, timing.csv and summary.json.
/// @throws std::runtime_error with a sentence for what cannot be read, drawn or written
void write_report(const std::filesystem::path& folder);

}  // namespace sightline
