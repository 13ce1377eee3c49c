/// What a flight left in its folder, as plain numbers over time: poses, velocities, inputs, statuses and events.
#pragma once

#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "sightline/record/cdr.hpp"
#include "sightline/record/mcap.hpp"

namespace sightline::test {

struct FlightLog {
  struct Seen {
    std::array<double, 3> p{}, v{};
    std::array<double, 2> d{1.0, 0.0};
  };
  struct Body {
    bool is_robot = false;
    std::vector<std::optional<Seen>> seen;  // one a period; none while it is not there
    std::vector<std::vector<double>> u;     // applied, one a period
  };
  struct Reported {
    double time = 0.0;
    std::string kind;
    int value = 0;
  };

  double period = 0.0;  // [s]
  std::vector<std::string> names, script;
  std::map<std::string, Body> bodies;
  std::vector<std::string> status;  // one a period
  std::vector<Reported> events;

  double time(std::size_t k) const { return period * static_cast<double>(k); }

  /// @throws std::runtime_error where the log is not whole
  explicit FlightLog(const std::filesystem::path& file) {
    McapReader reader(file);
    if (!reader.ok() || !reader.metadata().contains("sightline")) throw std::runtime_error(reader.error());
    const McapWords& words = reader.metadata().at("sightline");
    period = std::stod(words.at("period"));
    const auto team = nlohmann::json::parse(words.at("team"));
    for (const auto& body : team.at("bodies")) {
      names.push_back(body.at("name"));
      bodies[names.back()].is_robot = body.at("kind") == "agent";
    }
    for (const auto& event : team.at("events")) script.push_back(event);
    reader.visit([&](const McapMessage& message) { take(message); });
    if (!reader.ok() || reader.truncated())
      throw std::runtime_error("the log is not whole " + reader.error());
  }

 private:
  void take(const McapMessage& message) {
    const auto k =
        static_cast<std::size_t>(std::llround(1e-9 * static_cast<double>(message.log_time) / period));
    const std::string topic(message.topic.substr(1));
    const auto json = [&] {
      const auto* text = reinterpret_cast<const char*>(message.bytes.data());
      return nlohmann::json::parse(text, text + message.bytes.size());
    };
    if (topic == "events") {
      const auto event = json();
      const double value = event.at("value").is_null() ? -1.0 : event.at("value").get<double>();
      events.push_back({event.at("time"), event.at("kind"), static_cast<int>(value)});
      return;
    }
    if (topic == "solver") {
      status.resize(k + 1);
      status[k] = json().at("status");
      return;
    }
    const std::size_t slash = topic.find('/');
    const auto found = bodies.find(topic.substr(0, slash));
    if (slash == std::string::npos || found == bodies.end()) return;
    Body& body = found->second;
    const std::string what = topic.substr(slash + 1);
    const auto at = [&]() -> Seen& {
      if (body.seen.size() <= k) body.seen.resize(k + 1);
      if (!body.seen[k]) body.seen[k].emplace();
      return *body.seen[k];
    };
    if (what == "pose") {
      const auto pose = decode_pose(message.bytes);
      if (!pose) throw std::runtime_error("a pose cannot be read");
      at().p = pose->p, at().d = pose->d;
    } else if (what == "twist") {
      const auto twist = decode_twist(message.bytes);
      if (!twist) throw std::runtime_error("a twist cannot be read");
      at().v = twist->linear;
    } else if (what == "input") {
      constexpr double none = std::numeric_limits<double>::quiet_NaN();
      body.u.resize(k + 1);
      for (const auto& number : json().at("u"))
        body.u[k].push_back(number.is_null() ? none : number.get<double>());
    }
  }
};

}  // namespace sightline::test
