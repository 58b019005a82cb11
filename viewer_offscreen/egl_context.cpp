// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_offscreen/egl_context.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GLES3/gl32.h>
#include <fmt/format.h>

#include <array>
#include <cstdlib>

namespace covey::viewer {
namespace {

[[noreturn]] void fail(const char* step) {
  throw EglError(
      fmt::format("{} failed (EGL error 0x{:x}): no off-screen OpenGL ES here; install the packages libegl1, "
                  "libgles2, libegl-mesa0 and libgl1-mesa-dri (bin/setup does)",
                  step, eglGetError()));
}

}  // namespace

EglContext::EglContext() {
  setenv("LIBGL_ALWAYS_SOFTWARE", "1", /*overwrite=*/0);
  // llvmpipe draws in this thread: a process is to fill one core, not all.
  setenv("LP_NUM_THREADS", "0", /*overwrite=*/0);
  // The display is shared by all contexts of the process and stays initialised: to terminate it would take
  // the others with it.
  display_ = eglGetPlatformDisplay(EGL_PLATFORM_SURFACELESS_MESA, nullptr, nullptr);
  if (display_ == EGL_NO_DISPLAY) fail("eglGetPlatformDisplay");
  if (eglInitialize(display_, nullptr, nullptr) == EGL_FALSE) fail("eglInitialize");
  if (eglBindAPI(EGL_OPENGL_ES_API) == EGL_FALSE) fail("eglBindAPI");
  constexpr std::array<EGLint, 5> kVersion = {EGL_CONTEXT_MAJOR_VERSION, 3, EGL_CONTEXT_MINOR_VERSION, 2,
                                              EGL_NONE};
  context_ = eglCreateContext(display_, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, kVersion.data());
  if (context_ == EGL_NO_CONTEXT) fail("eglCreateContext (OpenGL ES 3.2)");
  make_current();
}

EglContext::~EglContext() {
  if (eglGetCurrentContext() == context_)
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  eglDestroyContext(display_, context_);
}

void EglContext::make_current() const {
  if (eglGetCurrentContext() == context_) return;
  if (eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_FALSE) fail("eglMakeCurrent");
}

std::string EglContext::renderer_name() const {
  make_current();
  return reinterpret_cast<const char*>(glGetString(GL_RENDERER));
}

}  // namespace covey::viewer
