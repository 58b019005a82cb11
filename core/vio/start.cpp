// SPDX-License-Identifier: BSD-3-Clause
#include "core/vio/start.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "core/graph/reduced.h"
#include "core/graph/solve.h"
#include "core/vio/keys.h"
#include "core/vio/place_mono.h"
#include "core/vio/triangulate.h"
#include "core/vio/window.h"

namespace covey::vio {
namespace {

using graph::Noise;
using graph::Robust;
using graph::Vector;

constexpr double kGravityTolerance = 0.15;  // of 9.81 m/s^2: the length that the linear system may find
constexpr double kStartGate = 3.0;  // wider: landmarks of a single frame are not where they seem, sideways
constexpr double kPositionSigma = 0.005;  // of the images' relative positions, m
constexpr double kVelocitySigma = 0.02;   // of dv, m/s
constexpr double kMonoParallax = 0.03;    // of one camera, on z = 1
constexpr double kScaleTolerance = 0.1;   // standard deviation of the scale that one camera may start with

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
    values.set(pose_key(k), poses[k]);
    for (const TrackObservation& seen : frames[k].tracks.tracks) {
      const auto found = landmarks.find(seen.id);
      if (found == landmarks.end()) continue;
      const Landmark& landmark = found->second;
      values.set(landmark_key(seen.id), Vector<3>(landmark.l));
      const auto add = [&](const SE3& T_C_B, const Eigen::Vector2d& m) {
        graph.add(ProjectionFactor{T_C_B, landmark.T_O_A, m}, {pose_key(k), landmark_key(seen.id)},
                  Noise<2>::sigma(seen.sigma), Robust::cauchy(2.0));
      };
      add(rig.T_L_B, seen.left);
      if (seen.right) add(rig.T_R_B, *seen.right);
    }
  }
  graph.set_constant(pose_key(0));
  graph::solve(graph, values,
               {.max_iterations = 10, .relative_cost_tolerance = 1e-4, .eliminate_first = 'l'});
  for (std::size_t k = 0; k < frames.size(); ++k) poses[k] = values.get<SE3>(pose_key(k));
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

Eigen::Vector3d gyro_bias_change(const std::vector<SO3>& rotations,
                                 const std::vector<Preintegration>& increments) {
  Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (std::size_t k = 0; k < increments.size(); ++k) {
    const SO3 R_i_j = rotations[k].inverse() * rotations[k + 1];
    const Eigen::Matrix3d J = increments[k].bias_jacobian().block<3, 3>(3, 0);
    H += J.transpose() * J;
    b += J.transpose() * (increments[k].increment().dR.inverse() * R_i_j).log();
  }
  return H.ldlt().solve(b);
}

// Bodies in V, the first body's frame: at known + s scaled, where two cameras know the scale s to be 1 and all of it is known.
struct Places {
  std::vector<SO3> rotations;
  std::vector<Eigen::Vector3d> known;
  std::vector<Eigen::Vector3d> scaled;  // empty: s is known
};

struct Alignment {
  std::vector<Eigen::Vector3d> velocities;  // in V
  Eigen::Vector3d gravity;                  // in V
  double scale = 1.0;
  double scale_sigma = 0.0;
};

// Step 3. Where gravity is given, only velocities (and scale) are looked for. With the scale the accelerometer's bias is unknown, too, to a prior: what it pretends
// to be way is what the scale is uncertain by.
Alignment align(const Places& places, const std::vector<Preintegration>& increments,
                const std::optional<Eigen::Vector3d>& gravity) {
  const auto states = static_cast<Eigen::Index>(places.rotations.size());
  const bool find_scale = !places.scaled.empty();
  const Eigen::Index g = 3 * states;
  const Eigen::Index s = g + 3;
  const Eigen::Index bias = s + 1;
  const Eigen::Index last = 6 * (states - 1);
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(last + (find_scale ? 6 : 3), find_scale ? bias + 3 : s);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(A.rows());
  for (Eigen::Index i = 0; i + 1 < states; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const Preintegration& increment = increments[k];
    const double T = increment.duration_s();
    const Eigen::Matrix3d R = places.rotations[k].matrix().transpose();
    const Eigen::Vector3d p = R * (places.known[k + 1] - places.known[k]);
    A.block<3, 3>(6 * i, 3 * i) = T / kPositionSigma * R;
    A.block<3, 3>(6 * i, g) = 0.5 * T * T / kPositionSigma * R;
    b.segment<3>(6 * i) = (p - increment.increment().dp) / kPositionSigma;
    A.block<3, 3>(6 * i + 3, 3 * i) = -R / kVelocitySigma;
    A.block<3, 3>(6 * i + 3, 3 * i + 3) = R / kVelocitySigma;
    A.block<3, 3>(6 * i + 3, g) = -T / kVelocitySigma * R;
    b.segment<3>(6 * i + 3) = increment.increment().dv / kVelocitySigma;
    if (!find_scale) continue;
    A.block<3, 1>(6 * i, s) = -R * (places.scaled[k + 1] - places.scaled[k]) / kPositionSigma;
    A.block<3, 3>(6 * i, bias) = increment.bias_jacobian().block<3, 3>(0, 3) / kPositionSigma;
    A.block<3, 3>(6 * i + 3, bias) = -increment.bias_jacobian().block<3, 3>(6, 3) / kVelocitySigma;
  }
  if (find_scale) A.block<3, 3>(last + 3, bias).diagonal().setConstant(1.0 / WindowPrior{}.accel_bias);
  if (gravity) {
    constexpr double kCertain = 1e6;
    A.block<3, 3>(last, g).diagonal().setConstant(kCertain);
    b.segment<3>(last) = kCertain * *gravity;
  }
  const Eigen::MatrixXd H = A.transpose() * A;
  const Eigen::VectorXd x = graph::solve_semidefinite(H, A.transpose() * b);
  Alignment result;
  for (Eigen::Index i = 0; i < states; ++i) result.velocities.push_back(x.segment<3>(3 * i));
  result.gravity = x.segment<3>(g);
  if (find_scale) {
    result.scale = x(s);
    result.scale_sigma = std::sqrt(graph::solve_semidefinite(H, Eigen::VectorXd::Unit(H.rows(), s))(s));
  }
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

Places in_one_piece(const std::vector<SE3>& poses) {
  Places places;
  for (const SE3& T_V_B : poses) {
    places.rotations.push_back(T_V_B.rotation);
    places.known.push_back(T_V_B.translation);
  }
  return places;
}

// From the poses of a camera on the body, up to scale, in the first one's frame.
Places of_body(const std::vector<SE3>& cameras, const SE3& T_B_C) {
  Places places;
  for (const SE3& T_V_C : cameras) {
    const SO3 R = T_B_C.rotation * T_V_C.rotation * T_B_C.rotation.inverse();
    places.rotations.push_back(R);
    places.known.push_back(T_B_C.translation - R * T_B_C.translation);
    places.scaled.push_back(T_B_C.rotation * T_V_C.translation);
  }
  return places;
}

MonoPlaces place_by_one_camera(const Rig& rig, std::span<const StartFrame> frames,
                               const std::vector<Preintegration>& increments) {
  std::vector<const FrameTracks*> tracks;
  std::vector<SO3> rotations;
  const SO3 R_B_C = rig.left.T_B_C.rotation;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    tracks.push_back(&frames[k].tracks);
    rotations.push_back(
        k == 0 ? SO3() : rotations.back() * R_B_C.inverse() * increments[k - 1].increment().dR * R_B_C);
  }
  return place_mono(tracks, rotations);
}

}  // namespace

