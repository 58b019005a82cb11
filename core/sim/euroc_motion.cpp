// SPDX-License-Identifier: BSD-3-Clause
#include "core/sim/euroc_motion.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include "core/base/angle.h"
#include "core/base/error.h"
#include "core/graph/solve.h"
#include "core/imu/imu_factor.h"

namespace covey::sim {
namespace {

constexpr graph::Key kTilt{'t', 0};

graph::Key pose_key(std::size_t node) { return {'x', node}; }
graph::Key velocity_key(std::size_t node) { return {'v', node}; }
graph::Key bias_key(std::size_t node) { return {'b', node}; }

SO3 tilt_rotation(const Eigen::Vector2d& tilt) { return SO3::exp({tilt.x(), tilt.y(), 0.0}); }

Eigen::Matrix<double, 3, 2> tilt_jacobian(const Eigen::Vector2d& tilt) {
  return SO3::right_jacobian({tilt.x(), tilt.y(), 0.0}).leftCols<2>();
}

// The ground truth between its samples; nothing where they are too far apart to tell.
std::optional<SE3> truth_at(const Trajectory& truth, Utime utime) {
  constexpr Utime kLongestGapUs = 60'000;
  const auto after = std::lower_bound(truth.begin(), truth.end(), utime,
                                      [](const StampedPose& pose, Utime t) { return pose.utime < t; });
  if (after == truth.end()) return std::nullopt;
  if (after->utime == utime) return after->pose;
  if (after == truth.begin()) return std::nullopt;
  const auto before = after - 1;
  if (after->utime - before->utime > kLongestGapUs) return std::nullopt;
  const double s =
      static_cast<double>(utime - before->utime) / static_cast<double>(after->utime - before->utime);
  const Eigen::Vector3d& p = before->pose.translation;
  return SE3{interpolate(before->pose.rotation, after->pose.rotation, s),
             p + s * (after->pose.translation - p)};
}

struct Step {
  Eigen::Vector3d p_W;
  Eigen::Vector3d v_W;
  SO3 R_W_B;
};

// One step of the midpoint rule from `first` to `second` (core/imu/preintegration.h), and the same backwards.
Step forwards(const Step& from, const ImuSample& first, const ImuSample& second, const ImuBias& bias) {
  const double dt = to_seconds(second.utime - first.utime);
  Step to;
  to.R_W_B = from.R_W_B * SO3::exp(dt * (0.5 * (first.gyro + second.gyro) - bias.gyro));
  const Eigen::Vector3d a = 0.5 * (from.R_W_B * Eigen::Vector3d(first.accel - bias.accel) +
                                   to.R_W_B * Eigen::Vector3d(second.accel - bias.accel)) +
                            kGravity;
  to.v_W = from.v_W + dt * a;
  to.p_W = from.p_W + dt * from.v_W + 0.5 * dt * dt * a;
  return to;
}

Step backwards(const Step& from, const ImuSample& first, const ImuSample& second, const ImuBias& bias) {
  const double dt = to_seconds(second.utime - first.utime);
  Step to;
  to.R_W_B = from.R_W_B * SO3::exp(-dt * (0.5 * (first.gyro + second.gyro) - bias.gyro));
  const Eigen::Vector3d a = 0.5 * (to.R_W_B * Eigen::Vector3d(first.accel - bias.accel) +
                                   from.R_W_B * Eigen::Vector3d(second.accel - bias.accel)) +
                            kGravity;
  to.v_W = from.v_W - dt * a;
  to.p_W = from.p_W - dt * from.v_W + 0.5 * dt * dt * a;
  return to;
}

// The least-squares problem over one stretch of samples.
class Smoother {
 public:
  Smoother(std::span<const ImuSample> samples, const Trajectory& truth, const EurocOptions& options)
      : samples_(samples), truth_(truth), options_(options) {
    for (std::size_t k = 0; k < samples.size(); k += options.stride) nodes_.push_back(k);
    if (nodes_.back() + 1 != samples.size()) nodes_.push_back(samples.size() - 1);
    start();
  }

