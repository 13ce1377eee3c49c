#include "sightline/analysis/localization/team_recording.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <regex>
#include <stdexcept>
#include <system_error>

#include "sightline/readers/packed_file.hpp"
#include "sightline/scenario/file_kind.hpp"

namespace sightline {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t folder_files_max = 4096;

bool is_of_mrclam(const std::string& name) {
  static const std::regex names(
      R"((Robot[0-9]+_(Odometry|Measurement|Groundtruth)|Barcodes|Landmark_Groundtruth)\.dat(\.gz)?)");
  return std::regex_match(name, names);
}

bool is_of_murp(const std::string& name) {
  static const std::regex names(R"(.*base-[0-9]+_targ-[0-9]+.*\.csv(\.gz)?)");
  return std::regex_match(name, names);
}

}  // namespace

std::optional<PlanarPose> TeamRecording::truth(int robot, double t) const {
  const std::vector<TruePose>& of = robots[static_cast<std::size_t>(robot)].truth;
  const double gap = relative ? 1.5 : 0.5;
  const auto after =
      std::lower_bound(of.begin(), of.end(), t, [](const TruePose& p, double s) { return p.t < s; });
  if (after == of.end()) return {};
  if (after->t == t) return after->pose;
  if (after == of.begin()) return {};
  const TruePose &a = *(after - 1), &b = *after;
  if (b.t - a.t > gap) return {};
  const double share = (t - a.t) / (b.t - a.t);
  return PlanarPose{a.pose.x + share * (b.pose.x - a.pose.x), a.pose.y + share * (b.pose.y - a.pose.y),
                    wrap(a.pose.psi + share * wrap(b.pose.psi - a.pose.psi))};
}

TeamRecording read_team_recording(const fs::path& place) {
  const std::string expected =
      "expected a folder of MRCLAM (Robot1_Odometry.dat, ...), files of MURP (NAME_base-1_targ-2.csv), or a "
      "camera rig (folder with tagslam.yaml, PREFIX of PREFIX_tagslam.yaml or its bag PREFIX.mcap)";
  std::error_code error;
  const fs::file_status status = fs::status(place, error);
  if (!fs::exists(status))
    throw std::invalid_argument(fmt::format(
        "{}: {}, {}", place.native(),
        error && error != std::errc::no_such_file_or_directory ? error.message() : "not there", expected));
  std::vector<fs::path> mrclam, murp;
  const auto add = [&](const fs::path& file) {
    const std::string name = file.filename().native();
    if (is_of_mrclam(name)) mrclam.push_back(file);
    if (is_of_murp(name)) murp.push_back(file);
  };
  if (fs::is_directory(status)) {
    std::size_t files = 0;
    for (fs::directory_iterator one(place, error), none; !error && one != none; one.increment(error)) {
      if (++files > folder_files_max)
        throw std::invalid_argument(
            fmt::format("{}: more than {} files, {}", place.native(), folder_files_max, expected));
      add(one->path());
    }
    if (error)
      throw std::invalid_argument(fmt::format("{}: {}, {}", place.native(), error.message(), expected));
  } else {
    if (place.native().ends_with(".tar.gz"))
      throw std::invalid_argument(fmt::format("{}: a packed archive, expected its folder: tar xzf {}",
                                              place.native(), place.native()));
    add(place);
    mrclam.clear();
  }
  const std::vector<fs::path>& files = mrclam.empty() ? murp : mrclam;
  if (files.empty()) {
    const FileKind kind = kind_at(place);
    throw std::invalid_argument(fmt::format(
        "{}: {}, {}", place.native(),
        kind.what.empty() ? "no recording of a known kind" : "this is " + kind.shown(), expected));
  }
  RecordingTexts texts;
  for (const fs::path& file : files) texts[file.native()] = read_packed_file(file);
  return mrclam.empty() ? parse_murp(texts, place.native()) : parse_mrclam(texts, place.native());
}

}  // namespace sightline
