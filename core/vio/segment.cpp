// SPDX-License-Identifier: BSD-3-Clause
#include "core/vio/segment.h"

#include <algorithm>
#include <iterator>

#include "core/vio/team_keyframes.h"

namespace covey::vio {
namespace {

constexpr int kStartIterations = 15;       // the start is farther from the solution than a new keyframe
constexpr Utime kCoastingAfter = 300'000;  // us without images
constexpr Utime kGap = 50'000;             // us without samples
constexpr double kBlindS = 0.3;            // without images and IMU
constexpr double kFastest = 50.0;          // m/s; beyond, an estimate has gone astray
constexpr double kLargestGyroBias = 1.0;   // rad/s
constexpr double kLargestAccelBias = 3.0;  // m/s^2

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Both by rising id.
FrameTracks without(const FrameTracks& frame, const std::vector<std::int64_t>& tracks) {
  FrameTracks rest{frame.utime, {}};
  std::copy_if(frame.tracks.begin(), frame.tracks.end(), std::back_inserter(rest.tracks),
               [&](const TrackObservation& seen) {
                 return !std::binary_search(tracks.begin(), tracks.end(), seen.id);
               });
  return rest;
}

VioState told(Utime segment, Utime utime, const NavState& state, const Matrix15d& covariance, bool coasting) {
  return {utime, segment, state, covariance.topLeftCorner<9, 9>(), coasting};
}

}  // namespace

Segment::Segment(const Rig& rig, const VioOptions& options, std::span<const StartFrame> frames,
                 const Start& start, VioFrame& result)
    : rig_(rig),
      stereo_(rig),
      options_(options),
      window_(rig, options),
      name_(frames.front().tracks.utime),
      from_keyframe_(rig.imu, {}),
      ahead_(rig.imu, {}) {
  window_.begin(frames[0].tracks, start.states[0], {});
  for (std::size_t k = 1; k < frames.size(); ++k) {
    window_.add(frames[k].tracks, start.states[k], frames[k].samples);
  }
  window_.optimise(kStartIterations);
  window_.discard_outliers();
  window_.optimise(kStartIterations);
  take_keyframe_state();
  last_used_utime_ = last_utime_;
  for (std::size_t k = 0; k < window_.size(); ++k) {
    result.states.push_back(told(name_, window_.utime(k), window_.state(k), keyframe_covariance_, false));
  }
  cut_team_keyframe(result);
  result.health.phase = VioPhase::kTracking;
  result.health.used = landmarks_in_keyframe_;
}

void Segment::add(const FrameTracks& frame, const std::vector<ImuSample>& samples, VioFrame& result) {
  for (std::size_t k = 1; k < samples.size(); ++k) from_keyframe_.add(samples[k - 1], samples[k]);
  since_keyframe_.insert(since_keyframe_.end(), samples.begin() + (since_keyframe_.empty() ? 0 : 1),
                         samples.end());

  const ImuLink link{keyframe_state_, from_keyframe_};
  const NavState predicted = from_keyframe_.predict(keyframe_state_);
  const FramePose placed = place_frame(stereo_, landmarks_, frame, predicted, &link, options_.gate);
  const bool coasting = placed.used < options_.min_tracks;
  const SO3 R_before = last_.T_W_B.rotation;
  const double since_s = to_seconds(frame.utime - last_utime_);
  last_utime_ = frame.utime;
  last_ = coasting ? predicted : placed.state;
  turning_ = (R_before.inverse() * last_.T_W_B.rotation).log() / since_s;
  last_covariance_ = propagate_covariance(keyframe_state_, keyframe_covariance_, from_keyframe_);
  if (!coasting) last_used_utime_ = frame.utime;
  blind_s_ = coasting && !samples.back().measured ? blind_s_ + since_s : 0.0;

  const bool for_team = team_due(frame.utime, last_.T_W_B);
  if (for_team || keyframe_due(frame, last_.T_W_B, placed.used)) {
    window_.add(without(frame, placed.outliers), last_, since_keyframe_);
    window_.optimise(options_.iterations);
    window_.discard_outliers();
    take_keyframe_state();
    if (for_team) cut_team_keyframe(result);
    window_.slide();
  }
  result.states.push_back(told(name_, frame.utime, last_, last_covariance_, coasting));
  result.health.phase = coasting ? VioPhase::kCoasting : VioPhase::kTracking;
  result.health.used = placed.used;
  result.health.outliers = static_cast<int>(placed.outliers.size());
  result.health.coasting_s = to_seconds(last_utime_ - last_used_utime_);
}

bool Segment::team_due(Utime utime, const SE3& T_O_B) const {
  const auto T_O_P = window_.pose_at(team_utime_);
  // The relative pose's covariance needs both ends in the window.
  const bool last_chance =
      window_.utime(0) == team_utime_ && window_.size() >= static_cast<std::size_t>(options_.window);
  return !T_O_P || last_chance ||
         team_keyframe_due(options_, T_O_P->inverse() * T_O_B, to_seconds(utime - team_utime_));
}

bool Segment::keyframe_due(const FrameTracks& frame, const SE3& T_O_B, int used) const {
  const double age_s = to_seconds(frame.utime - window_.newest_utime()) + 1e-3;
  if (age_s >= options_.keyframe_interval_s) return true;
  if (age_s < options_.keyframe_min_interval_s) return false;
  return used < options_.keyframe_overlap * landmarks_in_keyframe_ ||
         parallax(frame, T_O_B) > options_.keyframe_parallax;
}

// How far tracks have gone on z = 1 since the newest keyframe, but for the rotation: the median.
double Segment::parallax(const FrameTracks& frame, const SE3& T_O_B) const {
  const SO3 R_L_B = stereo_.T_L_B.rotation;
  const SO3 R_key_now = R_L_B * keyframe_state_.T_W_B.rotation.inverse() * T_O_B.rotation * R_L_B.inverse();
  const std::vector<TrackObservation>& before = window_.newest_tracks().tracks;
  std::vector<double> distances;
  auto old = before.begin();
  for (const TrackObservation& seen : frame.tracks) {
    while (old != before.end() && old->id < seen.id) ++old;
    if (old == before.end() || old->id != seen.id) continue;
    const Eigen::Vector3d turned = R_key_now * Eigen::Vector3d(seen.left.x(), seen.left.y(), 1.0);
    if (turned.z() > 0.1) distances.push_back((turned.head<2>() / turned.z() - old->left).norm());
  }
  return median(std::move(distances));
}

void Segment::take_keyframe_state() {
  landmarks_ = window_.landmarks();
  landmarks_in_keyframe_ = static_cast<int>(window_.landmarks_in_newest());
  keyframe_state_ = window_.newest_state();
  // Without a covariance of the smoother, the last one as the IMU has moved it.
  keyframe_covariance_ = window_.covariance().value_or(last_covariance_);
  since_keyframe_.clear();
  from_keyframe_ = Preintegration(rig_.imu, keyframe_state_.bias);
  last_utime_ = window_.newest_utime();
  last_ = keyframe_state_;
  last_covariance_ = keyframe_covariance_;
}

void Segment::cut_team_keyframe(VioFrame& result) {
  VioKeyframe keyframe;
  keyframe.utime = last_utime_;
  keyframe.segment = name_;
  keyframe.id = team_keyframes_;
  keyframe.T_O_K = last_.T_W_B;
  if (keyframe.id > 0) {
    const auto T_O_P = window_.pose_at(team_utime_);
    const auto covariance = window_.pose_covariance(team_utime_);
    if (!T_O_P || !covariance)
      return;  // the next keyframe tries again; when P has left the window, trouble() says so
    keyframe.T_P_K = T_O_P->inverse() * keyframe.T_O_K;
    keyframe.covariance = relative_covariance(options_, keyframe.T_P_K, *covariance);
  }
  ++team_keyframes_;
  keyframe.gravity_K = gravity_direction(keyframe.T_O_K);
  keyframe.gravity_sigma_rad = gravity_sigma(keyframe.T_O_K, last_covariance_.topLeftCorner<6, 6>());
  result.keyframes.push_back(keyframe);
  team_utime_ = last_utime_;
}

void Segment::set_ahead(const std::vector<ImuSample>& samples) {
  ahead_ = Preintegration(rig_.imu, last_.bias);
  ahead_measured_ = true;
  for (std::size_t k = 1; k < samples.size(); ++k) add_imu(samples[k - 1], samples[k]);
}

void Segment::add_imu(const ImuSample& before, const ImuSample& sample) {
  ahead_.add(before, sample);
  ahead_measured_ = ahead_measured_ && sample.measured && sample.utime - before.utime <= kGap;
}

ImuSample Segment::steady(Utime utime) const {
  return {utime, turning_ + last_.bias.gyro, last_.bias.accel - last_.T_W_B.rotation.inverse() * kGravity,
          false};
}

VioState Segment::predict(Utime utime) const {
  const bool coasting = utime - last_used_utime_ > kCoastingAfter || !ahead_measured_;
  return told(name_, utime, ahead_.predict(last_), propagate_covariance(last_, last_covariance_, ahead_),
              coasting);
}

const char* Segment::trouble() const {
  const bool finite = last_.T_W_B.translation.allFinite() &&
                      last_.T_W_B.rotation.quaternion().coeffs().allFinite() && last_.v_W.allFinite() &&
                      last_.bias.vector().allFinite() && last_covariance_.allFinite();
  if (!finite) return "the estimate is not finite";
  if (last_.v_W.norm() > kFastest) return "the estimate runs away";
  if (last_.bias.gyro.norm() > kLargestGyroBias || last_.bias.accel.norm() > kLargestAccelBias)
    return "the estimated bias is impossible";
  if (!window_.pose_at(team_utime_)) return "the keyframes' chain is broken";
  if (blind_s_ > kBlindS) return "neither images nor IMU";
  if (to_seconds(last_utime_ - last_used_utime_) > options_.coast_s) return "too long without images";
  return nullptr;
}

}  // namespace covey::vio
