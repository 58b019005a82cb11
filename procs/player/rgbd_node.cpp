// SPDX-License-Identifier: BSD-3-Clause
#include "procs/player/rgbd_node.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>

#include "core/base/error.h"
#include "procs/common/channels.h"
#include "procs/common/robot_config.h"
#include "procs/common/sensor_log.h"
#include "procs/player/pace.h"

namespace covey {
namespace {

constexpr Utime kLingerUs = 1'500'000;  // for STREAM_HEAD and the last requests
constexpr Utime kReaderUs = 40'000;     // a reader works on an image so long, at --speed 0

// O is the data's frame D, turned so that the axis `up` of D is O's z.
SE3 levelled(const std::string& up) {
  using Rows = std::array<Eigen::Vector3d, 2>;  // x and y of O, in D
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX();
  const Eigen::Vector3d y = Eigen::Vector3d::UnitY();
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
  Rows rows = {x, y};
  if (up == "-z") rows = {x, -y};
  if (up == "y") rows = {z, x};
  if (up == "-y") rows = {z, -x};
  if (up == "x") rows = {y, z};
  if (up == "-x") rows = {z, y};
  Eigen::Matrix3d R_O_D;
  R_O_D << rows[0].transpose(), rows[1].transpose(), rows[0].cross(rows[1]).transpose();
  return {SO3::from_matrix(R_O_D), Eigen::Vector3d::Zero()};
}

DepthCamera depth_camera(const Rig& rig) {
  if (!rig.depth) throw_input_error("--tum-rgbd: the rig that --config names has no depth camera");
  return *rig.depth;
}

RgbdFolder read_folder(const PlayerOptions& options) {
  RgbdFolder folder = read_rgbd(options.tum_rgbd);
  if (options.depth_per_m > 0.0) folder.depth_per_m = options.depth_per_m;
  if (folder.without_pose > 0)
    spdlog::warn("{} depth images have no pose and are left out", folder.without_pose);
  return folder;
}

}  // namespace

RgbdNode::RgbdNode(Process& process, const PlayerOptions& options)
    : process_(process),
      depth_bus_(process.depth_bus()),
      speed_(options.speed),
      T_O_D_(levelled(options.up)),
      T_C_B_(depth_camera(process.rig()).T_B_C.inverse()),
      folder_(read_folder(options)),
      odometry_(std::max(0, process.robot())) {
  process_.status().set_counter("without_pose", folder_.without_pose);
  load_next();
  start_ = process_.now();
  process_.status().set_phase("playing");
  process_.loop().call_every(kUsPerSecond, [this] { show_progress(); });
  wait_for_next();
}

void RgbdNode::wait_for_next() {
  if (next_ >= folder_.frames.size()) {
    process_.loop().call_at(not_before_ + kLingerUs, [this] { finish(); });
    return;
  }
  const Utime recorded_us = folder_.frames[next_].utime - folder_.frames.front().utime;
  const Utime paced_us = speed_ == 0.0 ? 0 : from_seconds(to_seconds(recorded_us) / speed_);
  process_.loop().call_at(std::max({start_ + paced_us, not_before_, process_.now()}),
                          [this] { publish_next(); });
}

void RgbdNode::publish_next() {
  const RgbdFrame& frame = folder_.frames[next_++];
  const GivenOdometry::Said said = odometry_.add(frame.utime, T_O_D_ * frame.T_D_C * T_C_B_);
  process_.bus().publish(kState, said.state);
  if (said.keyframe) process_.bus().publish(kKeyframe, *said.keyframe);
  if (loaded_) {
    depth_bus_.publish(kDepth, *loaded_);
    const std::size_t bytes = encode(*loaded_).size();
    not_before_ =
        std::max(not_before_, process_.now()) + time_to_receive(bytes) + (speed_ == 0.0 ? kReaderUs : 0);
  }
  process_.status().gauge("played_s", to_seconds(frame.utime - folder_.frames.front().utime));
  process_.loop().post([this] {
    load_next();
    wait_for_next();
  });
}

void RgbdNode::load_next() {
  loaded_.reset();
  if (next_ >= folder_.frames.size()) return;
  try {
    loaded_ = load_depth(folder_.frames[next_], folder_.depth_per_m);
  } catch (const InputError& error) {
    process_.status().count("dropped/DEPTH/unreadable");
    spdlog::warn("{}", error.what());
  }
}

void RgbdNode::finish() {
  show_progress();
  process_.status().set_phase("done");
  process_.stop();
}

void RgbdNode::show_progress() {
  spdlog::info("{:.1f} s played, {} of {} images", process_.status().gauge("played_s"), next_,
               folder_.frames.size());
}

void convert_rgbd(const PlayerOptions& options, const std::filesystem::path& config,
                  const std::filesystem::path& log) {
  const SE3 T_C_B = depth_camera(load_robot_rig(config)).T_B_C.inverse();
  const SE3 T_O_D = levelled(options.up);
  const RgbdFolder folder = read_folder(options);
  GivenOdometry odometry(0);
  SensorLogWriter writer(log.string());
  for (const RgbdFrame& frame : folder.frames) {
    const GivenOdometry::Said said = odometry.add(frame.utime, T_O_D * frame.T_D_C * T_C_B);
    writer.write(kState, said.state);
    if (said.keyframe) writer.write(kKeyframe, *said.keyframe);
    writer.write(kDepth, load_depth(frame, folder.depth_per_m));
  }
  spdlog::info("{} images", folder.frames.size());
  if (!writer.finish()) {
    throw std::runtime_error(
        fmt::format("{}: could not be written to the end; is the disk full?", log.string()));
  }
}

}  // namespace covey
