// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_offscreen/gl_program.h"

#include <GLES3/gl32.h>
#include <fmt/format.h>

#include <array>

#include "viewer_offscreen/egl_context.h"

namespace covey::viewer {
namespace {

unsigned compile(GLenum kind, const char* source) {
  const unsigned shader = glCreateShader(kind);
  glShaderSource(shader, 1, &source, nullptr);
  glCompileShader(shader);
  return shader;
}

}  // namespace

unsigned link_program(const char* vertex_source, const char* fragment_source) {
  const unsigned program = glCreateProgram();
  const unsigned vertex = compile(GL_VERTEX_SHADER, vertex_source);
  const unsigned fragment = compile(GL_FRAGMENT_SHADER, fragment_source);
  glAttachShader(program, vertex);
  glAttachShader(program, fragment);
  glLinkProgram(program);
  glDeleteShader(vertex);
  glDeleteShader(fragment);
  int linked = 0;
  glGetProgramiv(program, GL_LINK_STATUS, &linked);
  if (linked == 0) {
    std::array<char, 1024> log = {};
    glGetProgramInfoLog(program, log.size(), nullptr, log.data());
    throw EglError(fmt::format("this OpenGL ES refuses the shaders: {}", log.data()));
  }
  return program;
}

unsigned attach_renderbuffer(unsigned attachment, unsigned format, int width, int height, int samples) {
  unsigned buffer = 0;
  glGenRenderbuffers(1, &buffer);
  glBindRenderbuffer(GL_RENDERBUFFER, buffer);
  if (samples > 1) {
    glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, format, width, height);
  } else {
    glRenderbufferStorage(GL_RENDERBUFFER, format, width, height);
  }
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, buffer);
  return buffer;
}

void set_clip(unsigned program, const Camera& camera) {
  const Eigen::Matrix4f clip_from_world = camera.clip_from_world().cast<float>();
  glUniformMatrix4fv(glGetUniformLocation(program, "clip_from_world"), 1, GL_FALSE, clip_from_world.data());
}

}  // namespace covey::viewer
