#include "worlds/mujoco/camera/offscreen.hpp"

#include <EGL/egl.h>
#include <EGL/eglext.h>

#include "sightline/base.hpp"

namespace sightline::mujoco {

Offscreen::Offscreen() : display_(nullptr), context_(nullptr) {
  const auto platform_display =
      reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(eglGetProcAddress("eglGetPlatformDisplayEXT"));
  if (platform_display != nullptr)
    display_ = platform_display(EGL_PLATFORM_SURFACELESS_MESA, nullptr, nullptr);
  EGLint major = 0, minor = 0;
  if (display_ == nullptr || eglInitialize(display_, &major, &minor) == EGL_FALSE)
    throw_invalid("EGL has no surfaceless display, expected Mesa's (libgl1-mesa-dri)");
  const EGLint wanted[] = {EGL_SURFACE_TYPE,
                           EGL_PBUFFER_BIT,
                           EGL_RENDERABLE_TYPE,
                           EGL_OPENGL_BIT,
                           EGL_RED_SIZE,
                           8,
                           EGL_GREEN_SIZE,
                           8,
                           EGL_BLUE_SIZE,
                           8,
                           EGL_NONE};
  EGLConfig config = nullptr;
  EGLint count = 0;
  eglChooseConfig(display_, wanted, &config, 1, &count);
  eglBindAPI(EGL_OPENGL_API);
  context_ = eglCreateContext(display_, count > 0 ? config : nullptr, nullptr, nullptr);
  if (context_ == nullptr || !make_current())
    throw_invalid("EGL makes no context of OpenGL, error {:#x}", eglGetError());
}

Offscreen::~Offscreen() {
  if (eglGetCurrentContext() == context_) release();
  eglDestroyContext(display_, context_);
}

bool Offscreen::make_current() const noexcept {
  if (eglGetCurrentContext() == context_) return true;
  eglBindAPI(EGL_OPENGL_API);
  return eglMakeCurrent(display_, nullptr, nullptr, context_) == EGL_TRUE;
}

void Offscreen::release() const noexcept { eglMakeCurrent(display_, nullptr, nullptr, nullptr); }

}  // namespace sightline::mujoco
