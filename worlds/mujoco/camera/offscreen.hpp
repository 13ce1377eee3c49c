/// OpenGL without a screen: a context of EGL, on Mesa's surfaceless platform.
#pragma once

namespace sightline::mujoco {

/// Of one thread at a time: the one that made it current. Released once it is made.
class Offscreen {
 public:
  /// @throws std::invalid_argument where this machine has none
  Offscreen();
  ~Offscreen();
  Offscreen(const Offscreen&) = delete;
  Offscreen& operator=(const Offscreen&) = delete;

  /// Its calls are this thread's from now on; false where another thread has it.
  bool make_current() const noexcept;
  /// Any thread may have it.
  void release() const noexcept;

 private:
  void* display_;
  void* context_;
};

}  // namespace sightline::mujoco
