#include "bridges/dds/pose_intake.hpp"

#include <fmt/format.h>

namespace sightline::dds {

void PoseIntake::take(const Motion& local, Nanoseconds sampled, Nanoseconds arrived) noexcept {
  if (!is_finite(local)) {
    ++not_finite_;
    return;
  }
  if (!clock_.fits(sampled, arrived)) {
    ++other_time_;
    return;
  }
  const Nanoseconds stamp = clock_.on_ours(sampled, arrived);
  least_delay_ = clock_.least();
  motion_.put({in_G(origin_, local), stamp});
}

bool PoseIntake::look(SeenMotion& seen) noexcept {
  seen = newest();
  return motion_.count() > 0;
}

const SeenMotion& PoseIntake::newest() noexcept {
  (void)motion_.look(newest_);
  return newest_;
}

std::vector<std::string> PoseIntake::obstacles(std::string_view other_frames) const {
  std::vector<std::string> sentences;
  if (in_other_frames())
    sentences.push_back(
        fmt::format("{}: {} poses in {}", reader_->topic(), other_frame_.load(), other_frames));
  if (of_second_writer())
    sentences.push_back(fmt::format("{}: {} messages of a second writer", reader_->topic(),
                                    reader_->counts().foreign.load()));
  return sentences;
}

std::string PoseIntake::counts() const {
  const ReaderCounts& n = reader_->counts();
  return fmt::format("{} poses, {} not finite, {} of another time, {} in other frames, {} of a second writer",
                     n.received.load(), not_finite_.load(), other_time_.load(), other_frame_.load(),
                     n.foreign.load());
}

}  // namespace sightline::dds
