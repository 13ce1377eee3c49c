#include "worlds/mujoco/camera/picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "sightline/base.hpp"

namespace sightline::mujoco {
namespace {

constexpr std::size_t normals_drawn = 1 << 16;
constexpr int reach_max = 24;  // of a blur [px]

}  // namespace

Picture::Picture(int width, int height)
    : width_(width),
      height_(height),
      grey_(size(width) * size(height)),
      other_(grey_.size()),
      bytes_(grey_.size()),
      normals_(normals_drawn) {
  RandomStream chance(1, StreamId::sighting, 0);
  for (float& n : normals_) n = static_cast<float>(chance.normal());
}

void Picture::take(std::span<const std::uint8_t> rgb) noexcept {
  for (int y = 0; y < height_; ++y) {
    const std::uint8_t* p = &rgb[3 * at(0, height_ - 1 - y)];
    float* const row = &grey_[at(0, y)];
    for (int x = 0; x < width_; ++x, p += 3) row[x] = 0.125F * static_cast<float>(2 * p[0] + 5 * p[1] + p[2]);
  }
}

void Picture::blur(double sigma) noexcept {
  if (!(sigma > 0.01)) return;
  const int reach = std::min(reach_max, static_cast<int>(std::ceil(3 * sigma)));
  std::array<float, 2 * reach_max + 1> weight{};
  float sum = 0;
  for (int i = -reach; i <= reach; ++i)
    sum += weight[size(i + reach)] = static_cast<float>(std::exp(-0.5 * square(i / sigma)));
  for (float& w : weight) w /= sum;
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      float s = 0;
      for (int i = -reach; i <= reach; ++i)
        s += weight[size(i + reach)] * grey_[at(std::clamp(x + i, 0, width_ - 1), y)];
      other_[at(x, y)] = s;
    }
  }
  for (int y = 0; y < height_; ++y) {
    float* const to = &grey_[at(0, y)];
    std::fill_n(to, width_, 0.0F);
    for (int i = -reach; i <= reach; ++i) {
      const float w = weight[size(i + reach)];
      const float* const from = &other_[at(0, std::clamp(y + i, 0, height_ - 1))];
      for (int x = 0; x < width_; ++x) to[x] += w * from[x];
    }
  }
}

void Picture::smear(const Vec2<double>& way) noexcept {
  const double length = norm(way.x, way.y);
  if (!(length > 0.01)) return;
  const int steps = std::clamp(2 * static_cast<int>(std::ceil(length)) + 1, 3, 41);
  const auto value = [&](double x, double y) {
    x = std::clamp(x, 0.0, width_ - 1.001), y = std::clamp(y, 0.0, height_ - 1.001);
    const int i = static_cast<int>(x), j = static_cast<int>(y);
    const auto a = static_cast<float>(x - i), b = static_cast<float>(y - j);
    const float *const p = &grey_[at(i, j)], *const q = &grey_[at(i, j + 1)];
    return (1 - b) * ((1 - a) * p[0] + a * p[1]) + b * ((1 - a) * q[0] + a * q[1]);
  };
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      float s = 0;
      for (int k = 0; k < steps; ++k) {
        const double part = static_cast<double>(k) / (steps - 1) - 0.5;
        s += value(x + part * way.x, y + part * way.y);
      }
      other_[at(x, y)] = s / static_cast<float>(steps);
    }
  }
  grey_.swap(other_);
}

void Picture::add_noise(double sigma, RandomStream& chance) noexcept {
  const auto scale = static_cast<float>(sigma);
  for (int y = 0; y < height_; ++y) {
    std::size_t k = chance.bits() % normals_drawn;
    for (int x = 0; x < width_; ++x) {
      const float v = grey_[at(x, y)] + scale * normals_[k];
      bytes_[at(x, y)] = static_cast<std::uint8_t>(std::clamp(v + 0.5F, 0.0F, 255.0F));
      if (++k == normals_drawn) k = 0;
    }
  }
}

}  // namespace sightline::mujoco
