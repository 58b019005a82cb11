// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Dead reckoning: a state and what is known about it, moved by IMU samples.
//
// Errors of a state are [rho; phi; v; b_g; b_a]: T_W_B Exp([rho; phi]), the others added (m, rad, m/s, rad/s, m/s^2).

#include "core/imu/preintegration.h"

namespace covey {

// Samples in order of time, the first at the state's time.
NavState propagate(const NavState& state, const ImuNoise& noise, std::span<const ImuSample> samples,
                   const Eigen::Vector3d& gravity = kGravity);

// The covariance at t_j of Preintegration::predict(state), from the one at t_i.
Matrix15d propagate_covariance(const NavState& state, const Matrix15d& covariance,
                               const Preintegration& increment);

}  // namespace covey
