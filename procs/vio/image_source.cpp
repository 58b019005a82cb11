// SPDX-License-Identifier: BSD-3-Clause
#include "procs/vio/image_source.h"

#include <spdlog/spdlog.h>

#include <cmath>
#include <ctime>
#include <opencv2/core/utility.hpp>
#include <utility>

#include "procs/common/channels.h"
#include "procs/vio/messages.h"

namespace covey {
namespace {

constexpr std::size_t kMostWaiting = 3;  // pictures, on the bus
// For their IMU samples; when there are more the IMU has gone silent.
constexpr std::size_t kPatience = 6;
constexpr double kTurning = 0.05;  // rad/s: more than the bias of a gyroscope that nobody has calibrated yet

// Of this process, which has one thread: what a frame costs, whoever else is busy.
double cpu_ms() { return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

bool turns(const SO3& R_prev_cur, Utime us) {
  return R_prev_cur.log().norm() > kTurning * std::abs(to_seconds(us));
}

const char* word(vio::VioPhase phase) {
  switch (phase) {
    case vio::VioPhase::kStarting:
      return "initialising";
    case vio::VioPhase::kTracking:
      return "tracking";
    case vio::VioPhase::kCoasting:
      return "coasting";
  }
  return "";
}

}  // namespace

ImageSource::ImageSource(Process& process, const VioProcessOptions& options, VioOutput& output,
                         const std::filesystem::path& frames)
    : process_(process),
      output_(output),
      frames_(frames),
      front_end_(process.rig(), options.front_end),
      estimator_(process.rig(), options.estimator) {
  cv::setNumThreads(1);
  process_.sensor_bus().subscribe(kImu, [this](const imu_t& message) { on_imu(message); });
  process_.sensor_bus().subscribe(kStereo, [this](const stereo_t& message) { on_stereo(message); },
                                  {.newest_wins = true, .capacity = kMostWaiting});
  process_.status().set_phase("waiting");
}

void ImageSource::on_imu(const imu_t& message) {
  const Utime before = estimator_.imu_until();
  if (const char* reason = estimator_.add_imu(sample_from(message))) {
    process_.status().count(fmt::format("dropped/{}/{}", kImu.name, reason));
    if (estimator_.imu_until() == before) return;
  }
  if (estimator_.imu_until() < before) last_frame_ = 0;  // the clock went back
  if (const auto state = estimator_.predict()) output_.publish_state(*state);
  work();
}

void ImageSource::on_stereo(const stereo_t& message) {
  if (const char* reason = front_end_.refuse(pictures_from(message))) return drop(message.utime, reason);
  if (message.utime <= last_frame_) return drop(message.utime, "late");
  // What waits with a later stamp goes, else one false stamp would keep out all that come after it.
  while (!waiting_.empty() && waiting_.back().utime >= message.utime) {
    drop(waiting_.back().utime, "disorder");
    waiting_.pop_back();
  }
  waiting_.push_back(message);
  if (waiting_.size() > kPatience) go_without_imu();
  work();
}

// The oldest picture has waited long enough.
void ImageSource::go_without_imu() {
  if (estimator_.bridge_imu(waiting_.front().utime)) {
    process_.status().count("imu_bridged");
    work();
    if (const auto state = estimator_.predict()) output_.publish_state(*state);
  } else {
    drop(waiting_.front().utime, "no_imu");
    waiting_.pop_front();
  }
}

void ImageSource::work() {
  while (!waiting_.empty() && waiting_.front().utime <= estimator_.imu_until()) {
    const stereo_t message = std::move(waiting_.front());
    waiting_.pop_front();
    process(message);
  }
}

void ImageSource::process(const stereo_t& message) {
  const double began_ms = cpu_ms();
  const Utime before = front_end_.compared_with().value_or(message.utime);
  const SO3 R_prev_cur = estimator_.predict_rotation(before, message.utime);
  const StereoPictures pictures = pictures_from(message);
  last_frame_ = message.utime;
  if (front_end_.repeats(pictures) && turns(R_prev_cur, message.utime - before))
    return drop(message.utime, "frozen");
  const FrontEndFrame seen = front_end_.process(pictures, R_prev_cur);
  const double seen_ms = cpu_ms();
  const vio::VioFrame frame = estimator_.add_frame(seen.tracks);
  const double frame_ms = cpu_ms() - began_ms;
  Status& status = process_.status();
  status.sample("front_end_ms", seen_ms - began_ms);
  status.sample("frame_ms", frame_ms);
  status.gauge("tracks", static_cast<double>(seen.tracks.tracks.size()));
  status.gauge("tracks_stereo", seen.matched);
  if (frame.dropped != nullptr) return drop(message.utime, frame.dropped);
  frames_.write({message.utime, seen_ms - began_ms, frame_ms, static_cast<int>(seen.tracks.tracks.size()),
                 seen.matched, frame.health.used, word(frame.health.phase)});
  take(frame);
}

void ImageSource::take(const vio::VioFrame& frame) {
  Status& status = process_.status();
  status.count("frames");
  status.gauge("tracks_used", frame.health.used);
  status.gauge("tracks_outliers", frame.health.outliers);
  status.gauge("coasting_s", frame.health.coasting_s);
  for (const vio::VioState& state : frame.states) output_.add_to_trajectory(state);
  for (const vio::VioKeyframe& keyframe : frame.keyframes) output_.publish_keyframe(keyframe);
  status.set_phase(word(frame.health.phase));
  if (frame.health.trouble == trouble_) return;
  trouble_ = frame.health.trouble;
  spdlog::warn("{}", trouble_);
}

void ImageSource::drop(Utime utime, const char* reason) {
  frames_.write({.utime = utime, .fate = reason});
  process_.status().count(fmt::format("dropped/{}/{}", kStereo.name, reason));
  process_.status().count("frames_dropped");
}

}  // namespace covey
