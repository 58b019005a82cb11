// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/elected_messages.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <numeric>
#include <tuple>

namespace covey::pgo {
namespace {

constexpr float kFarthest = 1e7F;  // m; of a measurement or a pose
constexpr float kLargestPrecision = 1e16F;
constexpr float kLargestCovariance = 1e16F;

// -1: the robot or its segment is not among them.
int place_of(const SegmentNames& names, const KeyframeName& keyframe) {
  const auto robot = names.find(keyframe.robot);
  if (robot == names.end()) return -1;
  const auto found = std::lower_bound(robot->second.begin(), robot->second.end(), keyframe.segment);
  if (found == robot->second.end() || *found != keyframe.segment) return -1;
  return static_cast<int>(found - robot->second.begin());
}

// In what the loops of a group are alike.
auto group_of(const OwnedLoop& owned) {
  return std::tuple(owned.robot_b, owned.segment_a, owned.segment_b, owned.reversed,
                    owned.loop->known_inlier);
}

void append_group(const OwnedLoop& owned, dpgo_graph_t& message) {
  message.robots_b.push_back(owned.robot_b);
  message.segments_a.push_back(static_cast<std::int16_t>(owned.segment_a));
  message.segments_b.push_back(static_cast<std::int16_t>(owned.segment_b));
  message.reversed.push_back(static_cast<std::int8_t>(owned.reversed));
  message.known_inliers.push_back(static_cast<std::int8_t>(owned.loop->known_inlier));
  message.sizes.push_back(0);
}

void append_loops(const std::vector<OwnedLoop>& loops, dpgo_graph_t& message) {
  for (std::size_t k = 0; k < loops.size(); ++k) {
    if (k == 0 || group_of(loops[k]) != group_of(loops[k - 1])) append_group(loops[k], message);
    ++message.sizes.back();
    message.ids_a.push_back(loops[k].id_a);
    message.ids_b.push_back(loops[k].id_b);
  }
}

std::vector<float> packed(const std::vector<Precision>& precisions) {
  const auto alike = [&](const Precision& p) {
    return p.kappa == precisions.front().kappa && p.tau == precisions.front().tau;
  };
  const bool once = std::all_of(precisions.begin(), precisions.end(), alike);
  std::vector<float> values;
  for (const Precision& precision : precisions) {
    values.push_back(static_cast<float>(precision.kappa));
    values.push_back(static_cast<float>(precision.tau));
    if (once) break;
  }
  return values;
}

// Upper triangle, row by row.
void append_covariance(const Matrix6d& covariance, std::vector<float>& values) {
  for (int r = 0; r < 6; ++r) {
    for (int c = r; c < 6; ++c) values.push_back(static_cast<float>(covariance(r, c)));
  }
}
constexpr int kCovarianceFloats = 21;

void append_gravity(const Gravity& gravity, std::vector<float>& values) {
  for (const double value : gravity.down_K) values.push_back(static_cast<float>(value));
  values.push_back(static_cast<float>(gravity.sigma));
}
constexpr int kGravityFloats = 4;

template <typename T>
std::int32_t count(const std::vector<T>& list) {
  return static_cast<std::int32_t>(list.size());
}

template <typename T>
bool all_within(const std::vector<T>& values, T lowest, T highest) {
  return std::all_of(values.begin(), values.end(),
                     [&](T value) { return value >= lowest && value <= highest; });
}

template <typename T>
std::int64_t sum(const std::vector<T>& values) {
  return std::accumulate(values.begin(), values.end(), std::int64_t{0});
}

constexpr std::int32_t kMostIds = 1 << 24;

}  // namespace

std::vector<OwnedLoop> in_message_order(const std::vector<GraphLoop>& loops, int owner,
                                        const SegmentNames& names) {
  std::vector<OwnedLoop> owned;
  for (const GraphLoop& loop : loops) {
    const bool reversed = loop.a.robot != owner;
    const KeyframeName& a = reversed ? loop.b : loop.a;
    const KeyframeName& b = reversed ? loop.a : loop.b;
    const int segment_a = place_of(names, a);
    const int segment_b = place_of(names, b);
    if (segment_a < 0 || segment_b < 0) continue;
    owned.push_back({&loop, b.robot, segment_a, segment_b, reversed, a.id, b.id});
  }
  std::stable_sort(owned.begin(), owned.end(),
                   [](const OwnedLoop& x, const OwnedLoop& y) { return group_of(x) < group_of(y); });
  return owned;
}

dpgo_graph_t part_of(const GraphSnapshot& graph, const SegmentNames& names, const PackingOptions& options) {
  dpgo_graph_t message{};
  message.from = graph.robot;
  message.dimension = static_cast<std::int8_t>(options.dimension);
  std::vector<Precision> precisions;
  const auto append = [&](const SE3& T, const Precision& precision, const Matrix6d& covariance) {
    append_floats(T, options.dimension, message.values);
    if (options.full_covariances) {
      append_covariance(covariance, message.covariances);
    } else {
      precisions.push_back(precision);
    }
  };
  for (const Segment& segment : graph.segments) {
    message.poses.push_back(count(segment.poses));
    for (std::size_t k = 0; k < segment.poses.size(); ++k) {
      const OdometryPose& pose = segment.poses[k];
      if (k > 0) append(pose.T_P_K, pose.precision, pose.covariance);
      if (options.full_covariances) append_gravity(pose.gravity, message.gravity);
    }
  }
  const auto append_all = [&](const std::vector<GraphLoop>& loops) {
    const std::vector<OwnedLoop> owned = in_message_order(loops, graph.robot, names);
    append_loops(owned, message);
    for (const OwnedLoop& each : owned) append(each.loop->T_A_B, each.loop->precision, each.loop->covariance);
  };
  append_all(graph.private_loops);
  for (const auto& [peer, loops] : graph.shared_loops) {
    if (peer > graph.robot) append_all(loops);
  }
  message.precisions = packed(precisions);
  message.n_segments = count(message.poses);
  message.n_groups = count(message.sizes);
  message.n_loops = count(message.ids_a);
  message.n_values = count(message.values);
  message.n_precisions = count(message.precisions);
  message.n_covariances = count(message.covariances);
  message.n_gravity = count(message.gravity);
  return message;
}

int floats_per_pose(int dimension) { return dimension == 2 ? 3 : 6; }

void append_floats(const SE3& T, int dimension, std::vector<float>& values) {
  const Eigen::Vector3f phi = T.rotation.log().cast<float>();
  const Eigen::Vector3f t = T.translation.cast<float>();
  if (dimension == 2) {
    values.insert(values.end(), {phi.z(), t.x(), t.y()});
  } else {
    values.insert(values.end(), {phi.x(), phi.y(), phi.z(), t.x(), t.y(), t.z()});
  }
}

SE3 pose_from_floats(const std::vector<float>& values, int k, int dimension) {
  const float* v = values.data() + floats_per_pose(dimension) * static_cast<std::ptrdiff_t>(k);
  if (dimension == 2) return {SO3::exp({0.0, 0.0, v[0]}), Eigen::Vector3d(v[1], v[2], 0.0)};
  return {SO3::exp(Eigen::Vector3d(v[0], v[1], v[2])), Eigen::Vector3d(v[3], v[4], v[5])};
}

Precision precision_at(const dpgo_graph_t& message, int k) {
  const std::size_t first = message.n_precisions == 2 ? 0 : 2 * static_cast<std::size_t>(k);
  return {message.precisions[first], message.precisions[first + 1]};
}

Matrix6d covariance_at(const dpgo_graph_t& message, int k) {
  Matrix6d covariance;
  const float* value = message.covariances.data() + kCovarianceFloats * static_cast<std::ptrdiff_t>(k);
  for (int r = 0; r < 6; ++r) {
    for (int c = r; c < 6; ++c) covariance(r, c) = covariance(c, r) = *value++;
  }
  return covariance;
}

Gravity gravity_at(const dpgo_graph_t& message, int k) {
  const float* value = message.gravity.data() + kGravityFloats * static_cast<std::ptrdiff_t>(k);
  return {Eigen::Vector3d(value[0], value[1], value[2]), value[3]};
}

std::vector<std::int8_t> pack_bits(const std::vector<bool>& flags) {
  std::vector<std::int8_t> bytes((flags.size() + 7) / 8, 0);
  for (std::size_t k = 0; k < flags.size(); ++k) {
    if (flags[k]) bytes[k / 8] = static_cast<std::int8_t>(bytes[k / 8] | (1U << (k % 8)));
  }
  return bytes;
}

bool bit_at(const std::vector<std::int8_t>& bytes, int k) {
  return ((static_cast<unsigned>(bytes[static_cast<std::size_t>(k) / 8]) >> (k % 8)) & 1U) != 0;
}

bool values_are_good(const dpgo_graph_t& m) {
  if (m.dimension != 2 && m.dimension != 3) return false;
  if (m.n_segments == 0) return m.n_groups == 0 && m.n_loops == 0 && m.n_values == 0;
  if (!all_within(m.poses, 1, kMostIds) || !all_within(m.sizes, 1, kMostIds)) return false;
  if (sum(m.sizes) != m.n_loops || !all_within(m.ids_a, 0, kMostIds) || !all_within(m.ids_b, 0, kMostIds))
    return false;
  if (!all_within(m.segments_a, std::int16_t{0}, static_cast<std::int16_t>(m.n_segments - 1))) return false;
  const std::int64_t measurements = sum(m.poses) - m.n_segments + m.n_loops;
  const bool noise_fits = m.n_covariances > 0 || m.n_gravity > 0
                              ? m.n_precisions == 0 && m.n_covariances == kCovarianceFloats * measurements &&
                                    m.n_gravity == kGravityFloats * sum(m.poses)
                              : m.n_precisions == 2 || m.n_precisions == 2 * measurements;
  return noise_fits && m.n_values == floats_per_pose(m.dimension) * measurements &&
         all_within(m.values, -kFarthest, kFarthest) && all_within(m.precisions, 1e-16F, kLargestPrecision) &&
         all_within(m.covariances, -kLargestCovariance, kLargestCovariance) &&
         all_within(m.gravity, -10.0F, 10.0F);
}

bool values_are_good(const dpgo_poses_t& m) {
  if (m.dimension != 2 && m.dimension != 3) return false;
  return all_within(m.poses, 0, kMostIds) && m.n_values == floats_per_pose(m.dimension) * sum(m.poses) &&
         all_within(m.values, -kFarthest, kFarthest) && all_within(m.loops, 0, kMostIds) &&
         m.n_kept == (sum(m.loops) + 7) / 8 &&
         all_within(m.residuals_sq, 0.0F, std::numeric_limits<float>::infinity());
}

}  // namespace covey::pgo
