/// The effects of lens, motion and sensor on a rendered picture.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "sightline/base.hpp"
#include "sightline/world.hpp"

namespace sightline::mujoco {

/// Greyscale pictures of one size, top row first.
class Picture {
 public:
  Picture(int width, int height);

  /// Reads pixels of three bytes, bottom row first, as OpenGL returns them.
  void take(std::span<const std::uint8_t> rgb) noexcept;
  /// Applies a Gaussian blur with this standard deviation [px].
  void blur(double sigma) noexcept;
  /// Applies a linear motion blur to the whole picture; `way` points right and down [px].
  void smear(const Vec2<double>& way) noexcept;
  /// Adds normal noise with this standard deviation [grey levels], and rounds to levels from 0 to
  /// 255.
  void add_noise(double sigma, RandomStream& chance) noexcept;

  int width() const noexcept { return width_; }
  int height() const noexcept { return height_; }
  /// The pixels; valid after add_noise().
  std::span<const std::uint8_t> bytes() const noexcept { return bytes_; }

 private:
  std::size_t at(int x, int y) const noexcept { return static_cast<std::size_t>(y * width_ + x); }
  int width_, height_;
  std::vector<float> grey_, other_;
  std::vector<std::uint8_t> bytes_;
  std::vector<float> normals_;  // read from a position drawn per row
};

}  // namespace sightline::mujoco
