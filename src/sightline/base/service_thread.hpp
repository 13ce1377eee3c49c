/// The threads of the process. No other file creates one; tests/house/threads_test.cpp checks this.
#pragma once

#include <exception>
#include <future>
#include <thread>
#include <type_traits>
#include <utility>

#include "sightline/base/failure.hpp"

namespace sightline {

/// Thread of a service beside the control thread: a page, a publisher, a log. An exception of its
/// function ends that service alone: it is caught and reported once (Failure), and the process
/// continues. The same holds if the machine has no thread for it.
class ServiceThread {
 public:
  /// @param service  name for reports, "the page"; the text must outlive this object
  explicit ServiceThread(const char* service) noexcept : service_(service) {}
  /// As start().
  template <class Run>
  ServiceThread(const char* service, Run run) noexcept : ServiceThread(service) {
    start(std::move(run));
  }
  ~ServiceThread() { join(); }
  ServiceThread(const ServiceThread&) = delete;
  ServiceThread& operator=(const ServiceThread&) = delete;

  /// Runs a function on the thread; may be called once.
  /// @param on_failure  stops the service; called by that thread after run() threw, by the caller
  ///   if the machine had no thread. Its exceptions are dropped
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
  /// As start(), for a function that does not throw and without which a flight cannot begin.
  /// @throws std::system_error if the machine has no thread
  template <class Run>
  void start_or_throw(Run run) {
    static_assert(std::is_nothrow_invocable_v<Run&>, "what a flight waits for must not throw");
    thread_ = std::thread(std::move(run));
  }

  /// Waits until the function ends; the destructor calls it too.
  void join() noexcept {
    if (thread_.joinable()) thread_.join();
  }

  bool failed() const noexcept { return failure_.occurred(); }
  /// Why the service has ended; empty if nothing failed.
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

/// Runs a function on a separate thread and waits for its end. Changes to the thread, such as its
/// priority or floating point mode, end with it.
/// @throws the exceptions of the function; std::system_error if the machine has no thread
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

/// Result of a function that runs on a separate thread. The future rethrows its exception; the
/// future's destructor waits for the thread.
/// @throws std::system_error if the machine has no thread
template <class Run>
auto run_for_value(Run run) {
  return std::async(std::launch::async, std::move(run));
}

/// Runs a function on a detached thread; the function owns the data it uses. Its exceptions are
/// dropped.
/// @return whether the machine has a thread
template <class Run>
bool run_unattended(Run run) noexcept {
  try {
    std::thread([run = std::move(run)]() mutable noexcept {
      try {
        run();
      } catch (...) {
        static_cast<void>(0);  // the thread is detached
      }
    }).detach();
    return true;
  } catch (...) {
    return false;
  }
}

}  // namespace sightline
