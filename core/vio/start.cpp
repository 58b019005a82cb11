// SPDX-License-Identifier: BSD-3-Clause
#include "core/vio/start.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "core/graph/reduced.h"
#include "core/graph/solve.h"
#include "core/vio/triangulate.h"

namespace covey::vio {
namespace {

using graph::Key;
using graph::Noise;
using graph::Robust;
using graph::Vector;

constexpr double kGravityTolerance = 0.15;  // of 9.81 m/s^2: the length that the linear system may find
constexpr double kStartGate = 3.0;  // wider: landmarks of a single frame are not where they seem, sideways
constexpr double kPositionSigma = 0.005;  // of the images' relative positions, m
constexpr double kVelocitySigma = 0.02;   // of dv, m/s

Key start_pose_key(std::size_t k) { return {'x', k}; }
Key start_landmark_key(std::int64_t track) { return {'l', static_cast<std::uint64_t>(track)}; }

std::vector<Preintegration> integrate(const Rig& rig, const ImuBias& bias,
                                      std::span<const StartFrame> frames) {
  std::vector<Preintegration> increments;
  for (std::size_t k = 1; k < frames.size(); ++k) increments.emplace_back(rig.imu, bias, frames[k].samples);
  return increments;
}

void add_new_landmarks(const StereoRig& rig, const VioOptions& options, const FrameTracks& frame,
                       const SE3& T_V_B, Landmarks& landmarks) {
  for (const TrackObservation& seen : frame.tracks) {
    if (!seen.right || landmarks.contains(seen.id)) continue;
    const View view{T_V_B, &seen};
    if (const auto landmark = triangulate(rig, {&view, 1}, options.gate))
      landmarks.emplace(seen.id, *landmark);
  }
}

// All frames and landmarks by their images; the first pose stays.
void adjust(const StereoRig& rig, std::span<const StartFrame> frames, const Landmarks& landmarks,
            std::vector<SE3>& poses) {
  graph::Graph graph;
  graph::Values values;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    values.set(start_pose_key(k), poses[k]);
    for (const TrackObservation& seen : frames[k].tracks.tracks) {
      const auto found = landmarks.find(seen.id);
      if (found == landmarks.end()) continue;
      const Landmark& landmark = found->second;
      values.set(start_landmark_key(seen.id), Vector<3>(landmark.l));
      const auto add = [&](const SE3& T_C_B, const Eigen::Vector2d& m) {
        graph.add(ProjectionFactor{T_C_B, landmark.T_O_A, m},
                  {start_pose_key(k), start_landmark_key(seen.id)}, Noise<2>::sigma(seen.sigma),
                  Robust::cauchy(2.0));
      };
      add(rig.T_L_B, seen.left);
      if (seen.right) add(rig.T_R_B, *seen.right);
    }
  }
  graph.set_constant(start_pose_key(0));
  graph::solve(graph, values,
               {.max_iterations = 10, .relative_cost_tolerance = 1e-4, .eliminate_first = 'l'});
  for (std::size_t k = 0; k < frames.size(); ++k) poses[k] = values.get<SE3>(start_pose_key(k));
}

// Body poses in V, the first body's frame; fewer than frames where the images do not hold together.
std::vector<SE3> place_by_images(const Rig& rig, const VioOptions& options,
                                 std::span<const StartFrame> frames,
                                 const std::vector<Preintegration>& increments) {
  const StereoRig stereo(rig);
  Landmarks landmarks;
  std::vector<SE3> poses{SE3{}};
  add_new_landmarks(stereo, options, frames[0].tracks, poses[0], landmarks);
  for (std::size_t k = 1; k < frames.size(); ++k) {
    NavState guess;
    guess.T_W_B = poses.back();
    guess.T_W_B.rotation = poses.back().rotation * increments[k - 1].increment().dR;
    if (k > 1) guess.T_W_B.translation += poses[k - 1].translation - poses[k - 2].translation;
    const FramePose placed =
        place_frame(stereo, landmarks, frames[k].tracks, guess, nullptr, kStartGate * options.gate);
    if (placed.used < options.min_tracks || placed.used < static_cast<int>(placed.outliers.size()))
      return poses;
    poses.push_back(placed.state.T_W_B);
    add_new_landmarks(stereo, options, frames[k].tracks, poses.back(), landmarks);
  }
  adjust(stereo, frames, landmarks, poses);
  return poses;
}

Eigen::Vector3d gyro_bias_change(const std::vector<SE3>& poses,
                                 const std::vector<Preintegration>& increments) {
  Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < increments.size(); ++k) {
    const SO3 R_i_j = poses[k].rotation.inverse() * poses[k + 1].rotation;
    const Eigen::Matrix3d J = increments[k].bias_jacobian().block<3, 3>(3, 0);
    H += J.transpose() * J;
    b += J.transpose() * (increments[k].increment().dR.inverse() * R_i_j).log();
  }
  return H.ldlt().solve(b);
}

