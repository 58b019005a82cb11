// SPDX-License-Identifier: BSD-3-Clause
#include "core/vio/window.h"

#include <algorithm>

#include "core/graph/pose_factors.h"
#include "core/imu/imu_factor.h"
#include "core/vio/keys.h"
#include "core/vio/triangulate.h"

namespace covey::vio {
namespace {

using graph::FactorId;
using graph::Key;
using graph::Noise;
using graph::Robust;
using graph::Vector;

constexpr std::size_t kMinKeyframes = 2;  // that see a landmark
// Of the landmarks, at most, that a keyframe takes along while they are still seen. An eighth or a half does as well.
constexpr double kRenewed = 0.25;
// rad. Beyond, a keyframe is no longer linearised where it was held: a start may be a degree off.
constexpr double kPointReach = 2e-3;

const TrackObservation* find_track(const FrameTracks& frame, std::int64_t id) {
  const auto found =
      std::lower_bound(frame.tracks.begin(), frame.tracks.end(), id,
                       [](const TrackObservation& track, std::int64_t wanted) { return track.id < wanted; });
  return found != frame.tracks.end() && found->id == id ? &*found : nullptr;
}

// Position and turn about the vertical are held, tilt hardly: the accelerometer knows it.
Noise<6> first_pose_noise(const SE3& T_O_B, const WindowPrior& prior) {
  const Eigen::Vector3d up_B = T_O_B.rotation.inverse() * Eigen::Vector3d::UnitZ();
  const double tilt = 1.0 / (prior.tilt_rad * prior.tilt_rad);
  const double yaw = 1.0 / (prior.yaw_rad * prior.yaw_rad);
  Matrix6d information = Matrix6d::Zero();
  information.topLeftCorner<3, 3>().diagonal().setConstant(1.0 / (prior.position_m * prior.position_m));
  information.bottomRightCorner<3, 3>() =
      tilt * Eigen::Matrix3d::Identity() + (yaw - tilt) * up_B * up_B.transpose();
  return Noise<6>::information(information);
}

}  // namespace

Window::Window(const Rig& rig, const VioOptions& options) : rig_(rig), stereo_(rig), options_(options) {}

void Window::begin(const FrameTracks& frame, const NavState& state, const WindowPrior& prior) {
  graph_ = {};
  values_ = {};
  keyframes_.clear();
  landmarks_.clear();
  renewed_.clear();
  insert(frame, state);
  const std::uint64_t id = keyframes_.back().id;
  graph_.add(graph::Prior<SE3>{state.T_W_B}, {pose_key(id)}, first_pose_noise(state.T_W_B, prior));
  Vector6d bias_sigmas;
  bias_sigmas << Eigen::Vector3d::Constant(prior.gyro_bias), Eigen::Vector3d::Constant(prior.accel_bias);
  graph_.add(graph::Prior<Vector<6>>{state.bias.vector()}, {bias_key(id)}, Noise<6>::sigmas(bias_sigmas));
}

void Window::insert(const FrameTracks& frame, const NavState& state) {
  marginals_.reset();
  const std::uint64_t id = next_id_++;
  values_.set(pose_key(id), state.T_W_B);
  values_.set(velocity_key(id), Vector<3>(state.v_W));
  values_.set(bias_key(id), state.bias.vector());
  keyframes_.push_back({id, frame});
}

void Window::add(const FrameTracks& frame, const NavState& guess, std::span<const ImuSample> samples) {
  insert(frame, guess);
  link(samples);
  for (const TrackObservation& seen : frame.tracks) {
    const auto entry = landmarks_.find(seen.id);
    if (entry == landmarks_.end()) continue;
    const Landmark landmark{entry->second.T_O_A, values_.get<Vector<3>>(landmark_key(seen.id))};
    if (agrees(stereo_, guess.T_W_B, landmark, seen, 2.0 * options_.gate))
      add_views(entry->second, keyframes_.back(), seen);
  }
  add_landmarks();
}

// The IMU's factors between the last two keyframes.
void Window::link(std::span<const ImuSample> samples) {
  const std::uint64_t i = keyframes_[size() - 2].id;
  const std::uint64_t j = keyframes_.back().id;
  const Preintegration increment(rig_.imu, state(size() - 2).bias, samples);
  graph_.add(ImuFactor{increment}, {pose_key(i), velocity_key(i), bias_key(i), pose_key(j), velocity_key(j)},
             imu_noise(increment));
  graph_.add(BiasWalk{}, {bias_key(i), bias_key(j)}, bias_walk_noise(rig_.imu, increment.duration_s()));
}

void Window::add_views(Entry& entry, const Keyframe& keyframe, const TrackObservation& seen) {
  const auto noise = Noise<2>::sigma(seen.sigma);
  const Robust robust = Robust::huber(options_.robust_width);
  const double time_s = to_seconds(keyframe.frame.utime);
  const auto add_view = [&](const SE3& T_C_B, const Eigen::Vector2d& m, int camera) {
    return graph_.add(ProjectionFactor{T_C_B, entry.T_O_A, m, {camera, time_s}},
                      {pose_key(keyframe.id), landmark_key(seen.id)}, noise, robust);
  };
  SeenFrom from{keyframe.id, {add_view(stereo_.T_L_B, seen.left, 0)}};
  if (seen.right) from.views.push_back(add_view(stereo_.T_R_B, *seen.right, 1));
  entry.seen.push_back(std::move(from));
}

// Of tracks in the newest keyframe that are none yet, those seen from most keyframes first.
void Window::add_landmarks() {
  struct Candidate {
    std::int64_t track;
    std::vector<const Keyframe*> keyframes;
    std::vector<View> views;
  };
  std::vector<Candidate> candidates;
  for (const TrackObservation& track : newest_tracks().tracks) {
    if (landmarks_.contains(track.id)) continue;
    Candidate candidate{track.id, {}, {}};
    const auto renewed = renewed_.find(track.id);
    for (const Keyframe& keyframe : keyframes_) {
      if (renewed != renewed_.end() && keyframe.id <= renewed->second) continue;
      const TrackObservation* seen = find_track(keyframe.frame, track.id);
      if (!seen) continue;
      candidate.keyframes.push_back(&keyframe);
      candidate.views.push_back({values_.get<SE3>(pose_key(keyframe.id)), seen});
    }
    if (candidate.views.size() >= kMinKeyframes) candidates.push_back(std::move(candidate));
  }
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.views.size() > b.views.size(); });
  std::size_t visible = landmarks_in_newest();
  for (const Candidate& candidate : candidates) {
    if (visible >= static_cast<std::size_t>(options_.landmarks)) return;
    const auto landmark = triangulate(stereo_, candidate.views, options_.gate);
    if (!landmark) continue;
    values_.set(landmark_key(candidate.track), Vector<3>(landmark->l));
    Entry& entry = landmarks_.emplace(candidate.track, Entry{landmark->T_O_A, {}}).first->second;
    for (std::size_t k = 0; k < candidate.views.size(); ++k)
      add_views(entry, *candidate.keyframes[k], *candidate.views[k].seen);
    ++visible;
  }
}

