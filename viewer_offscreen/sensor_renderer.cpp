// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_offscreen/sensor_renderer.h"

#include <GLES3/gl32.h>

#include <array>
#include <utility>

#include "core/base/error.h"
#include "viewer_offscreen/gl_program.h"

namespace covey::viewer {
namespace {

constexpr const char* kGreyVertex = R"(#version 320 es
layout(location = 0) in vec3 p_W;
layout(location = 1) in vec2 uv;
layout(location = 2) in float layer;
layout(location = 4) in vec4 tint;
uniform mat4 clip_from_world;
out vec2 place;
flat out float page;
flat out float light;
void main() {
  gl_Position = clip_from_world * vec4(p_W, 1.0);
  place = uv;
  page = layer;
  light = tint.a;
}
)";

constexpr const char* kGreyFragment = R"(#version 320 es
precision highp float;
precision highp sampler2DArray;
in vec2 place;
flat in float page;
flat in float light;
uniform sampler2DArray surfaces;
out float pixel;
void main() { pixel = light * texture(surfaces, vec3(place, page)).r; }
)";

constexpr const char* kSensorVertex = R"(#version 320 es
layout(location = 0) in vec3 p_W;
layout(location = 1) in vec2 uv;
layout(location = 2) in float layer;
layout(location = 3) in uint vertex_label;
layout(location = 4) in vec4 tint;
uniform mat4 clip_from_world;
uniform vec4 depth_from_world;
out float depth;
out vec2 place;
flat out float page;
flat out vec3 light;
flat out uint label;
void main() {
  gl_Position = clip_from_world * vec4(p_W, 1.0);
  depth = dot(depth_from_world, vec4(p_W, 1.0));
  place = uv;
  page = layer;
  light = tint.rgb;
  label = vertex_label;
}
)";

constexpr const char* kSensorFragment = R"(#version 320 es
precision highp float;
precision highp sampler2DArray;
in float depth;
in vec2 place;
flat in float page;
flat in vec3 light;
flat in uint label;
uniform sampler2DArray surfaces;
layout(location = 0) out float measured_depth;
layout(location = 1) out uint measured_label;
layout(location = 2) out vec4 measured_colour;
void main() {
  measured_depth = depth;
  measured_label = label;
  measured_colour = vec4(light * texture(surfaces, vec3(place, page)).rgb, 1.0);
}
)";

void begin(const Camera& camera) {
  glViewport(0, 0, camera.width, camera.height);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_LESS);
  glEnable(GL_CULL_FACE);
  // Clip y grows downwards here (camera.h), which turns the sense of every triangle.
  glFrontFace(GL_CW);
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
}

}  // namespace

SensorRenderer::SensorRenderer()
    : context_(std::make_shared<EglContext>()),
      grey_program_(link_program(kGreyVertex, kGreyFragment)),
      measure_program_(link_program(kSensorVertex, kSensorFragment)) {}

SensorRenderer::~SensorRenderer() {
  context_->make_current();
  for (const auto& [key, framebuffer] : framebuffers_) {
    glDeleteFramebuffers(1, &framebuffer.name);
    glDeleteRenderbuffers(static_cast<GLsizei>(framebuffer.buffers.size()), framebuffer.buffers.data());
  }
  for (const unsigned program : {grey_program_, measure_program_}) glDeleteProgram(program);
}

const SensorRenderer::Framebuffer& SensorRenderer::framebuffer(Content content, int width, int height,
                                                               int samples) {
  const FramebufferKey key = {content, width, height, samples};
  const auto found = framebuffers_.find(key);
  if (found != framebuffers_.end()) return found->second;
  Framebuffer made = {};
  glGenFramebuffers(1, &made.name);
  glBindFramebuffer(GL_FRAMEBUFFER, made.name);
  const auto attach = [&](unsigned attachment, unsigned format) {
    made.buffers.push_back(attach_renderbuffer(attachment, format, width, height, samples));
  };
  if (content == Content::kGrey) {
    attach(GL_COLOR_ATTACHMENT0, GL_R8);
  } else {
    attach(GL_COLOR_ATTACHMENT0, GL_R32F);
    attach(GL_COLOR_ATTACHMENT1, GL_R16UI);
    attach(GL_COLOR_ATTACHMENT2, GL_RGBA8);
    constexpr std::array<GLenum, 3> kTargets = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1,
                                                GL_COLOR_ATTACHMENT2};
    glDrawBuffers(kTargets.size(), kTargets.data());
  }
  attach(GL_DEPTH_ATTACHMENT, GL_DEPTH_COMPONENT24);
  COVEY_CHECK(glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE);
  return framebuffers_.emplace(key, std::move(made)).first->second;
}

