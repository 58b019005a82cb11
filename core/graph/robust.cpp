// SPDX-License-Identifier: BSD-3-Clause
#include "core/graph/robust.h"

#include <cmath>

namespace covey::graph {

double Robust::cost(double squared) const {
  const double w2 = width * width;
  if (kind == Kind::kCauchy) return w2 * std::log1p(squared / w2);
  if (kind == Kind::kHuber && squared > w2) return 2.0 * width * std::sqrt(squared) - w2;
  return squared;
}

double Robust::derivative(double squared) const {
  const double w2 = width * width;
  if (kind == Kind::kCauchy) return w2 / (w2 + squared);
  if (kind == Kind::kHuber && squared > w2) return width / std::sqrt(squared);
  return 1.0;
}

double Robust::second_derivative(double squared) const {
  const double w2 = width * width;
  if (kind == Kind::kCauchy) return -w2 / ((w2 + squared) * (w2 + squared));
  if (kind == Kind::kHuber && squared > w2) return -0.5 * width / (squared * std::sqrt(squared));
  return 0.0;
}

}  // namespace covey::graph
