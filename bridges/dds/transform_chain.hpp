/// Where a body is by transforms between frames, as /tf and /tf_static have them.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "bridges/dds/conversion.hpp"

namespace sightline::dds {

/// A frame in another one, its parent.
struct FrameTransform {
  std::string_view parent, child;
  Vec3<double> p{};
  Quaternion q{};
  Nanoseconds stamp = 0;     ///< by the sender's clock
  std::uint64_t writer = 0;  ///< a number of its own for each
};

/// The chain of parents from a body's frame up to the frame that is G. Of each frame the newest transform counts. A pose is as old as
/// the moving transform that is nearest to the body: those above it may be corrections that come seldom. One thread.
class TransformChain {
 public:
  static constexpr std::size_t deepest = 16,
                               most_static = 256;  ///< frames that are kept; what is more is not

  TransformChain(std::string body, std::string top) : body_(std::move(body)), top_(std::move(top)) {}

  /// What became of a transform.
  enum class Taken {
    none,           ///< it is of no frame of the chain, or it does not move the body
    second_writer,  ///< another one said this frame before: not believed
    moved,          ///< the body is elsewhere, if the chain is whole
  };
  Taken take(const FrameTransform& transform);
  /// One that holds for ever.
  void take_static(const FrameTransform& transform);

  struct BodyPose {
    Vec3<double> p{};
    Quaternion q{};  ///< no_attitude, and p not a number, where one of them has none
    Nanoseconds stamp = 0;
  };
  /// None where the chain does not reach the top.
  std::optional<BodyPose> pose() const;
  /// The frame in which the chain ends that does not reach the top, the body's own where nothing was said of it; empty: it is whole.
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
  std::vector<const Edge*> chain_;  // from the body up
  bool whole_ = false;
};

}  // namespace sightline::dds
