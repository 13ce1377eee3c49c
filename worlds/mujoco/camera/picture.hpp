/// What a lens, motion and a sensor make of a rendered picture.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sightline/base/fixed.hpp"
#include "sightline/world/disturbance.hpp"

namespace sightline::mujoco {

/// Grey pictures of one size, the top row first.
class Picture {
 public:
  Picture(int width, int height);

  /// From pixels of three bytes, the bottom row first, as OpenGL reads them.
  void take(std::span<const std::uint8_t> rgb) noexcept;
  /// A Gaussian of that standard deviation [px].
  void blur(double sigma) noexcept;
  /// A straight way of the whole picture, to the right and down [px].
  void smear(const Vec2<double>& way) noexcept;
  /// Normal noise of that standard deviation [grey levels], and whole levels from 0 to 255.
  void add_noise(double sigma, RandomStream& chance) noexcept;

  int width() const noexcept { return width_; }
  int height() const noexcept { return height_; }
  /// After add_noise().
  std::span<const std::uint8_t> bytes() const noexcept { return bytes_; }

 private:
  std::size_t at(int x, int y) const noexcept { return static_cast<std::size_t>(y * width_ + x); }
  int width_, height_;
  std::vector<float> grey_, other_;
  std::vector<std::uint8_t> bytes_;
  std::vector<float> normals_;  // read from a place that is drawn for each row
};

}  // namespace sightline::mujoco
