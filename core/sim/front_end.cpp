// SPDX-License-Identifier: BSD-3-Clause
#include "core/sim/front_end.h"

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/pgo/trajectories.h"

namespace covey::sim {
namespace {

using pgo::Edge;
using pgo::EdgeKind;
using pgo::keyframe_utime;

void put_pose(const SE3& T, double (&q)[4], double (&t)[3]) {
  const Eigen::Quaterniond quaternion = T.rotation.canonical_quaternion();
  q[0] = quaternion.w();
  q[1] = quaternion.x();
  q[2] = quaternion.y();
  q[3] = quaternion.z();
  for (int k = 0; k < 3; ++k) t[k] = T.translation[k];
}

void put_covariance(const Edge& edge, double (&covariance)[36]) {
  for (int k = 0; k < 6; ++k) covariance[7 * k] = k < 3 ? 1.0 / edge.tau : 1.0 / (2.0 * edge.kappa);
}

std::vector<const Edge*> odometry_of(const pgo::PoseGraph& graph, int robot) {
  std::vector<const Edge*> steps(std::max(0, graph.poses_per_robot.at(robot) - 1), nullptr);
  for (const Edge& edge : graph.edges) {
    if (edge.kind == EdgeKind::kOdometry && edge.from.robot == robot) steps[edge.from.index] = &edge;
  }
  for (std::size_t k = 0; k < steps.size(); ++k) {
    if (steps[k] == nullptr)
      throw_input_error("robot {}: no odometry from pose {} to pose {}", robot, k, k + 1);
  }
  return steps;
}

keyframe_t first_keyframe(int robot) {
  keyframe_t message{};
  message.utime = keyframe_utime(0);
  message.robot = robot;
  message.segment = keyframe_utime(0);
  put_pose(SE3{}, message.q_O_K, message.t_O_K);
  put_pose(SE3{}, message.q_P_K, message.t_P_K);
  return message;
}

std::vector<keyframe_t> keyframes_of(const pgo::PoseGraph& graph, int robot) {
  std::vector<keyframe_t> keyframes = {first_keyframe(robot)};
  SE3 T_O_K;
  for (const Edge* step : odometry_of(graph, robot)) {
    T_O_K = T_O_K * step->measurement;
    keyframe_t message = first_keyframe(robot);
    message.id = step->to.index;
    message.utime = keyframe_utime(message.id);
    put_pose(T_O_K, message.q_O_K, message.t_O_K);
    put_pose(step->measurement, message.q_P_K, message.t_P_K);
    put_covariance(*step, message.covariance);
    keyframes.push_back(message);
  }
  return keyframes;
}

int last_own_pose(const Edge& edge, int robot) {
  return std::max(edge.from.robot == robot ? edge.from.index : -1,
                  edge.to.robot == robot ? edge.to.index : -1);
}

std::vector<loop_t> loops_of(const pgo::PoseGraph& graph, int robot) {
  std::vector<const Edge*> edges;
  for (const Edge& edge : graph.edges) {
    if (edge.kind == EdgeKind::kLoop && last_own_pose(edge, robot) >= 0) edges.push_back(&edge);
  }
  std::stable_sort(edges.begin(), edges.end(), [robot](const Edge* a, const Edge* b) {
    return last_own_pose(*a, robot) < last_own_pose(*b, robot);
  });
  std::vector<loop_t> loops;
  for (const Edge* edge : edges) {
    loop_t message{};
    message.utime = keyframe_utime(last_own_pose(*edge, robot));
    message.stream = keyframe_utime(0);
    message.number = static_cast<std::int32_t>(loops.size());
    message.robot_a = edge->from.robot;
    message.segment_a = keyframe_utime(0);
    message.id_a = edge->from.index;
    message.robot_b = edge->to.robot;
    message.segment_b = keyframe_utime(0);
    message.id_b = edge->to.index;
    put_pose(edge->measurement, message.q_A_B, message.t_A_B);
    put_covariance(*edge, message.covariance);
    loops.push_back(message);
  }
  return loops;
}

}  // namespace

std::vector<FrontEndMessage> front_end_messages(const pgo::PoseGraph& graph, int robot) {
  if (robot < 0 || robot >= graph.robots() || graph.poses_per_robot[robot] == 0) {
    throw_input_error("the pose graph has no poses of robot {}", robot);
  }
  const std::vector<loop_t> loops = loops_of(graph, robot);
  std::vector<FrontEndMessage> messages;
  auto loop = loops.begin();
  for (const keyframe_t& keyframe : keyframes_of(graph, robot)) {
    messages.emplace_back(keyframe);
    for (; loop != loops.end() && loop->utime <= keyframe.utime; ++loop) messages.emplace_back(*loop);
  }
  return messages;
}

Utime utime_of(const FrontEndMessage& message) {
  return std::visit([](const auto& inner) { return inner.utime; }, message);
}

}  // namespace covey::sim
