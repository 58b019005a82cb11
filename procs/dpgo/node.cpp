// SPDX-License-Identifier: BSD-3-Clause
#include "procs/dpgo/node.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <filesystem>
#include <string>

#include "core/geometry/trajectory.h"
#include "procs/dpgo/messages.h"
#include "procs/dpgo/options.h"
#include "procs/dpgo/words.h"

namespace covey {
namespace {

constexpr Utime kTickUs = 50'000;

const char* word(pgo::AgentPhase phase) {
  switch (phase) {
    case pgo::AgentPhase::kIdle:
      return "idle";
    case pgo::AgentPhase::kWaiting:
      return "waiting";
    case pgo::AgentPhase::kRound:
      return "round";
  }
  return "";
}

// Readers see the old file or the new one, never half of one.
void replace_tum(const std::filesystem::path& file, const Trajectory& trajectory) {
  std::filesystem::path fresh = file;
  fresh += ".new";
  try {
    write_tum(fresh, trajectory);
    std::filesystem::rename(fresh, file);
  } catch (const std::exception& error) {
    spdlog::warn("--tum: {}", error.what());
  }
}

}  // namespace

DpgoNode::DpgoNode(Process& process)
    : process_(process), agent_(process.robot(), process.now(), agent_options()) {
  if (!process.state_dir().empty()) restore();
  Bus& bus = process.bus();
  bus.subscribe(
      kKeyframe, [this](const keyframe_t& message) { on_keyframe(message); },
      log_ ? log_->keyframes() : StreamPositions{});
  bus.subscribe(
      kLoop, [this](const loop_t& message) { on_loop(message); }, log_ ? log_->loops() : StreamPositions{});
  listen(kDpgoBeacon);
  listen(kDpgoNeighbours);
  listen(kDpgoRound);
  listen(kDpgoRequest);
  listen(kDpgoJoin);
  listen(kDpgoKeys);
  listen(kDpgoStart);
  listen(kDpgoAlignment);
  listen(kDpgoAdvance);
  listen(kDpgoCoarse);
  listen(kDpgoGraph);
  listen(kDpgoPoses);
  listen(kDpgoRelay);
  listen(kDpgoRelayRound);
  if (process.from_log()) follow_log();
  process.loop().call_every(kTickUs, [this] {
    agent_.tick(process_.now());
    work();
    watch_team();
    publish_gauges();
  });
  publish_gauges();
}

pgo::AgentOptions DpgoNode::agent_options() {
  pgo::AgentOptions options = read_agent_options(process_.config().root().section("dpgo"));
  options.dgnc.meanwhile = [this] {
    agent_.say_presence(process_.now());
    publish_outgoing();
  };
  return options;
}

template <typename T>
void DpgoNode::listen(const RadioChannel<T>& channel) {
  process_.bus().subscribe(channel, [this, channel](const T& message) {
    const char* reason = agent_.receive(message, process_.now());
    if (reason != nullptr) process_.status().count(fmt::format("dropped/{}/{}", channel.in().name, reason));
    work();
  });
}

// A log of this robot's bus has what this process said when it was recorded: the others' messages answer that.
void DpgoNode::follow_log() {
  process_.bus().subscribe(kDpgoBeacon.out(), [this](const dpgo_beacon_t& own) { agent_.follow(own); });
  process_.bus().subscribe(kDpgoRound.out(), [this](const dpgo_round_t& own) {
    agent_.follow(own, process_.now());
    work();
  });
}

void DpgoNode::on_keyframe(const keyframe_t& message) {
  if (take(message) && log_) log_->append(message, process_.now());
}

void DpgoNode::on_loop(const loop_t& message) {
  if (take(message) && log_) log_->append(message, process_.now());
}

bool DpgoNode::take(const keyframe_t& message) {
  const auto keyframe = keyframe_from(message);
  const char* reason = keyframe ? agent_.add(*keyframe) : "values";
  if (reason != nullptr) process_.status().count(fmt::format("dropped/{}/{}", kKeyframe.name, reason));
  return reason == nullptr;
}

bool DpgoNode::take(const loop_t& message) {
  const auto loop = loop_from(message);
  const char* reason = loop ? agent_.add(*loop) : "values";
  if (reason != nullptr) process_.status().count(fmt::format("dropped/{}/{}", kLoop.name, reason));
  return reason == nullptr;
}

// At most one update of the poses per turn of the loop.
void DpgoNode::work() {
  const bool moved = !work_posted_ && agent_.advance(process_.now());
  publish_outgoing();
  if (const auto result = agent_.take_result()) take_result(*result);
  process_.status().set_phase(word(agent_.phase()));
  if (!moved) return;
  work_posted_ = true;
  process_.loop().post([this] {
    work_posted_ = false;
    work();
  });
}

void DpgoNode::publish_outgoing() {
  struct Publish {
    Bus& bus;
    void operator()(const dpgo_beacon_t& m) { bus.publish(kDpgoBeacon, m); }
    void operator()(const dpgo_neighbours_t& m) { bus.publish(kDpgoNeighbours, m); }
    void operator()(const dpgo_round_t& m) { bus.publish(kDpgoRound, m); }
    void operator()(const dpgo_request_t& m) { bus.publish(kDpgoRequest, m); }
    void operator()(const dpgo_join_t& m) { bus.publish(kDpgoJoin, m); }
    void operator()(const dpgo_keys_t& m) { bus.publish(kDpgoKeys, m); }
    void operator()(const dpgo_keyframes_t& m) { bus.publish(kDpgoStart, m); }
    void operator()(const dpgo_alignment_t& m) { bus.publish(kDpgoAlignment, m); }
    void operator()(const dpgo_advance_t& m) { bus.publish(kDpgoAdvance, m); }
    void operator()(const dpgo_coarse_t& m) { bus.publish(kDpgoCoarse, m); }
    void operator()(const dpgo_graph_t& m) { bus.publish(kDpgoGraph, m); }
    void operator()(const dpgo_poses_t& m) { bus.publish(kDpgoPoses, m); }
    void operator()(const dpgo_relay_t& m) {
      bus.publish(pgo::is_of_a_round(m) ? kDpgoRelayRound : kDpgoRelay, m);
    }
  };
  for (const pgo::AgentMessage& message : agent_.take_outgoing())
    std::visit(Publish{process_.bus()}, message);
}

void DpgoNode::take_result(const pgo::RoundResult& result) {
  const Utime now = process_.now();
  const pgo::RoundAccount& account = agent_.account();
  spdlog::info("{}", round_line(result, account));
  for (const std::string& rejected : result.rejected) spdlog::error("{}", rejected);
  for (const std::string& warning : result.warnings) spdlog::warn("{}", warning);
  SavedRound round{agent_.solution(),
                   trajectory_messages(result, agent_.graph(), now),
                   loop_weights_messages(result, agent_.robot(), now),
                   {}};
  round.gauges = {{"solved_keyframes", result.keyframes},
                  {"solved_loops", result.loops_used},
                  {"kept_loops", result.loops_kept},
                  {"cost", result.owned_cost},
                  {"round", static_cast<double>(result.name.number)},
                  {"robots", static_cast<double>(result.robots.size())},
                  {"updates", result.updates},
                  {"gradient", result.gradient},
                  {"weights_zero", static_cast<double>(result.weights_zero)},
                  {"weights_between", static_cast<double>(result.weights_between)},
                  {"weights_one", static_cast<double>(result.weights_one)},
                  {"rejected_pairs", static_cast<double>(result.rejected.size())},
                  {"round_s", to_seconds(account.duration_us)},
                  {"round_kb", static_cast<double>(account.total_bytes()) * 1e-3}};
  publish(round);
  if (!process_.tum_path().empty()) replace_tum(process_.tum_path(), trajectory_of(result, agent_.graph()));
  if (log_) log_->save(round, now);
}

void DpgoNode::publish(const SavedRound& round) {
  for (const trajectory_t& part : round.trajectory) process_.bus().publish(kTrajectory, part);
  for (const loop_weights_t& part : round.loop_weights) process_.bus().publish(kLoopWeights, part);
  for (const auto& [name, value] : round.gauges) process_.status().gauge(name, value);
  publish_gauges();
}

void DpgoNode::restore() {
  log_.emplace(process_.state_dir(), [this](const std::string& channel, const Bytes& bytes) {
    keyframe_t keyframe{};
    loop_t loop{};
    if (channel == kKeyframe.name && decode(bytes, keyframe)) take(keyframe);
    if (channel == kLoop.name && decode(bytes, loop)) take(loop);
  });
  if (const auto round = log_->load_round()) {
    agent_.restore(round->solution);
    publish(*round);
    spdlog::info("read back {} keyframes, {} loops and round {}", agent_.graph().poses(),
                 agent_.graph().loops(), round->solution.round.number);
  }
}

void DpgoNode::publish_gauges() {
  process_.status().gauge("keyframes", agent_.graph().poses());
  process_.status().gauge("loops", agent_.graph().loops());
  const Utime now = process_.now();
  const std::vector<int>& together = agent_.solution().robots;
  for (const auto& [robot, peer] : agent_.presence().peers()) {
    process_.status().gauge(fmt::format("silent_s/{}", robot), to_seconds(now - peer.heard));
    process_.status().gauge(fmt::format("together/{}", robot),
                            std::binary_search(together.begin(), together.end(), robot) ? 1.0 : 0.0);
  }
}

// Who is apart, whenever that changes; a robot that will be in the next round is no news.
void DpgoNode::watch_team() {
  if (agent_.solution().robots.empty()) return;
  const std::vector<pgo::ApartRobot> apart = agent_.apart(process_.now());
  std::vector<std::pair<int, pgo::Apart>> now_apart;
  for (const pgo::ApartRobot& robot : apart) {
    if (robot.why != pgo::Apart::kNotYet) now_apart.emplace_back(robot.robot, robot.why);
  }
  if (now_apart == said_apart_) return;
  said_apart_ = std::move(now_apart);
  spdlog::info("{}", team_line(agent_.solution().robots, apart));
}

}  // namespace covey
