// SPDX-License-Identifier: BSD-3-Clause
#include "core/mesh/simplify.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_map>
#include <unordered_set>
#include <utility>

namespace covey::mesh {
namespace {

constexpr double kCellStep = 1.25;

struct Cell {
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::int32_t z = 0;
  Utime segment = 0;

  bool operator==(const Cell&) const = default;
};

struct CellHash {
  std::size_t operator()(const Cell& cell) const {
    std::uint64_t h = static_cast<std::uint64_t>(cell.segment);
    for (const std::int32_t c : {cell.x, cell.y, cell.z}) {
      h = (h ^ static_cast<std::uint32_t>(c)) * 0x9E3779B97F4A7C15ULL;
      h ^= h >> 29;
    }
    return h;
  }
};

Cell cell_of(const MeasuredMesh& mesh, std::span<const PlacedKeyframe> keyframes, std::size_t vertex,
             double cell_m) {
  const Eigen::Vector3d place = mesh.p_O[vertex].cast<double>() / cell_m;
  return {static_cast<std::int32_t>(std::floor(place.x())), static_cast<std::int32_t>(std::floor(place.y())),
          static_cast<std::int32_t>(std::floor(place.z())), keyframes[mesh.seen_by[vertex]].segment};
}

// Vertices grouped by cell; the cells come in the order of their first vertices.
struct Cells {
  std::vector<std::int32_t> cell_of;  // by vertex
  int count = 0;
};

Cells group(const MeasuredMesh& mesh, std::span<const PlacedKeyframe> keyframes, double cell_m) {
  Cells cells;
  cells.cell_of.reserve(mesh.p_O.size());
  std::unordered_map<Cell, std::int32_t, CellHash> known;
  for (std::size_t v = 0; v < mesh.p_O.size(); ++v) {
    const auto [found, is_new] = known.try_emplace(cell_of(mesh, keyframes, v, cell_m), cells.count);
    cells.count += is_new ? 1 : 0;
    cells.cell_of.push_back(found->second);
  }
  return cells;
}

std::vector<std::vector<std::int32_t>> members_of(const std::vector<std::int32_t>& group_of, int count) {
  std::vector<std::vector<std::int32_t>> members(count);
  for (std::size_t v = 0; v < group_of.size(); ++v)
    members[group_of[v]].push_back(static_cast<std::int32_t>(v));
  return members;
}

Node make_node(const MeasuredMesh& mesh, std::span<const PlacedKeyframe> keyframes,
               std::span<const std::int32_t> vertices, int most_keyframes) {
  Node node;
  std::map<int, int> counts;
  for (const std::int32_t v : vertices) {
    node.g_O += mesh.p_O[v].cast<double>();
    ++counts[mesh.seen_by[v]];
  }
  node.g_O /= static_cast<double>(vertices.size());
  const PlacedKeyframe& any = keyframes[counts.begin()->first];
  node.segment = any.segment;
  node.first_us = node.last_us = any.utime;
  for (const auto& [keyframe, count] : counts) {
    node.first_us = std::min(node.first_us, keyframes[keyframe].utime);
    node.last_us = std::max(node.last_us, keyframes[keyframe].utime);
    node.seen_by.push_back({keyframe, count});
  }
  std::stable_sort(node.seen_by.begin(), node.seen_by.end(),
                   [](const Sighting& a, const Sighting& b) { return a.vertices > b.vertices; });
  if (static_cast<int>(node.seen_by.size()) > most_keyframes) node.seen_by.resize(most_keyframes);
  return node;
}

// Parts a cell's vertices into passes and makes a node of each.
void add_nodes(const MeasuredMesh& mesh, std::span<const PlacedKeyframe> keyframes,
               const SimplifyOptions& options, std::vector<std::int32_t>& vertices, SimplifiedMesh& simple) {
  const auto time = [&](std::int32_t v) { return keyframes[mesh.seen_by[v]].utime; };
  std::stable_sort(vertices.begin(), vertices.end(),
                   [&](std::int32_t a, std::int32_t b) { return time(a) < time(b); });
  std::size_t begin = 0;
  for (std::size_t end = 1; end <= vertices.size(); ++end) {
    if (end < vertices.size() && time(vertices[end]) - time(vertices[end - 1]) <= options.pass_us) continue;
    const auto pass = std::span(vertices).subspan(begin, end - begin);
    for (const std::int32_t v : pass) simple.node_of[v] = static_cast<std::int32_t>(simple.nodes.size());
    simple.nodes.push_back(make_node(mesh, keyframes, pass, options.keyframes_per_node));
    begin = end;
  }
}

std::vector<NodeEdge> join(const MeasuredMesh& mesh, const SimplifiedMesh& simple, Utime pass_us) {
  std::unordered_set<std::uint64_t> known;
  std::vector<NodeEdge> edges;
  for (const Face& face : mesh.faces) {
    for (const auto& [from, to] : {std::pair{0, 1}, std::pair{1, 2}, std::pair{2, 0}}) {
      const auto [a, b] = std::minmax(simple.node_of[face[from]], simple.node_of[face[to]]);
      if (a == b || !same_pass(simple.nodes[a], simple.nodes[b], pass_us)) continue;
      const std::uint64_t name = static_cast<std::uint64_t>(a) << 32 | static_cast<std::uint32_t>(b);
      if (known.insert(name).second) edges.push_back({a, b});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const NodeEdge& one, const NodeEdge& other) {
    return std::pair(one.a, one.b) < std::pair(other.a, other.b);
  });
  return edges;
}

}  // namespace

bool same_pass(const Node& node, const PlacedKeyframe& keyframe, Utime pass_us) {
  return node.segment == keyframe.segment && keyframe.utime >= node.first_us - pass_us &&
         keyframe.utime <= node.last_us + pass_us;
}

bool same_pass(const Node& a, const Node& b, Utime pass_us) {
  return a.segment == b.segment && a.first_us - pass_us <= b.last_us && b.first_us - pass_us <= a.last_us;
}

SimplifiedMesh simplify(const MeasuredMesh& mesh, std::span<const PlacedKeyframe> keyframes,
                        const SimplifyOptions& options) {
  SimplifiedMesh simple;
  simple.cell_m = options.min_cell_m;
  Cells cells = group(mesh, keyframes, simple.cell_m);
  while (cells.count > options.max_nodes) {
    simple.cell_m *= kCellStep;
    cells = group(mesh, keyframes, simple.cell_m);
  }
  simple.node_of.resize(mesh.p_O.size());
  for (auto& vertices : members_of(cells.cell_of, cells.count)) {
    add_nodes(mesh, keyframes, options, vertices, simple);
  }
  simple.edges = join(mesh, simple, options.pass_us);
  return simple;
}

}  // namespace covey::mesh
