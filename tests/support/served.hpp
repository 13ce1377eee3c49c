/// A command that serves a page, as a process.
#pragma once

#include <array>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

namespace sightline::test {

class Served {
 public:
  /// @param arguments  of a command that ends by itself
  explicit Served(const std::string& arguments)
      : pipe_(::popen(("echo $$; exec '" SIGHTLINE_BINARY "' " + arguments + " 2>&1").c_str(), "r")) {
    std::array<char, 4096> line{};
    while (url_.empty() && std::fgets(line.data(), line.size(), pipe_) != nullptr) {
      const std::string said(line.data());
      if (pid_ == 0) {
        pid_ = std::atoi(said.c_str());
        continue;
      }
      if (const std::size_t at = said.find("http://"); at != std::string::npos)
        url_ = said.substr(at, said.find('\n') - at);
      reported_ += said;
    }
  }
  /// Ends it now, as Ctrl-C does.
  ~Served() {
    if (pipe_ != nullptr && pid_ > 0) ::kill(pid_, SIGTERM);
    (void)end();
  }
  Served(const Served&) = delete;
  Served& operator=(const Served&) = delete;

  const std::string& url() const { return url_; }
  std::uint16_t port() const {
    const std::size_t colon = url_.rfind(':');
    return colon == std::string::npos ? std::uint16_t{0}
                                      : static_cast<std::uint16_t>(std::atoi(&url_[colon + 1]));
  }
  /// Waits for its end. @return what it said
  std::string end() {
    if (pipe_ == nullptr) return reported_;
    std::array<char, 4096> line{};
    while (std::fgets(line.data(), line.size(), pipe_) != nullptr) reported_ += line.data();
    ::pclose(pipe_);
    pipe_ = nullptr;
    return reported_;
  }

 private:
  FILE* pipe_;
  int pid_ = 0;
  std::string url_, reported_;
};

}  // namespace sightline::test
