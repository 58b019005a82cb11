// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/lcd_messages.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>

namespace covey::place {
namespace {

constexpr double kFarthestM = 1e6;
constexpr double kUnitTolerance = 0.01;

constexpr std::int32_t kMostId = 1'000'000'000;  // there are ids before and after it

bool is_id(std::int32_t id) { return id >= 0 && id <= kMostId; }

bool is_unit(double norm) { return std::abs(norm - 1.0) < kUnitTolerance; }

bool is_bearing(const Eigen::Vector3f& bearing) { return is_unit(bearing.norm()) && bearing.z() > 0.01F; }

bool is_depth(float depth) { return depth >= 0.0F && depth < 1e4F; }

}  // namespace

lcd_words_t words_message(const KeyframeName& name, Utime utime, const BagOfWords& bag,
                          std::uint64_t vocabulary) {
  lcd_words_t message{};
  message.utime = utime;
  message.from = name.robot;
  message.to = -1;
  message.vocabulary = static_cast<std::int64_t>(vocabulary);
  message.segment = name.segment;
  message.id = name.id;
  message.words = bag.words;
  message.weights = bag.weights;
  message.n = static_cast<std::int32_t>(bag.words.size());
  return message;
}

std::optional<BagOfWords> bag_from(const lcd_words_t& message, int words) {
  if (message.n <= 0 || message.n > words || !is_id(message.id) || message.utime < 0) return std::nullopt;
  double sum = 0.0;
  std::int32_t least = 0;
  for (std::size_t k = 0; k < message.words.size(); ++k) {
    if (message.words[k] < least || message.words[k] >= words) return std::nullopt;
    least = message.words[k] + 1;
    if (!(message.weights[k] > 0.0F && message.weights[k] <= 1.01F)) return std::nullopt;
    sum += static_cast<double>(message.weights[k]);
  }
  if (!is_unit(sum)) return std::nullopt;
  return BagOfWords{message.words, message.weights};
}

lcd_features_t features_message(const KeyframeName& name, Utime utime, int to,
                                const FrameFeatures& features) {
  lcd_features_t message{};
  message.utime = utime;
  message.from = name.robot;
  message.to = to;
  message.segment = name.segment;
  message.id = name.id;
  message.n = static_cast<std::int32_t>(features.size());
  message.n_values = 3 * message.n;
  for (const Eigen::Vector3f& bearing : features.bearings_C) {
    message.bearings.insert(message.bearings.end(), bearing.data(), bearing.data() + 3);
  }
  message.depths = features.depths_m;
  message.n_bytes = static_cast<std::int32_t>(kDescriptorBytes) * message.n;
  message.descriptors.resize(static_cast<std::size_t>(message.n_bytes));
  if (message.n > 0) {
    std::memcpy(message.descriptors.data(), features.descriptors.data(), message.descriptors.size());
  }
  const Eigen::Quaterniond q = features.T_B_C.rotation.canonical_quaternion();
  const Eigen::Vector3d& t = features.T_B_C.translation;
  const double values[7] = {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()};
  std::transform(std::begin(values), std::end(values), message.T_B_C,
                 [](double value) { return static_cast<float>(value); });
  return message;
}

std::optional<FrameFeatures> features_from(const lcd_features_t& message) {
  if (message.n < 0 || message.n > kMostFeatures || message.n_values != 3 * message.n ||
      message.n_bytes != static_cast<std::int32_t>(kDescriptorBytes) * message.n || !is_id(message.id)) {
    return std::nullopt;
  }
  FrameFeatures features;
  for (std::size_t k = 0; k < static_cast<std::size_t>(message.n); ++k) {
    features.bearings_C.emplace_back(message.bearings[3 * k], message.bearings[3 * k + 1],
                                     message.bearings[3 * k + 2]);
    features.descriptors.push_back(descriptor_from(message.descriptors.data() + kDescriptorBytes * k));
    if (!is_bearing(features.bearings_C.back()) || !is_depth(message.depths[k])) return std::nullopt;
  }
  features.depths_m = message.depths;
  const float* T = message.T_B_C;
  const Eigen::Quaterniond q(T[0], T[1], T[2], T[3]);
  const Eigen::Vector3d t(T[4], T[5], T[6]);
  if (!is_unit(q.norm()) || !(t.norm() < 100.0)) return std::nullopt;
  features.T_B_C = {SO3::from_quaternion(q), t};
  return features;
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
