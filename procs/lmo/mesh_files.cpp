// SPDX-License-Identifier: BSD-3-Clause
#include "procs/lmo/mesh_files.h"

#include <spdlog/spdlog.h>

#include <system_error>
#include <utility>

#include "core/base/error.h"
#include "viewer_offscreen/ply.h"

namespace covey {
namespace {

void replace(const std::filesystem::path& file, const mesh::MeshSnapshot& snapshot,
             std::span<const Eigen::Vector3f> p) {
  viewer::Mesh mesh;
  mesh.vertices.assign(p.begin(), p.end());
  mesh.faces = snapshot.mesh.faces;
  mesh.labels.assign(snapshot.labels.begin(), snapshot.labels.end());
  mesh.colours.reserve(p.size());
  for (std::size_t v = 0; v < p.size(); ++v) {
    const std::uint8_t* colour = &snapshot.colours[3 * v];
    mesh.colours.push_back({colour[0], colour[1], colour[2]});
  }
  std::filesystem::path fresh = file;
  fresh += ".new";
  try {
    viewer::write_ply(fresh, mesh);
    std::filesystem::rename(fresh, file);
  } catch (const std::exception& error) {
    spdlog::warn("--mesh: {}", error.what());
  }
}

}  // namespace

MeshFiles::MeshFiles(std::filesystem::path folder, int robot) : folder_(std::move(folder)), robot_(robot) {
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  if (error) throw_input_error("--mesh {}: {}", folder_.string(), error.message());
}

void MeshFiles::write_odometry(const mesh::MeshSnapshot& snapshot) const {
  replace(folder_ / fmt::format("robot{}_vio.ply", robot_), snapshot, snapshot.mesh.p_O);
}

void MeshFiles::write_team(const mesh::MeshSnapshot& snapshot, std::span<const Eigen::Vector3f> p_W) const {
  replace(folder_ / fmt::format("robot{}_team.ply", robot_), snapshot, p_W);
}

}  // namespace covey
