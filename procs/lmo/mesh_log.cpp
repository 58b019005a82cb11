// SPDX-License-Identifier: BSD-3-Clause
#include "procs/lmo/mesh_log.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "core/base/error.h"

namespace covey {
namespace {

constexpr std::size_t kLeastGrowth = 64 << 20;  // bytes, between two rewritings

void advance_to(StreamPositions& positions, std::int64_t stream, std::int32_t next) {
  std::int32_t& position = positions[stream];
  position = std::max(position, next);
}

}  // namespace

MeshLog::MeshLog(std::filesystem::path folder, mesh::RobotMesh& mesh)
    : folder_(std::move(folder)), mesh_(mesh) {
  read();
  rewrite(0);
}

void MeshLog::read() {
  const std::filesystem::path file = folder_ / "lmo.lcm";
  if (!std::filesystem::exists(file)) return;
  try {
    LogReader reader(file.string(), [this](const std::string& channel, const Bytes& bytes) {
      mesh_block_t block{};
      keyframe_t keyframe{};
      trajectory_t part{};
      if (channel == kMesh.name && decode(bytes, block) && mesh_.take(block) == nullptr) {
        advance_to(blocks_, block.stream, block.number + 1);
      } else if (channel == kKeyframe.name && decode(bytes, keyframe) && mesh_.take(keyframe) == nullptr) {
        advance_to(keyframes_, keyframe.segment, keyframe.id + 1);
      } else if (channel == kTrajectory.name && decode(bytes, part)) {
        mesh_.take(part);
      }
    });
    while (reader.next_time()) reader.deliver();
  } catch (const InputError& error) {
    spdlog::warn("{}: nothing can be read back, starting without", error.what());
  }
}

// The last message of a stream is never superseded, so its position survives.
void MeshLog::rewrite(Utime now) {
  const std::filesystem::path fresh = folder_ / "lmo.lcm.new";
  log_ = std::make_unique<LogRecorder>(fresh.string());
  bytes_ = 0;
  for (const auto& [name, keyframe] : mesh_.keyframes()) write(now, kKeyframe.name, encode(keyframe));
  for (const trajectory_t& part : mesh_.round()) write(now, kTrajectory.name, encode(part));
  for (const auto& [name, block] : mesh_.blocks()) write(now, kMesh.name, encode(block));
  log_->flush();
  rewritten_bytes_ = bytes_;
  std::filesystem::rename(fresh, folder_ / "lmo.lcm");
}

void MeshLog::write(Utime now, const char* channel, const Bytes& bytes) {
  log_->write(now, channel, bytes);
  bytes_ += bytes.size();
}

// A disk that is full or gone costs what would be read back after a restart, not the run.
void MeshLog::append(Utime now, const char* channel, const Bytes& bytes) {
  try {
    write(now, channel, bytes);
    log_->flush();
    if (bytes_ > 2 * rewritten_bytes_ + kLeastGrowth) rewrite(now);
    if (log_->good()) return;
  } catch (const std::exception& error) {
    spdlog::warn("--state: {}", error.what());
  }
  if (!std::exchange(said_failed_, true)) {
    spdlog::warn("{}: cannot be written; a restart will not find all", (folder_ / "lmo.lcm").string());
  }
}

void MeshLog::append(const mesh_block_t& block, Utime now) {
  advance_to(blocks_, block.stream, block.number + 1);
  append(now, kMesh.name, encode(block));
}

void MeshLog::append(const keyframe_t& keyframe, Utime now) {
  advance_to(keyframes_, keyframe.segment, keyframe.id + 1);
  append(now, kKeyframe.name, encode(keyframe));
}

void MeshLog::append(const trajectory_t& part, Utime now) { append(now, kTrajectory.name, encode(part)); }

}  // namespace covey
