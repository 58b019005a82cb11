// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// A uniform quintic B-spline in time, four times continuously differentiable. Control point k acts around begin + (k - 2) spacing; the
// spline is defined from begin to begin + (n - 5) spacing. Its derivatives are splines of lower degree of the control points' differences
// (de Boor, "A Practical Guide to Splines", 1978), so they are exact.

#include <Eigen/Core>
#include <array>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "core/base/time.h"

namespace covey::sim {

// The kDegree + 1 basis functions that are not zero on a segment, at u in [0, 1] of it, by the recurrence of Cox and de Boor.
template <int kDegree>
Eigen::Matrix<double, kDegree + 1, 1> spline_basis(double u) {
  Eigen::Matrix<double, kDegree + 1, 1> basis = Eigen::Matrix<double, kDegree + 1, 1>::Zero();
  basis[0] = 1.0;
  for (int p = 1; p <= kDegree; ++p) {
    for (int j = p; j >= 0; --j) {
      const double from_left = j > 0 ? (u + p - j) / p * basis[j - 1] : 0.0;
      const double from_right = j < p ? (j + 1 - u) / p * basis[j] : 0.0;
      basis[j] = from_left + from_right;
    }
  }
  return basis;
}

template <int kSize>
class UniformSpline {
 public:
  using Point = Eigen::Matrix<double, kSize, 1>;
  struct Sample {
    Point value;
    Point rate;          // 1 / s
    Point acceleration;  // 1 / s^2
  };

  UniformSpline(Utime begin, Utime spacing_us, std::vector<Point> control)
      : begin_(begin), spacing_us_(spacing_us), control_(std::move(control)) {
    COVEY_CHECK(spacing_us > 0 && control_.size() >= 6);
  }

  Utime begin() const { return begin_; }
  Utime end() const { return begin_ + (static_cast<Utime>(control_.size()) - 5) * spacing_us_; }

  Sample at(Utime utime) const {
    COVEY_CHECK(utime >= begin() && utime <= end());
    const auto last = static_cast<Utime>(control_.size()) - 6;
    const Utime segment = std::min((utime - begin_) / spacing_us_, last);
    const double u =
        static_cast<double>(utime - begin_ - segment * spacing_us_) / static_cast<double>(spacing_us_);
    const double h = to_seconds(spacing_us_);
    std::array<Point, 6> c;
    for (int k = 0; k < 6; ++k) c[k] = control_[segment + k];
    Sample sample;
    sample.value = combine<5>(c, u);
    for (int k = 0; k < 5; ++k) c[k] = (c[k + 1] - c[k]) / h;
    sample.rate = combine<4>(c, u);
    for (int k = 0; k < 4; ++k) c[k] = (c[k + 1] - c[k]) / h;
    sample.acceleration = combine<3>(c, u);
    return sample;
  }

 private:
  template <int kDegree>
  static Point combine(const std::array<Point, 6>& c, double u) {
    const auto basis = spline_basis<kDegree>(u);
    Point sum = basis[0] * c[0];
    for (int k = 1; k <= kDegree; ++k) sum += basis[k] * c[k];
    return sum;
  }

  Utime begin_;
  Utime spacing_us_;
  std::vector<Point> control_;
};

}  // namespace covey::sim
