// SPDX-License-Identifier: BSD-3-Clause
#include "core/pgo/pose_steps.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "core/base/error.h"

namespace covey::pgo {
namespace {

constexpr int kLargestRotationUnit = -1;     // log2 of rad
constexpr int kLargestTranslationUnit = 12;  // log2 of m
constexpr int kSmallestUnit = -33;           // of either: below any measure
constexpr double kFarthestM = 1e8;

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

Numbers in_units(const PoseUnits& units, const Step& step, const Step& foretold) {
  const auto whole = [](double value, double unit) {
    return static_cast<std::int32_t>(
        std::clamp<double>(std::round(value / unit), -kLargestCoded, kLargestCoded));
  };
  Numbers numbers{};
  for (int c = 0; c < 3; ++c) {
    numbers[c] = whole(step.phi[c] - foretold.phi[c], units.rotation);
    numbers[c + 3] = whole(step.delta[c] - foretold.delta[c], units.translation);
  }
  return numbers;
}

Step from_units(const PoseUnits& units, const Numbers& numbers, const Step& foretold) {
  Step step = foretold;
  for (int c = 0; c < 3; ++c) {
    step.phi[c] += units.rotation * numbers[c];
    step.delta[c] += units.translation * numbers[c + 3];
  }
  return step;
}

// One keyframe, between two whose steps are known already.
struct Visit {
  int place = 0;
  int before = -1;  // -1: none
  int after = -1;
  int level = 0;  // of how far apart these two are
};

std::vector<Visit> visits(int count, int levels) {
  std::vector<Visit> order;
  if (count > 0) order.push_back({});
  if (count > 1) order.push_back({count - 1, 0});
  std::vector<std::pair<int, int>> spans{{0, count - 1}};
  for (std::size_t s = 0; s < spans.size(); ++s) {
    const auto [first, last] = spans[s];
    if (last - first < 2) continue;
    const int middle = first + (last - first) / 2;
    const int level = std::bit_width(static_cast<unsigned>(last - first)) - 1;
    order.push_back({middle, first, last, std::min(level, levels - 1)});
    spans.emplace_back(first, middle);
    spans.emplace_back(middle, last);
  }
  return order;
}

// What the steps that are known say of the next one.
class Foretelling {
 public:
  // Of the chosen keyframes.
  Foretelling(std::vector<Eigen::Vector3d> positions, std::vector<double> along)
      : positions_(std::move(positions)), along_(std::move(along)), steps_(positions_.size()) {}

  Step at(const Visit& visit) const {
    if (visit.before < 0) return {};
    const Step first = moving_with(visit.before, visit.place);
    if (visit.after < 0) return first;
    const Step second = moving_with(visit.after, visit.place);
    const double length = along_[visit.after] - along_[visit.before];
    const double part = length > 0.0 ? (along_[visit.place] - along_[visit.before]) / length : 0.5;
    return {first.phi + part * (second.phi - first.phi), first.delta + part * (second.delta - first.delta)};
  }
  void take(const Visit& visit, const Step& step) { steps_[visit.place] = step; }

 private:
  Step moving_with(int neighbour, int place) const {
    const Step& step = steps_[neighbour];
    return {step.phi, step.delta + step.phi.cross(positions_[place] - positions_[neighbour])};
  }

  std::vector<Eigen::Vector3d> positions_;
  std::vector<double> along_;
  std::vector<Step> steps_;
};

Foretelling foretelling(const std::vector<int>& chosen, const std::vector<SE3>& expected,
                        const std::vector<double>& along) {
  std::vector<Eigen::Vector3d> positions;
  std::vector<double> places;
  for (const int k : chosen) {
    positions.push_back(expected[k].translation);
    places.push_back(along[k]);
  }
  return {std::move(positions), std::move(places)};
}

std::int8_t unit_within(double unit, int largest) {
  const double digits = unit > 0.0 ? std::round(std::log2(unit)) : kSmallestUnit;
  return static_cast<std::int8_t>(std::clamp<double>(digits, kSmallestUnit, largest));
}

PoseUnits units_in(const dpgo_advance_t& message) {
  return {std::ldexp(1.0, message.rotation_unit), std::ldexp(1.0, message.translation_unit)};
}

}  // namespace

StepCode::StepCode(std::vector<double> along) : along_(std::move(along)), chosen_(along_.size(), true) {}

void StepCode::encode(const std::vector<SE3>& expected, const std::vector<SE3>& wanted,
                      const std::vector<bool>& chosen, const PoseUnits& units,
                      dpgo_advance_t& message) const {
  COVEY_CHECK(expected.size() == along_.size() && wanted.size() == along_.size() &&
              chosen.size() == along_.size());
  message.rotation_unit = unit_within(units.rotation, kLargestRotationUnit);
  message.translation_unit = unit_within(units.translation, kLargestTranslationUnit);
  const PoseUnits rounded = units_in(message);
  RangeWriter writer;
  Models models = models_;
  std::vector<int> which;
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    writer.put(chosen[k], models.chosen[chosen_[k] ? 1 : 0]);
    if (chosen[k]) which.push_back(static_cast<int>(k));
  }
  Foretelling known = foretelling(which, expected, along_);
  for (const Visit& visit : visits(static_cast<int>(which.size()), kLevels)) {
    const Step foretold = known.at(visit);
    const int k = which[visit.place];
    const Numbers numbers = in_units(rounded, step_between(expected[k], wanted[k]), foretold);
    for (int c = 0; c < 6; ++c) writer.put(numbers[c], models.numbers[c][visit.level]);
    known.take(visit, from_units(rounded, numbers, foretold));
  }
  message.code = writer.finish();
  message.n = static_cast<std::int32_t>(message.code.size());
}

bool StepCode::add(const dpgo_advance_t& message, const std::vector<SE3>& expected, std::vector<SE3>& poses) {
  if (message.code.empty()) return true;
  const PoseUnits units = units_in(message);
  RangeReader reader(message.code);
  Models models = models_;
  std::vector<bool> chosen(along_.size());
  std::vector<int> which;
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    chosen[k] = reader.get(models.chosen[chosen_[k] ? 1 : 0]);
    if (chosen[k]) which.push_back(static_cast<int>(k));
  }
  std::vector<SE3> moved = poses;
  Foretelling known = foretelling(which, expected, along_);
  for (const Visit& visit : visits(static_cast<int>(which.size()), kLevels)) {
    const Step foretold = known.at(visit);
    const int k = which[visit.place];
    Numbers numbers{};
    for (int c = 0; c < 6; ++c) numbers[c] = reader.get(models.numbers[c][visit.level]);
    const Step step = from_units(units, numbers, foretold);
    known.take(visit, step);
    moved[k] = moved_by(step, expected[k]);
    if (!(moved[k].translation.cwiseAbs().maxCoeff() < kFarthestM)) return false;
  }
  if (!reader.ended_well()) return false;
  poses = std::move(moved);
  models_ = models;
  chosen_ = std::move(chosen);
  return true;
}

}  // namespace covey::pgo
