// SPDX-License-Identifier: BSD-3-Clause
#include "core/eval/drift.h"

#include <algorithm>
#include <cmath>

namespace covey {

Drift odometry_drift(const TrajectoryPair& pair, const DriftOptions& options) {
  std::vector<SE3> T_O;
  std::vector<SE3> T_W;
  std::vector<double> way_m;
  for (const auto& [i, j] :
       match_stamps(pair.estimate, pair.reference, options.stamps.max_stamp_difference_s)) {
    T_O.push_back(pair.estimate[static_cast<std::size_t>(i)].pose);
    T_W.push_back(pair.reference[static_cast<std::size_t>(j)].pose);
    const auto last = T_W.size() - 1;
    way_m.push_back(last == 0 ? 0.0
                              : way_m.back() + (T_W[last].translation - T_W[last - 1].translation).norm());
  }
  Drift drift;
  for (const double length : options.lengths_m) {
    for (std::size_t i = 0; i < T_W.size(); i += static_cast<std::size_t>(options.every)) {
      const auto end = std::lower_bound(way_m.begin(), way_m.end(), way_m[i] + length);
      if (end == way_m.end()) break;
      const auto j = static_cast<std::size_t>(end - way_m.begin());
      const SE3 error = (T_W[i].inverse() * T_W[j]).inverse() * (T_O[i].inverse() * T_O[j]);
      const double walked = way_m[j] - way_m[i];
      drift.translation_percent += 100.0 * error.translation.norm() / walked;
      drift.rotation_deg_per_m += error.rotation.log().norm() * 180.0 / M_PI / walked;
      ++drift.stretches;
    }
  }
  if (drift.stretches > 0) {
    drift.translation_percent /= drift.stretches;
    drift.rotation_deg_per_m /= drift.stretches;
  }
  return drift;
}

}  // namespace covey
