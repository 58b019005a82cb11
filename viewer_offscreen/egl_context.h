// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// OpenGL ES 3.2 without a screen: EGL on Mesa's surfaceless platform. There is no window and no default
// framebuffer; all drawing goes to framebuffer objects. Mesa's software rasteriser (llvmpipe) is asked for,
// so that a picture is the same on every machine and needs no GPU; LIBGL_ALWAYS_SOFTWARE=0 in the environment
// lets a GPU do it. One context belongs to one thread at a time.

#include <stdexcept>
#include <string>

namespace covey::viewer {

// No drawing is possible here; says what is missing.
class EglError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class EglContext {
 public:
  EglContext();  // makes itself current; EglError
  ~EglContext();
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;

  // Needed before any GL call where more than one context lives in the thread.
  void make_current() const;
  // "llvmpipe (LLVM 15.0.6, 256 bits)".
  std::string renderer_name() const;

 private:
  void* display_ = nullptr;
  void* context_ = nullptr;
};

}  // namespace covey::viewer
