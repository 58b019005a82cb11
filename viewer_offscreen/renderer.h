// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Draws scenes into memory: colour with anti-aliasing and, for simulated sensors, the exact depth and the
// label of what each pixel's centre sees. Programs and framebuffers are made once; what varies between two
// frames is a camera.
//
//   Renderer renderer;
//   Scene scene(renderer.context());
//   scene.add(mesh);
//   Rendering view = renderer.render(scene, camera, {.depth = true});
//
// A Renderer and its scenes belong to one thread.

#include <cstdint>
#include <map>
#include <memory>
#include <span>
#include <tuple>
#include <vector>

#include "viewer_offscreen/camera.h"
#include "viewer_offscreen/egl_context.h"
#include "viewer_offscreen/image.h"
#include "viewer_offscreen/scene.h"

namespace covey::viewer {

struct RenderOptions {
  bool colour = true;
  bool depth = false;
  bool labels = false;
  Rgb background = {255, 255, 255};
  int samples = 4;  // per pixel: 1 or 4; meshes' and lines' edges are as smooth as this
  int supersample =
      1;  // 1 or 2: 2 draws at twice the size and averages; for figures. Widths in pixels stay what they are
};

struct Rendering {
  Image image;
  // Meshes only, without lines and points; row by row from the top.
  std::vector<float> depth;           // metres along the optical axis, 0 where nothing is
  std::vector<std::uint16_t> labels;  // of the face's last corner; kNoLabel where nothing is
};

// One scene over another: the depth buffer starts anew, the colours stay.
struct Layer {
  const Scene* scene = nullptr;
  Camera camera;
};

class Renderer {
 public:
  Renderer();  // EglError where no off-screen drawing is possible
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  Rendering render(const Scene& scene, const Camera& camera, const RenderOptions& options = {});
  // Colour only; the cameras have one size.
  Image render(std::span<const Layer> layers, const RenderOptions& options = {});

  std::shared_ptr<const EglContext> context() const { return context_; }
  // Width and height that a picture may have with this supersampling.
  static constexpr int kLargestSide = 8192;

 private:
  struct Framebuffer {
    unsigned name;
    std::vector<unsigned> buffers;
  };
  enum class Content { kColour, kMeasurement };
  using FramebufferKey = std::tuple<Content, int, int, int>;  // width, height, samples

  const Framebuffer& framebuffer(Content content, int width, int height, int samples);
  Image read_image(int width, int height, const RenderOptions& options);
  void draw_colour(const Scene& scene, const Camera& camera, const RenderOptions& options) const;
  void measure(const Scene& scene, const Camera& camera, const RenderOptions& options, Rendering& rendering);

  std::shared_ptr<const EglContext> context_;
  unsigned mesh_program_ = 0;
  unsigned measure_program_ = 0;
  unsigned stroke_program_ = 0;
  std::map<FramebufferKey, Framebuffer> framebuffers_;
};

}  // namespace covey::viewer
