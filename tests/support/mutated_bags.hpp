/// Damaged bags of ROS 2, and what becomes of them.
#pragma once

#include <filesystem>
#include <fstream>
#include <random>
#include <stdexcept>
#include <string>
#include <string_view>

#include "sightline/readers/ros_bag.hpp"
#include "tests/support/mutated.hpp"
#include "tests/support/ros_bag.hpp"

namespace sightline::test {

/// Reads mutated bags; each is read or refused in one sentence. @return how many were read
inline int read_mutated_bags(int trials, unsigned seed, const std::filesystem::path& file) {
  std::mt19937 random(seed);
  const BagWriter writer = bag_of(LaggingFlight(0.03));
  // Most without compression, so that messages are damaged and not the chunk alone.
  const std::string bytes = writer.bytes(""), packed = writer.bytes("lz4");
  int accepted = 0;
  for (int trial = 0; trial < trials; ++trial) {
    std::filesystem::remove(file);  // a disk writes at once what replaces the content of a file
    std::ofstream(file, std::ios::binary) << mutated(trial % 4 == 0 ? packed : bytes, random);
    try {
      const RosBag bag(file);
      const BagTopics topics = bag.topics();
      (void)bag.cameras();
      if (!topics.bodies.empty()) (void)bag.motion(topics.bodies[random() % topics.bodies.size()]);
      ++accepted;
    } catch (const std::invalid_argument& refusal) {
      const std::string_view sentence = refusal.what();
      const bool is_one = sentence.starts_with(file.native() + ": ") &&
                          sentence.find_first_of(std::string_view("\n\0", 2)) == std::string_view::npos;
      if (!is_one) throw std::logic_error(std::string(sentence));
    }
  }
  return accepted;
}

}  // namespace sightline::test
