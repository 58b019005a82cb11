// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/features.h"

namespace covey::place {

FrameFeatures best_of(const FrameFeatures& features, int most, int known) {
  FrameFeatures best;
  int next = 0;
  best.T_B_C = features.T_B_C;
  best.noise = features.noise;
  for (const bool with_depth : {true, false}) {
    for (std::size_t k = 0; k < features.size(); ++k) {
      if (features.has_depth(k) != with_depth) continue;
      const int rank = next++;
      if (rank < known || rank >= most) continue;
      best.bearings_C.push_back(features.bearings_C[k]);
      best.depths_m.push_back(features.depths_m[k]);
      best.descriptors.push_back(features.descriptors[k]);
    }
  }
  return best;
}

}  // namespace covey::place
