#include "sightline/server/foxglove_session.hpp"

#include <fmt/format.h>

#include <string_view>
#include <utility>
#include <variant>

namespace sightline {
namespace {

ChannelId channel_id(std::uint32_t id) { return ChannelId{static_cast<std::uint16_t>(id)}; }

}  // namespace

FoxgloveSession::FoxgloveSession(FoxgloveFeed& feed, Connection& to) : feed_(feed), to_(to) {
  put(WebsocketOp::text, foxglove_server_info(feed.name(), feed.session()));
  advertise();
}

FoxgloveSession::~FoxgloveSession() {
  for (const auto& [subscription, channel] : channel_of_) feed_.unsubscribed(channel_id(channel));
}

void FoxgloveSession::advertise() {
  const std::vector<FoxgloveChannel> channels = feed_.channels(advertised_);
  // Sent regardless of size: the server itself defines the topics of a flight.
  if (!channels.empty()) to_.add(websocket_frame(WebsocketOp::text, foxglove_advertise(channels)));
  advertised_ += channels.size();
}

void FoxgloveSession::receive(const WebsocketReader::Frame& message) {
  if (message.op != WebsocketOp::text)
    return send_status(FoxgloveLevel::error, "a binary message, expected none: this server only publishes");
  const FoxgloveRequest request = read_foxglove(message.payload);
  if (const auto* more = std::get_if<FoxgloveSubscribe>(&request)) return subscribe(*more);
  if (const auto* less = std::get_if<FoxgloveUnsubscribe>(&request)) return unsubscribe(*less);
  send_status(FoxgloveLevel::error, std::get<FoxgloveRefused>(request).why);
}

void FoxgloveSession::subscribe(const FoxgloveSubscribe& request) {
  std::string fault;  // the first one: a request has at most one answer
  for (const auto& [id, channel] : request.subscriptions) {
    std::string why;
    if (channel >= advertised_) {
      why = fmt::format("channelId = {}, expected one that was advertised, below {}", channel, advertised_);
    } else if (channel_of_.contains(id)) {
      why = fmt::format("subscription id = {}, expected one that is not in use", id);
    } else if (subscription_of_.contains(channel)) {
      why = fmt::format("channelId = {}, expected one that is not subscribed to already", channel);
    } else {
      channel_of_[id] = channel;
      subscription_of_[channel] = id;
      feed_.subscribed(channel_id(channel));
    }
    if (fault.empty()) fault = std::move(why);
  }
  if (!fault.empty()) send_status(FoxgloveLevel::error, fault);
}

void FoxgloveSession::unsubscribe(const FoxgloveUnsubscribe& request) {
  std::string fault;
  for (const std::uint32_t id : request.ids) {
    const auto found = channel_of_.find(id);
    if (found == channel_of_.end()) {
      if (fault.empty()) fault = fmt::format("subscription id = {}, expected one that is in use", id);
      continue;
    }
    feed_.unsubscribed(channel_id(found->second));
    subscription_of_.erase(found->second);
    channel_of_.erase(found);
  }
  if (!fault.empty()) send_status(FoxgloveLevel::error, fault);
}

void FoxgloveSession::send(const std::vector<FoxgloveFeed::Batch>& batches) {
  if (feed_.channel_count() > advertised_) advertise();
  if (dropped_ > reported_dropped_ && to_.waiting() == 0) {
    send_status(FoxgloveLevel::warning,
                fmt::format("{} messages were left out, for they were not taken in time",
                            dropped_ - reported_dropped_));
    reported_dropped_ = dropped_;
  }
  for (const FoxgloveFeed::Batch& batch : batches) {
    for (const FoxgloveFeed::Message& message : batch.messages) {
      const auto found = subscription_of_.find(static_cast<std::uint32_t>(message.channel));
      if (found == subscription_of_.end()) continue;
      const auto bytes = std::string_view(batch.bytes).substr(message.at, message.count);
      ++(put(WebsocketOp::binary, foxglove_message(found->second, message.time, bytes)) ? sent_ : dropped_);
    }
    put(WebsocketOp::binary, foxglove_time(batch.time));
  }
}

void FoxgloveSession::send_status(FoxgloveLevel level, std::string_view sentence) {
  put(WebsocketOp::text, foxglove_status(level, sentence));
}

bool FoxgloveSession::put(WebsocketOp op, std::string_view message) {
  if (to_.waiting() + message.size() > waiting_max) return false;
  to_.add(websocket_frame(op, message));
  return true;
}

}  // namespace sightline
