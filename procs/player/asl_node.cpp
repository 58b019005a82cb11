// SPDX-License-Identifier: BSD-3-Clause
#include "procs/player/asl_node.h"

#include <spdlog/spdlog.h>

#include <algorithm>

#include "procs/common/channels.h"
#include "procs/common/sensor_log.h"
#include "procs/player/pace.h"

namespace covey {
namespace {

constexpr Utime kLongestReadUs = 2'000;  // then timers and signals have their turn

std::size_t bytes_of(const stereo_t& stereo) { return stereo.left.size() + stereo.right.size(); }

void warn_unpaired(const AslFolder& asl) {
  if (asl.unpaired_left + asl.unpaired_right == 0) return;
  spdlog::warn(
      "{} left pictures have no right one and go alone, {} right ones have no left one and are left out",
      asl.unpaired_left, asl.unpaired_right);
}

}  // namespace

AslNode::AslNode(Process& process, const PlayerOptions& options)
    : process_(process), speed_(options.speed), asl_(read_asl(options.asl)), start_(process.now()) {
  warn_unpaired(asl_);
  process_.status().set_counter("unpaired/left", asl_.unpaired_left);
  process_.status().set_counter("unpaired/right", asl_.unpaired_right);
  load_next();
  start_ = process_.now();
  first_ = next_utime().value_or(0);
  process_.status().set_phase("playing");
  process_.loop().call_every(kUsPerSecond, [this] { show_progress(); });
  process_.loop().call_at(start_, [this] { publish_due(); });
}

std::optional<Utime> AslNode::next_utime() const {
  const bool imu_left = next_imu_ < asl_.imu.size();
  const bool pictures_left = next_picture_ < asl_.pictures.size();
  if (!imu_left && !pictures_left) return std::nullopt;
  if (!pictures_left) return asl_.imu[next_imu_].utime;
  if (!imu_left) return asl_.pictures[next_picture_].utime;
  return std::min(asl_.imu[next_imu_].utime, asl_.pictures[next_picture_].utime);
}

Utime AslNode::due(Utime utime) const {
  const double paced_s = speed_ == 0.0 ? 0.0 : to_seconds(utime - first_) / speed_;
  return std::max(start_ + from_seconds(paced_s), not_before_);
}

void AslNode::publish_due() {
  const Utime until = process_.now() + kLongestReadUs;
  std::optional<Utime> next = next_utime();
  while (next && due(*next) <= process_.now() && process_.now() < until) {
    process_.status().gauge("played_s", to_seconds(*next - first_));
    if (next_imu_ < asl_.imu.size() && asl_.imu[next_imu_].utime == *next) {
      publish_imu();
    } else {
      publish_stereo();
    }
    next = next_utime();
  }
  if (next) {
    process_.loop().call_at(std::max(due(*next), process_.now()), [this] { publish_due(); });
    return;
  }
  // After the bands of the last picture, which are sent from timers.
  process_.loop().call_at(not_before_ + kUsPerSecond / 10, [this] {
    show_progress();
    process_.status().set_phase("done");
    process_.stop();
  });
}

void AslNode::publish_imu() {
  const imu_t& sample = asl_.imu[next_imu_++];
  process_.bus().publish(kImu, sample);
  not_before_ = std::max(not_before_, process_.now()) + time_to_receive(sizeof(imu_t));
}

void AslNode::publish_stereo() {
  ++next_picture_;
  if (loaded_) {
    process_.bus().publish(kStereo, *loaded_);
    not_before_ = std::max(not_before_, process_.now()) + time_to_receive(bytes_of(*loaded_));
  }
  process_.loop().post([this] { load_next(); });
}

void AslNode::load_next() {
  loaded_.reset();
  if (next_picture_ >= asl_.pictures.size()) return;
  try {
    loaded_ = load_stereo(asl_.pictures[next_picture_]);
  } catch (const InputError& error) {
    process_.status().count("dropped/STEREO/unreadable");
    spdlog::warn("{}", error.what());
  }
}

void AslNode::show_progress() {
  spdlog::info("{:.1f} s played, {} of {} pictures", process_.status().gauge("played_s"), next_picture_,
               asl_.pictures.size());
}

void convert_asl(const std::filesystem::path& folder, const std::filesystem::path& log) {
  const AslFolder asl = read_asl(folder);
  warn_unpaired(asl);
  SensorLogWriter writer(log.string());
  auto imu = asl.imu.begin();
  std::size_t done = 0;
  for (const AslPicture& picture : asl.pictures) {
    for (; imu != asl.imu.end() && imu->utime <= picture.utime; ++imu) writer.write(kImu, *imu);
    writer.write(kStereo, load_stereo(picture));
    constexpr std::size_t kShowEach = 100;
    if (++done % kShowEach == 0 || done == asl.pictures.size()) {
      spdlog::info("{} of {} pictures", done, asl.pictures.size());
    }
  }
  for (; imu != asl.imu.end(); ++imu) writer.write(kImu, *imu);
  if (!writer.finish()) {
    throw std::runtime_error(
        fmt::format("{}: could not be written to the end; is the disk full?", log.string()));
  }
}

}  // namespace covey
