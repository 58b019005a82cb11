// SPDX-License-Identifier: BSD-3-Clause
#include "procs/mesher/mesh_file.h"

#include "core/base/error.h"
#include "core/mesh/label_votes.h"
#include "viewer_offscreen/ply.h"

namespace covey {

void MeshFile::put(const mesh_block_t& block) {
  const Name name{block.segment, block.x, block.y, block.z};
  if (block.n_vertices == 0) {
    blocks_.erase(name);
  } else {
    blocks_[name] = block;
  }
}

void MeshFile::write(const std::filesystem::path& file) const {
  viewer::Mesh mesh;
  for (const auto& [name, block] : blocks_) {
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (std::size_t i = 0; i < block.labels.size(); ++i) {
      mesh.vertices.emplace_back(block.p_O[3 * i], block.p_O[3 * i + 1], block.p_O[3 * i + 2]);
      mesh.colours.push_back({block.colours[3 * i], block.colours[3 * i + 1], block.colours[3 * i + 2]});
      mesh.labels.push_back(block.labels[i]);
    }
    for (std::size_t i = 0; i < block.corners.size(); i += 3) {
      mesh.faces.push_back({first + static_cast<std::uint32_t>(block.corners[i]),
                            first + static_cast<std::uint32_t>(block.corners[i + 1]),
                            first + static_cast<std::uint32_t>(block.corners[i + 2])});
    }
  }
  std::filesystem::path fresh = file;
  fresh += ".new";
  viewer::write_ply(fresh, mesh);
  std::error_code error;
  std::filesystem::rename(fresh, file, error);
  if (error) throw_input_error("{}: {}", file.string(), error.message());
}

}  // namespace covey
