/// Pose of a body from a chain of frame transforms in /tf and /tf_static.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "bridges/dds/topics/conversion.hpp"

namespace sightline::dds {

/// A frame relative to its parent frame.
struct FrameTransform {
  std::string_view parent, child;
  Vec3<double> p{};
  Quaternion q{};
  Nanoseconds stamp = 0;     ///< by the sender's clock
  std::uint64_t writer = 0;  ///< identifier of the writer, unique per writer
};

/// Chain of parents from a body's frame to the frame that is G; the newest transform of each frame
/// applies.
/// A pose has the stamp of the moving transform nearest to the body; those above may be rare
/// corrections. Single thread.
class TransformChain {
 public:
  static constexpr std::size_t deepest = 16,
                               most_static = 256;  ///< frames kept; further ones are ignored

  TransformChain(std::string body, std::string top) : body_(std::move(body)), top_(std::move(top)) {}

  /// Effect of a transform.
  enum class Taken {
    none,           ///< not in the chain, or it does not move the body
    second_writer,  ///< another writer published this frame first; ignored
    moved,          ///< the body moved, if the chain is complete
  };
  Taken take(const FrameTransform& transform);
  /// Accepts a static transform.
  void take_static(const FrameTransform& transform);

  struct BodyPose {
    Vec3<double> p{};
    Quaternion q{};  ///< no_attitude, and p not a number, if a transform has no attitude
    Nanoseconds stamp = 0;
  };
  /// None if the chain does not reach the top frame.
  std::optional<BodyPose> pose() const;
  /// Frame at which an incomplete chain ends; the body's own frame if it has no transform yet;
  /// empty if the chain is complete.
  std::string ends_at() const;

 private:
  struct Edge {
    std::string parent, child;
    Vec3<double> p{};
    Quaternion q{};
    Nanoseconds stamp = 0;
    std::uint64_t writer = 0;
  };
  static void set(Edge& edge, const FrameTransform& transform);
  const Edge* fixed(std::string_view child) const;
  const Edge* moving(std::string_view child) const;
  void find_chain();

  std::string body_, top_;
  std::vector<Edge> fixed_, moving_;
  std::vector<const Edge*> chain_;  // from the body upwards
  bool whole_ = false;
};

}  // namespace sightline::dds
