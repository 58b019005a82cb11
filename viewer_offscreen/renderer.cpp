// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_offscreen/renderer.h"

#include <GLES3/gl32.h>

#include <algorithm>
#include <array>
#include <utility>

#include "core/base/error.h"
#include "viewer_offscreen/gl_program.h"

namespace covey::viewer {
namespace {

constexpr const char* kMeshVertex = R"(#version 320 es
layout(location = 0) in vec3 p_W;
layout(location = 1) in vec3 n_W;
layout(location = 2) in vec4 vertex_colour;
uniform mat4 clip_from_world;
out vec3 normal;
out vec4 colour;
void main() {
  gl_Position = clip_from_world * vec4(p_W, 1.0);
  normal = n_W;
  colour = vertex_colour;
}
)";

// Half-Lambert shading (a face turned away by 90 degrees gets half the light), so that nothing is ever black.
constexpr const char* kMeshFragment = R"(#version 320 es
precision highp float;
in vec3 normal;
in vec4 colour;
uniform float shade;
out vec4 pixel;
void main() {
  const vec3 light_W = vec3(0.37, -0.49, 0.79);
  float lit = 0.62 + 0.43 * dot(normal, light_W) / max(length(normal), 1e-6);
  pixel = vec4(min(colour.rgb * mix(1.0, lit, shade), 1.0), 1.0);
}
)";

constexpr const char* kMeasureVertex = R"(#version 320 es
layout(location = 0) in vec3 p_W;
layout(location = 3) in uint vertex_label;
uniform mat4 clip_from_world;
uniform vec4 depth_from_world;
out float depth;
flat out uint label;
void main() {
  gl_Position = clip_from_world * vec4(p_W, 1.0);
  depth = dot(depth_from_world, vec4(p_W, 1.0));
  label = vertex_label;
}
)";

constexpr const char* kMeasureFragment = R"(#version 320 es
precision highp float;
in float depth;
flat in uint label;
layout(location = 0) out float measured_depth;
layout(location = 1) out uint measured_label;
void main() {
  measured_depth = depth;
  measured_label = label;
}
)";

// A stroke is a capsule around the screen image of the segment a-b (a disc or square where a = b), drawn as
// one quad. It is flattened to w = 1 here, so that the distances in pixels are interpolated linearly on the
// screen.
constexpr const char* kStrokeVertex = R"(#version 320 es
layout(location = 0) in vec3 a_W;
layout(location = 1) in vec3 b_W;
layout(location = 2) in vec4 a_colour;
layout(location = 3) in vec4 b_colour;
uniform mat4 clip_from_world;
uniform vec2 half_size;
uniform float reach;
uniform float nearness;
out vec2 place;
flat out float extent;
out vec4 colour;
void main() {
  vec4 a = clip_from_world * vec4(a_W, 1.0);
  vec4 b = clip_from_world * vec4(b_W, 1.0);
  float a_inside = a.z + a.w;  // in front of the near plane where positive
  float b_inside = b.z + b.w;
  vec4 a_cut = a_inside < 0.0 ? mix(a, b, a_inside / (a_inside - b_inside)) : a;
  vec4 b_cut = b_inside < 0.0 ? mix(b, a, b_inside / (b_inside - a_inside)) : b;
  vec3 a_ndc = a_cut.xyz / a_cut.w;
  vec3 b_ndc = b_cut.xyz / b_cut.w;
  vec2 way = (b_ndc.xy - a_ndc.xy) * half_size;
  extent = length(way);
  vec2 along = extent > 1e-6 ? way / extent : vec2(1.0, 0.0);
  bool at_b = (gl_VertexID & 1) != 0;
  float side = (gl_VertexID & 2) != 0 ? 1.0 : -1.0;
  vec3 end = at_b ? b_ndc : a_ndc;
  place = vec2(at_b ? extent + reach : -reach, side * reach);
  vec2 shift = along * (at_b ? reach : -reach) + vec2(-along.y, along.x) * side * reach;
  gl_Position = vec4(end.xy + shift / half_size, end.z - nearness, 1.0);
  if (a_inside < 0.0 && b_inside < 0.0) gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
  colour = at_b ? b_colour : a_colour;
}
)";

constexpr const char* kStrokeFragment = R"(#version 320 es
precision highp float;
in vec2 place;
flat in float extent;
in vec4 colour;
uniform float half_width;
uniform int shape;
uniform float least_coverage;
out vec4 pixel;
void main() {
  vec2 away = vec2(place.x - clamp(place.x, 0.0, extent), place.y);
  float distance = shape == 1 ? max(abs(away.x), abs(away.y)) : length(away);
  float coverage = clamp(half_width + 0.5 - distance, 0.0, 1.0) * min(1.0, 2.0 * half_width);
  if (coverage < least_coverage) discard;
  pixel = vec4(colour.rgb, coverage);
}
)";

constexpr double kLayerStep = 2e-3;  // in normalised depth, which is 2 long

}  // namespace

