// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The few nodes that stand for a mesh of many vertices: vertex clustering on a grid (Rossignac and Borrel 1993; the paper's
// section VI merges the vertices of an octree's voxel). A node is the mean of the vertices of one cell that were last seen in
// one pass; an edge joins nodes whose vertices share a face.
//
// Where a robot comes by again after a long way, old and new vertices lie in the same cells, but drift lies between them, and
// the optimised trajectory moves them differently. So the vertices of a cell are parted where more than `pass_us` lies between
// the keyframes that saw them, and no edge joins nodes that are further apart in time than that, or of different segments.
//
// The cell is the smallest one, from `min_cell_m` up, with which there are no more than `max_nodes`: 0.3 m in a room and 1-2 m
// in a town come out of it.

#include <span>
#include <vector>

#include "core/mesh/measured_mesh.h"

namespace covey::mesh {

struct SimplifyOptions {
  double min_cell_m = 0.3;
  int max_nodes = 4000;
  Utime pass_us = 8'000'000;
  int keyframes_per_node = 4;  // those that saw the most of a node's vertices
};

// A keyframe that saw a node, and how many of the node's vertices it saw last.
struct Sighting {
  int keyframe = 0;
  int vertices = 0;
};

struct Node {
  Eigen::Vector3d g_O = Eigen::Vector3d::Zero();  // m, mean of its vertices
  Utime segment = 0;
  Utime first_us = 0;  // of the keyframes that saw its vertices
  Utime last_us = 0;
  std::vector<Sighting> seen_by;  // most vertices first
};

struct NodeEdge {
  int a = 0;  // a < b
  int b = 0;
};

struct SimplifiedMesh {
  std::vector<Node> nodes;
  std::vector<NodeEdge> edges;        // each once, in order
  std::vector<std::int32_t> node_of;  // by vertex
  double cell_m = 0.0;
};

// Whether a node and something seen at one time, or two nodes, belong to one pass.
bool same_pass(const Node& node, const PlacedKeyframe& keyframe, Utime pass_us);
bool same_pass(const Node& a, const Node& b, Utime pass_us);

SimplifiedMesh simplify(const MeasuredMesh& mesh, std::span<const PlacedKeyframe> keyframes,
                        const SimplifyOptions& options = {});

}  // namespace covey::mesh
