#include "bridges/dds/simulators/faults.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "sightline/base/now.hpp"

namespace sightline::dds {
namespace {

constexpr double reordered_by = 0.025;  // delay of a reordered message [s]

}  // namespace

void Faults::begin(LinkFaultKind kind, double size) {
  of(kind).size = size;
  of(kind).on = true;
  ++of(kind).changes;
}

void Faults::end(LinkFaultKind kind) {
  of(kind).on = false;
  ++of(kind).changes;
}

bool Faults::loses_request() {
  const std::scoped_lock lock(lock_);
  const bool lost =
      on(LinkFaultKind::request_lost) && of_requests_.uniform() <= size(LinkFaultKind::request_lost);
  counts_.requests_lost += lost ? 1 : 0;
  return lost;
}

bool Faults::changed(LinkFaultKind kind) {
  One& one = of(kind);
  return std::exchange(one.seen, one.changes.load()) != one.seen;
}

Vec3<double> Faults::shift() const {
  using K = LinkFaultKind;
  Vec3<double> shift{};
  for (const K jump : {K::jump, K::jump_reported})
    if (on(jump)) shift.x += size(jump);
  return shift;
}

Motion Faults::distorted(Motion motion) {
  using K = LinkFaultKind;
  if (!on(K::frozen)) frozen_.reset();
  if (on(K::frozen)) motion = frozen_ ? *frozen_ : frozen_.emplace(motion);
  motion.p = motion.p + shift();
  if (changed(K::jump_reported)) ++resets_;
  if (on(K::not_finite) && random_.uniform() <= size(K::not_finite)) {
    motion.p.x = std::numeric_limits<double>::quiet_NaN();
    const std::scoped_lock lock(lock_);
    ++counts_.not_finite;
  }
  return motion;
}

void Faults::pass_on() {
  const std::scoped_lock lock(lock_);
  for (FaultyWriter* writer : writers_) writer->pass_on(monotonic_now());
}

FaultCounts Faults::counts() const {
  const std::scoped_lock lock(lock_);
  return counts_;
}

std::string describe(const FaultCounts& n) {
  std::vector<std::string> words;
  const auto add = [&](std::int64_t count, std::string_view what) {
    if (count > 0) words.push_back(fmt::format("{} {}", count, what));
  };
  add(n.dropped, "messages lost"), add(n.duplicated, "sent twice"), add(n.reordered, "out of order"),
      add(n.not_finite, "poses not finite"), add(n.requests_lost, "requests lost");
  return fmt::format("{}", fmt::join(words, ", "));
}

FaultyWriter::FaultyWriter(dds_entity_t participant, const dds_topic_descriptor_t& type,
                           const std::string& topic, Quality quality, Faults& faults)
    : faults_(faults),
      size_(type.m_size),
      random_(faults.seed_, StreamId::fault,
              [&] {
                const std::scoped_lock lock(faults.lock_);
                return ++faults.writers_made_;
              }()),
      writer_(participant, type, topic, quality) {
  const std::scoped_lock lock(faults_.lock_);
  faults_.writers_.push_back(this);
}

FaultyWriter::~FaultyWriter() {
  const std::scoped_lock lock(faults_.lock_);
  std::erase(faults_.writers_, this);
}

void FaultyWriter::write(const void* message, const std::shared_ptr<const void>& pointed_to) {
  using K = LinkFaultKind;
  if (faults_.on(K::silent)) return;
  const auto occurs = [&](K kind) { return faults_.on(kind) && random_.uniform() <= faults_.size(kind); };
  bool dropped = false, twice = false, reordered = false;
  {
    const std::scoped_lock lock(lock_);
    dropped = occurs(K::drop), twice = occurs(K::duplicate), reordered = occurs(K::reorder);
    const double delay =
        (faults_.on(K::delay) ? faults_.size(K::delay) : 0.0) + (reordered ? reordered_by : 0.0);
    for (int copies = dropped ? 0 : twice ? 2 : 1; copies > 0; --copies) {
      if (delay > 0) {
        Late& late = late_.emplace_back(Late{monotonic_now() + to_nanoseconds(delay),
                                             std::vector<std::uint64_t>((size_ + 7) / 8), pointed_to});
        std::memcpy(late.message.data(), message, size_);
      } else {
        (void)writer_.write(message);
      }
    }
  }
  if (!dropped && !twice && !reordered) return;
  const std::scoped_lock lock(faults_.lock_);
  faults_.counts_.dropped += dropped ? 1 : 0;
  faults_.counts_.duplicated += twice && !dropped ? 1 : 0;
  faults_.counts_.reordered += reordered && !dropped ? 1 : 0;
}

void FaultyWriter::pass_on(std::int64_t now) {
  const std::scoped_lock lock(lock_);
  std::erase_if(late_, [&](const Late& one) {
    if (one.due > now) return false;
    (void)writer_.write(one.message.data());
    return true;
  });
}

}  // namespace sightline::dds
