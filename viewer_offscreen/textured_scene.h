// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A textured mesh as simulated cameras draw it, uploaded once. Its faces are sorted into chunks, columns over squares of the ground, so
// that a view draws only what its frustum may hold, near chunks first: what they hide costs no texture look-ups. Belongs to the context
// that it was made for, and keeps it alive.

#include <Eigen/Geometry>
#include <cstddef>
#include <memory>
#include <vector>

#include "viewer_offscreen/camera.h"
#include "viewer_offscreen/egl_context.h"
#include "viewer_offscreen/mesh.h"
#include "viewer_offscreen/texture.h"

namespace covey::viewer {

class TexturedScene {
 public:
  // The mesh has texture points and labels. Faces are seen from their free side only.
  TexturedScene(std::shared_ptr<const EglContext> context, const Mesh& mesh, const Textures& textures,
                double chunk_m = 8.0);
  ~TexturedScene();
  TexturedScene(const TexturedScene&) = delete;
  TexturedScene& operator=(const TexturedScene&) = delete;

  enum class Surface { kGrey, kColour };

  // For the renderer: draws what may be in view with the program in use, whose sampler reads texture unit 0.
  void draw(const Camera& camera, Surface surface) const;

 private:
  struct Chunk {
    Eigen::AlignedBox3f box_W;
    std::size_t first_index;
    int index_count;
  };

  std::shared_ptr<const EglContext> context_;
  std::vector<Chunk> chunks_;
  unsigned vertex_array_ = 0;
  unsigned vertices_ = 0;
  unsigned faces_ = 0;
  unsigned grey_ = 0;
  unsigned colour_ = 0;
};

}  // namespace covey::viewer
