// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// What is drawn: meshes, lines and points in one frame W, uploaded to the graphics library once and drawn as
// often as one likes. A scene belongs to the context of the Renderer that it was made for, and keeps that
// context alive.
//
// Lines and points have a width in pixels and a layer: what lies in one plane (a pose graph, its loops, the
// grid) shows in the order of its layers, higher ones on top, while real differences of depth still decide.
// One layer is worth 1/1000 of the camera's depth range.

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "viewer_offscreen/egl_context.h"
#include "viewer_offscreen/mesh.h"

namespace covey::viewer {

struct MeshStyle {
  double shade = 0.0;            // 0: the colours as they are; 1: fully by the angle to a light from above
  bool two_sided = true;         // false: faces seen from behind are left out, so that one looks into a room
  Rgb colour = {200, 200, 200};  // of a mesh that has no colours
};

struct ColouredPoint {
  Eigen::Vector3f p_W = Eigen::Vector3f::Zero();
  Rgb colour;
};

enum class LineForm {
  kStrip,     // from each point to the next
  kSegments,  // from point 0 to 1, 2 to 3, ...
};

struct LineStyle {
  double width_px = 1.0;
  int layer = 0;
  LineForm form = LineForm::kStrip;
};

enum class PointShape { kDisc, kSquare };

struct PointStyle {
  double size_px = 5.0;  // diameter or side
  int layer = 0;
  PointShape shape = PointShape::kDisc;
};

class Scene {
 public:
  explicit Scene(std::shared_ptr<const EglContext> context);
  ~Scene();
  Scene(const Scene&) = delete;
  Scene& operator=(const Scene&) = delete;

  void add(const Mesh& mesh, const MeshStyle& style = {});
  void add_lines(std::span<const ColouredPoint> points, const LineStyle& style = {});
  void add_points(std::span<const ColouredPoint> points, const PointStyle& style = {});

 private:
  friend class Renderer;
  // A vertex array with its buffers, and how to draw it; OpenGL's names are unsigned integers.
  struct MeshItem {
    unsigned vertex_array;
    unsigned vertices;
    unsigned faces;
    int index_count;
    MeshStyle style;
  };
  struct StrokeItem {  // lines, points
    unsigned vertex_array;
    unsigned points;
    int instances;
    float width_px;
    int layer;
    int shape;  // of the fragment shader: 0 capsule or disc, 1 square
  };

  std::shared_ptr<const EglContext> context_;
  std::vector<MeshItem> meshes_;
  std::vector<StrokeItem> strokes_;
};

}  // namespace covey::viewer
