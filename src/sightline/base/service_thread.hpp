/// The threads of the process. No other file makes one, which tests/house/threads_test.cpp checks.
#pragma once

#include <exception>
#include <future>
#include <thread>
#include <type_traits>
#include <utility>

#include "sightline/base/failure.hpp"

namespace sightline {

/// The thread of a service beside the control thread: a page, a publisher, a log. What its function throws ends that service
/// alone: it is caught, reported once (Failure), and the process goes on. The same holds where the machine has no thread for it.
class ServiceThread {
 public:
  /// @param service  in a report, "the page"; text that lives as long as this
  explicit ServiceThread(const char* service) noexcept : service_(service) {}
  /// As start().
  template <class Run>
  ServiceThread(const char* service, Run run) noexcept : ServiceThread(service) {
    start(std::move(run));
  }
  ~ServiceThread() { join(); }
  ServiceThread(const ServiceThread&) = delete;
  ServiceThread& operator=(const ServiceThread&) = delete;

  /// Runs a function on the thread; once.
  /// @param on_failure  stops the service after run() threw, by that thread; after the machine had no thread, by the caller. What
  ///                    it throws is dropped
  template <class Run, class OnFailure>
  void start(Run run, OnFailure on_failure) noexcept {
    try {
      thread_ = std::thread([this, run = std::move(run), on_failure]() mutable noexcept {
        try {
          run();
        } catch (...) {
          fail(on_failure);
        }
      });
    } catch (...) {
      fail(on_failure);
    }
  }
  template <class Run>
  void start(Run run) noexcept {
    start(std::move(run), [] {});
  }
  /// As start(), of a function that throws nothing, for work that a flight cannot begin without.
  /// @throws std::system_error where the machine has no thread
  template <class Run>
  void start_or_throw(Run run) {
    static_assert(std::is_nothrow_invocable_v<Run&>, "what a flight waits for must not throw");
    thread_ = std::thread(std::move(run));
  }

  /// Waits for the end of the function; the destructor does, too.
  void join() noexcept {
    if (thread_.joinable()) thread_.join();
  }

  bool failed() const noexcept { return failure_.occurred(); }
  /// Why the service has ended; empty where nothing failed.
  std::string_view failure() const noexcept { return failure_.sentence(); }

 private:
  template <class OnFailure>
  void fail(OnFailure& on_failure) noexcept {
    failure_.record(service_);
    try {
      on_failure();
    } catch (...) {
      static_cast<void>(0);  // the service is over in any case
    }
  }

  const char* service_;
  Failure failure_;
  std::thread thread_;
};

/// Runs a function on a thread of its own and waits for its end, for what it changes of its thread: a priority, a mode.
/// @throws what the function throws; std::system_error where the machine has no thread
template <class Run>
void run_apart(Run&& run) {
  std::exception_ptr thrown;
  std::thread([&]() noexcept {
    try {
      run();
    } catch (...) {
      thrown = std::current_exception();
    }
  }).join();
  if (thrown) std::rethrow_exception(thrown);
}

/// What a function computes on a thread of its own. The future throws what the function throws, and its end waits for the thread.
/// @throws std::system_error where the machine has no thread
template <class Run>
auto run_for_value(Run run) {
  return std::async(std::launch::async, std::move(run));
}

/// Runs a function on a thread that nobody waits for; the function owns what it uses. What it throws is dropped.
/// @return whether the machine has a thread
template <class Run>
bool run_unattended(Run run) noexcept {
  try {
    std::thread([run = std::move(run)]() mutable noexcept {
      try {
        run();
      } catch (...) {
        static_cast<void>(0);  // nobody waits for it
      }
    }).detach();
    return true;
  } catch (...) {
    return false;
  }
}

}  // namespace sightline
