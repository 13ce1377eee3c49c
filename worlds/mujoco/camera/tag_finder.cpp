#include "worlds/mujoco/camera/tag_finder.hpp"

#include <algorithm>
#include <cstdlib>

#include "sightline/base.hpp"

extern "C" {
#include <apriltag/apriltag.h>
#include <apriltag/common/image_u8.h>
#include <apriltag/tag36h11.h>
}

namespace sightline::mujoco {
namespace {

constexpr std::size_t tags_in_a_picture = 64;

}  // namespace

struct TagFinder::Library {
  apriltag_family_t* family = tag36h11_create();
  apriltag_detector_t* detector = apriltag_detector_create();
};

TagFinder::TagFinder() : library_(std::make_unique<Library>()) {
  apriltag_detector_add_family(library_->detector, library_->family);
  library_->detector->quad_decimate = 1.0F;  // a larger factor reduces the range
  library_->detector->nthreads = 1;          // equal results on every machine
  found_.reserve(tags_in_a_picture);
}

TagFinder::~TagFinder() {
  apriltag_detector_destroy(library_->detector);
  tag36h11_destroy(library_->family);
}

std::vector<std::uint8_t> TagFinder::image(int id) const {
  image_u8_t* const drawn = apriltag_to_image(library_->family, id);
  std::vector<std::uint8_t> all;
  for (int y = 0; y < drawn->height; ++y)
    all.insert(all.end(), drawn->buf + y * drawn->stride, drawn->buf + y * drawn->stride + drawn->width);
  std::free(drawn->buf);  // Debian's library does not export image_u8_destroy()
  std::free(drawn);
  return all;
}

const std::vector<TagInPicture>& TagFinder::find(const Picture& picture) noexcept {
  found_.clear();
  // AprilTag only reads the picture.
  auto* const bytes = const_cast<std::uint8_t*>(picture.bytes().data());
  image_u8_t image = {
      .width = picture.width(), .height = picture.height(), .stride = picture.width(), .buf = bytes};
  zarray_t* const all = apriltag_detector_detect(library_->detector, &image);
  for (int i = 0; i < zarray_size(all) && found_.size() < tags_in_a_picture; ++i) {
    apriltag_detection_t* one = nullptr;
    zarray_get(all, i, &one);
    if (one->hamming > 1) continue;
    TagInPicture& tag = found_.emplace_back(TagInPicture{.id = one->id});
    for (std::size_t k = 0; k < 4; ++k)
      tag.corners[k] = {one->p[k][0] - 0.5 * picture.width(), one->p[k][1] - 0.5 * picture.height()};
  }
  apriltag_detections_destroy(all);
  std::sort(found_.begin(), found_.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
  return found_;
}

}  // namespace sightline::mujoco
