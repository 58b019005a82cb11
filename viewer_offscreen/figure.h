// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A figure: what a team of robots did, as a picture for a report or a talk. Trajectories in one colour per
// robot with a ring where they start and a square where they end, loop closures as thin lines, a reference in
// thin grey, meshes; on a ground with lines at round metres; with a title, a legend and a scale bar. All
// coordinates are in W, in metres.
//
// Every size fits: the camera is placed by the content, whether it spans one metre or ten kilometres.
// Coordinates may be large (UTM): what is drawn is taken relative to the content's centre before it becomes
// float.

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "viewer_offscreen/camera.h"
#include "viewer_offscreen/image.h"
#include "viewer_offscreen/label_classes.h"
#include "viewer_offscreen/mesh.h"
#include "viewer_offscreen/renderer.h"

namespace covey::viewer {

struct Curve {
  std::string name;
  std::vector<Eigen::Vector3d> points_W;
  std::optional<Rgb> colour;  // otherwise the palette's, by the curve's place in the list
};

enum class LoopStatus {
  kAccepted,
  kRejected,
  kTrue,   // accepted and known to be right
  kFalse,  // accepted and known to be wrong
};

struct LoopLine {
  Eigen::Vector3d from_W = Eigen::Vector3d::Zero();
  Eigen::Vector3d to_W = Eigen::Vector3d::Zero();
  LoopStatus status = LoopStatus::kAccepted;
};

enum class ColourBy {
  kAuto,    // trajectories by robot; meshes by their colours, else their labels, else grey
  kRobot,   // meshes too: the n-th mesh is the n-th robot's
  kLabel,   // meshes by label
  kHeight,  // trajectories and meshes by height; of a mesh from its 1st to its 99th percentile, so that a stray does not count
};

struct FigureContent {
  std::string title;
  std::vector<Curve> trajectories;
  std::vector<Curve> references;
  std::vector<LoopLine> loops;
  std::vector<Mesh> meshes;
  ColourBy colour_by = ColourBy::kAuto;
  std::optional<ColourBy> mesh_colour;  // of the meshes, where it is not that of the trajectories
  LabelClasses classes;                 // names and colours of labels
};

enum class View {
  kTop,      // orthographic, x to the right, y up
  kOblique,  // perspective from above at an angle
};

struct FigureOptions {
  PictureSize size = {1600, 1200};
  ObliqueOptions oblique = {};
  // Meshes are shown from their free side only, so that one looks into a room through its walls and ceiling.
  bool see_through = true;
};

// COVEY_CHECK: something is there to be drawn (has_content), and it is finite.
bool has_content(const FigureContent& content);
Image draw_figure(Renderer& renderer, const FigureContent& content, View view,
                  const FigureOptions& options = {});

}  // namespace covey::viewer
