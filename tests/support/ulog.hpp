/// Writes ULogs by the published format, for the tests of their reader.
#pragma once

#include <cstdint>
#include <cstring>
#include <random>
#include <stdexcept>
#include <string>
#include <string_view>

#include "sightline/readers/ulog.hpp"
#include "tests/support/mutated.hpp"

namespace sightline::test {

/// The bytes of numbers, one after the other.
template <class... T>
std::string packed(T... numbers) {
  std::string bytes;
  const auto append = [&bytes](auto number) {
    bytes.append(reinterpret_cast<const char*>(&number), sizeof(number));
  };
  (append(numbers), ...);
  return bytes;
}

inline std::string ulog_message(char kind, const std::string& content) {
  return packed(static_cast<std::uint16_t>(content.size()), kind) + content;
}

inline std::string ulog_head() {
  return std::string("ULog\x01\x12\x35\x01", 8) + packed(std::uint64_t{1000});
}

/// @param appended  where appended data begins; 0: there is none
inline std::string ulog_flags(std::uint64_t appended = 0) {
  std::string flags(8, '\0');
  return ulog_message(
      'B', flags + packed(std::uint64_t{appended > 0}, appended, std::uint64_t{0}, std::uint64_t{0}));
}

inline std::string ulog_key(std::string_view key, const std::string& value) {
  return packed(static_cast<std::uint8_t>(key.size())) + std::string(key) + value;
}

inline std::string ulog_topic(std::uint16_t id, std::string_view name, std::uint8_t instance = 0) {
  return ulog_message('A', packed(instance) + packed(id) + std::string(name));
}

template <class... T>
std::string ulog_data(std::uint16_t id, T... numbers) {
  return ulog_message('D', packed(id, numbers...));
}

/// A small log with each kind of message: nested formats, arrays, padding, two instances.
inline std::string small_ulog() {
  std::string log = ulog_head() + ulog_flags();
  log += ulog_message('F', "esc:uint16_t rpm;float[2] u;uint8_t[2] _padding0;");
  log += ulog_message('F', "status:uint64_t timestamp;esc[2] esc;int8_t level;uint8_t[7] _padding0;");
  log += ulog_message('F', "battery:uint64_t timestamp;double v;bool on;");
  log += ulog_message('I', ulog_key("char[3] ver_hw", "SIM"));
  log += ulog_message('M', '\0' + ulog_key("char[2] boot", "ab"));
  log += ulog_message('M', '\1' + ulog_key("char[2] boot", "cd"));
  log += ulog_message('P', ulog_key("float V_MAX", packed(2.5F)));
  log += ulog_message('Q', '\1' + ulog_key("float V_MAX", packed(1.0F)));
  log += ulog_topic(7, "status") + ulog_topic(300, "battery") + ulog_topic(9, "battery", 1);
  const auto pad = std::uint16_t{0};
  for (std::uint64_t k = 0; k < 3; ++k) {
    const auto rpm = static_cast<std::uint16_t>(1000 + k);
    const float u = 0.25F * static_cast<float>(k);
    log += ulog_data(7, 1'000'000 + 20'000 * k, rpm, u, u + 1, pad, rpm, u + 2, u + 3, pad,
                     static_cast<std::int8_t>(k));
    log += ulog_data(300, 1'000'500 + k, 0.1 * static_cast<double>(k), true);
  }
  log += ulog_data(9, std::uint64_t{2'000'000}, 12.0, false);
  log += ulog_message('L', '6' + packed(std::uint64_t{5}) + "a remark");
  log += ulog_message('S', "\x2f\x73\x13\x20\x25\x0c\xbb\x12") + ulog_message('O', packed(std::uint16_t{40}));
  return log + ulog_message('P', ulog_key("float V_MAX", packed(3.5F)));
}

/// Reads mutated logs; each is read or refused in one sentence. @return how many were read
inline int read_mutated_ulogs(int trials, unsigned seed) {
  std::mt19937 random(seed);
  const std::string log = small_ulog();
  int accepted = 0;
  for (int trial = 0; trial < trials; ++trial) {
    try {
      const ULog read(mutated(log, random), "x.ulg");
      for (const ULog::Topic& topic : read.topics()) {
        if (read.times(topic).size() != topic.at.size()) throw std::logic_error("a message without its time");
        for (const char* field : {"v", "on", "level", "esc[1].rpm", "esc[0].u[1]"})
          if (read.has(topic, field)) (void)read.column(topic, field);
      }
      ++accepted;
    } catch (const std::invalid_argument& refusal) {
      const std::string_view sentence = refusal.what();
      const bool is_one = sentence.starts_with("x.ulg: ") && sentence.find('\n') == std::string_view::npos &&
                          sentence.find('\0') == std::string_view::npos;
      if (!is_one) throw std::logic_error(std::string(sentence));
    }
  }
  return accepted;
}

}  // namespace sightline::test
