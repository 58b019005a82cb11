// SPDX-License-Identifier: BSD-3-Clause
#include "core/mesh/mapper.h"

#include <algorithm>
#include <span>
#include <utility>

namespace covey::mesh {
namespace {

constexpr std::uint64_t kDigestOfNothing = 14695981039346656037ULL;

// FNV-1a (Fowler, Noll, Vo), a value at a time.
template <typename T>
void digest(std::span<const T> values, std::uint64_t& hash) {
  for (const std::byte byte : std::as_bytes(values)) {
    hash = (hash ^ static_cast<std::uint64_t>(byte)) * 1099511628211ULL;
  }
}

std::uint64_t digest_of(const mesh_block_t& block) {
  std::uint64_t hash = kDigestOfNothing;
  digest(std::span<const float>(block.p_O), hash);
  digest(std::span<const std::uint8_t>(block.labels), hash);
  digest(std::span<const std::int32_t>(block.corners), hash);
  return hash;
}

}  // namespace

void read_mapper(ConfigSection& section, MapperOptions& options) {
  read_tsdf(section, options.tsdf);
  read_surface(section, options.surface);
  section.read("period_s", options.schedule.period_s, 0.1, 60.0);
  section.read("idle_s", options.schedule.idle_s, 0.1, 60.0);
}

Integration Mapper::add(const depth_t& image, std::int64_t segment, const SE3& T_O_B, int keyframe) {
  if (!volume_ || segment != segment_) {
    rest_ = take_all();
    volume_.emplace(options_.tsdf);
    schedule_ = MeshSchedule(options_.schedule);
    said_.clear();
    segment_ = segment;
    now_ = image.utime;
  }
  Integration result = volume_->integrate(image, camera_, T_O_B * camera_.T_B_C, keyframe);
  now_ = std::max(now_, image.utime);
  schedule_.on_changed(blocks_to_extract(*volume_, result.changed), image.utime);
  return result;
}

std::vector<mesh_block_t> Mapper::take_due() {
  std::vector<mesh_block_t> out = std::exchange(rest_, {});
  if (volume_) say(schedule_.take_due(now_), out);
  return out;
}

std::vector<mesh_block_t> Mapper::take_all() {
  std::vector<mesh_block_t> out = std::exchange(rest_, {});
  if (volume_) say(schedule_.take_all(), out);
  return out;
}

void Mapper::say(const std::vector<BlockIndex>& indices, std::vector<mesh_block_t>& out) {
  for (const BlockIndex& index : indices) {
    if (!volume_->find(index)) continue;  // forgotten since: what was said of it stays
    mesh_block_t block = extract_block(*volume_, index, options_.surface);
    const std::uint64_t now = digest_of(block);
    std::uint64_t& before = said_.try_emplace(index, kDigestOfNothing).first->second;
    if (now == before) continue;
    before = now;
    block.segment = segment_;
    out.push_back(std::move(block));
  }
}

}  // namespace covey::mesh
