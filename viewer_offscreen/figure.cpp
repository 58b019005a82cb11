// SPDX-License-Identifier: BSD-3-Clause
#include "viewer_offscreen/figure.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <string>

#include "core/base/error.h"
#include "viewer_offscreen/ground.h"
#include "viewer_offscreen/legend.h"
#include "viewer_offscreen/text.h"

namespace covey::viewer {
namespace {

constexpr Rgb kGrey = {110, 116, 124};
constexpr Rgb kReference = {120, 124, 130};
constexpr Rgb kWhite = {255, 255, 255};
constexpr double kTrajectoryWidth = 3.4;

// Layers of what may lie in one plane, bottom up.
enum : int {
  kShadowLayer = 0,
  kRejectedLayer = 0,
  kAcceptedLayer = 1,
  kReferenceLayer = 2,
  kRobotLayer = 3,
  kMarkLayer = 4
};

struct LoopLook {
  LoopStatus status;
  Rgb colour;
  int layer;
  double width_px;
  const char* text;
};

constexpr std::array kLoopLooks = {
    LoopLook{LoopStatus::kRejected, {243, 178, 170}, kRejectedLayer, 1.2, "rejected loops"},
    LoopLook{LoopStatus::kAccepted, {150, 156, 165}, kAcceptedLayer, 1.2, "accepted loops"},
    LoopLook{LoopStatus::kTrue, {98, 168, 118}, kAcceptedLayer, 1.4, "true loops"},
    LoopLook{LoopStatus::kFalse, {205, 32, 44}, kAcceptedLayer, 2.0, "false loops"},
};

// What the drawing functions share.
struct Drawing {
  const FigureContent& content;
  const FigureOptions& options;
  View view;
  double unit;                // pixels per pixel of a picture 1200 high
  Eigen::AlignedBox3d box_W;  // of all content
  Eigen::Vector3d origin_W;   // the scene's zero
  HeightScale heights;        // that colours span

