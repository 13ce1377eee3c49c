#include "sightline/server/foxglove.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/beast/http/rfc7230.hpp>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>

#include "sightline/base/json_text.hpp"

namespace sightline {
namespace {

using FoxgloveJson = nlohmann::ordered_json;

/// Appends a number in little-endian order.
template <class T>
void put_number(std::string& to, T number) {
  for (std::size_t i = 0; i < sizeof(T); ++i)
    to += static_cast<char>(static_cast<unsigned char>(number >> (8 * i)));
}

std::optional<std::uint32_t> id_in(const FoxgloveJson& value) {
  if (!value.is_number_unsigned()) return std::nullopt;
  const auto id = value.get<std::uint64_t>();
  if (id > std::numeric_limits<std::uint32_t>::max()) return std::nullopt;
  return static_cast<std::uint32_t>(id);
}

std::optional<std::uint32_t> id_in(const FoxgloveJson& object, const char* key) {
  const auto found = object.find(key);
  return found == object.end() ? std::nullopt : id_in(*found);
}

FoxgloveRequest read_subscribe(const FoxgloveJson& json) {
  const auto list = json.find("subscriptions");
  if (list == json.end() || !list->is_array())
    return FoxgloveRefused{"subscribe has no list \"subscriptions\", expected one"};
  FoxgloveSubscribe request;
  for (const FoxgloveJson& one : *list) {
    const auto id = one.is_object() ? id_in(one, "id") : std::nullopt;
    const auto channel = one.is_object() ? id_in(one, "channelId") : std::nullopt;
    if (!id || !channel)
      return FoxgloveRefused{
          "a subscription is no object of an \"id\" and a \"channelId\", expected numbers"};
    request.subscriptions.push_back({*id, *channel});
  }
  return request;
}

FoxgloveRequest read_unsubscribe(const FoxgloveJson& json) {
  const auto list = json.find("subscriptionIds");
  if (list == json.end() || !list->is_array())
    return FoxgloveRefused{"unsubscribe has no list \"subscriptionIds\", expected one"};
  FoxgloveUnsubscribe request;
  for (const FoxgloveJson& one : *list) {
    const auto id = id_in(one);
    if (!id) return FoxgloveRefused{"a subscription id is no number, expected one"};
    request.ids.push_back(*id);
  }
  return request;
}

}  // namespace

std::string_view foxglove_protocol(std::string_view named) {
  const boost::beast::http::opt_token_list words({named.data(), named.size()});
  if (!boost::beast::http::validate_list(words)) return {};
  for (const auto word : words) {
    const auto found = std::find(foxglove_protocols.begin(), foxglove_protocols.end(), std::string(word));
    if (found != foxglove_protocols.end()) return *found;
  }
  return {};
}

std::string foxglove_server_info(std::string_view name, std::string_view session) {
  return json_text(FoxgloveJson{{"op", "serverInfo"},
                                {"name", name},
                                {"capabilities", FoxgloveJson::array({"time"})},
                                {"supportedEncodings", FoxgloveJson::array()},
                                {"metadata", FoxgloveJson::object()},
                                {"sessionId", session}});
}

std::string foxglove_advertise(std::span<const FoxgloveChannel> channels) {
  FoxgloveJson list = FoxgloveJson::array();
  for (const FoxgloveChannel& one : channels)
    list.push_back({{"id", one.id},
                    {"topic", one.topic},
                    {"encoding", one.encoding},
                    {"schemaName", one.schema_name},
                    {"schema", one.schema},
                    {"schemaEncoding", one.schema_encoding}});
  return json_text(FoxgloveJson{{"op", "advertise"}, {"channels", std::move(list)}});
}

std::string foxglove_status(FoxgloveLevel level, std::string_view sentence) {
  return json_text(FoxgloveJson{{"op", "status"}, {"level", static_cast<int>(level)}, {"message", sentence}});
}

std::string foxglove_message(std::uint32_t subscription, std::uint64_t time, std::string_view bytes) {
  std::string message = "\x01";
  message.reserve(1 + sizeof subscription + sizeof time + bytes.size());
  put_number(message, subscription);
  put_number(message, time);
  return message += bytes;
}

std::string foxglove_time(std::uint64_t time) {
  std::string message = "\x02";
  put_number(message, time);
  return message;
}

FoxgloveRequest read_foxglove(std::string_view text) {
  const FoxgloveJson json = FoxgloveJson::parse(text, nullptr, false);
  if (!json.is_object()) return FoxgloveRefused{"a message is no JSON object, expected one with an \"op\""};
  const auto op = json.find("op");
  if (op == json.end() || !op->is_string())
    return FoxgloveRefused{"a message has no \"op\", expected subscribe or unsubscribe"};
  const auto& word = op->get_ref<const std::string&>();
  if (word == "subscribe") return read_subscribe(json);
  if (word == "unsubscribe") return read_unsubscribe(json);
  constexpr std::size_t shown = 40;
  return FoxgloveRefused{fmt::format("op = {}, expected subscribe or unsubscribe: this server only publishes",
                                     word.substr(0, shown))};
}

}  // namespace sightline
