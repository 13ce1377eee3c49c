#include "bridges/dds/topics/transform_chain.hpp"

#include <algorithm>
#include <limits>

namespace sightline::dds {
namespace {

/// tf2 treats "/map" as "map".
std::string_view without_slash(std::string_view frame) {
  return frame.starts_with('/') ? frame.substr(1) : frame;
}

template <class Edges>
auto* edge_of(Edges& edges, std::string_view child) {
  const auto found =
      std::find_if(edges.begin(), edges.end(), [&](const auto& edge) { return edge.child == child; });
  return found != edges.end() ? &*found : nullptr;
}

}  // namespace

void TransformChain::set(Edge& edge, const FrameTransform& transform) {
  edge.parent = without_slash(transform.parent);
  edge.child = without_slash(transform.child);
  edge.p = transform.p;
  edge.q = normalised(transform.q);
  edge.stamp = transform.stamp;
  edge.writer = transform.writer;
}

const TransformChain::Edge* TransformChain::fixed(std::string_view child) const {
  return edge_of(fixed_, child);
}
const TransformChain::Edge* TransformChain::moving(std::string_view child) const {
  return edge_of(moving_, child);
}

void TransformChain::find_chain() {
  chain_.clear();
  std::string_view frame = body_;
  whole_ = false;
  while (!whole_ && chain_.size() < deepest) {
    const Edge* edge = moving(frame);
    if (edge == nullptr) edge = fixed(frame);
    if (edge == nullptr) return;
    chain_.push_back(edge);
    frame = edge->parent;
    whole_ = frame == top_;
  }
}

TransformChain::Taken TransformChain::take(const FrameTransform& transform) {
  const std::string_view child = without_slash(transform.child);
  Edge* edge = edge_of(moving_, child);
  const bool known = edge != nullptr;
  if (!known) {
    // Keeps only the frame of the body, or the frame at which the chain ends now.
    if (moving_.size() == deepest || (child != body_ && child != ends_at())) return Taken::none;
    // emplace_back() may invalidate the chain's pointers.
    chain_.clear();
    edge = &moving_.emplace_back();
  } else if (edge->writer != transform.writer) {
    return Taken::second_writer;
  }
  const bool elsewhere = !known || edge->parent != without_slash(transform.parent);
  set(*edge, transform);
  if (elsewhere) find_chain();
  const auto nearest =
      std::find_if(chain_.begin(), chain_.end(), [&](const Edge* e) { return moving(e->child) == e; });
  return nearest != chain_.end() && *nearest == edge ? Taken::moved : Taken::none;
}

void TransformChain::take_static(const FrameTransform& transform) {
  Edge* edge = edge_of(fixed_, without_slash(transform.child));
  if (edge == nullptr) {
    if (fixed_.size() == most_static) return;
    chain_.clear();
    edge = &fixed_.emplace_back();
  }
  set(*edge, transform);
  find_chain();
}

std::optional<TransformChain::BodyPose> TransformChain::pose() const {
  if (!whole_) return std::nullopt;
  BodyPose pose{{}, {1, 0, 0, 0}, 0};
  for (const Edge* edge : chain_) {
    if (edge->q == no_attitude) {
      constexpr double none = std::numeric_limits<double>::quiet_NaN();
      return BodyPose{{none, none, none}, no_attitude, edge->stamp};
    }
    pose.p = edge->p + rotation(edge->q).to_G(pose.p);
    pose.q = edge->q * pose.q;
    if (pose.stamp == 0 && moving(edge->child) == edge) pose.stamp = edge->stamp;
  }
  return pose;
}

std::string TransformChain::ends_at() const {
  if (chain_.empty()) return body_;
  return whole_ ? std::string() : chain_.back()->parent;
}

}  // namespace sightline::dds