  Eigen::Vector3f local(const Eigen::Vector3d& p_W) const { return (p_W - origin_W).cast<float>(); }
  bool by_height() const { return content.colour_by == ColourBy::kHeight; }
  Rgb height_colour_at(double z_W) const {
    return height_colour((z_W - heights.low_m) / std::max(heights.high_m - heights.low_m, 1e-9));
  }
};

template <typename Visit>
void for_each_point(const FigureContent& content, Visit&& visit) {
  for (const auto* curves : {&content.trajectories, &content.references}) {
    for (const Curve& curve : *curves) {
      for (const Eigen::Vector3d& p : curve.points_W) visit(p);
    }
  }
  for (const LoopLine& loop : content.loops) {
    visit(loop.from_W);
    visit(loop.to_W);
  }
  for (const Mesh& mesh : content.meshes) {
    for (const Eigen::Vector3f& p : mesh.vertices) visit(p.cast<double>());
  }
}

Rgb curve_colour(const std::vector<Curve>& curves, std::size_t index) {
  return curves[index].colour.value_or(palette_colour(static_cast<int>(index)));
}

enum class MeshColouring { kOwn, kRobot, kLabel, kHeight, kPlain };

MeshColouring mesh_colouring(const FigureContent& content, const Mesh& mesh) {
  switch (content.mesh_colour.value_or(content.colour_by)) {
    case ColourBy::kRobot:
      return MeshColouring::kRobot;
    case ColourBy::kHeight:
      return MeshColouring::kHeight;
    case ColourBy::kLabel:
      return mesh.labels.empty() ? MeshColouring::kPlain : MeshColouring::kLabel;
    case ColourBy::kAuto:
      break;
  }
  if (!mesh.colours.empty()) return MeshColouring::kOwn;
  return mesh.labels.empty() ? MeshColouring::kPlain : MeshColouring::kLabel;
}

Rgb mesh_robot_colour(const FigureContent& content, std::size_t index) {
  return index < content.trajectories.size() ? curve_colour(content.trajectories, index)
                                             : palette_colour(static_cast<int>(index));
}

constexpr Rgb kUnlabelled = {200, 203, 208};

Mesh coloured_local(const Drawing& drawing, std::size_t index) {
  Mesh mesh = drawing.content.meshes[index];
  const MeshColouring colouring = mesh_colouring(drawing.content, mesh);
  if (colouring != MeshColouring::kOwn) mesh.colours.assign(mesh.vertices.size(), kUnlabelled);
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
    const Eigen::Vector3d p_W = mesh.vertices[i].cast<double>();
    mesh.vertices[i] = drawing.local(p_W);
    if (colouring == MeshColouring::kHeight) mesh.colours[i] = drawing.height_colour_at(p_W.z());
    if (colouring == MeshColouring::kRobot) {
      mesh.colours[i] = mix(mesh_robot_colour(drawing.content, index), kWhite, 0.45);
    }
    if (colouring == MeshColouring::kLabel && mesh.labels[i] < kFirstNoLabel)
      mesh.colours[i] = label_class(drawing.content.classes, mesh.labels[i]).colour;
  }
  return mesh;
}

void add_loops(Scene& scene, const Drawing& drawing) {
  for (const LoopLook& look : kLoopLooks) {
    std::vector<ColouredPoint> lines;
    for (const LoopLine& loop : drawing.content.loops) {
      if (loop.status != look.status) continue;
      lines.push_back({drawing.local(loop.from_W), look.colour});
      lines.push_back({drawing.local(loop.to_W), look.colour});
    }
    scene.add_lines(lines, {look.width_px * drawing.unit, look.layer, LineForm::kSegments});
  }
}

// Of trajectories all of it, of meshes from the 1st to the 99th percentile.
HeightScale height_range(const FigureContent& content) {
  std::vector<double> heights;
  for (const Mesh& mesh : content.meshes) {
    for (const Eigen::Vector3f& p : mesh.vertices) heights.push_back(p.z());
  }
  Eigen::AlignedBox1d range;
  if (!heights.empty()) {
    for (const double part : {0.01, 0.99}) {
      const auto place = heights.begin() + std::lround(part * static_cast<double>(heights.size() - 1));
      std::nth_element(heights.begin(), place, heights.end());
      range.extend(Eigen::Matrix<double, 1, 1>(*place));
    }
  }
  for (const auto* curves : {&content.trajectories, &content.references}) {
    for (const Curve& curve : *curves) {
      for (const Eigen::Vector3d& p : curve.points_W) range.extend(Eigen::Matrix<double, 1, 1>(p.z()));
    }
  }
  if (range.isEmpty()) return {};
  return {range.min().x(), range.max().x()};
}

std::vector<ColouredPoint> curve_points(const Drawing& drawing, const Curve& curve, Rgb colour) {
  std::vector<ColouredPoint> points;
  points.reserve(curve.points_W.size());
  for (const Eigen::Vector3d& p : curve.points_W) {
    points.push_back({drawing.local(p), drawing.by_height() ? drawing.height_colour_at(p.z()) : colour});
  }
  return points;
}

void add_shadow(Scene& scene, const Drawing& drawing, const Curve& curve, Rgb colour) {
  std::vector<ColouredPoint> points = curve_points(drawing, curve, colour);
  for (ColouredPoint& point : points) {
    point.p_W.z() = static_cast<float>(drawing.box_W.min().z() - drawing.origin_W.z());
    point.colour = mix(point.colour, kWhite, 0.78);
  }
  scene.add_lines(points, {.width_px = 1.6 * drawing.unit, .layer = kShadowLayer});
}

void add_curves(Scene& scene, const Drawing& drawing) {
  const FigureContent& content = drawing.content;
  for (const Curve& curve : content.references) {
    std::vector<ColouredPoint> points = curve_points(drawing, curve, kReference);
    for (ColouredPoint& point : points) point.colour = curve.colour.value_or(kReference);
    scene.add_lines(points, {.width_px = 1.6 * drawing.unit, .layer = kReferenceLayer});
  }
  const Eigen::Vector3d sizes = drawing.box_W.sizes();
  const bool rises = sizes.z() > 0.03 * std::max(sizes.x(), sizes.y());
  for (std::size_t i = 0; i < content.trajectories.size(); ++i) {
    const Curve& curve = content.trajectories[i];
    if (curve.points_W.empty()) continue;
    const Rgb colour = curve_colour(content.trajectories, i);
    // On open ground a shadow tells how high a trajectory runs.
    if (rises && drawing.view == View::kOblique && content.meshes.empty())
      add_shadow(scene, drawing, curve, colour);
    const std::vector<ColouredPoint> points = curve_points(drawing, curve, colour);
    scene.add_lines(points, {.width_px = kTrajectoryWidth * drawing.unit, .layer = kRobotLayer});
    add_start_mark(scene, points.front(), drawing.unit, kMarkLayer);
    add_end_mark(scene, points.back(), drawing.unit, kMarkLayer);
  }
}

Legend make_legend(const Drawing& drawing) {
  using Swatch = LegendEntry::Swatch;
  const FigureContent& content = drawing.content;
  Legend legend;
  for (std::size_t i = 0; i < content.trajectories.size() && !drawing.by_height(); ++i) {
    legend.entries.push_back({content.trajectories[i].name, curve_colour(content.trajectories, i),
                              Swatch::kLine, kTrajectoryWidth * 1.3 * drawing.unit});
  }
  std::set<std::string> references;  // a team's truth is several curves of one name
  for (const Curve& curve : content.references) {
    if (!references.insert(curve.name).second) continue;
    legend.entries.push_back(
        {curve.name, curve.colour.value_or(kReference), Swatch::kLine, 1.6 * drawing.unit});
  }
  for (const LoopLook& look : kLoopLooks) {
    const auto count = std::count_if(content.loops.begin(), content.loops.end(),
                                     [&](const LoopLine& loop) { return loop.status == look.status; });
    if (count == 0) continue;
    legend.entries.push_back({fmt::format("{} {}", count, look.text), look.colour, Swatch::kLine,
                              1.4 * look.width_px * drawing.unit});
  }
  if (!content.trajectories.empty()) {
    legend.entries.push_back({"start", kGrey, Swatch::kStart, 0.0});
    legend.entries.push_back({"end", kGrey, Swatch::kEnd, 0.0});
  }
  std::set<std::uint16_t> labels;
  for (const Mesh& mesh : content.meshes) {
    if (mesh_colouring(content, mesh) == MeshColouring::kLabel)
      labels.insert(mesh.labels.begin(), mesh.labels.end());
  }
  labels.erase(labels.lower_bound(kFirstNoLabel), labels.end());
  constexpr std::size_t kMostLabels = 20;
  std::size_t shown = 0;
  for (const std::uint16_t label : labels) {
    if (++shown > kMostLabels) break;
    const LabelClass known = label_class(content.classes, label);
    legend.entries.push_back({known.name, known.colour, Swatch::kArea, 0.0});
  }
  const bool meshes_by_height = !content.meshes.empty() && content.mesh_colour == ColourBy::kHeight;
  if (drawing.by_height() || meshes_by_height) legend.heights = drawing.heights;
  return legend;
}

// What the camera must show: the corners of the ground and of the content's box, in the scene's coordinates.
std::vector<Eigen::Vector3d> framed_points(const Drawing& drawing, const Ground& ground) {
  std::vector<Eigen::Vector3d> points;
  for (const double x : {ground.x_low, ground.x_high}) {
    for (const double y : {ground.y_low, ground.y_high})
      points.push_back(Eigen::Vector3d(x, y, ground.z) - drawing.origin_W);
  }
  const auto visit = [&](const Eigen::Vector3d& p_W) { points.push_back(p_W - drawing.origin_W); };
  if (drawing.view == View::kOblique) for_each_point(drawing.content, visit);
  points.push_back(drawing.box_W.min() - drawing.origin_W);
  if (drawing.view == View::kTop) points.push_back(drawing.box_W.max() - drawing.origin_W);
  return points;
}

ColouredPoint pixel(const Eigen::Vector2d& p, Rgb colour) {
  return {Eigen::Vector3d(p.x(), p.y(), 1.0).cast<float>(), colour};
}

// An arrow with a letter at its head, from one pixel towards another and `length` beyond.
void add_axis(Scene& scene, const Eigen::Vector2d& from, const Eigen::Vector2d& towards, const char* letter,
              double unit) {
  constexpr Rgb kInk = {70, 74, 80};
  const Eigen::Vector2d along = (towards - from).normalized();
  const Eigen::Vector2d across(-along.y(), along.x());
  const Eigen::Vector2d head = towards + 22.0 * unit * along;
  const std::array lines = {pixel(towards, kInk), pixel(head, kInk),
                            pixel(head, kInk),    pixel(head + unit * (-8.0 * along + 5.0 * across), kInk),
                            pixel(head, kInk),    pixel(head + unit * (-8.0 * along - 5.0 * across), kInk)};
  scene.add_lines(lines, {.width_px = 1.6 * unit, .form = LineForm::kSegments});
  const Eigen::Vector2d letter_centre = head + 15.0 * unit * along;
  add_text(scene, letter, letter_centre.x(), letter_centre.y() + 5.0 * unit,
           {.height_px = 14.0 * unit, .colour = kInk, .align = Align::kCentre});
}

// A bar of one step, level with the ground, just outside its edge that is nearest to the viewer.
void add_scale_bar(Scene& scene, const Eigen::Vector2d& left, const Eigen::Vector2d& right,
                   const std::string& text, double unit) {
  constexpr Rgb kInk = {40, 42, 46};
  const Eigen::Vector2d tick(0.0, 6.0 * unit);
  const std::array lines = {pixel(left, kInk),        pixel(right, kInk),        pixel(left - tick, kInk),
                            pixel(left + tick, kInk), pixel(right - tick, kInk), pixel(right + tick, kInk)};
  scene.add_lines(lines, {.width_px = 2.4 * unit, .form = LineForm::kSegments});
  const Eigen::Vector2d middle = 0.5 * (left + right);
  add_text(scene, text, middle.x(), middle.y() + 26.0 * unit,
           {.height_px = 13.0 * unit, .colour = kInk, .align = Align::kCentre});
}

void add_marks_beside_ground(Scene& scene, const Drawing& drawing, const Ground& ground,
                             const Camera& camera) {
  const auto project = [&](double x, double y) -> Eigen::Vector2d {
    return camera.project(Eigen::Vector3d(x, y, ground.z) - drawing.origin_W).head<2>();
  };
  const double unit = drawing.unit;
  // The edges nearest to the viewer carry the axes; seen from above those are the lower and the left one.
  const Eigen::Vector3d viewer = camera.T_C_W.inverse().translation;
  const bool top = drawing.view == View::kTop;
  const double x_edge = !top && viewer.x() > 0.0 ? ground.x_high : ground.x_low;
  const double y_edge = !top && viewer.y() > 0.0 ? ground.y_high : ground.y_low;
  add_axis(scene, project(ground.x_low, y_edge), project(ground.x_high, y_edge), "x", unit);
  add_axis(scene, project(x_edge, ground.y_low), project(x_edge, ground.y_high), "y", unit);

  if (top) {
    const TextStyle style = {.height_px = 10.5 * unit, .colour = kGrey, .align = Align::kCentre};
    const double bottom = project(ground.x_low, ground.y_low).y() + 20.0 * unit;
    for (double i = std::ceil(ground.x_low / ground.step); i * ground.step <= ground.x_high; ++i) {
      const double x = i * ground.step;
      add_text(scene, tick_text(x), project(x, ground.y_low).x(), bottom, style);
    }
    TextStyle right_aligned = style;
    right_aligned.align = Align::kRight;
    const double left = project(ground.x_low, ground.y_low).x() - 8.0 * unit;
    for (double i = std::ceil(ground.y_low / ground.step); i * ground.step <= ground.y_high; ++i) {
      const double y = i * ground.step;
      add_text(scene, tick_text(y), left, project(ground.x_low, y).y() + 5.0 * unit, right_aligned);
    }
  }
  const Eigen::Vector2d down(0.0, (top ? 50.0 : 24.0) * unit);
  const Eigen::Vector2d bar_start = project(ground.x_low, y_edge) + down;
  add_scale_bar(scene, bar_start,
                bar_start + project(ground.x_low + ground.step, y_edge) - project(ground.x_low, y_edge),
                format_length(ground.step), unit);
}

}  // namespace

