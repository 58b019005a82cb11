// SPDX-License-Identifier: BSD-3-Clause
#include "core/vio/estimator.h"

#include <algorithm>
#include <deque>

#include "core/vio/segment.h"

namespace covey::vio {
namespace {

constexpr double kStartSpacingS = 0.09;  // between the frames that a segment starts from, at least
constexpr double kRetryS = 0.2;          // between attempts to start
constexpr int kClockWentBack = 200;      // late samples in a row: not disorder, but another clock
// Of samples before the last frame: the front end may ask for them.
constexpr Utime kRememberedUs = 1'000'000;
constexpr double kFarAhead = 10.0;  // sampling intervals: a false stamp, unless the next sample is there, too

bool saturated(const ImuNoise& imu, const ImuSample& sample) {
  return sample.gyro.cwiseAbs().maxCoeff() >= imu.gyro_range ||
         sample.accel.cwiseAbs().maxCoeff() >= imu.accel_range;
}

bool usable(const TrackObservation& seen) {
  return seen.id >= 0 && seen.left.allFinite() && (!seen.right || seen.right->allFinite()) &&
         std::isfinite(seen.sigma) && seen.sigma > 0.0;
}

// By rising id, each once, what cannot be used left out.
FrameTracks sanitised(const FrameTracks& frame) {
  FrameTracks clean{frame.utime, {}};
  std::copy_if(frame.tracks.begin(), frame.tracks.end(), std::back_inserter(clean.tracks), usable);
  std::stable_sort(clean.tracks.begin(), clean.tracks.end(),
                   [](const TrackObservation& a, const TrackObservation& b) { return a.id < b.id; });
  const auto doubled =
      std::unique(clean.tracks.begin(), clean.tracks.end(),
                  [](const TrackObservation& a, const TrackObservation& b) { return a.id == b.id; });
  clean.tracks.erase(doubled, clean.tracks.end());
  return clean;
}

}  // namespace

class VioEstimator::Impl {
 public:
  Impl(const Rig& rig, const VioOptions& options) : rig_(rig), stereo_(rig), options_(options) {}

  const char* add_imu(const ImuSample& sample);
  bool bridge_imu(Utime until);
  Utime imu_until() const { return imu_.empty() ? 0 : imu_.back().utime; }
  SO3 predict_rotation(Utime from, Utime until) const;
  VioFrame add_frame(const FrameTracks& frame);
  std::optional<VioState> predict() const;
  const VioHealth& health() const { return health_; }

 private:
  void go_on(const FrameTracks& frame, VioFrame& result);
  void wait(FrameTracks frame, VioFrame& result);
  void try_to_start(VioFrame& result);
  std::vector<StartFrame> start_frames() const;
  void add_frames_between(VioFrame& result) const;
  void give_up(const char* why);
  bool far_ahead(Utime utime);
  ImuSample made_up(Utime utime) const;
  void take(const ImuSample& sample);

