// SPDX-License-Identifier: BSD-3-Clause
#include "core/vio/place_mono.h"

#include <algorithm>
#include <map>

#include "core/graph/solve.h"
#include "core/vio/keys.h"
#include "core/vio/projection_factor.h"

namespace covey::vio {
namespace {

using graph::Noise;
using graph::Robust;
using graph::Vector;

constexpr int kFewestViews = 4;        // of a track that counts
constexpr double kFirstInverse = 0.3;  // 1/m: scale is free
constexpr double kHoldTogether = 0.7;  // of the views, at least, agree in the end
constexpr double kAgrees = 4.0;        // sigmas
constexpr std::size_t kFewestTracks = 20;

struct Chain {
  std::size_t first = 0;
  std::vector<std::pair<std::size_t, const TrackObservation*>> views;  // by frame
};

std::map<std::int64_t, Chain> chains_of(std::span<const FrameTracks* const> frames) {
  std::map<std::int64_t, Chain> chains;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    for (const TrackObservation& seen : frames[k]->tracks) {
      Chain& chain = chains[seen.id];
      if (chain.views.empty()) chain.first = k;
      chain.views.emplace_back(k, &seen);
    }
  }
  std::erase_if(chains, [](const auto& chain) { return chain.second.views.size() < kFewestViews; });
  return chains;
}

double median_parallax(const std::map<std::int64_t, Chain>& chains, std::span<const SO3> rotations) {
  std::vector<double> distances;
  for (const auto& [track, chain] : chains) {
    if (chain.first != 0 || chain.views.back().first + 1 != rotations.size()) continue;
    const Eigen::Vector3d turned = rotations.back() * chain.views.back().second->left.homogeneous();
    if (turned.z() > 0.1)
      distances.push_back((turned.head<2>() / turned.z() - chain.views.front().second->left).norm());
  }
  if (distances.size() < kFewestTracks) return 0.0;
  const auto middle = distances.begin() + static_cast<std::ptrdiff_t>(distances.size() / 2);
  std::nth_element(distances.begin(), middle, distances.end());
  return *middle;
}

}  // namespace

MonoPlaces place_mono(std::span<const FrameTracks* const> frames, std::span<const SO3> rotations) {
  MonoPlaces result;
  const auto chains = chains_of(frames);
  result.parallax = median_parallax(chains, rotations);
  if (chains.size() < kFewestTracks) return result;

  graph::Values values;
  for (std::size_t k = 0; k < frames.size(); ++k)
    values.set(pose_key(k), SE3{rotations[k], Eigen::Vector3d::Zero()});
  for (const auto& [track, chain] : chains) {
    const Eigen::Vector2d& m = chain.views.front().second->left;
    values.set(landmark_key(track), Vector<3>(m.x(), m.y(), kFirstInverse));
  }
  // Wide at first: nothing is where it will be.
  for (const double width : {100.0, 10.0, 2.0}) {
    graph::Graph graph;
    for (const auto& [track, chain] : chains) {
      const SE3 T_V_A{rotations[chain.first], Eigen::Vector3d::Zero()};
      for (const auto& [k, seen] : chain.views) {
        graph.add(ProjectionFactor{{}, T_V_A, seen->left}, {pose_key(k), landmark_key(track)},
                  Noise<2>::sigma(seen->sigma), Robust::huber(width));
      }
    }
    graph.set_constant(pose_key(0));
    graph::solve(graph, values,
                 {.max_iterations = 25,
                  .relative_cost_tolerance = 1e-4,
                  .initial_trust_radius = 1e4,
                  .eliminate_first = 'l'});
  }

  int agreeing = 0;
  int all = 0;
  for (const auto& [track, chain] : chains) {
    const SE3 T_V_A{rotations[chain.first], Eigen::Vector3d::Zero()};
    const Vector<3> l = values.get<Vector<3>>(landmark_key(track));
    for (const auto& [k, seen] : chain.views) {
      const ProjectionFactor factor{{}, T_V_A, seen->left};
      const double miss = factor.evaluate(values.get<SE3>(pose_key(k)), l, nullptr, nullptr).norm();
      agreeing += miss < kAgrees * seen->sigma ? 1 : 0;
      ++all;
    }
  }
  if (agreeing < kHoldTogether * all) return result;
  for (std::size_t k = 0; k < frames.size(); ++k) result.T_V_C.push_back(values.get<SE3>(pose_key(k)));
  return result;
}

}  // namespace covey::vio
