/// Damaged recordings of camera rigs, and what becomes of them.
#pragma once

#include <array>
#include <filesystem>
#include <fstream>
#include <random>
#include <stdexcept>
#include <string>
#include <string_view>

#include "sightline/import/read_rig.hpp"
#include "sightline/readers/packed_file.hpp"
#include "sightline/scenario.hpp"
#include "tests/support/mutated.hpp"
#include "tests/support/recorded_rig.hpp"
#include "tests/support/rig_bag.hpp"

namespace sightline::test {

/// Reads mutated recordings, each with one damaged file; each is read or refused in one sentence.
/// @param folder  empty, for the files @return how many were read
inline int read_mutated_rigs(int trials, unsigned seed, const std::filesystem::path& folder) {
  const SyntheticRig rig({.seconds = 0.2});
  const std::filesystem::path table = folder / "table", bag = folder / "bag";
  for (const auto& place : {table, bag}) {
    std::filesystem::create_directories(place);
    write_rig(rig.recording, (place / "").string());
  }
  for (const char* file : {"tag_detections.csv", "cameras.yaml", "camera_poses.yaml"})
    std::filesystem::remove(bag / file);
  std::ofstream(bag / "rig_0.mcap", std::ios::binary) << bag_with_cameras(rig.recording, {}).bytes("");
  const std::array files = {table / "tagslam.yaml",  table / "cameras.yaml", table / "camera_poses.yaml",
                            table / "reference.csv", bag / "tagslam.yaml",   table / "tag_detections.csv",
                            bag / "rig_0.mcap",      bag / "rig_0.mcap"};
  std::mt19937 random(seed);
  int accepted = 0;
  for (int trial = 0; trial < trials; ++trial) {
    const std::filesystem::path& file = files[static_cast<std::size_t>(trial) % files.size()];
    const std::string sound = read_packed_file(file);
    std::filesystem::remove(file);
    std::ofstream(file, std::ios::binary) << mutated(sound, random);
    const auto check = [&](std::string_view sentence) {
      const bool is_one = sentence.starts_with(folder.native()) &&
                          sentence.find_first_of(std::string_view("\n\0", 2)) == std::string_view::npos;
      if (!is_one) throw std::logic_error(std::string(sentence));
    };
    try {
      (void)read_rig_recording(file.parent_path());
      ++accepted;
    } catch (const std::invalid_argument& refusal) {
      check(refusal.what());
    } catch (const ScenarioError& refusal) {
      check(refusal.what());
    }
    std::filesystem::remove(file);
    std::ofstream(file, std::ios::binary) << sound;
  }
  return accepted;
}

}  // namespace sightline::test
