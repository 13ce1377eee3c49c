#include "cli/fault_keys.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>

namespace sightline::cli {
namespace {

constexpr int key_wait = 100;              // [ms]
constexpr int largest_number = 1'000'000;  // greatest number of a robot

}  // namespace

std::optional<FaultTyping::Requested> FaultTyping::take(char key) {
  help_ = key == '?' || key == 'h';
  const bool digit = std::isdigit(static_cast<unsigned char>(key)) != 0;
  if (digit) number_ = std::min(largest_number, (typing_ ? 10 * number_ : 0) + (key - '0'));
  typing_ = digit;
  for (std::size_t i = 0; i < link_faults.size(); ++i) {
    if (link_faults[i].key == key && number_ > 0)
      return Requested{static_cast<std::size_t>(number_ - 1), static_cast<LinkFaultKind>(i)};
  }
  return std::nullopt;
}

std::string fault_keys_help() {
  std::string text = "faults by key: the number of a robot, then a letter; again: it ends\n";
  for (const LinkFaultText& fault : link_faults) {
    text += fmt::format("  {}  {:<18}{}", fault.key, fault.name, fault.meaning);
    if (!fault.size.empty()) text += fmt::format(" ({} {})", fault.fallback, fault.size);
    text += '\n';
  }
  return text + "  ?  this\n";
}

bool FaultKeys::on_a_terminal() {
  // Do not read from a terminal that belongs to another process group in the foreground.
  return ::isatty(STDIN_FILENO) == 1 && ::tcgetpgrp(STDIN_FILENO) == ::getpgrp();
}

FaultKeys::FaultKeys(Take take, Help help) {
  if (!on_a_terminal()) return;
  thread_.start([this, take = std::move(take), help = std::move(help)] { read(take, help); });
}

FaultKeys::~FaultKeys() {
  done_ = true;
  thread_.join();
}

void FaultKeys::read(const Take& take, const Help& help) const {
  termios before{};
  if (::tcgetattr(STDIN_FILENO, &before) != 0) return;
  termios by_key = before;
  by_key.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);
  (void)::tcsetattr(STDIN_FILENO, TCSANOW, &by_key);
  FaultTyping typing;
  while (!done_) {
    pollfd waiting = {STDIN_FILENO, POLLIN, 0};
    if (::poll(&waiting, 1, key_wait) <= 0) continue;
    char key = 0;
    if (::read(STDIN_FILENO, &key, 1) != 1) break;
    if (const auto requested = typing.take(key)) take(*requested);
    if (typing.asks_for_help()) help();
  }
  (void)::tcsetattr(STDIN_FILENO, TCSANOW, &before);
}

}  // namespace sightline::cli
