// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What ideal pinhole cameras measure in a textured scene: grey pictures, and depth with labels and colour. Programs and framebuffers are
// made once and kept for each size.

#include <cstdint>
#include <map>
#include <memory>
#include <tuple>
#include <vector>

#include "viewer_offscreen/camera.h"
#include "viewer_offscreen/egl_context.h"
#include "viewer_offscreen/textured_scene.h"

namespace covey::viewer {

// Row by row from the top.
struct Measurement {
  std::vector<float> depth;           // metres along the optical axis, 0 where nothing is
  std::vector<std::uint16_t> labels;  // kNoLabel where nothing is
  std::vector<std::uint8_t> rgb;      // red, green, blue, pixel by pixel
};

class SensorRenderer {
 public:
  SensorRenderer();  // EglError where no off-screen drawing is possible
  ~SensorRenderer();
  SensorRenderer(const SensorRenderer&) = delete;
  SensorRenderer& operator=(const SensorRenderer&) = delete;

  // One byte a pixel; `samples` per pixel are 1 or 4, `sky` is seen where nothing is.
  void draw_grey(const TexturedScene& scene, const Camera& camera, int samples, std::uint8_t sky,
                 std::vector<std::uint8_t>& pixels);
  Measurement measure(const TexturedScene& scene, const Camera& camera, Rgb sky);

  std::shared_ptr<const EglContext> context() const { return context_; }

 private:
  struct Framebuffer {
    unsigned name;
    std::vector<unsigned> buffers;
  };
  enum class Content { kGrey, kMeasurement };
  using FramebufferKey = std::tuple<Content, int, int, int>;  // width, height, samples

  const Framebuffer& framebuffer(Content content, int width, int height, int samples);

  std::shared_ptr<const EglContext> context_;
  unsigned grey_program_ = 0;
  unsigned measure_program_ = 0;
  std::map<FramebufferKey, Framebuffer> framebuffers_;
};

}  // namespace covey::viewer
