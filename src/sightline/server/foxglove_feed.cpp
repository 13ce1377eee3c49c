#include "sightline/server/foxglove_feed.hpp"

#include <sys/eventfd.h>
#include <unistd.h>

#include <cassert>
#include <utility>

#include "sightline/server/admission.hpp"

namespace sightline {

FoxgloveFeed::FoxgloveFeed(std::string name)
    : name_(std::move(name)), session_(random_token()), waiting_(::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)) {}

SchemaId FoxgloveFeed::schema(std::string_view name, std::string_view encoding, std::string_view text) {
  schemas_.push_back({std::string(name), std::string(encoding), std::string(text)});
  return SchemaId{static_cast<std::uint16_t>(schemas_.size() - 1)};
}

ChannelId FoxgloveFeed::channel(SchemaId schema, std::string_view topic, std::string_view message_encoding,
                                const McapWords&) {
  const Schema& of = schemas_.at(static_cast<std::size_t>(schema));
  const std::scoped_lock lock(lock_);
  const std::size_t id = channels_.size();
  channels_.push_back({static_cast<std::uint32_t>(id), std::string(topic), std::string(message_encoding),
                       of.name, of.encoding, of.text});
  subscribers_.push_back(0);
  return ChannelId{static_cast<std::uint16_t>(id)};
}

void FoxgloveFeed::message(ChannelId channel, std::uint32_t, std::uint64_t log_time,
                           std::span<const std::byte> bytes) {
  {
    const std::scoped_lock lock(lock_);
    if (subscribers_.at(static_cast<std::size_t>(channel)) == 0) return;
  }
  open_.messages.push_back({channel, log_time, open_.bytes.size(), bytes.size()});
  open_.bytes.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

void FoxgloveFeed::hand_over(std::uint64_t time) {
  open_.time = time;
  {
    const std::scoped_lock lock(lock_);
    if (bytes_ + open_.bytes.size() > waiting_max) {  // the server has not taken batches for long
      for (const Batch& one : batches_) dropped_ += static_cast<std::int64_t>(one.messages.size());
      batches_.clear();
      bytes_ = 0;
    }
    bytes_ += open_.bytes.size();
    batches_.push_back(std::exchange(open_, {}));
  }
  const std::uint64_t one = 1;
  (void)!::write(waiting_.get(), &one, sizeof one);
}

bool FoxgloveFeed::is_requested() const {
  const std::scoped_lock lock(lock_);
  return subscriptions_ > 0;
}

std::vector<FoxgloveFeed::Batch> FoxgloveFeed::take() {
  std::uint64_t ignored = 0;
  (void)!::read(waiting_.get(), &ignored, sizeof ignored);
  const std::scoped_lock lock(lock_);
  bytes_ = 0;
  return std::exchange(batches_, {});
}

std::vector<FoxgloveChannel> FoxgloveFeed::channels(std::size_t from) const {
  const std::scoped_lock lock(lock_);
  assert(from <= channels_.size() && "channels are never taken away");
  return {channels_.begin() + static_cast<std::ptrdiff_t>(from), channels_.end()};
}

std::size_t FoxgloveFeed::channel_count() const {
  const std::scoped_lock lock(lock_);
  return channels_.size();
}

void FoxgloveFeed::subscribed(ChannelId channel) {
  const std::scoped_lock lock(lock_);
  ++subscribers_.at(static_cast<std::size_t>(channel));
  ++subscriptions_;
}

void FoxgloveFeed::unsubscribed(ChannelId channel) {
  const std::scoped_lock lock(lock_);
  --subscribers_.at(static_cast<std::size_t>(channel));
  --subscriptions_;
}

std::int64_t FoxgloveFeed::dropped() const {
  const std::scoped_lock lock(lock_);
  return dropped_;
}

}  // namespace sightline