graph::SolveResult Window::optimise(int iterations) {
  marginals_.reset();
  const auto result = graph::solve(graph_, values_,
                                   {.max_iterations = iterations,
                                    .relative_cost_tolerance = 1e-4,
                                    .gradient_tolerance = 1e-6,
                                    .eliminate_first = 'l'});
  release_turned();
  return result;
}

void Window::release_turned() {
  for (const Keyframe& keyframe : keyframes_) {
    const Key pose = pose_key(keyframe.id);
    if (!graph_.held().has(pose)) continue;
    const SO3 turn = graph_.held().get<SE3>(pose).rotation.inverse() * values_.get<SE3>(pose).rotation;
    if (turn.log().norm() < kPointReach) continue;
    for (const Key key : {pose, velocity_key(keyframe.id), bias_key(keyframe.id)}) graph_.release(key);
  }
}

int Window::discard_outliers() {
  marginals_.reset();
  const double limit = options_.gate * options_.gate;
  std::vector<std::int64_t> bad;
  for (auto& [track, entry] : landmarks_) {
    std::erase_if(entry.seen, [&](const SeenFrom& from) {
      const bool off = std::any_of(from.views.begin(), from.views.end(), [&](FactorId id) {
        return !(graph::squared_residual(graph_.factor(id), values_) < limit);
      });
      if (off) {
        for (const FactorId id : from.views) graph_.remove(id);
      }
      return off;
    });
    if (entry.seen.size() < kMinKeyframes) bad.push_back(track);
  }
  for (const std::int64_t track : bad) remove_landmark(track);
  return static_cast<int>(bad.size());
}

void Window::slide() {
  marginals_.reset();
  while (size() > static_cast<std::size_t>(options_.window)) marginalise_oldest();
}

void Window::remove_views(Entry& entry, std::uint64_t keyframe) {
  std::erase_if(entry.seen, [&](const SeenFrom& from) {
    if (from.keyframe != keyframe) return false;
    for (const FactorId id : from.views) graph_.remove(id);
    return true;
  });
}

void Window::remove_landmark(std::int64_t track) {
  const auto entry = landmarks_.find(track);
  for (const SeenFrom& from : entry->second.seen) {
    for (const FactorId id : from.views) graph_.remove(id);
  }
  landmarks_.erase(entry);
  values_.erase(landmark_key(track));
}

