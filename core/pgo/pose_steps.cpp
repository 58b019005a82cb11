// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/pose_steps.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/pgo/bit_code.h"

namespace covey::pgo {
namespace {

constexpr double kLargestRotationUnit = 1.0;
constexpr double kLargestTranslationUnit = 1e4;
constexpr double kSmallestUnit = 1e-10;  // rad, m: below any measure
constexpr double kFarthestM = 1e8;
constexpr int kParameterBits = 5;
constexpr int kNotCoded = 31;  // parameter of a component that is zero for all

struct Step {
  Eigen::Vector3d phi = Eigen::Vector3d::Zero();    // Gibbs' vector times 2
  Eigen::Vector3d delta = Eigen::Vector3d::Zero();  // m
};
using Numbers = std::array<std::int32_t, 6>;

Step step_between(const SE3& from, const SE3& to) {
  const Eigen::Quaterniond q = (to.rotation * from.rotation.inverse()).canonical_quaternion();
  return {2.0 / std::max(q.w(), 1e-3) * q.vec(), to.translation - from.translation};
}

// By +, *, / and roots alone, which are the same on every machine.
SE3 moved_by(const Step& step, const SE3& pose) {
  const Eigen::Quaterniond q(1.0, 0.5 * step.phi.x(), 0.5 * step.phi.y(), 0.5 * step.phi.z());
  return {SO3::from_quaternion(q) * pose.rotation, pose.translation + step.delta};
}

// The step of a keyframe if it moved with the one before it as one rigid body.
class Prediction {
 public:
  Step at(const Eigen::Vector3d& t) const { return {last_.phi, last_.delta + last_.phi.cross(t - t_)}; }
  void take(const Step& step, const Eigen::Vector3d& t) {
    last_ = step;
    t_ = t;
  }

 private:
  Step last_;
  Eigen::Vector3d t_ = Eigen::Vector3d::Zero();
};

struct Units {
  double rotation;
  double translation;

  Numbers numbers(const Step& step, const Step& foretold) const {
    Numbers result{};
    for (int c = 0; c < 3; ++c) {
      result[c] = in_units(step.phi[c] - foretold.phi[c], rotation);
      result[c + 3] = in_units(step.delta[c] - foretold.delta[c], translation);
    }
    return result;
  }
  Step step(const Numbers& numbers, const Step& foretold) const {
    Step result = foretold;
    for (int c = 0; c < 3; ++c) {
      result.phi[c] += rotation * numbers[c];
      result.delta[c] += translation * numbers[c + 3];
    }
    return result;
  }
  static std::int32_t in_units(double value, double unit) {
    return static_cast<std::int32_t>(
        std::clamp<double>(std::round(value / unit), -kLargestCoded, kLargestCoded));
  }
};

float unit_of(double mean_square, double resolution, double largest) {
  return static_cast<float>(std::clamp(std::sqrt(mean_square) / resolution, kSmallestUnit, 0.5 * largest));
}

}  // namespace

void encode_steps(const std::vector<SE3>& sent, const std::vector<SE3>& wanted,
                  const std::vector<bool>& chosen, double resolution, dpgo_step_t& message) {
  COVEY_CHECK(wanted.size() == sent.size() && chosen.size() == sent.size());
  std::vector<Step> steps;
  std::vector<int> which;
  double rotation_sq = 0.0;
  double translation_sq = 0.0;
  for (std::size_t k = 0; k < sent.size(); ++k) {
    if (!chosen[k]) continue;
    which.push_back(static_cast<int>(k));
    steps.push_back(step_between(sent[k], wanted[k]));
    rotation_sq += steps.back().phi.squaredNorm();
    translation_sq += steps.back().delta.squaredNorm();
  }
  const double n = std::max<double>(1.0, static_cast<double>(steps.size()));
  message.rotation_unit = unit_of(rotation_sq / n, resolution, kLargestRotationUnit);
  message.translation_unit = unit_of(translation_sq / n, resolution, kLargestTranslationUnit);
  const Units units{message.rotation_unit, message.translation_unit};

  std::array<std::vector<std::int32_t>, 6> numbers;
  Prediction prediction;
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const Eigen::Vector3d& t = sent[which[i]].translation;
    const Step foretold = prediction.at(t);
    const Numbers of_step = units.numbers(steps[i], foretold);
    for (int c = 0; c < 6; ++c) numbers[c].push_back(of_step[c]);
    prediction.take(units.step(of_step, foretold), t);
  }
  BitWriter writer;
  std::array<int, 6> parameters{};
  for (int c = 0; c < 6; ++c) {
    const bool zero = std::all_of(numbers[c].begin(), numbers[c].end(), [](int v) { return v == 0; });
    parameters[c] = zero ? kNotCoded : best_rice(numbers[c]);
    writer.put(static_cast<std::uint32_t>(parameters[c]), kParameterBits);
  }
  const bool all = which.size() == sent.size();
  writer.put(all ? 1 : 0, 1);
  std::size_t i = 0;
  for (const bool is_chosen : chosen) {
    if (!all) writer.put(is_chosen ? 1 : 0, 1);
    if (!is_chosen) continue;
    for (int c = 0; c < 6; ++c) {
      if (parameters[c] != kNotCoded) writer.put_rice(numbers[c][i], parameters[c]);
    }
    ++i;
  }
  message.code = writer.bytes();
  message.n = static_cast<std::int32_t>(message.code.size());
}

bool add_steps(const dpgo_step_t& message, std::vector<SE3>& poses) {
  if (message.code.empty()) return true;
  BitReader reader(message.code);
  std::array<int, 6> parameters{};
  for (int& parameter : parameters) {
    parameter = static_cast<int>(reader.get(kParameterBits));
    if (parameter > kLargestRice && parameter != kNotCoded) return false;
  }
  const bool all = reader.get(1) == 1;
  const Units units{message.rotation_unit, message.translation_unit};
  std::vector<SE3> moved = poses;
  Prediction prediction;
  for (SE3& pose : moved) {
    if (!all && reader.get(1) == 0) continue;
    Numbers numbers{};
    for (int c = 0; c < 6; ++c) {
      if (parameters[c] != kNotCoded) numbers[c] = reader.get_rice(parameters[c]);
    }
    const Step step = units.step(numbers, prediction.at(pose.translation));
    prediction.take(step, pose.translation);
    pose = moved_by(step, pose);
    if (!(pose.translation.cwiseAbs().maxCoeff() < kFarthestM)) return false;
  }
  if (!reader.ended_well()) return false;
  poses = std::move(moved);
  return true;
}

}  // namespace covey::pgo
