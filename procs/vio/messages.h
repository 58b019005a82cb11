// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <covey/imu_t.hpp>
#include <covey/keyframe_t.hpp>
#include <covey/odometry_t.hpp>
#include <covey/state_t.hpp>
#include <covey/stereo_t.hpp>
#include <optional>

#include "core/vio/external_odometry.h"
#include "core/vio/output.h"
#include "core/vision/stereo_front_end.h"

namespace covey {

ImuSample sample_from(const imu_t& message);
// A view: it lives as long as the message.
StereoPictures pictures_from(const stereo_t& message);
// Nothing where a value is not finite or the quaternion is zero.
std::optional<vio::OdometryPose> odometry_from(const odometry_t& message);

state_t to_message(const vio::VioState& state, int robot);
keyframe_t to_message(const vio::VioKeyframe& keyframe, int robot);

}  // namespace covey
