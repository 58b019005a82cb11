// SPDX-License-Identifier: BSD-3-Clause
#include "procs/lmo/node.h"

#include <spdlog/spdlog.h>

#include <iterator>
#include <utility>

#include "core/mesh/optimized_parts.h"

namespace covey {
namespace {

constexpr Utime kTickUs = 200'000;
constexpr Utime kPublishUs = 20'000;

}  // namespace

LmoNode::LmoNode(Process& process, const std::filesystem::path& mesh_dir)
    : process_(process),
      options_(read_lmo_options(process.config().root().section("lmo"))),
      mesh_(process.robot()) {
  if (!mesh_dir.empty()) files_.emplace(mesh_dir, process.robot());
  if (!process.state_dir().empty()) restore();
  Bus& bus = process.bus();
  bus.subscribe(
      kMesh, [this](const mesh_block_t& block) { on_mesh(block); },
      log_ ? log_->blocks() : StreamPositions{});
  bus.subscribe(
      kKeyframe, [this](const keyframe_t& keyframe) { take(kKeyframe.name, keyframe); },
      log_ ? log_->keyframes() : StreamPositions{});
  bus.subscribe(kTrajectory, [this](const trajectory_t& part) { on_trajectory(part); });
  process.loop().call_every(kTickUs, [this] { consider(); });
  process.loop().call_every(kPublishUs, [this] { publish_next(); });
  if (process.from_log()) process.on_stop([this] { finish_log(); });
  report();
}

template <typename T>
bool LmoNode::take(const char* channel, const T& message) {
  const char* reason = mesh_.take(message);
  if (reason != nullptr) process_.status().count(fmt::format("dropped/{}/{}", channel, reason));
  if (reason == nullptr && log_) log_->append(message, process_.now());
  return reason == nullptr;
}

void LmoNode::on_mesh(const mesh_block_t& block) {
  if (!take(kMesh.name, block)) return;
  ++known_.blocks;
  known_.mesh_number = block.number;
  changed_us_ = process_.now();
  if (solving_.blocks + 1 == known_.blocks) first_changed_us_ = changed_us_;
}

void LmoNode::on_trajectory(const trajectory_t& part) {
  if (!take(kTrajectory.name, part)) return;
  known_.round_utime = mesh_.round().empty() ? 0 : mesh_.round().front().utime;
  known_.round = mesh_.round().empty() ? 0 : mesh_.round().front().round;
  consider();
}

void LmoNode::restore() {
  log_.emplace(process_.state_dir(), mesh_);
  known_.blocks = static_cast<std::int64_t>(mesh_.blocks().size());
  for (const auto& [stream, next] : log_->blocks())
    known_.mesh_number = next - 1;  // the newest stream comes last
  if (!mesh_.round().empty()) {
    known_.round_utime = mesh_.round().front().utime;
    known_.round = mesh_.round().front().round;
  }
  first_changed_us_ = changed_us_ = process_.now();
  if (known_.blocks > 0) {
    spdlog::info("read back {} blocks, {} keyframes and round {}", known_.blocks, mesh_.keyframes().size(),
                 known_.round);
  }
}

bool LmoNode::has_news() const {
  return known_.round_utime != solved_.round_utime || known_.blocks != solved_.blocks;
}

bool LmoNode::is_due() const {
  if (known_.round_utime != solved_.round_utime && known_.blocks > 0) return true;
  if (known_.blocks == solved_.blocks) return false;
  const Utime now = process_.now();
  return now - changed_us_ >= options_.settle_us || now - first_changed_us_ >= options_.patience_us;
}

void LmoNode::consider() {
  if (!job_ && is_due()) {
    begin();
    process_.loop().post([this] { work(); });
  }
  process_.status().set_phase(job_ ? "solving" : has_news() ? "waiting" : "idle");
  report();
}

void LmoNode::begin() {
  solving_ = known_;
  begun_us_ = process_.now();
  job_.emplace(mesh_.team(), options_.deformation);
}

// One piece of the optimisation in each turn of the loop.
void LmoNode::work() {
  if (job_->advance()) {
    process_.loop().post([this] { work(); });
    return;
  }
  finish();
  consider();
}

void LmoNode::finish() {
  const mesh::MeshSnapshot& snapshot = job_->snapshot();
  if (!snapshot.mesh.p_O.empty()) {
    mesh_optimized_t name{};
    name.utime = process_.now();
    name.robot = process_.robot();
    name.anchor = mesh_.round().front().anchor;
    name.round = solving_.round;
    auto parts = mesh::optimized_parts(name, snapshot, job_->moved());
    outgoing_.assign(std::make_move_iterator(parts.begin()), std::make_move_iterator(parts.end()));
    if (files_) files_->write_team(snapshot, job_->moved());
  }
  if (files_ && solving_.blocks != solved_.blocks) files_->write_odometry(mesh_.odometry());
  Status& status = process_.status();
  const graph::SolveResult& result = job_->deformation()->result();
  status.gauge("vertices", static_cast<double>(snapshot.mesh.p_O.size()));
  status.gauge("left_out", snapshot.left_out);
  status.gauge("torn", job_->torn());
  status.gauge("nodes", static_cast<double>(job_->deformation()->simplified().nodes.size()));
  status.gauge("cell_m", job_->deformation()->simplified().cell_m);
  status.gauge("iterations", result.iterations);
  status.gauge("solve_ms", 1e3 * to_seconds(process_.now() - begun_us_));
  status.gauge("optimisations", ++optimisations_);
  solved_ = solving_;
  job_.reset();
}

void LmoNode::publish_next() {
  if (outgoing_.empty()) return;
  process_.bus().publish(kMeshOptimized, outgoing_.front());
  outgoing_.pop_front();
}

// The log has ended: nothing more will come that would be worth waiting for.
void LmoNode::finish_log() {
  if (process_.loop().interrupted()) return;
  if (has_news()) begin();  // anew, where one is under way
  if (job_) {
    while (job_->advance()) continue;
    finish();
  }
  while (!outgoing_.empty()) publish_next();
  process_.status().set_phase("idle");
  report();
}

void LmoNode::report() {
  Status& status = process_.status();
  status.gauge("round", static_cast<double>(known_.round));
  status.gauge("solved_round", static_cast<double>(solved_.round));
  status.gauge("blocks", static_cast<double>(mesh_.blocks().size()));
  status.gauge("blocks_pending", static_cast<double>(known_.blocks - solved_.blocks));
  status.gauge("mesh_number", solved_.mesh_number);
  status.gauge("parts_pending", static_cast<double>(outgoing_.size()));
}

}  // namespace covey
