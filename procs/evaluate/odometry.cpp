// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>
#include <covey/keyframe_t.hpp>
#include <covey/state_t.hpp>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "core/base/bytes.h"
#include "core/base/error.h"
#include "core/eval/ate.h"
#include "core/eval/consistency.h"
#include "core/eval/drift.h"
#include "procs/common/channels.h"
#include "procs/common/log_file.h"
#include "procs/evaluate/commands.h"

namespace covey {
namespace {

using Json = nlohmann::ordered_json;
using RowMajor6d = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;
using RowMajor9f = Eigen::Matrix<float, 9, 9, Eigen::RowMajor>;

constexpr Utime kStateEveryUs = 500'000;  // states between two images say nearly the same
constexpr std::array kSpansS = {1, 10, 60};

struct OdometryOptions {
  std::string estimate;
  std::string reference;
  std::string log;
};

struct Beliefs {
  std::vector<PoseBelief> states;
  std::vector<EdgeBelief> edges;
};

SE3 pose_of(const double (&q)[4], const double (&t)[3]) {
  return {SO3::from_quaternion({q[0], q[1], q[2], q[3]}), Eigen::Vector3d(&t[0])};
}

Beliefs read_beliefs(const std::string& file) {
  Beliefs beliefs;
  LogReader log(file, [&beliefs](const std::string& channel, const Bytes& bytes) {
    state_t state{};
    keyframe_t keyframe{};
    if (channel == kState.name && decode(bytes, state)) {
      const bool due = beliefs.states.empty() || beliefs.states.back().segment != state.segment ||
                       state.utime - beliefs.states.back().utime >= kStateEveryUs;
      if (!due) return;
      const RowMajor9f covariance = Eigen::Map<const RowMajor9f>(&state.covariance[0]);
      beliefs.states.push_back({state.utime, state.segment, pose_of(state.q_O_B, state.t_O_B),
                                Matrix6d(covariance.topLeftCorner<6, 6>().cast<double>())});
    }
    if (channel == kKeyframe.name && decode(bytes, keyframe)) {
      beliefs.edges.push_back({keyframe.utime, keyframe.segment, keyframe.id,
                               pose_of(keyframe.q_P_K, keyframe.t_P_K),
                               Matrix6d(Eigen::Map<const RowMajor6d>(&keyframe.covariance[0]))});
    }
  });
  while (log.next_time()) log.deliver();
  return beliefs;
}

void print_odometry(const OdometryOptions& options) {
  const TrajectoryPair pair{read_tum(options.estimate), read_tum(options.reference)};
  const TrajectoryError error = trajectory_error(pair);
  if (error.matched == 0)
    throw_input_error("{} and {} have no stamps in common", options.estimate, options.reference);
  const Eigen::Quaterniond q = error.T_reference_estimate.rotation.canonical_quaternion();
  const Eigen::Vector3d& t = error.T_reference_estimate.translation;
  Json json = {{"ate_m", error.rmse_m},
               {"max_m", error.max_m},
               {"matched", error.matched},
               {"T_reference_estimate", {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()}}};
  const Drift drift = odometry_drift(pair);
  if (drift.stretches > 0) {
    json["rpe_percent"] = drift.translation_percent;
    json["rpe_deg_per_m"] = drift.rotation_deg_per_m;
  }
  if (!options.log.empty()) {
    const Beliefs beliefs = read_beliefs(options.log);
    const Nees nees = state_nees(beliefs.states, pair.reference);
    if (nees.count > 0) {
      json["nees"] = nees.mean;
      json["position_nees"] = nees.position;
      json["yaw_nees"] = nees.rotation;
    }
    for (const int span_s : kSpansS) {
      const Nees edges = edge_nees(beliefs.edges, pair.reference, span_s);
      if (edges.count == 0) continue;
      json[fmt::format("edge_nees_{}s", span_s)] = edges.mean;
      json[fmt::format("edge_position_nees_{}s", span_s)] = edges.position;
      json[fmt::format("edge_rotation_nees_{}s", span_s)] = edges.rotation;
    }
  }
  std::cout << json.dump(2) << "\n";
}

}  // namespace

void add_odometry_command(CLI::App& app) {
  auto options = std::make_shared<OdometryOptions>();
  CLI::App* command = app.add_subcommand(
      "odometry", "error of one robot's odometry, its drift, and whether it knows how wrong it is");
  command->add_option("--estimate", options->estimate, "TUM file: the --tum file of vio")->required();
  command->add_option("--reference", options->reference, "TUM file")->required();
  command->add_option("--log", options->log, "log of the robot's bus, with STATE and KEYFRAME: vio's --out");
  command->callback([options] { print_odometry(*options); });
}

}  // namespace covey
