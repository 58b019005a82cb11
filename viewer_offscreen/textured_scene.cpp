// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_offscreen/textured_scene.h"

#include <GLES3/gl32.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <utility>

#include "core/base/error.h"

namespace covey::viewer {
namespace {

// Attribute locations as in the shaders of sensor_renderer.cpp.
struct TexturedVertex {
  std::array<float, 3> position;
  std::array<float, 2> uv;
  std::uint16_t layer;
  std::uint16_t label;
  std::array<std::uint8_t, 4> tint;  // red, green, blue, and their grey
};

const void* offset(std::size_t bytes) { return reinterpret_cast<const void*>(bytes); }

// Rec. 601 luma, in whole numbers.
std::uint8_t luma(int r, int g, int b) {
  return static_cast<std::uint8_t>((77 * r + 150 * g + 29 * b + 128) >> 8);
}

std::vector<TexturedVertex> pack(const Mesh& mesh) {
  std::vector<TexturedVertex> vertices(mesh.vertices.size());
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const Eigen::Vector3f& p = mesh.vertices[i];
    const TexturePoint& point = mesh.texture[i];
    const Rgb& tint = point.tint;
    vertices[i] = {{p.x(), p.y(), p.z()},
                   {point.u, point.v},
                   point.layer,
                   mesh.labels[i],
                   {tint.r, tint.g, tint.b, luma(tint.r, tint.g, tint.b)}};
  }
  return vertices;
}

// Texels of all layers, `channels` bytes each.
struct Level {
  int side;
  int channels;
  std::vector<std::uint8_t> bytes;
};

// Rows and then columns through a symmetric filter of four whole-number weights around a texel's middle or edge, keeping every `step`-th;
// textures wrap. Done here and not by the driver, so that pictures depend on nothing but this.
Level filter(const Level& fine, int layers, const std::array<int, 4>& weights, int step) {
  const int sum = weights[0] + weights[1] + weights[2] + weights[3];
  const int mask = fine.side - 1;
  const int side = fine.side / step;
  const int channels = fine.channels;
  Level coarse = {side, channels, {}};
  coarse.bytes.resize(static_cast<std::size_t>(side * side) * static_cast<std::size_t>(channels * layers));
  const auto row_bytes = static_cast<std::size_t>(side * channels);
  std::vector<std::uint16_t> narrow(row_bytes * static_cast<std::size_t>(fine.side));  // one layer, rows done
  for (int layer = 0; layer < layers; ++layer) {
    const std::uint8_t* from = &fine.bytes[static_cast<std::size_t>(layer * fine.side) *
                                           static_cast<std::size_t>(fine.side * channels)];
    std::uint16_t* out = narrow.data();
    for (int row = 0; row < fine.side; ++row, from += fine.side * channels) {
      for (int column = 0; column < side; ++column) {
        std::array<const std::uint8_t*, 4> taps = {};
        for (int k = 0; k < 4; ++k) {
          taps[static_cast<std::size_t>(k)] = from + ((step * column - 1 + k) & mask) * channels;
        }
        for (int c = 0; c < channels; ++c) {
          *out++ = static_cast<std::uint16_t>(weights[0] * taps[0][c] + weights[1] * taps[1][c] +
                                              weights[2] * taps[2][c] + weights[3] * taps[3][c]);
        }
      }
    }
    std::uint8_t* to = &coarse.bytes[static_cast<std::size_t>(layer * side) * row_bytes];
    for (int row = 0; row < side; ++row) {
      std::array<const std::uint16_t*, 4> taps = {};
      for (int k = 0; k < 4; ++k) {
        taps[static_cast<std::size_t>(k)] =
            narrow.data() + static_cast<std::size_t>((step * row - 1 + k) & mask) * row_bytes;
      }
      for (std::size_t i = 0; i < row_bytes; ++i) {
        const int total = weights[0] * taps[0][i] + weights[1] * taps[1][i] + weights[2] * taps[2][i] +
                          weights[3] * taps[3][i];
        *to++ = static_cast<std::uint8_t>((total + sum * sum / 2) / (sum * sum));
      }
    }
  }
  return coarse;
}

// A lens is never sharper than its pixels: without this smoothing the edges of texels, sampled once a pixel, would move by a tenth of one.
Level soften(const Level& level, int layers) { return filter(level, layers, {1, 2, 1, 0}, 1); }
Level halve(const Level& level, int layers) { return filter(level, layers, {1, 3, 3, 1}, 2); }

unsigned upload_texture(Level level, int layers) {
  unsigned texture = 0;
  glGenTextures(1, &texture);
  glBindTexture(GL_TEXTURE_2D_ARRAY, texture);
  const bool grey = level.channels == 1;
  int levels = 1;
  while (level.side >> levels > 0) ++levels;
  glTexStorage3D(GL_TEXTURE_2D_ARRAY, levels, grey ? GL_R8 : GL_RGBA8, level.side, level.side, layers);
  glPixelStorei(GL_UNPACK_ALIGNMENT, 1);
  for (int i = 0; i < levels; ++i) {
    glTexSubImage3D(GL_TEXTURE_2D_ARRAY, i, 0, 0, 0, level.side, level.side, layers, grey ? GL_RED : GL_RGBA,
                    GL_UNSIGNED_BYTE, level.bytes.data());
    if (i + 1 < levels) level = halve(level, layers);
  }
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_WRAP_S, GL_REPEAT);
  glTexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_WRAP_T, GL_REPEAT);
  COVEY_CHECK(glGetError() == GL_NO_ERROR);
  return texture;
}

