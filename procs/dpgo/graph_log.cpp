// SPDX-License-Identifier: BSD-3-Clause
#include "procs/dpgo/graph_log.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/pgo/public_poses.h"

namespace covey {
namespace {

struct Event {
  Utime utime;
  std::string channel;
  Bytes bytes;
};

std::vector<Event> read_events(const std::filesystem::path& file) {
  std::vector<Event> events;
  if (!std::filesystem::exists(file)) return events;
  try {
    Utime utime = 0;
    LogReader reader(file.string(), [&](const std::string& channel, const Bytes& bytes) {
      events.push_back({utime, channel, bytes});
    });
    while (const auto next = reader.next_time()) {
      utime = *next;
      reader.deliver();
    }
  } catch (const InputError& error) {
    spdlog::warn("{}: nothing can be read back, starting without", error.what());
  }
  return events;
}

void advance_to(StreamPositions& positions, std::int64_t stream, std::int32_t next) {
  std::int32_t& position = positions[stream];
  position = std::max(position, next);
}

}  // namespace

GraphLog::GraphLog(std::filesystem::path folder, const Take& take) : folder_(std::move(folder)) {
  // Rewritten on each start, so that a cut-off end is not followed by good events.
  const std::vector<Event> events = read_events(folder_ / "dpgo_graph.lcm");
  const std::filesystem::path fresh = folder_ / "dpgo_graph.lcm.new";
  log_ = std::make_unique<LogRecorder>(fresh.string());
  for (const Event& event : events) {
    keyframe_t keyframe{};
    loop_t loop{};
    if (event.channel == kKeyframe.name && decode(event.bytes, keyframe)) {
      append(keyframe, event.utime);
    } else if (event.channel == kLoop.name && decode(event.bytes, loop)) {
      append(loop, event.utime);
    } else {
      continue;
    }
    take(event.channel, event.bytes);
  }
  log_->flush();
  std::filesystem::rename(fresh, folder_ / "dpgo_graph.lcm");
}

void GraphLog::append(const keyframe_t& keyframe, Utime now) {
  log_->write(now, kKeyframe.name, encode(keyframe));
  log_->flush();
  advance_to(keyframes_, kKeyframe.stream(keyframe), kKeyframe.number(keyframe) + 1);
}

void GraphLog::append(const loop_t& loop, Utime now) {
  log_->write(now, kLoop.name, encode(loop));
  log_->flush();
  advance_to(loops_, kLoop.stream(loop), kLoop.number(loop) + 1);
}

// A disk that is full or gone costs what would be read back after a restart, not the run.
void GraphLog::save(const SavedRound& round, Utime now) {
  try {
    write_round(round, now);
  } catch (const std::exception& error) {
    spdlog::warn("this round is not saved: {}", error.what());
  }
}

void GraphLog::write_round(const SavedRound& round, Utime now) const {
  const std::filesystem::path fresh = folder_ / "dpgo_solution.lcm.new";
  {
    LogRecorder log(fresh.string());
    dpgo_beacon_t beacon{};
    beacon.utime = now;
    beacon.solved_round = round.solution.round.number;
    beacon.solved_anchor = round.solution.round.anchor;
    beacon.solved_graph = static_cast<std::int64_t>(round.solution.graph);
    log.write(now, kDpgoBeacon.name, encode(beacon));
    dpgo_join_t starts{};
    for (const auto& [segment, T_W_K] : round.solution.segments) {
      starts.segments.push_back(segment);
      starts.solutions.push_back(round.solution.frame);
    }
    starts.n_segments = static_cast<std::int32_t>(starts.segments.size());
    starts.peers.assign(round.solution.robots.begin(), round.solution.robots.end());
    starts.loops.resize(starts.peers.size());
    starts.hashes.resize(starts.peers.size());
    starts.n_peers = static_cast<std::int32_t>(starts.peers.size());
    log.write(now, kDpgoJoin.name, encode(starts));
    for (const trajectory_t& part : round.trajectory) log.write(now, kTrajectory.name, encode(part));
    for (const loop_weights_t& part : round.loop_weights) log.write(now, kLoopWeights.name, encode(part));
    status_t status{};
    status.utime = now;
    for (const auto& [name, value] : round.gauges) {
      status.gauge_names.push_back(name);
      status.gauge_values.push_back(value);
    }
    status.n_gauges = static_cast<std::int32_t>(status.gauge_names.size());
    log.write(now, kStatus.name, encode(status));
    log.flush();
    if (!log.good()) {
      spdlog::warn("{}: cannot be written", fresh.string());
      return;
    }
  }
  std::filesystem::rename(fresh, folder_ / "dpgo_solution.lcm");
}

std::optional<SavedRound> GraphLog::load_round() const {
  SavedRound round;
  pgo::Solution& solution = round.solution;
  bool complete = false;  // STATUS comes last
  for (const Event& event : read_events(folder_ / "dpgo_solution.lcm")) {
    dpgo_beacon_t beacon{};
    dpgo_join_t starts{};
    trajectory_t poses{};
    loop_weights_t weights{};
    status_t status{};
    if (event.channel == kDpgoBeacon.name && decode(event.bytes, beacon)) {
      solution.round = {beacon.solved_round, beacon.solved_anchor};
      solution.graph = static_cast<std::uint64_t>(beacon.solved_graph);
    } else if (event.channel == kDpgoJoin.name && decode(event.bytes, starts)) {
      if (starts.n_segments > 0) solution.frame = starts.solutions.front();
      solution.robots.assign(starts.peers.begin(), starts.peers.end());
    } else if (event.channel == kTrajectory.name && decode(event.bytes, poses)) {
      round.trajectory.push_back(poses);
    } else if (event.channel == kLoopWeights.name && decode(event.bytes, weights)) {
      round.loop_weights.push_back(weights);
    } else if (event.channel == kStatus.name && decode(event.bytes, status)) {
      for (int k = 0; k < status.n_gauges; ++k) round.gauges[status.gauge_names[k]] = status.gauge_values[k];
      complete = true;
    }
  }
  if (!complete || solution.round.number <= 0) return std::nullopt;
  for (const trajectory_t& part : round.trajectory) {
    if (part.n_values != 7 * part.n || !pgo::poses_are_good(part.T_W_K)) return std::nullopt;
    for (int k = 0; k < part.n; ++k) {
      auto& T_W_K = solution.segments[part.segments[k]];
      if (part.ids[k] != static_cast<int>(T_W_K.size())) return std::nullopt;
      T_W_K.push_back(pgo::pose_at(part.T_W_K, k));
      if (!T_W_K.back().translation.allFinite()) return std::nullopt;
    }
  }
  return round;
}

}  // namespace covey
