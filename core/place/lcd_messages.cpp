// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/lcd_messages.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "core/place/point_code.h"
#include "core/place/word_code.h"

namespace covey::place {
namespace {

constexpr double kFarthestM = 1e6;
constexpr double kUnitTolerance = 0.01;

bool is_id(std::int32_t id) { return id >= 0 && id <= kMostId; }

bool is_unit(double norm) { return std::abs(norm - 1.0) < kUnitTolerance; }

// Of a direction or an inverse depth.
bool is_sigma(float sigma) { return sigma >= 1e-6F && sigma <= 1.0F; }

}  // namespace

lcd_bag_t bag_message(const KeyframeName& name, Utime utime, const WordCounts& counts,
                      std::uint64_t vocabulary) {
  lcd_bag_t message{};
  message.utime = utime;
  message.from = name.robot;
  message.to = -1;
  message.vocabulary = static_cast<std::int64_t>(vocabulary);
  message.segment = name.segment;
  message.id = name.id;
  message.n = static_cast<std::int32_t>(counts.words.size());
  message.code = encode_words(counts);
  message.n_code = static_cast<std::int32_t>(message.code.size());
  return message;
}

const char* read_bag(const lcd_bag_t& message, int words, WordCounts& counts) {
  if (!is_id(message.id)) return "id";
  if (message.utime < 0) return "utime";
  return decode_words(message.code, message.n, words, kMostFeatures, counts);
}

lcd_frame_t frame_message(const KeyframeName& name, Utime utime, int to, const FrameFeatures& features) {
  lcd_frame_t message{};
  message.utime = utime;
  message.from = name.robot;
  message.to = to;
  message.segment = name.segment;
  message.id = name.id;
  const Eigen::Quaterniond q = features.T_B_C.rotation.canonical_quaternion();
  const Eigen::Vector3d& t = features.T_B_C.translation;
  const double values[7] = {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()};
  std::transform(std::begin(values), std::end(values), message.T_B_C,
                 [](double value) { return static_cast<float>(value); });
  message.direction_sigma = static_cast<float>(features.noise.direction);
  message.inverse_depth_sigma = static_cast<float>(features.noise.inverse_depth);
  message.n = static_cast<std::int32_t>(features.size());
  message.n_bytes = static_cast<std::int32_t>(kDescriptorBytes) * message.n;
  message.descriptors.resize(static_cast<std::size_t>(message.n_bytes));
  if (message.n > 0) {
    std::memcpy(message.descriptors.data(), features.descriptors.data(), message.descriptors.size());
  }
  message.code = encode_points(features);
  message.n_code = static_cast<std::int32_t>(message.code.size());
  return message;
}

const char* read_frame(const lcd_frame_t& message, FrameFeatures& features) {
  if (!is_id(message.id)) return "id";
  if (message.n < 0 || message.n > kMostFeatures ||
      message.n_bytes != static_cast<std::int32_t>(kDescriptorBytes) * message.n) {
    return "size";
  }
  if (!is_sigma(message.direction_sigma) || !is_sigma(message.inverse_depth_sigma)) return "noise";
  const float* T = message.T_B_C;
  const Eigen::Quaterniond q(T[0], T[1], T[2], T[3]);
  const Eigen::Vector3d t(T[4], T[5], T[6]);
  if (!is_unit(q.norm()) || !(t.norm() < 100.0)) return "camera";
  FrameFeatures read;
  read.T_B_C = {SO3::from_quaternion(q), t};
  read.noise = {message.direction_sigma, message.inverse_depth_sigma};
  for (std::size_t k = 0; k < static_cast<std::size_t>(message.n); ++k) {
    read.descriptors.push_back(descriptor_from(message.descriptors.data() + kDescriptorBytes * k));
  }
  if (const char* reason = decode_points(message.code, message.n, read)) return reason;
  features = std::move(read);
  return nullptr;
}

lcd_inventory_t inventory_message(int robot, Utime utime, std::int64_t vocabulary,
                                  const Inventory& inventory) {
  lcd_inventory_t message{};
  message.utime = utime;
  message.from = robot;
  message.to = -1;
  message.vocabulary = vocabulary;
  message.whole = inventory.whole ? 1 : 0;
  message.n = static_cast<std::int32_t>(inventory.runs.size());
  for (const RunInventory& run : inventory.runs) {
    message.robots.push_back(static_cast<std::int16_t>(run.robot));
    message.segments.push_back(run.segment);
  }
  message.code = encode_ids(inventory.runs);
  message.n_code = static_cast<std::int32_t>(message.code.size());
  return message;
}

const char* read_inventory(const lcd_inventory_t& message, Inventory& inventory) {
  if (message.n < 0 || message.n > kMostRuns) return "size";
  Inventory read;
  read.whole = message.whole != 0;
  for (std::size_t k = 0; k < static_cast<std::size_t>(message.n); ++k) {
    if (!is_robot(message.robots[k])) return "robot";
    read.runs.push_back({.robot = message.robots[k], .segment = message.segments[k]});
  }
  if (const char* reason = decode_ids(message.code, read.runs)) return reason;
  inventory = std::move(read);
  return nullptr;
}

loop_t loop_message(const KeyframeName& a, const KeyframeName& b, const Verification& verification,
                    double similarity) {
  loop_t loop{};
  loop.robot_a = a.robot;
  loop.segment_a = a.segment;
  loop.id_a = a.id;
  loop.robot_b = b.robot;
  loop.segment_b = b.segment;
  loop.id_b = b.id;
  const Eigen::Quaterniond q = verification.T_A_B.rotation.canonical_quaternion();
  const double values[4] = {q.w(), q.x(), q.y(), q.z()};
  std::copy(std::begin(values), std::end(values), loop.q_A_B);
  std::copy_n(verification.T_A_B.translation.data(), 3, loop.t_A_B);
  const Matrix6d symmetric = 0.5 * (verification.covariance + verification.covariance.transpose());
  std::copy_n(symmetric.data(), 36, loop.covariance);
  loop.similarity = std::clamp(similarity, 0.0, 1.0);
  loop.matches = verification.matches;
  loop.inliers = verification.inliers;
  return loop;
}

bool is_good(const loop_t& loop) {
  if (!is_id(loop.id_a) || !is_id(loop.id_b)) return false;
  const Eigen::Map<const Eigen::Vector4d> q(loop.q_A_B);
  const Eigen::Map<const Eigen::Vector3d> t(loop.t_A_B);
  const Eigen::Map<const Matrix6d> covariance(loop.covariance);
  return is_unit(q.norm()) && t.norm() < kFarthestM && covariance.allFinite() &&
         (covariance.diagonal().array() > 0.0).all() && loop.similarity >= 0.0 && loop.similarity <= 1.0;
}

bool is_same_closure(const loop_t& a, const loop_t& b) {
  return a.robot_a == b.robot_a && a.segment_a == b.segment_a && a.id_a == b.id_a && a.robot_b == b.robot_b &&
         a.segment_b == b.segment_b && a.id_b == b.id_b && std::equal(a.q_A_B, a.q_A_B + 4, b.q_A_B) &&
         std::equal(a.t_A_B, a.t_A_B + 3, b.t_A_B) &&
         std::equal(a.covariance, a.covariance + 36, b.covariance);
}

}  // namespace covey::place