Renderer::Renderer()
    : context_(std::make_shared<EglContext>()),
      mesh_program_(link_program(kMeshVertex, kMeshFragment)),
      measure_program_(link_program(kMeasureVertex, kMeasureFragment)),
      stroke_program_(link_program(kStrokeVertex, kStrokeFragment)) {}

Renderer::~Renderer() {
  context_->make_current();
  for (const auto& [key, framebuffer] : framebuffers_) {
    glDeleteFramebuffers(1, &framebuffer.name);
    glDeleteRenderbuffers(static_cast<GLsizei>(framebuffer.buffers.size()), framebuffer.buffers.data());
  }
  for (const unsigned program : {mesh_program_, measure_program_, stroke_program_}) glDeleteProgram(program);
}

Rendering Renderer::render(const Scene& scene, const Camera& camera, const RenderOptions& options) {
  Rendering rendering;
  if (options.colour) {
    const Layer layer = {&scene, camera};
    rendering.image = render(std::span(&layer, 1), options);
  }
  if (options.depth || options.labels) measure(scene, camera, options, rendering);
  return rendering;
}

Image Renderer::render(std::span<const Layer> layers, const RenderOptions& options) {
  COVEY_CHECK(!layers.empty() && (options.samples == 1 || options.samples == 4));
  COVEY_CHECK(options.supersample == 1 || options.supersample == 2);
  const int width = layers[0].camera.width;
  const int height = layers[0].camera.height;
  COVEY_CHECK(width > 0 && height > 0 && std::max(width, height) <= kLargestSide);
  context_->make_current();
  const int scale = options.supersample;
  glBindFramebuffer(GL_FRAMEBUFFER,
                    framebuffer(Content::kColour, scale * width, scale * height, options.samples).name);
  glViewport(0, 0, scale * width, scale * height);
  const Rgb& paper = options.background;
  glClearColor(paper.r / 255.0F, paper.g / 255.0F, paper.b / 255.0F, 1.0F);
  glClear(GL_COLOR_BUFFER_BIT);
  for (const Layer& layer : layers) {
    COVEY_CHECK(layer.camera.width == width && layer.camera.height == height);
    glClear(GL_DEPTH_BUFFER_BIT);
    draw_colour(*layer.scene, layer.camera, options);
  }
  return read_image(width, height, options);
}

const Renderer::Framebuffer& Renderer::framebuffer(Content content, int width, int height, int samples) {
  const FramebufferKey key = {content, width, height, samples};
  const auto found = framebuffers_.find(key);
  if (found != framebuffers_.end()) return found->second;
  Framebuffer made = {};
  glGenFramebuffers(1, &made.name);
  glBindFramebuffer(GL_FRAMEBUFFER, made.name);
  if (content == Content::kColour) {
    made.buffers.push_back(attach_renderbuffer(GL_COLOR_ATTACHMENT0, GL_RGBA8, width, height, samples));
  } else {
    made.buffers.push_back(attach_renderbuffer(GL_COLOR_ATTACHMENT0, GL_R32F, width, height, samples));
    made.buffers.push_back(attach_renderbuffer(GL_COLOR_ATTACHMENT1, GL_R16UI, width, height, samples));
    constexpr std::array<GLenum, 2> kTargets = {GL_COLOR_ATTACHMENT0, GL_COLOR_ATTACHMENT1};
    glDrawBuffers(kTargets.size(), kTargets.data());
  }
  made.buffers.push_back(
      attach_renderbuffer(GL_DEPTH_ATTACHMENT, GL_DEPTH_COMPONENT24, width, height, samples));
  COVEY_CHECK(glCheckFramebufferStatus(GL_FRAMEBUFFER) == GL_FRAMEBUFFER_COMPLETE);
  return framebuffers_.emplace(key, std::move(made)).first->second;
}

