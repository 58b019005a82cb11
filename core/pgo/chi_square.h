// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace covey::pgo {

// The x below which a chi-square variable of 3 or 6 degrees of freedom lies with the given probability in (0,
// 1). A pose residual has 3 degrees of freedom in 2D and 6 in 3D.
double chi_square_quantile(double probability, int degrees_of_freedom);

inline int pose_degrees_of_freedom(int dimension) { return dimension == 2 ? 3 : 6; }

}  // namespace covey::pgo