Start find_start(const Rig& rig, const VioOptions& options, std::span<const StartFrame> frames) {
  if (frames.size() < 3) return {{}, "too few frames"};
  ImuBias bias;
  std::vector<Preintegration> increments = integrate(rig, bias, frames);
  Places places;
  if (rig.right) {
    places = in_one_piece(place_by_images(rig, options, frames, increments));
  } else {
    const MonoPlaces found = place_by_one_camera(rig, frames, increments);
    if (found.parallax < kMonoParallax) return {{}, "too little parallax for one camera"};
    places = of_body(found.T_V_C, rig.left.T_B_C);
  }
  if (places.rotations.size() < frames.size()) return {{}, "too few tracks that agree"};

  bias.gyro += gyro_bias_change(places.rotations, increments);
  increments = integrate(rig, bias, frames);

  Alignment found = align(places, increments, std::nullopt);
  const double length = found.gravity.norm();
  if (!(std::abs(length / kGravity.norm() - 1.0) < kGravityTolerance))
    return {{}, "images and accelerometer do not agree"};
  const Eigen::Vector3d down_V = found.gravity / length;
  found = align(places, increments, Eigen::Vector3d(kGravity.norm() * down_V));
  if (!(found.scale > 0.0) || found.scale_sigma > kScaleTolerance * found.scale)
    return {{}, "the motion does not tell the scale yet"};

  const SO3 R_O_V = shortest_rotation(down_V, -Eigen::Vector3d::UnitZ());
  Start start;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    Eigen::Vector3d p_V = places.known[k];
    if (!places.scaled.empty()) p_V += found.scale * places.scaled[k];
    start.states.push_back(
        {SE3{R_O_V * places.rotations[k], R_O_V * p_V}, R_O_V * found.velocities[k], bias});
  }
  return start;
}

}  // namespace covey::vio
