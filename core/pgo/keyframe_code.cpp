// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/keyframe_code.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/pgo/range_code.h"

namespace covey::pgo {
namespace {

constexpr int kMostKeyframes = 200'000;
constexpr int kMostSegments = 1 << 20;
constexpr int kMostIds = 1 << 28;
constexpr double kFarthestKeyframeM = 1e8;
constexpr double kSmallestKeyframeUnit = 2.0 / kLargestCoded;  // rad; m where the next keyframe is within 2 m

struct Models {
  NumberModel segment;
  NumberModel id;
  NumberModel largest;  // component of the quaternion
  std::array<NumberModel, 6> motion;
};

std::int32_t whole(double value, double unit) {
  return static_cast<std::int32_t>(
      std::clamp<double>(std::round(value / unit), -kLargestCoded, kLargestCoded));
}

struct Motion {  // from one keyframe to the next, in units
  int largest = 3;
  std::array<std::int32_t, 6> numbers{};
};

// Components in the order x, y, z, w.
Motion in_units(const SE3& T, const PoseUnits& units) {
  Motion motion;
  Eigen::Vector4d q = T.rotation.quaternion().coeffs();
  q.cwiseAbs().maxCoeff(&motion.largest);
  if (q[motion.largest] < 0.0) q = -q;
  for (int c = 0; c < 3; ++c) {
    motion.numbers[c] = whole(q[(motion.largest + 1 + c) % 4], 0.5 * units.rotation);
    motion.numbers[c + 3] = whole(T.translation[c], units.translation);
  }
  return motion;
}

SE3 from_units(const Motion& motion, const PoseUnits& units) {
  Eigen::Vector4d q = Eigen::Vector4d::Zero();
  SE3 T;
  for (int c = 0; c < 3; ++c) {
    q[(motion.largest + 1 + c) % 4] = 0.5 * units.rotation * motion.numbers[c];
    T.translation[c] = units.translation * motion.numbers[c + 3];
  }
  q[motion.largest] = std::sqrt(std::max(1e-6, 1.0 - q.squaredNorm()));
  T.rotation = SO3::from_quaternion(Eigen::Quaterniond(q));
  return T;
}

// The finest that can say the longest way from one keyframe to the next.
double smallest_translation_unit(const std::vector<PublicKeyframe>& keyframes) {
  double farthest = keyframes.front().T_S_K.translation.norm();
  for (std::size_t k = 1; k < keyframes.size(); ++k) {
    farthest =
        std::max(farthest, (keyframes[k].T_S_K.translation - keyframes[k - 1].T_S_K.translation).norm());
  }
  return (1.0 + farthest) * kSmallestKeyframeUnit;
}

}  // namespace

void encode_keyframes(const std::vector<PublicKeyframe>& keyframes, const PoseUnits& units,
                      dpgo_keyframes_t& message) {
  COVEY_CHECK(!keyframes.empty() && keyframes.size() <= kMostKeyframes);
  message.rotation_unit = static_cast<float>(std::clamp(units.rotation, kSmallestKeyframeUnit, 0.5));
  message.translation_unit =
      static_cast<float>(std::max(units.translation, smallest_translation_unit(keyframes)));
  const PoseUnits rounded{message.rotation_unit, message.translation_unit};
  RangeWriter writer;
  Models models;
  NumberModel count;
  writer.put(static_cast<std::int32_t>(keyframes.size()), count);
  PublicKeyframe before;
  for (const PublicKeyframe& keyframe : keyframes) {
    writer.put(keyframe.segment - before.segment, models.segment);
    writer.put(keyframe.id - (keyframe.segment == before.segment ? before.id : 0), models.id);
    const Motion motion = in_units(before.T_S_K.inverse() * keyframe.T_S_K, rounded);
    writer.put(motion.largest, models.largest);
    for (int c = 0; c < 6; ++c) writer.put(motion.numbers[c], models.motion[c]);
    before = {keyframe.segment, keyframe.id, before.T_S_K * from_units(motion, rounded)};
  }
  message.code = writer.finish();
  message.n = static_cast<std::int32_t>(message.code.size());
}

std::optional<std::vector<PublicKeyframe>> decode_keyframes(const dpgo_keyframes_t& message) {
  const PoseUnits units{message.rotation_unit, message.translation_unit};
  RangeReader reader(message.code);
  Models models;
  NumberModel counted;
  const int count = reader.get(counted);
  if (count <= 0 || count > kMostKeyframes) return std::nullopt;
  std::vector<PublicKeyframe> keyframes;
  PublicKeyframe before;
  for (int k = 0; k < count; ++k) {
    PublicKeyframe keyframe;
    keyframe.segment = before.segment + reader.get(models.segment);
    keyframe.id = reader.get(models.id) + (keyframe.segment == before.segment ? before.id : 0);
    Motion motion;
    motion.largest = reader.get(models.largest);
    if (motion.largest < 0 || motion.largest > 3) return std::nullopt;
    for (int c = 0; c < 6; ++c) motion.numbers[c] = reader.get(models.motion[c]);
    keyframe.T_S_K = before.T_S_K * from_units(motion, units);
    const bool ascending =
        k == 0 ? keyframe.segment >= 0 && keyframe.id >= 0
               : std::pair(keyframe.segment, keyframe.id) > std::pair(before.segment, before.id);
    if (!ascending || keyframe.segment > kMostSegments || keyframe.id < 0 || keyframe.id > kMostIds ||
        !(keyframe.T_S_K.translation.cwiseAbs().maxCoeff() < kFarthestKeyframeM)) {
      return std::nullopt;
    }
    keyframes.push_back(keyframe);
    before = keyframe;
  }
  if (!reader.ended_well()) return std::nullopt;
  return keyframes;
}

}  // namespace covey::pgo
