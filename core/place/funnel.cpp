// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/funnel.h"

namespace covey::place {

Funnel::Counts Funnel::total() const {
  Counts total;
  for (const auto& [robot, counts] : counts_) {
    for (const auto& [step, n] : counts) total[step] += n;
  }
  return total;
}

}  // namespace covey::place
