#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "sightline/base.hpp"
#include "sightline/import/kinds.hpp"
#include "sightline/readers/ros_bag.hpp"
#include "sightline/sensors.hpp"

namespace sightline {
namespace {

constexpr std::string_view distortion_words = "plumb_bob, rational_polynomial or equidistant";
constexpr Range of_focal_length = {1.0, 1e5, "1 to 1e5 px"}, of_point = {0.01, 4096, "0.01 to 4096 px"};
constexpr Range of_coefficient = {-1e6, 1e6, "-1e6 to 1e6"};
constexpr std::int64_t side_min = 16, side_max = 4096;

template <class All, class Name>
[[noreturn]] void throw_unknown_camera(const std::string& file, const ImportOptions& options, const All& all,
                                       Name name) {
  std::vector<std::string> names;
  for (const auto& one : all) names.push_back(shortened(one_line(one.*name), shown_size));
  throw ScenarioError(
      file, 0, fmt::format("--camera = {}, expected one of {}", options.camera, fmt::join(names, ", ")));
}

/// The tables of a camera, which our reader accepts.
Imported camera_tables(const Camera& camera, const std::string& file, const ImportOptions& options) {
  const std::string robot = options.agent.empty() ? "uav0" : options.agent;
  Imported made;
  made.what = fmt::format("the camera of {}", robot);
  made.text = fmt::format(
      "# Of {}, by `sightline import`: beside the [agent.{}.sensor] that says where the camera is mounted.\n"
      "[agent.{}.camera]\nwidth = {}\nheight = {}\nfocal_length = {}\nprincipal_point = {}\n",
      file_name(file), robot, robot, camera.width, camera.height, toml_numbers(camera.focal_length),
      toml_numbers(camera.principal_point));
  if (camera.distortion != Distortion::none)
    made.text += fmt::format("distortion = \"{}\"\ncoefficients = {}\n",
                             distortions[static_cast<std::size_t>(camera.distortion)],
                             toml_numbers(camera.coefficients));
  return made;
}

/// @param at  the coefficients in the file
void set_distortion_of(Camera& camera, Distortion model, const YamlValue& at) {
  camera.distortion = model;
  camera.coefficients = at.numbers(0, of_coefficient);
  try {
    camera.check();
  } catch (const std::invalid_argument& error) {
    at.throw_invalid(fmt::format("those of its distortion ({})", error.what()));
  }
  const std::vector<double>& all = camera.coefficients;
  const bool zero = std::all_of(all.begin(), all.end(), [](double c) { return c == 0; });
  if (zero && model != Distortion::equidistant)
    camera.distortion = Distortion::none, camera.coefficients.clear();
}

}  // namespace

Camera ros_camera(const YamlValue& camera) {
  Camera read;
  read.width = static_cast<int>(camera.at("image_width", "the width in px").integer(side_min, side_max));
  read.height = static_cast<int>(camera.at("image_height", "the height in px").integer(side_min, side_max));
  const YamlValue matrix = camera.at("camera_matrix", "the 9 numbers of the matrix K");
  const std::vector<double> K = matrix.numbers(9);
  const bool pinhole = K[1] == 0 && K[3] == 0 && K[6] == 0 && K[7] == 0 && K[8] == 1;
  if (!pinhole) matrix.throw_invalid("[f_x, 0, c_x, 0, f_y, c_y, 0, 0, 1]: pixels without skew");
  for (const std::size_t i : {std::size_t{0}, std::size_t{4}})
    if (!of_focal_length.holds(K[i]))
      matrix.throw_invalid(fmt::format("focal lengths of {}", of_focal_length.expected));
  for (const std::size_t i : {std::size_t{2}, std::size_t{5}})
    if (!of_point.holds(K[i]))
      matrix.throw_invalid(fmt::format("a principal point of {}", of_point.expected));
  read.focal_length = {K[0], K[4]};
  read.principal_point = {K[2], K[5]};
  const std::optional<YamlValue> word = camera.find("distortion_model");
  const std::optional<YamlValue> numbers = camera.find("distortion_coefficients");
  if (word) {
    const std::string name = word->text(distortion_words);
    const auto model = std::find(distortions.begin() + 1, distortions.end(), name);
    if (model == distortions.end()) word->throw_invalid(distortion_words);
    const YamlValue list = camera.at("distortion_coefficients", "the coefficients of the distortion");
    set_distortion_of(read, static_cast<Distortion>(model - distortions.begin()), list);
  } else if (numbers) {
    // Older files have the coefficients of plumb_bob alone.
    set_distortion_of(read, Distortion::plumb_bob, *numbers);
  }
  return read;
}

Imported import_camera_info(const YamlValue& camera, const std::string& file, const ImportOptions& options) {
  Imported made = camera_tables(ros_camera(camera), file, options);
  if (const auto R = camera.find("rectification_matrix")) {
    const std::vector<double> r = R->numbers(9);
    for (std::size_t i = 0; i < 9; ++i) {
      if (std::abs(r[i] - (i % 4 == 0 ? 1.0 : 0.0)) < 1e-6) continue;
      made.notes.emplace_back(
          "rectification_matrix has no counterpart: the picture is that of camera_matrix");
      break;
    }
  }
  return made;
}

YamlValue calibration_of(const std::string& file, const BagCamera& camera) {
  const std::string& word = camera.distortion_model;
  const bool known = std::find(distortions.begin() + 1, distortions.end(), word) != distortions.end();
  if (!known && !(word.empty() && camera.D.empty()))
    throw ScenarioError(file, 0,
                        fmt::format("{}: distortion_model = {}, expected {}", camera.topic,
                                    shortened(word, shown_size), distortion_words));
  std::string text =
      fmt::format("{{image_width: {}, image_height: {}, camera_matrix: [{}], rectification_matrix: [{}]",
                  camera.width, camera.height, fmt::join(camera.K, ", "), fmt::join(camera.R, ", "));
  if (known)
    text +=
        fmt::format(", distortion_model: {}, distortion_coefficients: [{}]", word, fmt::join(camera.D, ", "));
  return {text + "}", fmt::format("{}: {}", file, camera.topic)};
}

Imported import_bag(const std::filesystem::path& bag, const ImportOptions& options) {
  const std::string& file = bag.native();
  const auto all = [&] {
    try {
      return RosBag(bag).cameras();
    } catch (const std::invalid_argument& error) {
      const std::string_view sentence = error.what();
      // It begins with the file.
      throw ScenarioError(file, 0, sentence.substr(sentence.starts_with(file + ": ") ? file.size() + 2 : 0));
    }
  }();
  if (all.empty())
    throw ScenarioError(file, 0,
                        "no sensor_msgs/CameraInfo, expected a bag with the calibration of a camera");
  const auto chosen = std::find_if(all.begin(), all.end(), [&](const BagCamera& camera) {
    return options.camera.empty() || camera.topic == options.camera;
  });
  if (chosen == all.end()) throw_unknown_camera(file, options, all, &BagCamera::topic);
  Imported made = import_camera_info(calibration_of(file, *chosen), file, options);
  made.text.insert(made.text.find('\n') + 1, fmt::format("# The topic {}.\n", chosen->topic));
  for (const BagCamera& one : all)
    if (one.topic != chosen->topic)
      made.notes.push_back(fmt::format("{} is left out, --camera chooses it", one.topic));
  return made;
}

Camera kalibr_camera(const YamlValue& camera) {
  const YamlValue model = camera.at("camera_model", "pinhole");
  if (model.text("pinhole") != "pinhole")
    model.throw_invalid("pinhole: calibrate with pinhole-equi, which has wide angles too");
  Camera read;
  const std::vector<YamlValue> size =
      camera.at("resolution", "[width, height] in px").items("[width, height] in px");
  if (size.size() != 2) camera.at("resolution", "").throw_invalid("[width, height] in px");
  read.width = static_cast<int>(size[0].integer(side_min, side_max));
  read.height = static_cast<int>(size[1].integer(side_min, side_max));
  const YamlValue intrinsics = camera.at("intrinsics", "[f_x, f_y, c_x, c_y] in px");
  const std::vector<YamlValue> K = intrinsics.items("[f_x, f_y, c_x, c_y] in px");
  if (K.size() != 4) intrinsics.throw_invalid("[f_x, f_y, c_x, c_y] in px");
  read.focal_length = {K[0].number(of_focal_length), K[1].number(of_focal_length)};
  read.principal_point = {K[2].number(of_point), K[3].number(of_point)};
  if (const auto word = camera.find("distortion_model")) {
    const std::string name = word->text("radtan, equidistant or none");
    if (name != "radtan" && name != "equidistant" && name != "none")
      word->throw_invalid("radtan, equidistant or none");
    if (name != "none") {
      const YamlValue list = camera.at("distortion_coeffs", "the coefficients of the distortion");
      set_distortion_of(read, name == "radtan" ? Distortion::plumb_bob : Distortion::equidistant, list);
    }
  }
  return read;
}

Imported import_camchain(const YamlValue& chain, const std::string& file, const ImportOptions& options) {
  const auto all = chain.entries("the cameras by their names, cam0");
  const auto chosen = std::find_if(all.begin(), all.end(), [&](const auto& entry) {
    return options.camera.empty() || entry.first == options.camera;
  });
  if (chosen == all.end())
    throw_unknown_camera(file, options, all, &std::pair<std::string, YamlValue>::first);
  const Camera read = kalibr_camera(chosen->second);
  Imported made = camera_tables(read, file, options);
  made.text.insert(made.text.find('\n') + 1,
                   fmt::format("# Camera {} of kalibr.\n", one_line(chosen->first)));
  for (const std::string_view key : {"T_cam_imu", "timeshift_cam_imu"})
    if (chosen->second.find(key))
      made.notes.push_back(
          fmt::format("{} has no counterpart here: [agent.NAME.sensor] has the mounting", key));
  for (const auto& [name, unused] : all)
    if (name != chosen->first)
      made.notes.push_back(fmt::format("{} is left out, --camera chooses it", one_line(name)));
  return made;
}

}  // namespace sightline