  // The preintegrated samples are linear in the biases around the ones they were integrated with: after the first solution they are
  // integrated again with the biases found.
  void solve() {
    constexpr int kRounds = 3;
    for (int round = 0; round < kRounds; ++round) {
      const graph::SolveResult result =
          graph::solve(build(), values_,
                       {.max_iterations = 50, .relative_cost_tolerance = 1e-7, .initial_trust_radius = 1e4});
      iterations_ += result.iterations;
    }
  }

  const std::vector<std::size_t>& nodes() const { return nodes_; }
  int iterations() const { return iterations_; }
  Eigen::Vector2d tilt() const { return values_.get<graph::Vector<2>>(kTilt); }
  ImuBias bias(std::size_t node) const {
    return ImuBias::from_vector(values_.get<graph::Vector<6>>(bias_key(node)));
  }
  Step state(std::size_t node) const {
    const SE3 pose = values_.get<SE3>(pose_key(node));
    return {pose.translation, values_.get<graph::Vector<3>>(velocity_key(node)), pose.rotation};
  }

 private:
  SE3 nearest_truth(Utime utime) const {
    if (const auto pose = truth_at(truth_, utime)) return *pose;
    const auto after = std::lower_bound(truth_.begin(), truth_.end(), utime,
                                        [](const StampedPose& pose, Utime t) { return pose.utime < t; });
    return after == truth_.end() ? truth_.back().pose : after->pose;
  }

  void start() {
    constexpr Utime kReachUs = 100'000;  // a velocity over less would make much of a jump
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t n = 0; n < nodes_.size(); ++n) {
      const Utime utime = samples_[nodes_[n]].utime;
      const SE3 pose = nearest_truth(utime);
      const Eigen::Vector3d moved =
          nearest_truth(utime + kReachUs).translation - nearest_truth(utime - kReachUs).translation;
      values_.set(pose_key(n), pose);
      values_.set(velocity_key(n), graph::Vector<3>(moved / to_seconds(2 * kReachUs)));
      sum += pose.translation;
    }
    centre_ = sum / static_cast<double>(nodes_.size());
    const Vector6d bias = mean_bias();
    for (std::size_t n = 0; n < nodes_.size(); ++n) values_.set(bias_key(n), bias);
    values_.set(kTilt, graph::Vector<2>(Eigen::Vector2d::Zero()));
  }

  // Of the gyroscope: what it measures more than the ground truth's turns, over steps in which that cannot jump far.
  Vector6d mean_bias() const {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    int count = 0;
    for (std::size_t n = 0; n + 1 < nodes_.size(); ++n) {
      const auto stretch = samples_.subspan(nodes_[n], nodes_[n + 1] - nodes_[n] + 1);
      const Preintegration increment(options_.imu, {}, stretch);
      const SO3 turned = nearest_truth(stretch.front().utime).rotation.inverse() *
                         nearest_truth(stretch.back().utime).rotation;
      const Eigen::Vector3d excess =
          (turned.inverse() * increment.increment().dR).log() / increment.duration_s();
      if (excess.norm() > 0.5) continue;
      sum += excess;
      ++count;
    }
    Vector6d bias = Vector6d::Zero();
    if (count > 0) bias.head<3>() = sum / count;
    return bias;
  }

