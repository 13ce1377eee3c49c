/// Callbacks for C libraries. No exception passes through the frames of such a library;
/// scripts/lint.py checks that no other functions are passed to them.
#pragma once

#include <type_traits>

#include "sightline/base.hpp"

namespace sightline {

/// Wraps a function in a noexcept one of the same signature. An exception is caught and reported
/// once per function (Failure); the library then receives zero.
template <auto function, class Signature = decltype(function)>
struct CCallback;

template <auto function, class R, class... Args>
struct CCallback<function, R (*)(Args...)> {
  static R call(Args... args) noexcept {
    try {
      return function(args...);
    } catch (...) {
      failure.record("a callback");
    }
    if constexpr (!std::is_void_v<R>) return R{};
  }
  static inline Failure failure{};
};

template <auto function, class R, class... Args>
struct CCallback<function, R (*)(Args...) noexcept> : CCallback<function, R (*)(Args...)> {};

/// The pointer for a C library: c_callback<on_data>, where on_data is a function or a static
/// member.
template <auto function>
inline constexpr auto c_callback = &CCallback<function>::call;

}  // namespace sightline