bool has_content(const FigureContent& content) {
  bool any = false;
  for_each_point(content, [&](const Eigen::Vector3d&) { any = true; });
  return any;
}

Image draw_figure(Renderer& renderer, const FigureContent& content, View view, const FigureOptions& options) {
  const auto [width, height] = options.size;
  Drawing drawing = {content,
                     options,
                     view,
                     std::max(0.4, std::min(width / 1600.0, height / 1200.0)),
                     {},
                     {},
                     height_range(content)};
  for_each_point(content, [&](const Eigen::Vector3d& p) { drawing.box_W.extend(p); });
  COVEY_CHECK(!drawing.box_W.isEmpty() && drawing.box_W.sizes().allFinite());
  drawing.origin_W = drawing.box_W.center();
  const double unit = drawing.unit;

  const Legend legend = make_legend(drawing);
  const double beside = legend_width(legend, unit);
  const Frame frame = {72.0 * unit, (content.title.empty() ? 64.0 : 126.0) * unit,
                       width - (beside > 0.0 ? beside + 112.0 * unit : 72.0 * unit), height - 96.0 * unit};
  const double aspect = view == View::kTop ? (frame.right - frame.left) / (frame.bottom - frame.top) : 0.0;
  const Ground ground = plan_ground(drawing.box_W, aspect);
  const std::vector<Eigen::Vector3d> framed = framed_points(drawing, ground);
  const Camera camera = view == View::kTop ? top_camera(framed, frame, options.size)
                                           : oblique_camera(framed, frame, options.size, options.oblique);

  Scene scene(renderer.context());
  add_ground(scene, ground, drawing.origin_W, unit);
  for (std::size_t i = 0; i < content.meshes.size(); ++i) {
    scene.add(coloured_local(drawing, i), {.shade = 0.9, .two_sided = !options.see_through});
  }
  add_loops(scene, drawing);
  add_curves(scene, drawing);

  Scene notes(renderer.context());
  add_text(notes, content.title, 72.0 * unit, 58.0 * unit,
           {.height_px = 21.0 * unit, .colour = {25, 27, 30}});
  add_legend(notes, legend, width - beside - 36.0 * unit, frame.top, unit);
  add_marks_beside_ground(notes, drawing, ground, camera);

  const std::array layers = {Layer{&scene, camera}, Layer{&notes, pixel_camera(options.size)}};
  return renderer.render(layers, {.samples = 4, .supersample = 2});
}

}  // namespace covey::viewer
