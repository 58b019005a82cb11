// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The smoother: keyframes with pose, velocity and bias, landmarks, the factors between them, and a linear prior for what has left.
//
//   x v b   of a keyframe      ImuFactor and BiasWalk from each keyframe to the next
//   l       of a landmark      ProjectionFactor, one per camera and keyframe that saw it, with Huber's kernel
//
// A keyframe that leaves takes along the landmarks that are no longer seen: they are marginalised with all their views. Of those that are still seen it
// takes some along, too: else, standing still, all views of the oldest keyframes would be lost and only the IMU would tie the window to the past. Their tracks
// become landmarks anew, from later views. The other ones stay and only lose their view from that keyframe. So no view is counted twice.

#include <span>
#include <vector>

#include "core/graph/graph.h"
#include "core/graph/marginal.h"
#include "core/graph/solve.h"
#include "core/vio/frame_pose.h"
#include "core/vio/options.h"

namespace covey::vio {

struct WindowPrior {
  double position_m = 1e-4;
  double yaw_rad = 1e-4;
  double tilt_rad = 0.2;
  double gyro_bias = 0.02;  // rad/s, around the start's
  double accel_bias = 0.2;  // m/s^2, around the start's
};

class Window {
 public:
  Window(const Rig& rig, const VioOptions& options);

  // The first keyframe. Earlier content is forgotten.
  void begin(const FrameTracks& frame, const NavState& state, const WindowPrior& prior);
  // The next one; samples from the last keyframe's time to this one's. Landmarks are made of tracks that were seen before.
  void add(const FrameTracks& frame, const NavState& guess, std::span<const ImuSample> samples);
  graph::SolveResult optimise(int iterations);
  // Takes views away that are more than the gate off, and landmarks that have too few left. How many landmarks went.
  int discard_outliers();
  // Down to the window's size.
  void slide();

  std::size_t size() const { return keyframes_.size(); }
  Utime utime(std::size_t k) const { return keyframes_[k].frame.utime; }
  Utime newest_utime() const { return keyframes_.back().frame.utime; }
  const FrameTracks& newest_tracks() const { return keyframes_.back().frame; }
  NavState state(std::size_t k) const;
  NavState newest_state() const { return state(size() - 1); }
  std::optional<SE3> pose_at(Utime utime) const;  // of a keyframe in the window
  // As they are now; of all landmarks in the window.
  Landmarks landmarks() const;
  std::size_t landmarks_in_newest() const;

  // Of [rho; phi; v; b_g; b_a] of the newest keyframe; of [rho; phi] of the keyframe at `other` and of the newest one. Views are as wrong as the options
  // say, not as the solver takes them.
  std::optional<Matrix15d> covariance();
  std::optional<Eigen::Matrix<double, 12, 12>> pose_covariance(Utime other);

  const graph::Graph& graph() const { return graph_; }

 private:
  struct Keyframe {
    std::uint64_t id = 0;
    FrameTracks frame;
  };
  struct SeenFrom {
    std::uint64_t keyframe = 0;
    std::vector<graph::FactorId> views;
  };
  struct Entry {
    SE3 T_O_A;
    std::vector<SeenFrom> seen;  // in order of time
  };

  void insert(const FrameTracks& frame, const NavState& state);
  void add_views(Entry& entry, const Keyframe& keyframe, const TrackObservation& seen);
  void add_landmarks();
  void link(std::span<const ImuSample> samples);
  void release_turned();
  void remove_views(Entry& entry, std::uint64_t keyframe);
  void remove_landmark(std::int64_t track);
  std::vector<std::int64_t> choose_renewed() const;
  void marginalise_oldest();
  const Keyframe* find(Utime utime) const;
  graph::SharedError shared_error() const;
  const graph::DenseMarginals& marginals();

  Rig rig_;
  StereoRig stereo_;
  VioOptions options_;
  graph::Graph graph_;
  graph::Values values_;
  std::optional<graph::DenseMarginals> marginals_;  // as long as the graph and its values stay
  std::vector<Keyframe> keyframes_;                 // in order of time
  std::map<std::int64_t, Entry> landmarks_;
  // Of tracks that were landmarks and were marginalised, the last keyframe whose view is in the prior.
  std::map<std::int64_t, std::uint64_t> renewed_;
  std::uint64_t next_id_ = 0;
};

}  // namespace covey::vio
