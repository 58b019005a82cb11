// SPDX-License-Identifier: BSD-3-Clause
#include "core/mesh/optimized_parts.h"

namespace covey::mesh {
namespace {

class PartWriter {
 public:
  PartWriter(const mesh_optimized_t& name, const MeshSnapshot& snapshot, std::span<const Eigen::Vector3f> p_W)
      : name_(name), snapshot_(snapshot), p_W_(p_W), part_of_(p_W.size(), -1), place_(p_W.size(), 0) {
    begin_part();
  }

  void add(const Face& face) {
    if (parts_.back().n_vertices + 3 > kVerticesPerPart) begin_part();
    for (const std::uint32_t corner : face) parts_.back().corners.push_back(place_of(corner));
    parts_.back().n_corners += 3;
  }

  std::vector<mesh_optimized_t> finish() {
    for (mesh_optimized_t& part : parts_) {
      part.parts = static_cast<std::int32_t>(parts_.size());
      part.n_values = 3 * part.n_vertices;
    }
    return std::move(parts_);
  }

 private:
  void begin_part() {
    parts_.push_back(name_);
    parts_.back().part = static_cast<std::int32_t>(parts_.size()) - 1;
  }

  std::int32_t place_of(std::uint32_t vertex) {
    mesh_optimized_t& part = parts_.back();
    if (part_of_[vertex] != part.part) {
      part_of_[vertex] = part.part;
      place_[vertex] = part.n_vertices++;
      part.p_W.insert(part.p_W.end(), p_W_[vertex].begin(), p_W_[vertex].end());
      const auto colour = snapshot_.colours.begin() + 3 * static_cast<std::ptrdiff_t>(vertex);
      part.colours.insert(part.colours.end(), colour, colour + 3);
      part.labels.push_back(snapshot_.labels[vertex]);
    }
    return place_[vertex];
  }

  const mesh_optimized_t& name_;
  const MeshSnapshot& snapshot_;
  std::span<const Eigen::Vector3f> p_W_;
  std::vector<std::int32_t> part_of_;  // the last part that has the vertex, and where it stands there
  std::vector<std::int32_t> place_;
  std::vector<mesh_optimized_t> parts_;
};

}  // namespace

std::vector<mesh_optimized_t> optimized_parts(const mesh_optimized_t& name, const MeshSnapshot& snapshot,
                                              std::span<const Eigen::Vector3f> p_W) {
  PartWriter writer(name, snapshot, p_W);
  for (const Face& face : snapshot.mesh.faces) writer.add(face);
  return writer.finish();
}

}  // namespace covey::mesh
