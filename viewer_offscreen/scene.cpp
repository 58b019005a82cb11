// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_offscreen/scene.h"

#include <GLES3/gl32.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/base/error.h"

namespace covey::viewer {
namespace {

// Attribute locations as in the shaders of renderer.cpp.
struct MeshVertex {
  std::array<float, 3> position;
  std::array<std::int8_t, 4> normal;  // in 1/127
  std::array<std::uint8_t, 4> colour;
  std::uint16_t label;
  std::uint16_t unused;
};

struct StrokeVertex {
  std::array<float, 3> position;
  std::array<std::uint8_t, 4> colour;
};

const void* offset(std::size_t bytes) { return reinterpret_cast<const void*>(bytes); }

template <typename T>
unsigned upload(GLenum target, std::span<const T> data) {
  unsigned buffer = 0;
  glGenBuffers(1, &buffer);
  glBindBuffer(target, buffer);
  glBufferData(target, static_cast<GLsizeiptr>(data.size_bytes()), data.data(), GL_STATIC_DRAW);
  return buffer;
}

unsigned begin_vertex_array() {
  unsigned array = 0;
  glGenVertexArrays(1, &array);
  glBindVertexArray(array);
  return array;
}

std::vector<MeshVertex> pack(const Mesh& mesh, const MeshStyle& style) {
  const std::vector<Eigen::Vector3f> normals =
      style.shade > 0.0 ? vertex_normals(mesh)
                        : std::vector<Eigen::Vector3f>(mesh.vertices.size(), {0, 0, 0});
  std::vector<MeshVertex> vertices(mesh.vertices.size());
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const Eigen::Vector3f& p = mesh.vertices[i];
    const Rgb colour = mesh.colours.empty() ? style.colour : mesh.colours[i];
    vertices[i].position = {p.x(), p.y(), p.z()};
    for (int axis = 0; axis < 3; ++axis) {
      vertices[i].normal[static_cast<std::size_t>(axis)] =
          static_cast<std::int8_t>(std::lround(127.0F * normals[i][axis]));
    }
    vertices[i].colour = {colour.r, colour.g, colour.b, 255};
    vertices[i].label = mesh.labels.empty() ? kNoLabel : mesh.labels[i];
  }
  return vertices;
}

std::vector<StrokeVertex> pack(std::span<const ColouredPoint> points) {
  std::vector<StrokeVertex> vertices;
  vertices.reserve(points.size());
  for (const ColouredPoint& point : points) {
    vertices.push_back({{point.p_W.x(), point.p_W.y(), point.p_W.z()},
                        {point.colour.r, point.colour.g, point.colour.b, 255}});
  }
  return vertices;
}

// One instance of a stroke reads two vertices: number i * step and the one 'ahead' of it.
unsigned stroke_array(unsigned buffer, std::size_t step, std::size_t ahead) {
  const unsigned array = begin_vertex_array();
  glBindBuffer(GL_ARRAY_BUFFER, buffer);
  const auto stride = static_cast<GLsizei>(step * sizeof(StrokeVertex));
  for (unsigned end = 0; end < 2; ++end) {
    const std::size_t base = end * ahead * sizeof(StrokeVertex);
    glVertexAttribPointer(end, 3, GL_FLOAT, GL_FALSE, stride,
                          offset(base + offsetof(StrokeVertex, position)));
    glVertexAttribPointer(2 + end, 4, GL_UNSIGNED_BYTE, GL_TRUE, stride,
                          offset(base + offsetof(StrokeVertex, colour)));
  }
  for (unsigned location = 0; location < 4; ++location) {
    glEnableVertexAttribArray(location);
    glVertexAttribDivisor(location, 1);
  }
  glBindVertexArray(0);
  return array;
}

}  // namespace

Scene::Scene(std::shared_ptr<const EglContext> context) : context_(std::move(context)) {}

Scene::~Scene() {
  context_->make_current();
  for (const MeshItem& item : meshes_) {
    glDeleteVertexArrays(1, &item.vertex_array);
    glDeleteBuffers(1, &item.vertices);
    glDeleteBuffers(1, &item.faces);
  }
  for (const StrokeItem& item : strokes_) {
    glDeleteVertexArrays(1, &item.vertex_array);
    glDeleteBuffers(1, &item.points);
  }
}

void Scene::add(const Mesh& mesh, const MeshStyle& style) {
  COVEY_CHECK(mesh.colours.empty() || mesh.colours.size() == mesh.vertices.size());
  COVEY_CHECK(mesh.labels.empty() || mesh.labels.size() == mesh.vertices.size());
  if (mesh.faces.empty()) return;
  context_->make_current();
  MeshItem item = {};
  item.style = style;
  item.index_count = static_cast<int>(3 * mesh.faces.size());
  item.vertex_array = begin_vertex_array();
  item.vertices = upload(GL_ARRAY_BUFFER, std::span<const MeshVertex>(pack(mesh, style)));
  item.faces = upload(GL_ELEMENT_ARRAY_BUFFER, std::span(mesh.faces));
  constexpr GLsizei kStride = sizeof(MeshVertex);
  glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, kStride, offset(offsetof(MeshVertex, position)));
  glVertexAttribPointer(1, 3, GL_BYTE, GL_TRUE, kStride, offset(offsetof(MeshVertex, normal)));
  glVertexAttribPointer(2, 4, GL_UNSIGNED_BYTE, GL_TRUE, kStride, offset(offsetof(MeshVertex, colour)));
  glVertexAttribIPointer(3, 1, GL_UNSIGNED_SHORT, kStride, offset(offsetof(MeshVertex, label)));
  for (unsigned location = 0; location < 4; ++location) glEnableVertexAttribArray(location);
  glBindVertexArray(0);
  meshes_.push_back(item);
}

void Scene::add_lines(std::span<const ColouredPoint> points, const LineStyle& style) {
  const bool strip = style.form == LineForm::kStrip;
  COVEY_CHECK(strip || points.size() % 2 == 0);
  if (points.size() < 2) return;
  context_->make_current();
  StrokeItem item = {};
  item.points = upload(GL_ARRAY_BUFFER, std::span<const StrokeVertex>(pack(points)));
  item.vertex_array = stroke_array(item.points, strip ? 1 : 2, 1);
  item.instances = static_cast<int>(strip ? points.size() - 1 : points.size() / 2);
  item.width_px = static_cast<float>(style.width_px);
  item.layer = style.layer;
  strokes_.push_back(item);
}

void Scene::add_points(std::span<const ColouredPoint> points, const PointStyle& style) {
  if (points.empty()) return;
  context_->make_current();
  StrokeItem item = {};
  item.points = upload(GL_ARRAY_BUFFER, std::span<const StrokeVertex>(pack(points)));
  item.vertex_array = stroke_array(item.points, 1, 0);
  item.instances = static_cast<int>(points.size());
  item.width_px = static_cast<float>(style.size_px);
  item.layer = style.layer;
  item.shape = style.shape == PointShape::kSquare ? 1 : 0;
  strokes_.push_back(item);
}

}  // namespace covey::viewer