Level grey_level(const Textures& textures) {
  Level level = {textures.side, 1, {}};
  const std::vector<std::uint8_t>& rgb = textures.rgb;
  level.bytes.reserve(rgb.size() / 3);
  for (std::size_t i = 0; i < rgb.size(); i += 3) level.bytes.push_back(luma(rgb[i], rgb[i + 1], rgb[i + 2]));
  return level;
}

Level colour_level(const Textures& textures) {
  Level level = {textures.side, 4, {}};
  const std::vector<std::uint8_t>& rgb = textures.rgb;
  level.bytes.reserve(rgb.size() / 3 * 4);
  for (std::size_t i = 0; i < rgb.size(); i += 3) {
    level.bytes.insert(level.bytes.end(), {rgb[i], rgb[i + 1], rgb[i + 2], 255});
  }
  return level;
}

// A box is out of view where all of it lies beyond one of the frustum's planes. Planes are sums and differences of the rows of
// clip_from_world (Gribb and Hartmann 2001).
struct Frustum {
  explicit Frustum(const Eigen::Matrix4f& clip_from_world) {
    for (int axis = 0; axis < 3; ++axis) {
      planes[static_cast<std::size_t>(2 * axis)] = clip_from_world.row(3) + clip_from_world.row(axis);
      planes[static_cast<std::size_t>(2 * axis + 1)] = clip_from_world.row(3) - clip_from_world.row(axis);
    }
  }
  bool may_hold(const Eigen::AlignedBox3f& box_W) const {
    return std::all_of(planes.begin(), planes.end(), [&](const Eigen::Vector4f& plane) {
      const Eigen::Vector3f farthest = (plane.head<3>().array() > 0.0F).select(box_W.max(), box_W.min());
      return plane.head<3>().dot(farthest) + plane.w() >= 0.0F;
    });
  }
  std::array<Eigen::Vector4f, 6> planes;
};

}  // namespace