// Of the landmarks that the oldest keyframe saw and the newest still sees, those with the most views.
std::vector<std::int64_t> Window::choose_renewed() const {
  std::vector<std::pair<std::size_t, std::int64_t>> seen;
  for (const auto& [track, entry] : landmarks_) {
    if (entry.seen.front().keyframe == keyframes_.front().id &&
        entry.seen.back().keyframe == keyframes_.back().id)
      seen.emplace_back(entry.seen.size(), track);
  }
  std::stable_sort(seen.begin(), seen.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  const auto most = static_cast<std::size_t>(kRenewed * options_.landmarks);
  std::vector<std::int64_t> chosen;
  for (std::size_t k = 0; k < std::min(most, seen.size()); ++k) chosen.push_back(seen[k].second);
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

void Window::marginalise_oldest() {
  const std::uint64_t oldest = keyframes_.front().id;
  const std::uint64_t newest = keyframes_.back().id;
  const std::vector<std::int64_t> renewed = choose_renewed();
  for (const std::int64_t track : renewed) renewed_[track] = newest;
  std::erase_if(renewed_, [&](const auto& entry) { return !find_track(newest_tracks(), entry.first); });
  std::vector<Key> removed{pose_key(oldest), velocity_key(oldest), bias_key(oldest)};
  std::vector<std::int64_t> without_views;
  std::vector<std::int64_t> gone;
  for (auto& [track, entry] : landmarks_) {
    if (entry.seen.front().keyframe != oldest) continue;
    if (entry.seen.back().keyframe == newest && !std::binary_search(renewed.begin(), renewed.end(), track)) {
      remove_views(entry, oldest);
      if (entry.seen.size() < kMinKeyframes) without_views.push_back(track);
    } else {
      removed.push_back(landmark_key(track));
      gone.push_back(track);
    }
  }
  for (const std::int64_t track : without_views) remove_landmark(track);
  for (const std::int64_t track : gone) landmarks_.erase(track);
  if (const auto prior = graph::marginalise_out(graph_, values_, removed, 'l', shared_error())) {
    for (const Key key : graph_.factor(*prior).keys()) graph_.hold(key, values_);
  }
  keyframes_.erase(keyframes_.begin());
}

NavState Window::state(std::size_t k) const {
  const std::uint64_t id = keyframes_[k].id;
  return {values_.get<SE3>(pose_key(id)), values_.get<Vector<3>>(velocity_key(id)),
          ImuBias::from_vector(values_.get<Vector<6>>(bias_key(id)))};
}

const Window::Keyframe* Window::find(Utime utime) const {
  for (const Keyframe& keyframe : keyframes_) {
    if (keyframe.frame.utime == utime) return &keyframe;
  }
  return nullptr;
}

std::optional<SE3> Window::pose_at(Utime utime) const {
  const Keyframe* keyframe = find(utime);
  if (!keyframe) return std::nullopt;
  return values_.get<SE3>(pose_key(keyframe->id));
}

Landmarks Window::landmarks() const {
  Landmarks landmarks;
  for (const auto& [track, entry] : landmarks_) {
    landmarks.emplace(track, Landmark{entry.T_O_A, values_.get<Vector<3>>(landmark_key(track))});
  }
  return landmarks;
}

std::size_t Window::landmarks_in_newest() const {
  const std::uint64_t newest = keyframes_.back().id;
  return static_cast<std::size_t>(std::count_if(landmarks_.begin(), landmarks_.end(), [&](const auto& entry) {
    return entry.second.seen.back().keyframe == newest;
  }));
}

// Tracks lag behind the scene together, each way by some share: in the window all views are as from cameras that stand off, the farther the longer the way.
graph::SharedError Window::shared_error() const {
  graph::SharedError shared{options_.view_variance, options_.view_lasting, options_.view_memory_s};
  double way_m = 0.0;
  for (std::size_t k = 1; k < size(); ++k) {
    const SE3 T_O_B = state(k).T_W_B;
    way_m += (T_O_B.translation - state(k - 1).T_W_B.translation).norm();
    Eigen::Matrix<double, 6, 3> off = Eigen::Matrix<double, 6, 3>::Zero();
    off.topRows<3>() = options_.way_share * way_m * T_O_B.rotation.matrix().transpose();
    shared.common[pose_key(keyframes_[k].id)] = off;
  }
  return shared;
}

const graph::DenseMarginals& Window::marginals() {
  if (!marginals_) marginals_.emplace(graph_, values_, 'l', shared_error());
  return *marginals_;
}

std::optional<Matrix15d> Window::covariance() {
  const std::uint64_t id = keyframes_.back().id;
  const auto covariance = marginals().covariance({pose_key(id), velocity_key(id), bias_key(id)});
  if (!covariance) return std::nullopt;
  return Matrix15d(*covariance);
}

std::optional<Eigen::Matrix<double, 12, 12>> Window::pose_covariance(Utime other) {
  const Keyframe* keyframe = find(other);
  if (!keyframe) return std::nullopt;
  const auto covariance = marginals().covariance({pose_key(keyframe->id), pose_key(keyframes_.back().id)});
  if (!covariance) return std::nullopt;
  return Eigen::Matrix<double, 12, 12>(*covariance);
}

}  // namespace covey::vio