struct Alignment {
  std::vector<Eigen::Vector3d> velocities;  // in V
  Eigen::Vector3d gravity;                  // in V
};

// Step 3. Where gravity is given, only velocities are looked for.
Alignment align(const std::vector<SE3>& poses, const std::vector<Preintegration>& increments,
                const std::optional<Eigen::Vector3d>& gravity) {
  const auto states = static_cast<Eigen::Index>(poses.size());
  const Eigen::Index g = 3 * states;
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(6 * (states - 1) + 3, g + 3);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(A.rows());
  for (Eigen::Index i = 0; i + 1 < states; ++i) {
    const Preintegration& increment = increments[static_cast<std::size_t>(i)];
    const SE3& T_V_i = poses[static_cast<std::size_t>(i)];
    const double T = increment.duration_s();
    const Eigen::Matrix3d R = T_V_i.rotation.matrix().transpose();
    const Eigen::Vector3d p = R * (poses[static_cast<std::size_t>(i) + 1].translation - T_V_i.translation);
    A.block<3, 3>(6 * i, 3 * i) = T / kPositionSigma * R;
    A.block<3, 3>(6 * i, g) = 0.5 * T * T / kPositionSigma * R;
    b.segment<3>(6 * i) = (p - increment.increment().dp) / kPositionSigma;
    A.block<3, 3>(6 * i + 3, 3 * i) = -R / kVelocitySigma;
    A.block<3, 3>(6 * i + 3, 3 * i + 3) = R / kVelocitySigma;
    A.block<3, 3>(6 * i + 3, g) = -T / kVelocitySigma * R;
    b.segment<3>(6 * i + 3) = increment.increment().dv / kVelocitySigma;
  }
  if (gravity) {
    constexpr double kCertain = 1e6;
    A.bottomRightCorner<3, 3>().diagonal().setConstant(kCertain);
    b.tail<3>() = kCertain * *gravity;
  }
  const Eigen::VectorXd x = graph::solve_semidefinite(A.transpose() * A, A.transpose() * b);
  Alignment result;
  for (Eigen::Index i = 0; i < states; ++i) result.velocities.push_back(x.segment<3>(3 * i));
  result.gravity = x.tail<3>();
  return result;
}

// Takes one unit vector to another.
SO3 shortest_rotation(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const Eigen::Vector3d axis = from.cross(to);
  const double sine = axis.norm();
  const double angle = std::atan2(sine, from.dot(to));
  if (sine > 1e-12) return SO3::exp(angle / sine * axis);
  return SO3::exp(angle *
                  from.unitOrthogonal());  // along each other: none, or half a turn about any axis across
}

}  // namespace

Start find_start(const Rig& rig, const VioOptions& options, std::span<const StartFrame> frames) {
  if (frames.size() < 3) return {{}, "too few frames"};
  ImuBias bias;
  std::vector<Preintegration> increments = integrate(rig, bias, frames);
  const std::vector<SE3> poses = place_by_images(rig, options, frames, increments);
  if (poses.size() < frames.size()) return {{}, "too few tracks that agree"};

  bias.gyro += gyro_bias_change(poses, increments);
  increments = integrate(rig, bias, frames);

  Alignment found = align(poses, increments, std::nullopt);
  const double length = found.gravity.norm();
  if (!(std::abs(length / kGravity.norm() - 1.0) < kGravityTolerance))
    return {{}, "images and accelerometer do not agree"};
  const Eigen::Vector3d down_V = found.gravity / length;
  found = align(poses, increments, Eigen::Vector3d(kGravity.norm() * down_V));

  const SO3 R_O_V = shortest_rotation(down_V, -Eigen::Vector3d::UnitZ());
  Start start;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    start.states.push_back(
        {SE3{R_O_V, Eigen::Vector3d::Zero()} * poses[k], R_O_V * found.velocities[k], bias});
  }
  return start;
}

}  // namespace covey::vio