TexturedScene::TexturedScene(std::shared_ptr<const EglContext> context, const Mesh& mesh,
                             const Textures& textures, double chunk_m)
    : context_(std::move(context)) {
  COVEY_CHECK(mesh.texture.size() == mesh.vertices.size() && mesh.labels.size() == mesh.vertices.size());
  context_->make_current();
  std::map<std::pair<int, int>, std::vector<std::uint32_t>> columns;
  for (const std::array<std::uint32_t, 3>& face : mesh.faces) {
    const Eigen::Vector3f centre =
        (mesh.vertices[face[0]] + mesh.vertices[face[1]] + mesh.vertices[face[2]]) / 3.0F;
    const auto cell = [&](float x) { return static_cast<int>(std::floor(x / chunk_m)); };
    std::vector<std::uint32_t>& column = columns[{cell(centre.x()), cell(centre.y())}];
    column.insert(column.end(), face.begin(), face.end());
  }
  std::vector<std::uint32_t> indices;
  for (const auto& [cell, column] : columns) {
    Chunk chunk = {{}, indices.size(), static_cast<int>(column.size())};
    for (const std::uint32_t index : column) chunk.box_W.extend(mesh.vertices[index]);
    chunks_.push_back(chunk);
    indices.insert(indices.end(), column.begin(), column.end());
  }

  glGenVertexArrays(1, &vertex_array_);
  glBindVertexArray(vertex_array_);
  const std::vector<TexturedVertex> vertices = pack(mesh);
  glGenBuffers(1, &vertices_);
  glBindBuffer(GL_ARRAY_BUFFER, vertices_);
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(vertices.size() * sizeof(TexturedVertex)),
               vertices.data(), GL_STATIC_DRAW);
  glGenBuffers(1, &faces_);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, faces_);
  glBufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(indices.size() * sizeof(std::uint32_t)),
               indices.data(), GL_STATIC_DRAW);
  constexpr GLsizei kStride = sizeof(TexturedVertex);
  glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, kStride, offset(offsetof(TexturedVertex, position)));
  glVertexAttribPointer(1, 2, GL_FLOAT, GL_FALSE, kStride, offset(offsetof(TexturedVertex, uv)));
  glVertexAttribPointer(2, 1, GL_UNSIGNED_SHORT, GL_FALSE, kStride, offset(offsetof(TexturedVertex, layer)));
  glVertexAttribIPointer(3, 1, GL_UNSIGNED_SHORT, kStride, offset(offsetof(TexturedVertex, label)));
  glVertexAttribPointer(4, 4, GL_UNSIGNED_BYTE, GL_TRUE, kStride, offset(offsetof(TexturedVertex, tint)));
  for (unsigned location = 0; location < 5; ++location) glEnableVertexAttribArray(location);
  glBindVertexArray(0);

  grey_ = upload_texture(soften(grey_level(textures), textures.layers()), textures.layers());
  // Colour is for small pictures: half the side is enough.
  const Level colour = colour_level(textures);
  colour_ = upload_texture(colour.side > 1 ? halve(colour, textures.layers()) : colour, textures.layers());
}

TexturedScene::~TexturedScene() {
  context_->make_current();
  glDeleteVertexArrays(1, &vertex_array_);
  glDeleteBuffers(1, &vertices_);
  glDeleteBuffers(1, &faces_);
  glDeleteTextures(1, &grey_);
  glDeleteTextures(1, &colour_);
}

void TexturedScene::draw(const Camera& camera, Surface surface) const {
  const Frustum frustum(camera.clip_from_world().cast<float>());
  const Eigen::Vector3f eye_W = camera.T_C_W.inverse().translation.cast<float>();
  std::vector<std::pair<float, const Chunk*>> in_view;
  for (const Chunk& chunk : chunks_) {
    if (frustum.may_hold(chunk.box_W))
      in_view.emplace_back(chunk.box_W.squaredExteriorDistance(eye_W), &chunk);
  }
  std::stable_sort(in_view.begin(), in_view.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });

  glActiveTexture(GL_TEXTURE0);
  glBindTexture(GL_TEXTURE_2D_ARRAY, surface == Surface::kGrey ? grey_ : colour_);
  glBindVertexArray(vertex_array_);
  for (const auto& [distance, chunk] : in_view) {
    glDrawElements(GL_TRIANGLES, chunk->index_count, GL_UNSIGNED_INT,
                   offset(chunk->first_index * sizeof(std::uint32_t)));
  }
  glBindVertexArray(0);
}

}  // namespace covey::viewer
