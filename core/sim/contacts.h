// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// Which robots' radios hear each other while they move: within range_m in the open, within range_behind_m where a building stands between
// the two. The plan is of the form that the radio's simulation reads (core/radio/link_model.h), seconds from the beginning. When the
// motions end the team comes together: from then on everyone hears everyone, so that what was found last can still be shared.

#include <Eigen/Geometry>
#include <string>
#include <vector>

#include "core/radio/link_model.h"
#include "core/sim/motion.h"

namespace covey::sim {

struct ContactOptions {
  double range_m = 60.0;
  double range_behind_m = 20.0;
  double antenna_m = 0.5;  // above the body
  double step_s = 0.25;
};

// Of robots 0 ... n - 1, whose motions cover the same time; in order of pairs, then of time.
std::vector<radio::Contact> find_contacts(const std::vector<Motion>& motions,
                                          const std::vector<Eigen::AlignedBox3d>& buildings_W,
                                          const ContactOptions& options = {});

// A file for `radio_bridge --config`.
std::string format_contacts(const std::vector<radio::Contact>& contacts);

// Whether the straight line from a to b passes through the box.
bool is_between(const Eigen::AlignedBox3d& box, const Eigen::Vector3d& a, const Eigen::Vector3d& b);

}  // namespace covey::sim