void Renderer::draw_colour(const Scene& scene, const Camera& camera, const RenderOptions& options) const {
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_LEQUAL);
  // Clip y grows downwards here (camera.h), which turns the sense of every triangle.
  glFrontFace(GL_CW);
  glUseProgram(mesh_program_);
  set_clip(mesh_program_, camera);
  for (const Scene::MeshItem& item : scene.meshes_) {
    item.style.two_sided ? glDisable(GL_CULL_FACE) : glEnable(GL_CULL_FACE);
    glUniform1f(glGetUniformLocation(mesh_program_, "shade"), static_cast<float>(item.style.shade));
    glBindVertexArray(item.vertex_array);
    glDrawElements(GL_TRIANGLES, item.index_count, GL_UNSIGNED_INT, nullptr);
  }

  glDisable(GL_CULL_FACE);
  // Coverage becomes a share of the samples: smooth edges that need no order of drawing.
  if (options.samples > 1) glEnable(GL_SAMPLE_ALPHA_TO_COVERAGE);
  glUseProgram(stroke_program_);
  set_clip(stroke_program_, camera);
  glUniform1f(glGetUniformLocation(stroke_program_, "least_coverage"), options.samples > 1 ? 0.1F : 0.5F);
  const auto scale = static_cast<float>(options.supersample);
  glUniform2f(glGetUniformLocation(stroke_program_, "half_size"),
              0.5F * scale * static_cast<float>(camera.width),
              0.5F * scale * static_cast<float>(camera.height));
  for (const Scene::StrokeItem& item : scene.strokes_) {
    const float half_width = 0.5F * scale * item.width_px;
    glUniform1f(glGetUniformLocation(stroke_program_, "half_width"), half_width);
    glUniform1f(glGetUniformLocation(stroke_program_, "reach"), half_width + 1.0F);
    glUniform1f(glGetUniformLocation(stroke_program_, "nearness"),
                static_cast<float>(kLayerStep * item.layer));
    glUniform1i(glGetUniformLocation(stroke_program_, "shape"), item.shape);
    glBindVertexArray(item.vertex_array);
    glDrawArraysInstanced(GL_TRIANGLE_STRIP, 0, 4, item.instances);
  }
  glDisable(GL_SAMPLE_ALPHA_TO_COVERAGE);
  glBindVertexArray(0);
}

Image Renderer::read_image(int width, int height, const RenderOptions& options) {
  const int full_width = options.supersample * width;
  const int full_height = options.supersample * height;
  const auto blit = [&](int from_samples, int to_width, int to_height, GLenum filter) {
    const unsigned from = framebuffer(Content::kColour, full_width, full_height, from_samples).name;
    const unsigned to = framebuffer(Content::kColour, to_width, to_height, 1).name;
    glBindFramebuffer(GL_READ_FRAMEBUFFER, from);
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, to);
    glBlitFramebuffer(0, 0, full_width, full_height, 0, 0, to_width, to_height, GL_COLOR_BUFFER_BIT, filter);
  };
  // The samples are averaged first, then each square of 2 x 2 pixels: a linear blit to half the size is their
  // mean.
  if (options.samples > 1) blit(options.samples, full_width, full_height, GL_NEAREST);
  if (options.supersample > 1) blit(1, width, height, GL_LINEAR);
  glBindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer(Content::kColour, width, height, 1).name);

  const std::size_t pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  std::vector<std::uint8_t> rgba(4 * pixels);
  glReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, rgba.data());
  COVEY_CHECK(glGetError() == GL_NO_ERROR);
  Image image = {width, height, std::vector<std::uint8_t>(3 * pixels)};
  for (std::size_t i = 0; i < pixels; ++i) {
    for (std::size_t channel = 0; channel < 3; ++channel) image.rgb[3 * i + channel] = rgba[4 * i + channel];
  }
  return image;
}

void Renderer::measure(const Scene& scene, const Camera& camera, const RenderOptions& options,
                       Rendering& rendering) {
  context_->make_current();
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer(Content::kMeasurement, camera.width, camera.height, 1).name);
  glViewport(0, 0, camera.width, camera.height);
  constexpr std::array<float, 4> kNothing = {0.0F, 0.0F, 0.0F, 0.0F};
  constexpr std::array<GLuint, 4> kUnlabelled = {kNoLabel, 0, 0, 0};
  glClearBufferfv(GL_COLOR, 0, kNothing.data());
  glClearBufferuiv(GL_COLOR, 1, kUnlabelled.data());
  glClear(GL_DEPTH_BUFFER_BIT);
  glEnable(GL_DEPTH_TEST);
  glDepthFunc(GL_LEQUAL);
  glFrontFace(GL_CW);
  glUseProgram(measure_program_);
  set_clip(measure_program_, camera);
  const Eigen::Vector4f depth_from_world = camera.T_C_W.matrix().row(2).cast<float>();
  glUniform4fv(glGetUniformLocation(measure_program_, "depth_from_world"), 1, depth_from_world.data());
  for (const Scene::MeshItem& item : scene.meshes_) {
    item.style.two_sided ? glDisable(GL_CULL_FACE) : glEnable(GL_CULL_FACE);
    glBindVertexArray(item.vertex_array);
    glDrawElements(GL_TRIANGLES, item.index_count, GL_UNSIGNED_INT, nullptr);
  }
  glBindVertexArray(0);

  const std::size_t pixels = static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
  if (options.depth) {
    rendering.depth.resize(pixels);
    glReadBuffer(GL_COLOR_ATTACHMENT0);
    glReadPixels(0, 0, camera.width, camera.height, GL_RED, GL_FLOAT, rendering.depth.data());
  }
  if (options.labels) {
    rendering.labels.resize(pixels);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadBuffer(GL_COLOR_ATTACHMENT1);
    glReadPixels(0, 0, camera.width, camera.height, GL_RED_INTEGER, GL_UNSIGNED_SHORT,
                 rendering.labels.data());
  }
  COVEY_CHECK(glGetError() == GL_NO_ERROR);
}

}  // namespace covey::viewer
