/// OpenGL without a screen: an EGL context on Mesa's surfaceless platform.
#pragma once

namespace sightline::mujoco {

/// An OpenGL context for one thread at a time, the one that made it current. The constructor
/// releases the context.
class Offscreen {
 public:
  /// @throws std::invalid_argument if this machine has no such context
  Offscreen();
  ~Offscreen();
  Offscreen(const Offscreen&) = delete;
  Offscreen& operator=(const Offscreen&) = delete;

  /// Binds the context to the calling thread; false if another thread holds it.
  bool make_current() const noexcept;
  /// Releases the context, so that any thread may take it.
  void release() const noexcept;

 private:
  void* display_;
  void* context_;
};

}  // namespace sightline::mujoco
