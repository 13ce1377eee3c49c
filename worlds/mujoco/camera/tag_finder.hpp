/// AprilTag: draws tags, and finds tags in pictures.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "sightline/sensors.hpp"
#include "worlds/mujoco/camera/picture.hpp"

namespace sightline::mujoco {

/// A tag in a picture.
struct TagInPicture {
  int id = 0;
  std::array<Vec2<double>, 4>
      corners{};  ///< as of FoundTag: from the centre of the picture, to the right and down [px]
};

/// Finder for tags of tag36h11. For one thread; find() allocates memory.
class TagFinder {
 public:
  /// Number of tags in the family.
  static constexpr int tags = 587;
  /// Side of image() in pixels; the black square takes 8 of 10.
  static constexpr int cells = 10;

  TagFinder();
  ~TagFinder();
  TagFinder(const TagFinder&) = delete;
  TagFinder& operator=(const TagFinder&) = delete;

  /// A tag with its white border: `cells` x `cells` grey levels, top row first.
  std::vector<std::uint8_t> image(int id) const;
  /// The tags in the picture with at most one wrong bit; valid until the next call.
  const std::vector<TagInPicture>& find(const Picture& picture) noexcept;

 private:
  struct Library;
  std::unique_ptr<Library> library_;
  std::vector<TagInPicture> found_;
};

}  // namespace sightline::mujoco
