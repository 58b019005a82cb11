// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What the renderers share: programs and framebuffer attachments in the current context.

#include "viewer_offscreen/camera.h"

namespace covey::viewer {

// A linked program of a vertex and a fragment shader; EglError with the compiler's words where it is refused.
unsigned link_program(const char* vertex_source, const char* fragment_source);

// A renderbuffer of the bound framebuffer; `attachment` and `format` as in OpenGL.
unsigned attach_renderbuffer(unsigned attachment, unsigned format, int width, int height, int samples);

// The uniform mat4 clip_from_world of the program in use.
void set_clip(unsigned program, const Camera& camera);

}  // namespace covey::viewer
