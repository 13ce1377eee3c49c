/// Decorator that adds sensors to a world, and the queue of measurements in transit.
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "sightline/base/same_time.hpp"
#include "sightline/world/rigid_body.hpp"
#include "sightline/world/world.hpp"

namespace sightline {

/// Base of worlds that add sensors to a world with known true states. Everything except those
/// measurements comes from the inner world.
class SensingWorld : public World {
 public:
  const Team& team() const noexcept override { return world_->team(); }
  std::span<const double> start() const noexcept override { return world_->start(); }
  MeasuredMost measured_max() const noexcept override { return world_->measured_max(); }
  void set_presence(std::span<const Presence> presence) noexcept override { world_->set_presence(presence); }
  void surround(const Surroundings& around) noexcept override { world_->surround(around); }
  Measured measure(double t) noexcept override { return world_->measure(t); }
  bool apply(double t, std::span<const double> estimated, const Command& u, double period,
             std::int64_t periods) noexcept override;
  std::span<const double> truth() const noexcept override { return world_->truth(); }
  std::string ended() const override { return world_->ended(); }

  /// The inner world.
  World& seen() noexcept { return *world_; }

 protected:
  explicit SensingWorld(std::unique_ptr<World> world);

  /// Pose and velocity of a body in the stacked state x, under the inputs applied last.
  Sight<double> sight_of(BodyId body, std::span<const double> x) const noexcept;
  /// Attitude, body to G: from the inner world if it reports one, else from the tilt of the model.
  /// Upright if the model has no tilt.
  Quaternion attitude_of(BodyId body, const Sight<double>& sight, const Measured& now) const noexcept;

 private:
  std::unique_ptr<World> world_;
  std::vector<double> applied_;  // inputs, on which the tilt of a model depends
};

/// Queue of items that were measured or sent and have not arrived. Allocates only in its
/// constructor.
///
/// @tparam T  has `arrival` [s]
template <class T>
class UnderWay {
 public:
  UnderWay() = default;
  explicit UnderWay(std::size_t most) : waiting_(most), arrived_(most) {}

  std::size_t capacity() const noexcept { return waiting_.size(); }
  /// Drops the item if the queue is full.
  void send(const T& one) noexcept {
    if (count_ < waiting_.size()) waiting_[count_++] = one;
  }
  template <class Predicate>
  void drop_if(Predicate of_it) noexcept {
    const auto end = waiting_.begin() + static_cast<std::ptrdiff_t>(count_);
    count_ = static_cast<std::size_t>(std::remove_if(waiting_.begin(), end, of_it) - waiting_.begin());
  }
  /// Items that arrive by t [s], in the order of arrival and then of sending; valid until the next
  /// call.
  std::span<const T> take(double t) noexcept {
    std::size_t count = 0, kept = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      T& to = waiting_[i].arrival <= t + same_time ? arrived_[count++] : waiting_[kept++];
      to = waiting_[i];
    }
    count_ = kept;
    // Insertion sort is stable and does not allocate.
    for (std::size_t i = 1; i < count; ++i) {
      for (std::size_t k = i; k > 0 && arrived_[k].arrival < arrived_[k - 1].arrival; --k)
        std::swap(arrived_[k], arrived_[k - 1]);
    }
    return std::span(arrived_).first(count);
  }

 private:
  std::vector<T> waiting_, arrived_;  // the first count_ of waiting_ are pending
  std::size_t count_ = 0;
};

}  // namespace sightline
