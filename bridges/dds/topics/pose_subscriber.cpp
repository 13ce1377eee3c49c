#include "bridges/dds/topics/pose_subscriber.hpp"

#include <fmt/format.h>

#include "sightline/base/now.hpp"

namespace sightline::dds {

bool PoseSubscriber::is_of_numbers(const Motion& motion) noexcept {
  if (is_finite(motion)) return true;
  ++not_finite_;
  return false;
}

bool PoseSubscriber::is_of_our_time(Nanoseconds sampled, Nanoseconds arrived) noexcept {
  const RemoteClock::Stamp stamp = clock_.take(sampled, arrived);
  if (stamp == RemoteClock::Stamp::repeated) ++repeated_;
  if (stamp == RemoteClock::Stamp::ahead) ++other_time_;
  const Nanoseconds late = arrived - clock_.on_ours();
  latency_.note(sampled, arrived, late);
  if (stamp == RemoteClock::Stamp::good) lateness_.add(to_seconds(late));
  if (clock_.jumps() > clock_jumps_) fit_ = {};
  clock_offset_ = clock_.offset();
  clock_drift_ = clock_.drift();
  clock_jumps_ = clock_.jumps();
  return stamp == RemoteClock::Stamp::good;
}

void PoseSubscriber::put(const Motion& local) noexcept {
  const SeenMotion seen = {in_G(origin_, local), clock_.on_ours(), clock_.on_ours() - clock_.offset()};
  motion_.put(seen);
  SeenMotion* const place = each_ ? each_->claim() : nullptr;
  if (place == nullptr) return;
  *place = seen;
  each_->publish();
}

void PoseSubscriber::take_pose(const Vec3<double>& p, const Quaternion& q, Nanoseconds sampled,
                               Nanoseconds arrived) noexcept {
  Motion motion = {p, q, {}, 0.0};
  if (!is_of_numbers(motion) || !is_of_our_time(sampled, arrived)) return;
  switch (fit_.take(p, q, sampled, motion)) {
    case VelocityFit::Outcome::good:
      if (is_of_numbers(motion)) put(motion);
      break;
    case VelocityFit::Outcome::too_few:
      break;
    case VelocityFit::Outcome::jump:
      ++jumps_;
      break;
  }
}

bool PoseSubscriber::look(SeenMotion& seen) noexcept {
  seen = newest();
  return motion_.count() > 0;
}

bool PoseSubscriber::next(SeenMotion& seen) noexcept {
  const SeenMotion* const oldest = each_ ? each_->front() : nullptr;
  if (oldest == nullptr) return false;
  seen = *oldest;
  each_->pop();
  return true;
}

SeenMotion PoseSubscriber::last() const noexcept {
  SeenMotion seen;
  (void)motion_.look(seen);
  return seen;
}

const SeenMotion& PoseSubscriber::newest() noexcept {
  (void)motion_.look(newest_);
  return newest_;
}

void PoseSubscriber::examine(std::string_view frames, std::string_view other_frames, FindingList& to) const {
  const std::string& topic = reader().topic();
  if (in_other_frames())
    to.add(Aspect::frames, Light::red, "{}: {} poses in {}", topic, other_frame_.load(), other_frames);
  else if (motion_.count() > 0)
    to.add(Aspect::frames, Light::green, "poses in {}", frames);
  if (of_second_writer())
    to.add(Aspect::writers, Light::red,
           "{}: {} messages of a second writer; if the first one was restarted, start this program anew",
           topic, second_writer());
  if (why_none_ && motion_.count() == 0) {
    if (reader().counts().received == 0)
      to.add(Aspect::topics, Light::red, "{}: no message", topic);
    else if (not_finite_ > 0)
      to.add(Aspect::topics, Light::red, "{}: {} poses that are not finite", topic, not_finite_.load());
    else if (repeated_ > 0)
      to.add(Aspect::topics, Light::red, "{}: {} poses whose stamps do not rise", topic, repeated_.load());
    else if (!in_other_frames())
      to.add(Aspect::topics, Light::red, "{}: {}", topic, why_none_());
  }
}

std::string PoseSubscriber::counts() const {
  std::string words = fmt::format(
      "{} poses, {} not finite, {} of another time, {} repeated, {} in other frames, {} of a second writer",
      reader().counts().received.load(), not_finite_.load(), other_time_.load(), repeated_.load(),
      other_frame_.load(), second_writer());
  if (clock_jumps_ > 0) words += fmt::format(", {} jumps of its clock", clock_jumps_.load());
  if (why_none_) words += fmt::format(", {} that jumped", jumps_.load());
  return words;
}

}  // namespace sightline::dds
