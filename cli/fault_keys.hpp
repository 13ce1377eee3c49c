/// Faults of simulated vehicles by key: the number of a robot, then the letter of a fault.
#pragma once

#include <atomic>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "bridges/dds/fleet/link_fault.hpp"
#include "sightline/base.hpp"

namespace sightline::cli {

/// Decodes a sequence of keys.
class FaultTyping {
 public:
  struct Requested {
    std::size_t robot;  ///< from 0
    LinkFaultKind kind;
  };
  /// Takes the next key; a digit begins or continues the number of a robot, which stays until the
  /// next number.
  /// @return a fault to begin or to end
  std::optional<Requested> take(char key);
  /// Whether the last key requested help: ? or h.
  bool asks_for_help() const { return help_; }

 private:
  int number_ = 1;
  bool typing_ = false, help_ = false;
};

/// The keys of all faults, one line each, and their use.
std::string fault_keys_help();

/// Reads keys from a terminal as they are typed, until destroyed; inactive if stdin is no terminal.
class FaultKeys {
 public:
  using Take = std::function<void(FaultTyping::Requested)>;
  using Help = std::function<void()>;
  /// Calls `take` and `help` on a separate thread.
  FaultKeys(Take take, Help help);
  ~FaultKeys();
  FaultKeys(const FaultKeys&) = delete;
  FaultKeys& operator=(const FaultKeys&) = delete;

  static bool on_a_terminal();

 private:
  void read(const Take& take, const Help& help) const;

  std::atomic<bool> done_{false};
  ServiceThread thread_{"the keys of faults"};
};

}  // namespace sightline::cli
