// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/features.h"

namespace covey::place {

FrameFeatures best_of(const FrameFeatures& features, int most) {
  FrameFeatures best;
  best.T_B_C = features.T_B_C;
  best.noise = features.noise;
  for (const bool with_depth : {true, false}) {
    for (std::size_t k = 0; k < features.size(); ++k) {
      if (features.has_depth(k) != with_depth || static_cast<int>(best.size()) >= most) continue;
      best.bearings_C.push_back(features.bearings_C[k]);
      best.depths_m.push_back(features.depths_m[k]);
      best.descriptors.push_back(features.descriptors[k]);
    }
  }
  return best;
}

}  // namespace covey::place