  graph::Graph build() const {
    graph::Graph graph;
    const auto position_noise = graph::Noise<3>::sigma(options_.position_sigma_m);
    const auto rotation_noise = graph::Noise<3>::sigma(options_.rotation_sigma_deg * kDegree);
    const graph::Robust robust = graph::Robust::huber(options_.robust_width);
    for (std::size_t n = 0; n < nodes_.size(); ++n) {
      if (const auto pose = truth_at(truth_, samples_[nodes_[n]].utime)) {
        graph.add(TiltedPosition{pose->translation, centre_}, {pose_key(n), kTilt}, position_noise, robust);
        graph.add(TiltedRotation{pose->rotation}, {pose_key(n), kTilt}, rotation_noise, robust);
      }
      if (n + 1 == nodes_.size()) break;
      const Preintegration increment(options_.imu, bias(n),
                                     samples_.subspan(nodes_[n], nodes_[n + 1] - nodes_[n] + 1));
      graph.add(ImuFactor{increment},
                {pose_key(n), velocity_key(n), bias_key(n), pose_key(n + 1), velocity_key(n + 1)},
                imu_noise(increment));
      graph.add(BiasWalk{}, {bias_key(n), bias_key(n + 1)},
                bias_walk_noise(options_.imu, increment.duration_s()));
    }
    return graph;
  }

  std::span<const ImuSample> samples_;
  const Trajectory& truth_;
  EurocOptions options_;
  std::vector<std::size_t> nodes_;  // indices of samples
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();
  graph::Values values_;
  int iterations_ = 0;
};

// From 0 to 1 over [0, 1], with zero first and second derivatives at both ends; and its first derivative.
double smooth_step(double u) { return u * u * u * (10.0 + u * (6.0 * u - 15.0)); }
double smooth_step_rate(double u) { return 30.0 * u * u * (1.0 - u) * (1.0 - u); }

// States at the samples from one node to the next, without the last.
void append_states(const Smoother& smoother, std::size_t node, std::span<const ImuSample> samples,
                   std::vector<MotionState>& states, std::vector<ImuBias>& biases) {
  const ImuBias bias = smoother.bias(node);
  const std::size_t n = samples.size();
  std::vector<Step> ahead(n);
  std::vector<Step> back(n);
  ahead.front() = smoother.state(node);
  back.back() = smoother.state(node + 1);
  for (std::size_t k = 1; k < n; ++k) {
    ahead[k] = forwards(ahead[k - 1], samples[k - 1], samples[k], bias);
    back[n - 1 - k] = backwards(back[n - k], samples[n - 1 - k], samples[n - k], bias);
  }
  const double duration = to_seconds(samples.back().utime - samples.front().utime);
  for (std::size_t k = 0; k + 1 < n; ++k) {
    const double u = to_seconds(samples[k].utime - samples.front().utime) / duration;
    const double s = smooth_step(u);
    const double s_rate = smooth_step_rate(u) / duration;
    const Step& a = ahead[k];
    const Step& b = back[k];
    const Eigen::Vector3d turn = (a.R_W_B.inverse() * b.R_W_B).log();
    MotionState state;
    state.T_W_B = {a.R_W_B * SO3::exp(s * turn), (1.0 - s) * a.p_W + s * b.p_W};
    state.v_W = (1.0 - s) * a.v_W + s * b.v_W + s_rate * (b.p_W - a.p_W);
    state.a_W = state.T_W_B.rotation * Eigen::Vector3d(samples[k].accel - bias.accel) + kGravity;
    state.omega_B = samples[k].gyro - bias.gyro + s_rate * turn;
    states.push_back(state);
    biases.push_back(bias);
  }
}

// Between samples: positions on Hermite's cubic through positions and velocities, rotations at constant rate, the rest linear.
MotionState between(const MotionState& a, const MotionState& b, double dt, double u) {
  MotionState state;
  const double u2 = u * u;
  const double u3 = u2 * u;
  state.T_W_B.rotation = interpolate(a.T_W_B.rotation, b.T_W_B.rotation, u);
  state.T_W_B.translation = (2.0 * u3 - 3.0 * u2 + 1.0) * a.T_W_B.translation +
                            (3.0 * u2 - 2.0 * u3) * b.T_W_B.translation +
                            dt * ((u3 - 2.0 * u2 + u) * a.v_W + (u3 - u2) * b.v_W);
  state.v_W = 6.0 * (u - u2) / dt * (b.T_W_B.translation - a.T_W_B.translation) +
              (3.0 * u2 - 4.0 * u + 1.0) * a.v_W + (3.0 * u2 - 2.0 * u) * b.v_W;
  state.a_W = a.a_W + u * (b.a_W - a.a_W);
  state.omega_B = a.omega_B + u * (b.omega_B - a.omega_B);
  return state;
}

Motion motion_of(const std::vector<ImuSample>& samples, std::vector<MotionState> states) {
  std::vector<Utime> utimes;
  utimes.reserve(samples.size());
  for (const ImuSample& sample : samples) utimes.push_back(sample.utime);
  const Utime begin = utimes.front();
  const Utime end = utimes.back();
  return {begin, end, [utimes = std::move(utimes), states = std::move(states)](Utime utime) {
            COVEY_CHECK(utime >= utimes.front() && utime <= utimes.back());
            const auto after = std::lower_bound(utimes.begin(), utimes.end(), utime);
            const auto k = static_cast<std::size_t>(after - utimes.begin());
            if (*after == utime) return states[k];
            const double dt = to_seconds(utimes[k] - utimes[k - 1]);
            return between(states[k - 1], states[k], dt, to_seconds(utime - utimes[k - 1]) / dt);
          }};
}

void measure_truth(const Trajectory& truth, EurocMotion& result) {
  double sum = 0.0;
  int count = 0;
  for (const StampedPose& pose : truth) {
    if (pose.utime < result.motion.begin || pose.utime > result.motion.end) continue;
    sum += (result.motion.at(pose.utime).T_W_B.translation - pose.pose.translation).squaredNorm();
    ++count;
  }
  if (count > 0) result.evidence.truth_rms_m = std::sqrt(sum / count);
}

void measure_misfit(EurocMotion& result) {
  constexpr Utime kSpanUs = 500'000;
  constexpr Utime kEveryUs = 50'000;
  const std::vector<ImuSample>& samples = result.imu.samples;
  std::vector<double> misfits;
  Utime next = result.motion.begin;
  for (std::size_t k = 0; k < samples.size() && samples[k].utime + kSpanUs <= result.motion.end; ++k) {
    if (samples[k].utime < next) continue;
    next = samples[k].utime + kEveryUs;
    const MotionState state = result.motion.at(samples[k].utime);
    Step step{state.T_W_B.translation, state.v_W, state.T_W_B.rotation};
    std::size_t last = k;
    for (; samples[last].utime < samples[k].utime + kSpanUs; ++last)
      step = forwards(step, samples[last], samples[last + 1], result.imu.biases[k]);
    misfits.push_back((step.p_W - result.motion.at(samples[last].utime).T_W_B.translation).norm());
  }
  if (misfits.empty()) return;
  std::sort(misfits.begin(), misfits.end());
  result.evidence.misfit_median_m = misfits[misfits.size() / 2];
  result.evidence.misfit_max_m = misfits.back();
}

}  // namespace

