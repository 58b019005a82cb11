// SPDX-License-Identifier: BSD-3-Clause
#include "core/sim/contacts.h"

#include <algorithm>

#include "core/base/error.h"

namespace covey::sim {
namespace {

constexpr double kForEverS = 1e6;

bool hear_each_other(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                     const std::vector<Eigen::AlignedBox3d>& buildings_W, const ContactOptions& options) {
  const double distance = (a - b).norm();
  if (distance > options.range_m) return false;
  if (distance <= options.range_behind_m) return true;
  return std::none_of(buildings_W.begin(), buildings_W.end(),
                      [&](const Eigen::AlignedBox3d& box) { return is_between(box, a, b); });
}

}  // namespace

bool is_between(const Eigen::AlignedBox3d& box, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  double enter = 0.0;
  double leave = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double step = b[axis] - a[axis];
    if (step == 0.0) {
      if (a[axis] < box.min()[axis] || a[axis] > box.max()[axis]) return false;
      continue;
    }
    const double to_min = (box.min()[axis] - a[axis]) / step;
    const double to_max = (box.max()[axis] - a[axis]) / step;
    enter = std::max(enter, std::min(to_min, to_max));
    leave = std::min(leave, std::max(to_min, to_max));
  }
  return enter <= leave;
}

std::vector<radio::Contact> find_contacts(const std::vector<Motion>& motions,
                                          const std::vector<Eigen::AlignedBox3d>& buildings_W,
                                          const ContactOptions& options) {
  std::vector<radio::Contact> contacts;
  const Eigen::Vector3d antenna(0.0, 0.0, options.antenna_m);
  for (int a = 0; a < static_cast<int>(motions.size()); ++a) {
    for (int b = a + 1; b < static_cast<int>(motions.size()); ++b) {
      COVEY_CHECK(motions[a].begin == motions[b].begin && motions[a].end == motions[b].end);
      const Utime begin = motions[a].begin;
      const double end_s = to_seconds(motions[a].end - begin);
      bool in_contact = false;
      double since_s = 0.0;
      for (Utime t = begin; t <= motions[a].end; t += from_seconds(options.step_s)) {
        const bool heard =
            hear_each_other(motions[a].at(t).T_W_B.translation + antenna,
                            motions[b].at(t).T_W_B.translation + antenna, buildings_W, options);
        if (heard && !in_contact) since_s = to_seconds(t - begin);
        if (!heard && in_contact) contacts.push_back({a, b, since_s, to_seconds(t - begin)});
        in_contact = heard;
      }
      contacts.push_back({a, b, in_contact ? since_s : end_s, kForEverS});
    }
  }
  return contacts;
}

std::string format_contacts(const std::vector<radio::Contact>& contacts) {
  std::string text =
      "# Who hears whom, by range and line of sight; at the end of the run the team comes together.\n"
      "# Seconds count from epoch_utime (us), the same for all bridges.\n"
      "radio_bridge:\n";
  text += contacts.empty() ? "  contacts: []\n" : "  contacts:\n";
  for (const radio::Contact& contact : contacts) {
    text += fmt::format("    - {{a: {}, b: {}, from_s: {}, until_s: {}}}\n", contact.a, contact.b,
                        contact.from_s, contact.until_s);
  }
  return text;
}

}  // namespace covey::sim
