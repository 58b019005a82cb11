// SPDX-License-Identifier: BSD-3-Clause
#include "core/mesh/tsdf_volume.h"

#include <algorithm>
#include <cmath>

namespace covey::mesh {
namespace {

// How far behind a surface along the ray, in truncations, its plane is believed: at grazing angles the truncation along the normal is
// much farther along the ray, where there may be something else.
constexpr float kDeepestTruncations = 3.0F;
// Nearer than this, all depths weigh the same.
constexpr float kWeightNearest = 1.0F;
// A ray that passes through counts so many times what was taken to lie behind a surface: the one was measured, the other extrapolated.
constexpr float kPassing = 10.0F;
constexpr std::uint16_t kMostColours = 64;
// Pixels between two that blocks are made for: at 10 m and 229 px of focal length 9 cm, far less than a block.
constexpr int kAllocationStride = 2;
constexpr double kBytesPerBlock = sizeof(Block) + 64.0;  // the map's node and pointers
constexpr double kBytesPerSurface = sizeof(std::array<SurfaceVoxel, kBlockVoxels>);

int floor_div(float value, float size) { return static_cast<int>(std::floor(value / size)); }

}  // namespace

struct TsdfVolume::View {
  const depth_t& image;
  const PinholeCamera& camera;
  const TangentPlanes& planes;
  Eigen::Matrix3f R_O_C;
  Eigen::Vector3f p_O_C;
  Eigen::Matrix3f R_C_O;
  Eigen::Vector3f p_C_O;
  float nearest_m;
  int keyframe;
  bool has_labels;
  bool has_colours;
};

void read_tsdf(ConfigSection& section, TsdfOptions& options) {
  section.read("voxel_m", options.voxel_m, 0.01, 1.0);
  section.read("truncation_voxels", options.truncation_voxels, 2.0, 8.0);
  section.read("surface_voxels", options.surface_voxels, 1.0, 4.0);
  section.read("most_weight", options.most_weight, 0.1, 1e6);
  section.read("depth_noise_m", options.depth_noise_m, 0.0, 0.1);
  section.read("memory_mb", options.memory_mb, 1.0, 1500.0);
}

TsdfVolume::TsdfVolume(const TsdfOptions& options)
    : options_(options),
      voxel_m_(static_cast<float>(options.voxel_m)),
      truncation_m_(static_cast<float>(options.voxel_m * options.truncation_voxels)) {}

const Block* TsdfVolume::find(const BlockIndex& index) const {
  const auto found = by_index_.find(index);
  return found == by_index_.end() ? nullptr : found->second;
}

std::size_t TsdfVolume::bytes() const {
  return static_cast<std::size_t>(static_cast<double>(blocks_.size()) * kBytesPerBlock +
                                  static_cast<double>(surfaces_) * kBytesPerSurface);
}

Integration TsdfVolume::integrate(const depth_t& image, const DepthCamera& camera, const SE3& T_O_C,
                                  int keyframe) {
  Integration result;
  planes_.compute(image, camera, {0.5F * truncation_m_, static_cast<float>(options_.depth_noise_m)});
  const SE3 T_C_O = T_O_C.inverse();
  const std::size_t pixels = image.depth_mm.size();
  const View view{.image = image,
                  .camera = camera.camera,
                  .planes = planes_,
                  .R_O_C = T_O_C.rotation.matrix().cast<float>(),
                  .p_O_C = T_O_C.translation.cast<float>(),
                  .R_C_O = T_C_O.rotation.matrix().cast<float>(),
                  .p_C_O = T_C_O.translation.cast<float>(),
                  .nearest_m = static_cast<float>(0.5 * camera.near_m),
                  .keyframe = keyframe,
                  .has_labels = image.labels.size() == pixels,
                  .has_colours = image.colours.size() == 3 * pixels};
  allocate(view, result);
  const float block_m = voxel_m_ * kBlockSide;
  const float radius = 0.5F * block_m * std::sqrt(3.0F);
  // A sphere is outside of the picture where its centre is farther than its radius beyond a side's plane.
  const auto outside = [&](float tangent, float away, float z) {
    return away - tangent * z > radius * std::sqrt(1.0F + tangent * tangent);
  };
  const PinholeCamera& pinhole = camera.camera;
  const auto left = static_cast<float>((pinhole.cx + 0.5) / pinhole.fx);
  const auto right = static_cast<float>((pinhole.width - 0.5 - pinhole.cx) / pinhole.fx);
  const auto up = static_cast<float>((pinhole.cy + 0.5) / pinhole.fy);
  const auto down = static_cast<float>((pinhole.height - 0.5 - pinhole.cy) / pinhole.fy);
  for (const auto& block : blocks_) {
    const Eigen::Vector3f lowest(static_cast<float>(block->index.x), static_cast<float>(block->index.y),
                                 static_cast<float>(block->index.z));
    const Eigen::Vector3f c =
        view.R_C_O * (block_m * lowest + Eigen::Vector3f::Constant(0.5F * block_m)) + view.p_C_O;
    if (c.z() + radius < view.nearest_m ||
        c.z() - radius > planes_.farthest_m() + kDeepestTruncations * truncation_m_)
      continue;
    if (outside(left, -c.x(), c.z()) || outside(right, c.x(), c.z()) || outside(up, -c.y(), c.z()) ||
        outside(down, c.y(), c.z()))
      continue;
    ++result.blocks_in_view;
    block->utime = image.utime;
    if (update(*block, view)) result.changed.push_back(block->index);
  }
  forget_oldest(result);
  return result;
}

// Blocks within the truncation of the surface, before and behind it.
void TsdfVolume::allocate(const View& view, Integration& result) {
  const float block_m = voxel_m_ * kBlockSide;
  BlockIndex last{INT32_MAX, 0, 0};
  for (int v = 0; v < view.camera.height; v += kAllocationStride) {
    for (int u = 0; u < view.camera.width; u += kAllocationStride) {
      const TangentPlane& plane = view.planes.at(u, v);
      if (plane.distance <= 0.0F) continue;
      const Eigen::Vector3f p_O = view.R_O_C * view.planes.point(u, v) + view.p_O_C;
      const Eigen::Vector3f normal_O = view.R_O_C * (plane.a * plane.distance);
      for (const float s : {-1.0F, 0.0F, 1.0F}) {
        const Eigen::Vector3f q_O = p_O + s * truncation_m_ * normal_O;
        const BlockIndex index{floor_div(q_O.x(), block_m), floor_div(q_O.y(), block_m),
                               floor_div(q_O.z(), block_m)};
        if (index == last) continue;
        last = index;
        find_or_make(index, result);
      }
    }
  }
}

Block& TsdfVolume::find_or_make(const BlockIndex& index, Integration& result) {
  const auto [place, is_new] = by_index_.try_emplace(index, nullptr);
  if (is_new) {
    blocks_.push_back(std::make_unique<Block>());
    blocks_.back()->index = index;
    place->second = blocks_.back().get();
    ++result.new_blocks;
  }
  return *place->second;
}

// A ray that passes says that a voxel is free, but not how far from it the nearest surface is: it moves voxels that are taken to be inside
// of something, and tells those that nothing is known of. And the first surface that is seen near a voxel that was only known to be free
// replaces that. So the field before a surface stays a distance, whatever is seen behind it.
bool TsdfVolume::average_in(Voxel& voxel, float distance, float weight) const {
  const auto most_weight = static_cast<float>(options_.most_weight);
  const bool only_free = voxel.weight > 0.0F && voxel.distance >= truncation_m_;
  if (distance >= truncation_m_ && voxel.weight > 0.0F && voxel.distance >= 0.0F) {
    if (only_free) voxel.weight = std::min(voxel.weight + weight, most_weight);
    return false;
  }
  if (only_free && distance >= 0.0F) {
    voxel = {distance, weight};
    return true;
  }
  if (distance >= truncation_m_) weight *= kPassing;
  const bool changed = distance < truncation_m_ || voxel.weight > 0.0F;
  voxel.distance = (voxel.distance * voxel.weight + distance * weight) / (voxel.weight + weight);
  voxel.weight = std::min(voxel.weight + weight, most_weight);
  return changed;
}

// True where something near a surface has changed.
bool TsdfVolume::update(Block& block, const View& view) {
  const Eigen::Vector3f step = view.R_C_O.col(0) * voxel_m_;
  const auto fx = static_cast<float>(view.camera.fx);
  const auto fy = static_cast<float>(view.camera.fy);
  const auto cx = static_cast<float>(view.camera.cx) + 0.5F;
  const auto cy = static_cast<float>(view.camera.cy) + 0.5F;
  const auto width = static_cast<float>(view.camera.width);
  const auto height = static_cast<float>(view.camera.height);
  const float surface_m = static_cast<float>(options_.surface_voxels) * voxel_m_;
  const float per_aside2 = 1.0F / (4.0F * voxel_m_ * voxel_m_);  // half the weight two voxels aside
  bool changed = false;
  for (int k = 0; k < kBlockSide; ++k) {
    for (int j = 0; j < kBlockSide; ++j) {
      const Eigen::Vector3f first_O =
          voxel_m_ * Eigen::Vector3f(static_cast<float>(block.index.x * kBlockSide),
                                     static_cast<float>(block.index.y * kBlockSide + j),
                                     static_cast<float>(block.index.z * kBlockSide + k));
      const Eigen::Vector3f first_C = view.R_C_O * first_O + view.p_C_O;
      for (int i = 0; i < kBlockSide; ++i) {
        const Eigen::Vector3f p_C = first_C + static_cast<float>(i) * step;
        if (p_C.z() < view.nearest_m) continue;
        const float inverse_z = 1.0F / p_C.z();
        const float mx = p_C.x() * inverse_z;
        const float my = p_C.y() * inverse_z;
        const float u = fx * mx + cx;
        const float v = fy * my + cy;
        if (!(u >= 0.0F && v >= 0.0F && u < width && v < height)) continue;
        const int pixel_u = static_cast<int>(u);
        const int pixel_v = static_cast<int>(v);
        const TangentPlane& plane = view.planes.at(pixel_u, pixel_v);
        if (plane.distance <= 0.0F) continue;
        const float q = plane.a.dot(p_C);  // depth of the voxel over that of the plane, on this ray
        const float distance = (1.0F - q) * plane.distance;
        if (distance <= -truncation_m_) continue;
        const float measured_z = q > 0.0F ? p_C.z() / q : 1e3F;
        const float behind = p_C.z() - measured_z;
        if (behind >= kDeepestTruncations * truncation_m_) continue;
        float weight = 1.0F / std::max(kWeightNearest, measured_z * measured_z);
        if (distance < truncation_m_) {
          const float aside2 = behind * behind * (1.0F + mx * mx + my * my) - distance * distance;
          weight /= 1.0F + std::max(0.0F, aside2) * per_aside2;
        }
        if (distance < -voxel_m_) weight *= (truncation_m_ + distance) / (truncation_m_ - voxel_m_);
        if (behind > truncation_m_)
          weight *= (kDeepestTruncations - behind / truncation_m_) / (kDeepestTruncations - 1.0F);

        const int number = voxel_number(i, j, k);
        Voxel& voxel = block.voxels[static_cast<std::size_t>(number)];
        changed |= average_in(voxel, std::min(distance, truncation_m_), weight);
        if (std::abs(distance) <= surface_m && std::abs(behind) <= truncation_m_) {
          update_surface(block, number, view, pixel_v * view.camera.width + pixel_u);
        }
      }
    }
  }
  return changed;
}

void TsdfVolume::update_surface(Block& block, int number, const View& view, int pixel) {
  if (!block.surface) {
    block.surface = std::make_unique<std::array<SurfaceVoxel, kBlockVoxels>>();
    ++surfaces_;
  }
  SurfaceVoxel& voxel = (*block.surface)[static_cast<std::size_t>(number)];
  voxel.keyframe = std::max(voxel.keyframe, view.keyframe);
  if (view.has_labels) voxel.labels.observe(view.image.labels[static_cast<std::size_t>(pixel)]);
  if (!view.has_colours) return;
  if (voxel.colours < kMostColours) ++voxel.colours;
  for (std::size_t channel = 0; channel < 3; ++channel) {
    const int seen = 256 * view.image.colours[3 * static_cast<std::size_t>(pixel) + channel];
    const int mean = voxel.colour[channel];
    voxel.colour[channel] = static_cast<std::uint16_t>(mean + (seen - mean) / voxel.colours);
  }
}

void TsdfVolume::forget_oldest(Integration& result) {
  const auto budget = static_cast<std::size_t>(options_.memory_mb * 1e6);
  if (bytes() <= budget) return;
  // An eighth at once, so that this is rare.
  const std::size_t keep = blocks_.size() - blocks_.size() / 8 - 1;
  std::stable_sort(blocks_.begin(), blocks_.end(),
                   [](const auto& a, const auto& b) { return a->utime > b->utime; });
  for (std::size_t i = keep; i < blocks_.size(); ++i) {
    by_index_.erase(blocks_[i]->index);
    if (blocks_[i]->surface) --surfaces_;
    ++result.forgotten_blocks;
  }
  blocks_.resize(keep);
}

}  // namespace covey::mesh
