// SPDX-License-Identifier: BSD-3-Clause
#include "core/sim/drive.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <random>

#include "core/base/angle.h"
#include "core/sim/spline.h"

namespace covey::sim {
namespace {

using Vector = Eigen::Matrix<double, 6, 1>;  // x y z roll pitch yaw
using Spline = UniformSpline<6>;

constexpr Utime kSpacingUs = 50'000;
constexpr double kStepM = 0.05;  // between the samples of a rounded path

struct PathSample {
  Eigen::Vector3d p_W;
  double yaw = 0.0;  // continuous along the path
};

std::vector<Eigen::Vector3d> sample_polyline(const std::vector<Eigen::Vector3d>& corners) {
  std::vector<Eigen::Vector3d> samples;
  double next = 0.0;  // arc length of the next sample
  double done = 0.0;
  for (std::size_t k = 0; k + 1 < corners.size(); ++k) {
    const double length = (corners[k + 1] - corners[k]).norm();
    COVEY_CHECK(length > 0.0);
    for (; next <= done + length; next += kStepM) {
      samples.emplace_back(corners[k] + (next - done) / length * (corners[k + 1] - corners[k]));
    }
    done += length;
  }
  return samples;
}

// The mean over `window` samples around each; beyond its ends the path goes on straight, so that the ends stay where they are.
std::vector<Eigen::Vector3d> box_filter(const std::vector<Eigen::Vector3d>& samples, int window) {
  const int n = static_cast<int>(samples.size());
  const int half = window / 2;
  const auto sample = [&](int k) -> Eigen::Vector3d {
    if (k < 0) return samples[0] + k * (samples[1] - samples[0]);
    if (k >= n) return samples[n - 1] + (k - n + 1) * (samples[n - 1] - samples[n - 2]);
    return samples[k];
  };
  std::vector<Eigen::Vector3d> filtered;
  filtered.reserve(samples.size());
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (int k = -half; k <= half; ++k) sum += sample(k);
  for (int k = 0; k < n; ++k) {
    filtered.emplace_back(sum / (2 * half + 1));
    sum += sample(k + half + 1) - sample(k - half);
  }
  return filtered;
}

std::vector<PathSample> rounded(const std::vector<Eigen::Vector3d>& corners, double corner_m) {
  std::vector<Eigen::Vector3d> samples = sample_polyline(corners);
  COVEY_CHECK(samples.size() >= 2);
  for (int pass = 0; pass < 3; ++pass)
    samples = box_filter(samples, static_cast<int>(std::lround(corner_m / kStepM)));
  std::vector<PathSample> path;
  path.reserve(samples.size());
  for (std::size_t k = 0; k < samples.size(); ++k) {
    const std::size_t before = k == 0 ? 0 : k - 1;
    const std::size_t after = std::min(k + 1, samples.size() - 1);
    const Eigen::Vector3d ahead = samples[after] - samples[before];
    double yaw = std::atan2(ahead.y(), ahead.x());
    if (k > 0) yaw = path[k - 1].yaw + std::remainder(yaw - path[k - 1].yaw, 2.0 * M_PI);
    path.push_back({samples[k], yaw});
  }
  return path;
}

PathSample at_length(const std::vector<PathSample>& path, double length) {
  const double index = length / kStepM;
  const auto k = static_cast<std::size_t>(index);
  COVEY_CHECK(k + 1 < path.size());
  const double s = index - static_cast<double>(k);
  return {path[k].p_W + s * (path[k + 1].p_W - path[k].p_W),
          path[k].yaw + s * (path[k + 1].yaw - path[k].yaw)};
}

// A random walk that is pulled back to zero: standard deviation 1, correlation time `correlation_s`.
class Play {
 public:
  Play(double correlation_s, std::mt19937_64& random)
      : keep_(std::exp(-to_seconds(kSpacingUs) / correlation_s)), random_(random) {}
  double next() {
    value_ = keep_ * value_ + std::sqrt(1.0 - keep_ * keep_) * normal_(random_);
    return value_;
  }

 private:
  double keep_;
  double value_ = 0.0;
  std::normal_distribution<double> normal_;
  std::mt19937_64& random_;
};

std::vector<Vector> control_points(const std::vector<PathSample>& path, const DriveOptions& options, int n,
                                   std::uint64_t seed) {
  std::mt19937_64 random(seed);
  Play bounce(options.suspension_s, random);
  Play roll(options.suspension_s, random);
  Play pitch(options.suspension_s, random);
  std::vector<Vector> control;
  control.reserve(n);
  for (int k = 0; k < n; ++k) {
    const double t = (k - 2) * to_seconds(kSpacingUs);
    const PathSample sample = at_length(path, driven_length(options, t));
    const double rolling =
        (driven_length(options, t + 0.1) - driven_length(options, t - 0.1)) / 0.2 / options.speed;
    const double sway = rolling * options.sway_deg * kDegree;
    Vector point;
    point << sample.p_W, sway * roll.next(), sway * pitch.next(), sample.yaw;
    point.z() += options.body_height_m + rolling * options.bounce_m * bounce.next();
    control.push_back(point);
  }
  return control;
}

MotionState to_state(const Spline::Sample& sample) {
  const double roll = sample.value[3];
  const double pitch = sample.value[4];
  MotionState state;
  state.T_W_B = {
      SO3::exp({0.0, 0.0, sample.value[5]}) * SO3::exp({0.0, pitch, 0.0}) * SO3::exp({roll, 0.0, 0.0}),
      sample.value.head<3>()};
  state.v_W = sample.rate.head<3>();
  state.a_W = sample.acceleration.head<3>();
  // omega_B = x roll' + Rx^T (y pitch' + Ry^T z yaw')
  const double roll_rate = sample.rate[3];
  const double pitch_rate = sample.rate[4];
  const double yaw_rate = sample.rate[5];
  state.omega_B = {roll_rate - yaw_rate * std::sin(pitch),
                   pitch_rate * std::cos(roll) + yaw_rate * std::cos(pitch) * std::sin(roll),
                   yaw_rate * std::cos(pitch) * std::cos(roll) - pitch_rate * std::sin(roll)};
  return state;
}

}  // namespace

double driven_length(const DriveOptions& options, double seconds) {
  const double rolling = std::max(0.0, seconds - options.stand_s);
  const double ramp = options.speed / options.acceleration;
  if (rolling < ramp) return 0.5 * options.acceleration * rolling * rolling;
  return options.speed * (rolling - 0.5 * ramp);
}

Motion drive(const std::vector<Eigen::Vector3d>& path, const DriveOptions& options, Utime begin,
             double seconds, std::uint64_t seed) {
  const Utime duration = from_seconds(seconds);
  const int n = static_cast<int>((duration + kSpacingUs - 1) / kSpacingUs) + 6;
  const auto spline = std::make_shared<const Spline>(
      begin, kSpacingUs, control_points(rounded(path, options.corner_m), options, n, seed));
  return {begin, begin + duration, [spline](Utime utime) { return to_state(spline->at(utime)); }};
}

}  // namespace covey::sim
