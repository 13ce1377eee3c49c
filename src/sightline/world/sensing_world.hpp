/// A world around another, with sensors of its own; and what is on its way from a sensor to the controller.
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

/// Any world that knows the truth, for sensors that are not part of it: all but what they measure is the inner world's.
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

  /// What is seen of a body in this state of the team, under the inputs that were applied last.
  Sight<double> sight_of(BodyId body, std::span<const double> x) const noexcept;
  /// Body to G: as the inner world tells it, else as the model leans; upright where it says nothing.
  Quaternion attitude_of(BodyId body, const Sight<double>& sight, const Measured& now) const noexcept;

 private:
  std::unique_ptr<World> world_;
  std::vector<double> applied_;  // inputs, by which robots lean
};

/// Things that were measured or sent and have not arrived; takes no memory after its construction.
///
/// @tparam T  has `arrival` [s]
template <class T>
class UnderWay {
 public:
  UnderWay() = default;
  explicit UnderWay(std::size_t most) : waiting_(most), arrived_(most) {}

  std::size_t capacity() const noexcept { return waiting_.size(); }
  /// Drops it when there is no room.
  void send(const T& one) noexcept {
    if (count_ < waiting_.size()) waiting_[count_++] = one;
  }
  template <class Predicate>
  void drop_if(Predicate of_it) noexcept {
    const auto end = waiting_.begin() + static_cast<std::ptrdiff_t>(count_);
    count_ = static_cast<std::size_t>(std::remove_if(waiting_.begin(), end, of_it) - waiting_.begin());
  }
  /// What arrives by t [s], in the order of arrival and then of sending; valid until the next call.
  std::span<const T> take(double t) noexcept {
    std::size_t count = 0, kept = 0;
    for (std::size_t i = 0; i < count_; ++i) {
      T& to = waiting_[i].arrival <= t + same_time ? arrived_[count++] : waiting_[kept++];
      to = waiting_[i];
    }
    count_ = kept;
    // Insertion keeps the order of equals and takes no memory.
    for (std::size_t i = 1; i < count; ++i) {
      for (std::size_t k = i; k > 0 && arrived_[k].arrival < arrived_[k - 1].arrival; --k)
        std::swap(arrived_[k], arrived_[k - 1]);
    }
    return std::span(arrived_).first(count);
  }

 private:
  std::vector<T> waiting_, arrived_;  // the first count_ wait
  std::size_t count_ = 0;
};

}  // namespace sightline
