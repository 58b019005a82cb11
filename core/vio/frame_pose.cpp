// SPDX-License-Identifier: BSD-3-Clause
#include "core/vio/frame_pose.h"

#include <cmath>

#include "core/graph/solve.h"
#include "core/imu/imu_factor.h"
#include "core/vio/keys.h"

namespace covey::vio {
namespace {

using graph::Graph;
using graph::Key;
using graph::Noise;
using graph::Robust;
using graph::Values;
using graph::Vector;

constexpr Key kPose{'x', 1};
constexpr Key kVelocity{'v', 1};
// Of Cauchy's kernel, in sigmas: of a frame that the IMU has placed already, and of one that nobody has.
constexpr double kNarrow = 2.0;
constexpr double kWide = 30.0;
constexpr double kVague = 0.02;  // rad, standard deviation of a turn that says hardly more than nothing

void add_link(const ImuLink& link, const NavState& guess, Graph& graph, Values& values) {
  const Key pose{'x', 0};
  const Key velocity{'v', 0};
  const Key bias{'b', 0};
  values.set(pose, link.from.T_W_B);
  values.set(velocity, Vector<3>(link.from.v_W));
  values.set(bias, link.from.bias.vector());
  values.set(kVelocity, Vector<3>(guess.v_W));
  graph.add(ImuFactor{link.increment}, {pose, velocity, bias, kPose, kVelocity}, imu_noise(link.increment));
  for (const Key key : {pose, velocity, bias}) graph.set_constant(key);
}

void add_views(const StereoRig& rig, const TrackObservation& seen, const Landmark& landmark, double width,
               Graph& graph, Values& values) {
  const Key key = landmark_key(seen.id);
  values.set(key, Vector<3>(landmark.l));
  graph.set_constant(key);
  const auto noise = Noise<2>::sigma(seen.sigma);
  graph.add(ProjectionFactor{rig.T_L_B, landmark.T_O_A, seen.left}, {kPose, key}, noise,
            Robust::cauchy(width));
  if (!seen.right) return;
  graph.add(ProjectionFactor{rig.T_R_B, landmark.T_O_A, *seen.right}, {kPose, key}, noise,
            Robust::cauchy(width));
}

NavState descend(const StereoRig& rig, const Landmarks& landmarks, const FrameTracks& frame,
                 const NavState& guess, const ImuLink* link, double width) {
  Graph graph;
  Values values;
  values.set(kPose, guess.T_W_B);
  if (link) add_link(*link, guess, graph, values);
  for (const TrackObservation& seen : frame.tracks) {
    const auto landmark = landmarks.find(seen.id);
    if (landmark != landmarks.end()) add_views(rig, seen, landmark->second, width, graph, values);
  }
  graph::solve(graph, values, {.max_iterations = 6, .relative_cost_tolerance = 1e-4});
  NavState state = guess;
  state.T_W_B = values.get<SE3>(kPose);
  if (link) state.v_W = values.get<Vector<3>>(kVelocity);
  return state;
}

}  // namespace

FramePose place_frame(const StereoRig& rig, const Landmarks& landmarks, const FrameTracks& frame,
                      const NavState& guess, const ImuLink* link, double gate) {
  FramePose result{guess, 0, {}};
  const bool vague = !link || std::sqrt(link->increment.covariance()(3, 3)) > kVague;
  if (vague) result.state = descend(rig, landmarks, frame, guess, link, kWide);
  result.state = descend(rig, landmarks, frame, result.state, link, kNarrow);
  for (const TrackObservation& seen : frame.tracks) {
    const auto landmark = landmarks.find(seen.id);
    if (landmark == landmarks.end()) continue;
    if (agrees(rig, result.state.T_W_B, landmark->second, seen, gate)) {
      ++result.used;
    } else {
      result.outliers.push_back(seen.id);
    }
  }
  return result;
}

}  // namespace covey::vio
