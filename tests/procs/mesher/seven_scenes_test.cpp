// SPDX-License-Identifier: BSD-3-Clause
// A real room (7-Scenes): player and mesher from the recording to a mesh and a picture of it, and the mesh against the depth images.
#include <catch2/catch.hpp>
#include <cstdio>
#include <unordered_map>

#include "core/geometry/rig.h"
#include "core/mesh/block.h"
#include "procs/player/rgbd_folder.h"
#include "tests/child_process.h"
#include "tests/core/pgo/scratch.h"
#include "tests/data.h"
#include "viewer_offscreen/ply.h"

using namespace covey;

namespace {

constexpr double kRunPatienceS = 110.0;
constexpr double kVoxelM = 0.03;  // configs/robots/seven_scenes.yaml

// Vertices by cells of 5 cm.
class NearestVertex {
 public:
  explicit NearestVertex(const viewer::Mesh& mesh) {
    for (const auto& p : mesh.vertices) cells_[cell_of(p)].push_back(p);
  }
  // Not beyond 5 cm.
  double distance(const Eigen::Vector3f& p) const {
    float best = kCellM;
    const mesh::BlockIndex at = cell_of(p);
    for (int n = 0; n < 27; ++n) {
      const auto cell = cells_.find({at.x + n % 3 - 1, at.y + n / 3 % 3 - 1, at.z + n / 9 - 1});
      if (cell == cells_.end()) continue;
      for (const auto& q : cell->second) best = std::min(best, (p - q).norm());
    }
    return best;
  }

 private:
  static constexpr float kCellM = 0.05F;
  static mesh::BlockIndex cell_of(const Eigen::Vector3f& p) {
    return {static_cast<int>(std::floor(p.x() / kCellM)), static_cast<int>(std::floor(p.y() / kCellM)),
            static_cast<int>(std::floor(p.z() / kCellM))};
  }
  std::unordered_map<mesh::BlockIndex, std::vector<Eigen::Vector3f>, mesh::BlockIndexHash> cells_;
};

void run(const std::string& program, const std::vector<std::string>& arguments, const ScratchFile& said) {
  ChildProcess process(program, arguments, said.path);
  const std::optional<int> code = process.wait(kRunPatienceS);
  INFO(program + ": " + process.output());
  REQUIRE(code == 0);
}

}  // namespace

TEST_CASE("the 7-Scenes room becomes a mesh that agrees with the depth images") {
  const auto folder = test_data("rgbd/seven_scenes");
  if (!folder) return;
  const std::filesystem::path config =
      std::filesystem::path(COVEY_SOURCE_DIR) / "configs/robots/seven_scenes.yaml";
  const ScratchFile log;
  const ScratchFile ply;
  const ScratchFile png(ScratchFile::Extension{".png"});
  const ScratchFile said;
  run("player", {"--tum-rgbd", *folder, "--up", "-y", "--config", config, "--out", log.path}, said);
  run("mesher",
      {"--robot", "0", "--config", config, "--url", "file://" + log.path.string(), "--ply", ply.path}, said);
  run("viewer_offscreen",
      {"--mesh", ply.path, "--view", "oblique", "--azimuth", "180", "--elevation", "25", "--out", png.path},
      said);
  CHECK(std::filesystem::file_size(png.path) > 50'000);

  const viewer::Mesh mesh = viewer::read_ply(ply.path);
  const NearestVertex nearest(mesh);
  const DepthCamera camera = *read_rig(config.parent_path() / "../sensors/seven_scenes.yaml").depth;
  SE3 T_O_D;  // --up -y is the frame of the rig's body
  T_O_D.rotation = camera.T_B_C.rotation;
  const RgbdFolder recording = read_rgbd(*folder);
  std::vector<double> distances;
  std::int64_t seen = 0;
  std::int64_t before_the_surface = 0;
  for (std::size_t i = 0; i < recording.frames.size(); i += 20) {
    const RgbdFrame& frame = recording.frames[i];
    const depth_t image = load_depth(frame, recording.depth_per_m);
    const SE3 T_O_C = T_O_D * frame.T_D_C;
    for (int v = 4; v < image.height; v += 8) {
      for (int u = 4; u < image.width; u += 8) {
        const double z = 0.001 * image.depth_mm[static_cast<std::size_t>(v * image.width + u)];
        if (z < camera.near_m || z > camera.far_m) continue;
        const Eigen::Vector3d p_C = z * Eigen::Vector3d((u - camera.camera.cx) / camera.camera.fx,
                                                        (v - camera.camera.cy) / camera.camera.fy, 1.0);
        distances.push_back(nearest.distance((T_O_C * p_C).cast<float>()));
      }
    }
    const SE3 T_C_O = T_O_C.inverse();
    for (const auto& p_O : mesh.vertices) {
      const Eigen::Vector3d p_C = T_C_O * p_O.cast<double>();
      const auto pixel = camera.camera.project(p_C);
      if (!pixel || !camera.camera.contains(*pixel)) continue;
      const auto number = std::lround(pixel->y()) * image.width + std::lround(pixel->x());
      const double z = 0.001 * image.depth_mm[static_cast<std::size_t>(number)];
      if (z < camera.near_m || z > camera.far_m) continue;
      ++seen;
      if (p_C.z() < z - 0.1) ++before_the_surface;
    }
  }
  REQUIRE(distances.size() > 10'000);
  REQUIRE(seen > 100'000);
  std::sort(distances.begin(), distances.end());
  const double median = distances[distances.size() / 2];
  const auto far = distances.end() - std::lower_bound(distances.begin(), distances.end(), 0.05);
  const double missing = static_cast<double>(far) / static_cast<double>(distances.size());
  const double in_the_way = static_cast<double>(before_the_surface) / static_cast<double>(seen);
  std::printf(
      "7-Scenes: %zu vertices; measured points: median %.1f mm from a vertex, %.1f %% farther than 50 mm; "
      "vertices in free space: %.2f %%\n",
      mesh.vertices.size(), 1000.0 * median, 100.0 * missing, 100.0 * in_the_way);
  CHECK(median < 0.7 * kVoxelM);
  CHECK(missing < 0.1);
  CHECK(in_the_way < 0.05);
}
