// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A corridor of one segment (corridor.h) as what vio, mesher and dpgo would say of it: blocks of one metre along x, each with
// its own copies of the vertices at its ends.

#include <covey/keyframe_t.hpp>
#include <covey/mesh_block_t.hpp>
#include <covey/trajectory_t.hpp>
#include <map>
#include <vector>

#include "tests/core/mesh/corridor.h"

namespace covey::testing {

constexpr std::int64_t kMeshStream = 77;

inline void put_pose(const SE3& T, double (&q)[4], double (&t)[3]) {
  const Eigen::Quaterniond r = T.rotation.canonical_quaternion();
  q[0] = r.w(), q[1] = r.x(), q[2] = r.y(), q[3] = r.z();
  for (int i = 0; i < 3; ++i) t[i] = T.translation[i];
}

inline std::vector<keyframe_t> keyframe_messages(const Corridor& corridor) {
  std::vector<keyframe_t> messages;
  for (const mesh::PlacedKeyframe& keyframe : corridor.keyframes) {
    keyframe_t message{};
    message.utime = keyframe.utime;
    message.segment = keyframe.segment;
    message.id = keyframe.id;
    put_pose(keyframe.T_O_K, message.q_O_K, message.t_O_K);
    put_pose({}, message.q_P_K, message.t_P_K);
    messages.push_back(message);
  }
  return messages;
}

// Of the first `keyframes` only; in parts of 20.
inline std::vector<trajectory_t> trajectory_messages(const Corridor& corridor, std::int64_t round,
                                                     Utime utime, std::size_t keyframes = 1000,
                                                     const SE3& T_new_W = {}) {
  constexpr std::size_t kPart = 20;
  const std::size_t total = std::min(keyframes, corridor.keyframes.size());
  std::vector<trajectory_t> parts((total + kPart - 1) / kPart);
  for (std::size_t p = 0; p < parts.size(); ++p) {
    trajectory_t& part = parts[p] = {};
    part.utime = utime;
    part.round = round;
    part.part = static_cast<std::int32_t>(p);
    part.parts = static_cast<std::int32_t>(parts.size());
    part.total_poses = static_cast<std::int32_t>(total);
    for (std::size_t k = p * kPart; k < std::min(total, (p + 1) * kPart); ++k) {
      const SE3 T = T_new_W * corridor.keyframes[k].T_W_K;
      const Eigen::Quaterniond q = T.rotation.canonical_quaternion();
      part.segments.push_back(corridor.keyframes[k].segment);
      part.ids.push_back(corridor.keyframes[k].id);
      part.utimes.push_back(corridor.keyframes[k].utime);
      part.T_W_K.insert(part.T_W_K.end(), {q.w(), q.x(), q.y(), q.z(), T.translation.x(), T.translation.y(),
                                           T.translation.z()});
    }
    part.n = static_cast<std::int32_t>(part.ids.size());
    part.n_values = 7 * part.n;
  }
  return parts;
}

// Blocks, and for each of their vertices where it truly is.
struct CorridorBlocks {
  std::vector<mesh_block_t> messages;
  std::vector<std::vector<Eigen::Vector3f>> p_W;
};

// A vertex's label is 1 on the walls and 2 on the floor, its colour says its block.
inline CorridorBlocks block_messages(const Corridor& corridor) {
  CorridorBlocks blocks;
  std::vector<std::map<std::uint32_t, std::int32_t>> places;
  const auto place_of = [&](std::size_t b, std::uint32_t v) {
    const auto [found, is_new] = places[b].try_emplace(v, blocks.messages[b].n_vertices);
    if (is_new) {
      mesh_block_t& block = blocks.messages[b];
      ++block.n_vertices;
      block.n_values += 3;
      const mesh::PlacedKeyframe& keyframe = corridor.keyframes[corridor.mesh.seen_by[v]];
      for (const float value : corridor.mesh.p_O[v]) block.p_O.push_back(value);
      for (int c = 0; c < 3; ++c) block.colours.push_back(static_cast<std::uint8_t>(b));
      block.labels.push_back(corridor.p_W[v].z() == 0.0F ? 2 : 1);
      block.keyframes.push_back(keyframe.id);
      block.segment = keyframe.segment;
      block.utime = std::max(block.utime, keyframe.utime);
      blocks.p_W[b].push_back(corridor.p_W[v]);
    }
    return found->second;
  };
  for (const mesh::Face& face : corridor.mesh.faces) {
    float x = 0.0F;
    for (const std::uint32_t v : face) x += corridor.p_W[v].x() / 3.0F;
    const auto b = static_cast<std::size_t>(x);
    while (blocks.messages.size() <= b) {
      mesh_block_t block{};
      block.stream = kMeshStream;
      block.number = block.x = static_cast<std::int32_t>(blocks.messages.size());
      blocks.messages.push_back(block);
      blocks.p_W.emplace_back();
      places.emplace_back();
    }
    for (const std::uint32_t v : face) blocks.messages[b].corners.push_back(place_of(b, v));
    blocks.messages[b].n_corners += 3;
  }
  return blocks;
}

}  // namespace covey::testing
