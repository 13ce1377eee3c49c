/// Functions that libraries of C call. No exception passes through their frames; tests/house/threads_test.cpp checks that they get
/// no other functions.
#pragma once

#include <type_traits>

#include "sightline/base/failure.hpp"

namespace sightline {

/// A function behind a noexcept one of the same signature. What it throws is caught and reported once for each function (Failure);
/// the library then gets a value of zero.
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

/// For a library of C: c_callback<on_data>, where on_data is a function or a static member.
template <auto function>
inline constexpr auto c_callback = &CCallback<function>::call;

}  // namespace sightline
