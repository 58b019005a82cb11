// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A front end without pictures: points on the walls of a room and in it, seen by the rig's cameras from a motion in closed form, and the IMU that
// rides along.

#include <map>
#include <set>

#include "core/vio/estimator.h"
#include "tests/core/imu/motion.h"

namespace covey::testing {

struct TrackSimOptions {
  std::uint64_t seed = 1;
  int points = 1500;
  int tracks = 150;       // at most
  double sigma_px = 0.5;  // of each coordinate
  double outliers = 0.0;  // share of tracks that slide over the scene, at up to 40 px/s
  double mono = 0.1;      // share of observations without a right one
  double focal_px = 458.0;
  Eigen::Vector3d room_m{8.0, 8.0, 4.0};
};

inline Rig stereo_rig() {
  Rig rig;
  rig.left.camera = {752, 480, 458.0, 458.0, 375.5, 239.5, {}};
  rig.right = rig.left;
  Eigen::Matrix3d R_B_C;  // the camera looks along body x, body z up
  R_B_C << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  rig.left.T_B_C = {SO3::from_matrix(R_B_C) * SO3::exp({0.02, -0.01, 0.03}), {0.05, 0.06, 0.01}};
  rig.right->T_B_C = {SO3::from_matrix(R_B_C) * SO3::exp({0.01, 0.02, 0.025}), {0.05, -0.06, 0.012}};
  return rig;
}

class TrackSim {
 public:
  TrackSim(const Rig& rig, const TrackSimOptions& options)
      : rig_(rig), options_(options), random_(options.seed) {
    for (int k = 0; k < options.points; ++k) {
      Eigen::Vector3d p = Eigen::Vector3d::NullaryExpr([&] { return random_.uniform(-0.5, 0.5); });
      const int wall = random_.index(4);
      if (wall < 3) p[wall] = p[wall] < 0.0 ? -0.5 : 0.5;
      points_.push_back(p.cwiseProduct(options.room_m));
    }
  }

  FrameTracks see(Utime utime, const SE3& T_W_B) {
    std::map<std::int64_t, TrackObservation> seen;
    std::map<int, Track> still;
    for (auto& [point, track] : tracks_) {
      if (const auto observation = observe(utime, T_W_B, point, track)) {
        seen.emplace(track.id, *observation);
        still.emplace(point, track);
      }
    }
    tracks_ = std::move(still);
    const int first = random_.index(options_.points);
    for (int k = 0; k < options_.points && static_cast<int>(seen.size()) < options_.tracks; ++k) {
      const int point = (first + k) % options_.points;
      if (tracks_.contains(point)) continue;
      Track track{next_id_, utime, Eigen::Vector2d::Zero()};
      if (random_.uniform(0.0, 1.0) < options_.outliers)
        track.slide = random_.vector<2>(20.0 / options_.focal_px);
      if (const auto observation = observe(utime, T_W_B, point, track)) {
        ++next_id_;
        seen.emplace(track.id, *observation);
        tracks_.emplace(point, track);
      }
    }
    FrameTracks frame{utime, {}};
    for (const auto& [id, observation] : seen) frame.tracks.push_back(observation);
    return frame;
  }
  // As after a dark picture.
  void lose_all() { tracks_.clear(); }

 private:
  struct Track {
    std::int64_t id = 0;
    Utime since = 0;
    Eigen::Vector2d slide;  // 1/s, on z = 1
  };

  std::optional<Eigen::Vector2d> project(const MountedCamera& camera, const SE3& T_W_B, int point) {
    const Eigen::Vector3d p_C = (T_W_B * camera.T_B_C).inverse() * points_[static_cast<std::size_t>(point)];
    if (p_C.z() < 0.3) return std::nullopt;
    const Eigen::Vector2d m = p_C.head<2>() / p_C.z();
    if (std::abs(m.x()) > 0.8 || std::abs(m.y()) > 0.5) return std::nullopt;
    return m;
  }

  std::optional<TrackObservation> observe(Utime utime, const SE3& T_W_B, int point, const Track& track) {
    const auto left = project(rig_.left, T_W_B, point);
    if (!left) return std::nullopt;
    const double sigma = options_.sigma_px / options_.focal_px;
    const Eigen::Vector2d slid = to_seconds(utime - track.since) * track.slide;
    TrackObservation observation{track.id, *left + slid + random_.vector<2>(sigma), std::nullopt, sigma};
    const auto right = rig_.right ? project(*rig_.right, T_W_B, point) : std::nullopt;
    if (right && random_.uniform(0.0, 1.0) >= options_.mono)
      observation.right = *right + slid + random_.vector<2>(sigma);
    return observation;
  }

  Rig rig_;
  TrackSimOptions options_;
  RandomGeometry random_;
  std::vector<Eigen::Vector3d> points_;
  std::map<int, Track> tracks_;  // by point
  std::int64_t next_id_ = 0;
};

}  // namespace covey::testing