Eigen::Vector3d TiltedPosition::evaluate(const SE3& T_W_B, const Eigen::Vector2d& tilt,
                                         Eigen::Matrix<double, 3, 6>* J_pose,
                                         Eigen::Matrix<double, 3, 2>* J_tilt) const {
  const SO3 R_G_W = tilt_rotation(tilt);
  const Eigen::Vector3d arm = T_W_B.translation - centre;
  if (J_pose) {
    J_pose->setZero();
    J_pose->leftCols<3>() = (R_G_W * T_W_B.rotation).matrix();
    *J_tilt = -R_G_W.matrix() * hat(arm) * tilt_jacobian(tilt);
  }
  return centre + R_G_W * arm - p_G;
}

Eigen::Vector3d TiltedRotation::evaluate(const SE3& T_W_B, const Eigen::Vector2d& tilt,
                                         Eigen::Matrix<double, 3, 6>* J_pose,
                                         Eigen::Matrix<double, 3, 2>* J_tilt) const {
  const Eigen::Vector3d r = (R_G_B.inverse() * tilt_rotation(tilt) * T_W_B.rotation).log();
  if (J_pose) {
    J_pose->setZero();
    J_pose->rightCols<3>() = SO3::right_jacobian_inverse(r);
    *J_tilt = J_pose->rightCols<3>() * T_W_B.rotation.inverse().matrix() * tilt_jacobian(tilt);
  }
  return r;
}