  Rig rig_;
  StereoRig stereo_;
  VioOptions options_;
  ImuBuffer imu_;
  int late_samples_ = 0;
  Utime doubtful_ = 0;  // of the last sample, where it was far ahead
  Utime measured_until_ = 0;
  std::unique_ptr<Segment> segment_;
  std::deque<FrameTracks> waiting_;  // while there is no segment
  Utime last_attempt_ = 0;
  Utime last_frame_ = 0;
  bool any_frame_ = false;
  VioHealth health_;
};

const char* VioEstimator::Impl::add_imu(const ImuSample& sample) {
  const bool late = !imu_.empty() && sample.utime <= measured_until_;
  late_samples_ = late ? late_samples_ + 1 : 0;
  if (late_samples_ > kClockWentBack) {
    give_up("the clock went back");
    imu_.clear();
    measured_until_ = 0;
    waiting_.clear();
    any_frame_ = false;
  }
  if (const char* refused = imu_.refuse(sample)) return refused;
  if (far_ahead(sample.utime)) return "ahead";
  const bool anything = !imu_.empty() && saturated(rig_.imu, sample);
  take(anything ? made_up(sample.utime) : sample);
  measured_until_ = sample.utime;
  return anything ? "saturated" : nullptr;
}

// Of two in a row the second is believed.
bool VioEstimator::Impl::far_ahead(Utime utime) {
  const bool far = !imu_.empty() && to_seconds(utime - imu_.back().utime) * rig_.imu.rate_hz > kFarAhead;
  const bool confirmed = doubtful_ != 0 && utime > doubtful_ && utime - doubtful_ < kUsPerSecond;
  doubtful_ = far && !confirmed ? utime : 0;
  return doubtful_ != 0;
}

ImuSample VioEstimator::Impl::made_up(Utime utime) const {
  ImuSample sample = segment_ ? segment_->steady(utime) : imu_.back();
  sample.utime = utime;
  sample.measured = false;
  return sample;
}

void VioEstimator::Impl::take(const ImuSample& sample) {
  const std::optional<ImuSample> before = imu_.empty() ? std::nullopt : std::optional(imu_.back());
  if (imu_.add(sample) == nullptr && segment_ && before) segment_->add_imu(*before, sample);
}

bool VioEstimator::Impl::bridge_imu(Utime until) {
  if (!segment_) return false;
  if (to_seconds(until - measured_until_) > options_.imu_bridge_s) {
    give_up("too long without IMU");
    return false;
  }
  take(made_up(until));
  return true;
}

SO3 VioEstimator::Impl::predict_rotation(Utime from, Utime until) const {
  const ImuBias bias = segment_ ? segment_->last_state().bias : ImuBias{};
  const std::vector<ImuSample> samples = imu_.between(from, until);
  const SO3 R_B = Preintegration(rig_.imu, bias, samples).increment().dR;
  return stereo_.T_L_B.rotation * R_B * stereo_.T_L_B.rotation.inverse();
}

VioFrame VioEstimator::Impl::add_frame(const FrameTracks& frame) {
  VioFrame result;
  if (any_frame_ && frame.utime <= last_frame_) {
    result.dropped = "late";
  } else if (imu_.empty() || frame.utime > imu_.back().utime) {
    result.dropped = "ahead_of_imu";
  } else if (frame.utime < imu_.front().utime) {
    result.dropped = "before_imu";
  } else {
    any_frame_ = true;
    last_frame_ = frame.utime;
    health_.tracks = static_cast<int>(frame.tracks.size());
    result.health = health_;
    if (segment_) {
      go_on(sanitised(frame), result);
    } else {
      wait(sanitised(frame), result);
    }
    health_ = result.health;
  }
  result.health = health_;
  return result;
}

void VioEstimator::Impl::go_on(const FrameTracks& frame, VioFrame& result) {
  const std::vector<ImuSample> samples = imu_.between(segment_->last_utime(), frame.utime);
  if (samples.empty() || to_seconds(longest_gap(samples)) > options_.imu_gap_s) {
    give_up("a gap in the IMU's samples");
    result.health = health_;
    result.dropped = "imu_gap";
    return wait(frame, result);
  }
  segment_->add(frame, samples, result);
  if (const char* trouble = segment_->trouble()) {
    give_up(trouble);
    result.states.clear();
    result.keyframes.clear();
    result.health = health_;
    return wait(frame, result);
  }
  imu_.drop_before(frame.utime - kRememberedUs);
  segment_->set_ahead(imu_.between(frame.utime, imu_.back().utime));
}

void VioEstimator::Impl::wait(FrameTracks frame, VioFrame& result) {
  if (!waiting_.empty()) {
    const auto samples = imu_.between(waiting_.back().utime, frame.utime);
    if (samples.empty() || to_seconds(longest_gap(samples)) > options_.imu_gap_s) waiting_.clear();
  }
  waiting_.push_back(std::move(frame));
  const auto span_s = [&] { return to_seconds(waiting_.back().utime - waiting_.front().utime); };
  const double start_s = rig_.right ? options_.start_s : options_.mono_start_s;
  while (span_s() > start_s + kRetryS) waiting_.pop_front();
  imu_.drop_before(waiting_.front().utime);
  const bool again = to_seconds(waiting_.back().utime - last_attempt_) >= kRetryS;
  if (span_s() >= start_s && again) try_to_start(result);
}

// The newest frame and some before it, evenly spaced, no more than fit the window.
std::vector<StartFrame> VioEstimator::Impl::start_frames() const {
  const double span_s = to_seconds(waiting_.back().utime - waiting_.front().utime);
  const double spacing_s = std::max(kStartSpacingS, span_s / (options_.window - 1) - 1e-3);
  std::vector<const FrameTracks*> chosen{&waiting_.back()};
  for (auto frame = waiting_.rbegin(); frame != waiting_.rend(); ++frame) {
    if (to_seconds(chosen.back()->utime - frame->utime) >= spacing_s) chosen.push_back(&*frame);
  }
  std::vector<StartFrame> frames;
  for (auto frame = chosen.rbegin(); frame != chosen.rend(); ++frame) {
    frames.push_back({**frame, {}});
    if (frames.size() > 1) frames.back().samples = imu_.between((*std::prev(frame))->utime, (*frame)->utime);
  }
  return frames;
}

void VioEstimator::Impl::try_to_start(VioFrame& result) {
  last_attempt_ = waiting_.back().utime;
  const std::vector<StartFrame> frames = start_frames();
  const Start start = find_start(rig_, options_, frames);
  if (!start.failure.empty()) {
    result.health.no_start = start.failure;
    return;
  }
  auto segment = std::make_unique<Segment>(rig_, options_, frames, start, result);
  if (const char* trouble = segment->trouble()) {
    result.health.no_start = trouble;
    result.health.phase = VioPhase::kStarting;
    result.states.clear();
    result.keyframes.clear();
    return;
  }
  segment_ = std::move(segment);
  ++result.health.segments;
  result.health.no_start.clear();
  result.health.coasting_s = 0.0;
  add_frames_between(result);
  waiting_.clear();
  segment_->set_ahead(imu_.between(segment_->last_utime(), imu_.back().utime));
}

// The states of the frames that the segment did not start from, by the IMU from the one before.
void VioEstimator::Impl::add_frames_between(VioFrame& result) const {
  std::vector<VioState> states;
  auto known = result.states.begin();
  for (const FrameTracks& frame : waiting_) {
    if (known != result.states.end() && known->utime == frame.utime) {
      states.push_back(*known++);
    } else if (!states.empty()) {
      VioState state = states.back();
      state.state = propagate(state.state, rig_.imu, imu_.between(state.utime, frame.utime));
      state.utime = frame.utime;
      states.push_back(state);
    }
  }
  result.states = std::move(states);
}

void VioEstimator::Impl::give_up(const char* why) {
  segment_.reset();
  last_attempt_ = 0;
  waiting_.clear();
  health_.phase = VioPhase::kStarting;
  health_.trouble = why;
  health_.used = health_.outliers = 0;
}

std::optional<VioState> VioEstimator::Impl::predict() const {
  if (!segment_ || imu_.empty()) return std::nullopt;
  return segment_->predict(imu_.back().utime);
}

VioEstimator::VioEstimator(const Rig& rig, const VioOptions& options)
    : impl_(std::make_unique<Impl>(rig, options)) {}
VioEstimator::~VioEstimator() = default;
const char* VioEstimator::add_imu(const ImuSample& sample) { return impl_->add_imu(sample); }
Utime VioEstimator::imu_until() const { return impl_->imu_until(); }
bool VioEstimator::bridge_imu(Utime until) { return impl_->bridge_imu(until); }
SO3 VioEstimator::predict_rotation(Utime from, Utime until) const {
  return impl_->predict_rotation(from, until);
}
VioFrame VioEstimator::add_frame(const FrameTracks& frame) { return impl_->add_frame(frame); }
std::optional<VioState> VioEstimator::predict() const { return impl_->predict(); }
const VioHealth& VioEstimator::health() const { return impl_->health(); }

}  // namespace covey::vio