void SensorRenderer::draw_grey(const TexturedScene& scene, const Camera& camera, int samples,
                               std::uint8_t sky, std::vector<std::uint8_t>& pixels) {
  COVEY_CHECK(samples == 1 || samples == 4);
  context_->make_current();
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer(Content::kGrey, camera.width, camera.height, samples).name);
  begin(camera);
  glClearColor(sky / 255.0F, 0.0F, 0.0F, 1.0F);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  glUseProgram(grey_program_);
  set_clip(grey_program_, camera);
  scene.draw(camera, TexturedScene::Surface::kGrey);
  if (samples > 1) {
    const unsigned from = framebuffer(Content::kGrey, camera.width, camera.height, samples).name;
    const unsigned to = framebuffer(Content::kGrey, camera.width, camera.height, 1).name;
    glBindFramebuffer(GL_READ_FRAMEBUFFER, from);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, to);
    glBlitFramebuffer(0, 0, camera.width, camera.height, 0, 0, camera.width, camera.height,
                      GL_COLOR_BUFFER_BIT, GL_NEAREST);
    glBindFramebuffer(GL_READ_FRAMEBUFFER, to);
  }
  pixels.resize(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height));
  glReadPixels(0, 0, camera.width, camera.height, GL_RED, GL_UNSIGNED_BYTE, pixels.data());
  COVEY_CHECK(glGetError() == GL_NO_ERROR);
}

Measurement SensorRenderer::measure(const TexturedScene& scene, const Camera& camera, Rgb sky) {
  context_->make_current();
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer(Content::kMeasurement, camera.width, camera.height, 1).name);
  begin(camera);
  constexpr std::array<float, 4> kNothing = {0.0F, 0.0F, 0.0F, 0.0F};
  constexpr std::array<GLuint, 4> kUnlabelled = {kNoLabel, 0, 0, 0};
  const std::array<float, 4> sky_colour = {sky.r / 255.0F, sky.g / 255.0F, sky.b / 255.0F, 1.0F};
  glClearBufferfv(GL_COLOR, 0, kNothing.data());
  glClearBufferuiv(GL_COLOR, 1, kUnlabelled.data());
  glClearBufferfv(GL_COLOR, 2, sky_colour.data());
  glClear(GL_DEPTH_BUFFER_BIT);
  glUseProgram(measure_program_);
  set_clip(measure_program_, camera);
  const Eigen::Vector4f depth_from_world = camera.T_C_W.matrix().row(2).cast<float>();
  glUniform4fv(glGetUniformLocation(measure_program_, "depth_from_world"), 1, depth_from_world.data());
  scene.draw(camera, TexturedScene::Surface::kColour);

  const std::size_t pixels = static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
  Measurement measurement;
  measurement.depth.resize(pixels);
  glReadBuffer(GL_COLOR_ATTACHMENT0);
  glReadPixels(0, 0, camera.width, camera.height, GL_RED, GL_FLOAT, measurement.depth.data());
  measurement.labels.resize(pixels);
  glReadBuffer(GL_COLOR_ATTACHMENT1);
  glReadPixels(0, 0, camera.width, camera.height, GL_RED_INTEGER, GL_UNSIGNED_SHORT,
               measurement.labels.data());
  std::vector<std::uint8_t> rgba(4 * pixels);
  glReadBuffer(GL_COLOR_ATTACHMENT2);
  glReadPixels(0, 0, camera.width, camera.height, GL_RGBA, GL_UNSIGNED_BYTE, rgba.data());
  COVEY_CHECK(glGetError() == GL_NO_ERROR);
  measurement.rgb.resize(3 * pixels);
  for (std::size_t i = 0; i < pixels; ++i) {
    for (std::size_t channel = 0; channel < 3; ++channel) {
      measurement.rgb[3 * i + channel] = rgba[4 * i + channel];
    }
  }
  return measurement;
}

}  // namespace covey::viewer