EurocOptions euroc_options(const std::string& sequence, const ImuNoise& imu) {
  EurocOptions options{.imu = imu};
  if (sequence.starts_with("MH")) options.position_sigma_m = 0.005;
  return options;
}

EurocMotion smooth_euroc(const EurocSequence& sequence, Utime from, Utime until,
                         const EurocOptions& options) {
  const auto first = std::lower_bound(sequence.imu.begin(), sequence.imu.end(), from,
                                      [](const ImuSample& sample, Utime t) { return sample.utime < t; });
  const auto last = std::upper_bound(first, sequence.imu.end(), until,
                                     [](Utime t, const ImuSample& sample) { return t < sample.utime; });
  if (last - first < 2 || from < sequence.truth.front().utime || until > sequence.truth.back().utime) {
    throw_input_error("the ground truth and the IMU's record do not cover the time from {:.3f} to {:.3f} s",
                      to_seconds(from), to_seconds(until));
  }
  EurocMotion result;
  result.imu.samples.assign(first, last);
  const std::vector<ImuSample>& samples = result.imu.samples;
  Smoother smoother(samples, sequence.truth, options);
  smoother.solve();

  std::vector<MotionState> states;
  const std::vector<std::size_t>& nodes = smoother.nodes();
  for (std::size_t n = 0; n + 1 < nodes.size(); ++n) {
    append_states(smoother, n, std::span(samples).subspan(nodes[n], nodes[n + 1] - nodes[n] + 1), states,
                  result.imu.biases);
  }
  const ImuBias bias = result.imu.biases.back();
  const Step end = smoother.state(nodes.size() - 1);
  MotionState state{.T_W_B = {end.R_W_B, end.p_W}, .v_W = end.v_W, .a_W = {}, .omega_B = {}};
  state.a_W = end.R_W_B * Eigen::Vector3d(samples.back().accel - bias.accel) + kGravity;
  state.omega_B = samples.back().gyro - bias.gyro;
  states.push_back(state);
  result.imu.biases.push_back(bias);

  result.motion = motion_of(samples, std::move(states));
  result.evidence.tilt_deg = smoother.tilt().norm() / kDegree;
  result.evidence.nodes = static_cast<int>(nodes.size());
  result.evidence.iterations = smoother.iterations();
  measure_truth(sequence.truth, result);
  measure_misfit(result);
  return result;
}

EurocMotion cut(const EurocMotion& whole, Utime from, Utime until, Utime begin) {
  COVEY_CHECK(from >= whole.motion.begin && until <= whole.motion.end && from < until);
  EurocMotion part = whole;
  const Utime earlier = from - begin;
  part.motion = {begin, until - earlier,
                 [at = whole.motion.at, earlier](Utime utime) { return at(utime + earlier); }};
  part.imu = {};
  for (std::size_t k = 0; k < whole.imu.samples.size(); ++k) {
    ImuSample sample = whole.imu.samples[k];
    if (sample.utime < from || sample.utime > until) continue;
    sample.utime -= earlier;
    part.imu.samples.push_back(sample);
    part.imu.biases.push_back(whole.imu.biases[k]);
  }
  return part;
}

Utime take_off(const Trajectory& truth) {
  constexpr double kAwayM = 0.05;
  const auto away = std::find_if(truth.begin(), truth.end(), [&](const StampedPose& pose) {
    return (pose.pose.translation - truth.front().pose.translation).norm() > kAwayM;
  });
  return away == truth.end() ? truth.back().utime : away->utime;
}

}  // namespace covey::sim
