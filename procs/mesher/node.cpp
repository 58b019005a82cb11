// SPDX-License-Identifier: BSD-3-Clause
#include "procs/mesher/node.h"

#include <spdlog/spdlog.h>

#include <chrono>
#include <limits>

#include "core/base/error.h"
#include "procs/common/channels.h"

namespace covey {
namespace {

constexpr std::size_t kMostImages = 16;
constexpr Utime kSayPeriodUs = 10'000;
constexpr std::size_t kBytesPerTick =
    40'000;  // stock receive buffers hold 212,992 bytes, and a reader may be late by some ticks
// From a robot's start: beyond it a float has no centimetres, and lmo takes no vertices.
constexpr double kFurthestM = 1e5;
constexpr Utime kDuePeriodUs = 250'000;

SE3 pose_of(const state_t& state) {
  const auto& q = state.q_O_B;
  return {SO3::from_quaternion({q[0], q[1], q[2], q[3]}), {state.t_O_B[0], state.t_O_B[1], state.t_O_B[2]}};
}

bool is_pose(const state_t& state) {
  const Eigen::Map<const Eigen::Vector4d> q(state.q_O_B);
  const Eigen::Map<const Eigen::Vector3d> t(state.t_O_B);
  return q.allFinite() && t.norm() < kFurthestM && std::abs(q.norm() - 1.0) < 1e-3;
}

const char* word(mesh::PoseLookup lookup) {
  switch (lookup) {
    case mesh::PoseLookup::kTooOld:
      return "dropped/DEPTH/no_pose";
    case mesh::PoseLookup::kGap:
      return "dropped/DEPTH/gap";
    case mesh::PoseLookup::kCoasting:
      return "dropped/DEPTH/coasting";
    case mesh::PoseLookup::kFound:
    case mesh::PoseLookup::kNotYet:
      return "";
  }
  return "";
}

DepthCamera depth_camera(const Process& process) {
  const Rig rig = process.rig();
  if (!rig.depth)
    throw_input_error("the rig that --config names has no camera 'depth', which a mesher needs");
  return *rig.depth;
}

std::size_t bytes_of(const mesh_block_t& block) {
  return 20 * static_cast<std::size_t>(block.n_vertices) + 4 * static_cast<std::size_t>(block.n_corners) +
         100;
}

class Stopwatch {
 public:
  double ms() const {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace

MesherNode::MesherNode(Process& process, const MesherOptions& options)
    : process_(process), ply_(options.ply), camera_(depth_camera(process)) {
  mesh::read_mapper(process.config().root().section("mesher"), options_);
  mapper_.emplace(options_, camera_);
  process.status().set_phase("waiting");
  process.depth_bus().subscribe(kDepth, [this](const depth_t& image) { on_depth(image); });
  process.bus().subscribe(kState, [this](const state_t& state) { on_state(state); });
  process.bus().subscribe(kKeyframe, [this](const keyframe_t& keyframe) {
    if (keyframe.robot != process_.robot()) return process_.status().count("dropped/KEYFRAME/other_robot");
    keyframes_.add(keyframe.segment, keyframe.id, keyframe.utime);
  });
  process.loop().call_every(kDuePeriodUs, [this] { take_due(); });
  process.loop().call_every(kSayPeriodUs, [this] { publish_some(kBytesPerTick); });
  process.on_stop([this] { finish(); });
}

void MesherNode::on_depth(const depth_t& image) {
  const PinholeCamera& camera = camera_.camera;
  const auto pixels = static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height);
  if (image.width != camera.width || image.height != camera.height || image.depth_mm.size() != pixels) {
    return process_.status().count("dropped/DEPTH/size");
  }
  images_.push_back(image);
  if (images_.size() > kMostImages) {
    images_.pop_front();
    process_.status().count("dropped/DEPTH/overflow");
  }
  work();
}

void MesherNode::on_state(const state_t& state) {
  if (state.robot != process_.robot()) return process_.status().count("dropped/STATE/other_robot");
  if (!is_pose(state)) return process_.status().count("dropped/STATE/values");
  if (!poses_.add({state.utime, state.segment, pose_of(state), state.coasting != 0})) {
    return process_.status().count("dropped/STATE/old");
  }
  work();
}

void MesherNode::work() {
  while (!images_.empty()) {
    mesh::TimedPose pose;
    const mesh::PoseLookup lookup = poses_.at(images_.front().utime, pose);
    if (lookup == mesh::PoseLookup::kNotYet) return;
    const depth_t image = std::move(images_.front());
    images_.pop_front();
    if (lookup != mesh::PoseLookup::kFound) {
      process_.status().count(word(lookup));
    } else {
      integrate(image, pose);
    }
  }
}

void MesherNode::integrate(const depth_t& image, const mesh::TimedPose& pose) {
  if (pose.segment == segment_ && image.utime <= newest_image_)
    return process_.status().count("dropped/DEPTH/late");
  const Stopwatch watch;
  const int keyframe = keyframes_.newest_at(pose.segment, image.utime);
  const mesh::Integration result = mapper_->add(image, pose.segment, pose.T_O_B, keyframe);
  process_.status().sample("integrate_ms", watch.ms());
  process_.status().count("integrated");
  if (result.forgotten_blocks > 0) process_.status().count("blocks_forgotten", result.forgotten_blocks);
  segment_ = pose.segment;
  newest_image_ = image.utime;
  integrated_at_ = process_.now();
  process_.status().set_phase("mapping");
}

void MesherNode::take_due() {
  const bool idle = process_.now() - integrated_at_ > from_seconds(options_.schedule.idle_s);
  const Stopwatch watch;
  std::vector<mesh_block_t> blocks = idle ? mapper_->take_all() : mapper_->take_due();
  if (!blocks.empty()) process_.status().sample("mesh_ms", watch.ms());
  enqueue(std::move(blocks));
  publish_gauges();
}

void MesherNode::enqueue(std::vector<mesh_block_t> blocks) {
  for (mesh_block_t& block : blocks) to_say_.push_back(std::move(block));
}

void MesherNode::publish_some(std::size_t most_bytes) {
  std::size_t bytes = 0;
  while (!to_say_.empty() && bytes < most_bytes) {
    mesh_block_t& block = to_say_.front();
    if (next_number_ == 0) stream_ = process_.now();
    block.stream = stream_;
    block.number = next_number_++;
    block.robot = process_.robot();
    process_.bus().publish(kMesh, block);
    bytes += bytes_of(block);
    if (!ply_.empty()) file_.put(block);
    to_say_.pop_front();
  }
}

void MesherNode::finish() {
  enqueue(mapper_->take_all());
  publish_some(std::numeric_limits<std::size_t>::max());
  publish_gauges();
  if (!ply_.empty()) file_.write(ply_);
}

void MesherNode::publish_gauges() {
  process_.status().gauge("waiting_images", static_cast<double>(images_.size()));
  process_.status().gauge("waiting_blocks", static_cast<double>(mapper_->waiting() + to_say_.size()));
  if (const mesh::TsdfVolume* volume = mapper_->volume()) {
    process_.status().gauge("blocks", static_cast<double>(volume->blocks().size()));
    process_.status().gauge("volume_mb", 1e-6 * static_cast<double>(volume->bytes()));
  }
}

}  // namespace covey
