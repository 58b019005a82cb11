// SPDX-License-Identifier: BSD-3-Clause
#pragma once

// The scalar functions of the angle that exp, log and their Jacobians are made of. Each is smooth and even,
// so it is a power series in x = angle^2 that replaces the closed form where that would cancel. The switch at
// angle = 0.5 leaves both sides an error of about 1e-14.

#include <cmath>

namespace covey::rotation_series {

constexpr double kSwitch = 0.25;  // of the squared angle

// sin(a) / a
inline double sinc(double x) {
  if (x < kSwitch)
    return 1.0 - x / 6.0 * (1.0 - x / 20.0 * (1.0 - x / 42.0 * (1.0 - x / 72.0 * (1.0 - x / 110.0))));
  const double angle = std::sqrt(x);
  return std::sin(angle) / angle;
}

// (1 - cos a) / a^2
inline double one_minus_cos(double x) {
  const double half = sinc(0.25 * x);
  return 0.5 * half * half;
}

// (a - sin a) / a^3
inline double a_minus_sin(double x) {
  if (x < kSwitch) {
    return 1.0 / 6.0 * (1.0 - x / 20.0 * (1.0 - x / 42.0 * (1.0 - x / 72.0 * (1.0 - x / 110.0))));
  }
  const double angle = std::sqrt(x);
  return (angle - std::sin(angle)) / (x * angle);
}

// (a^2 / 2 + cos a - 1) / a^4
inline double half_square_plus_cos(double x) {
  if (x < kSwitch) {
    return 1.0 / 24.0 * (1.0 - x / 30.0 * (1.0 - x / 56.0 * (1.0 - x / 90.0 * (1.0 - x / 132.0))));
  }
  return (0.5 * x + std::cos(std::sqrt(x)) - 1.0) / (x * x);
}

// (2 a - 3 sin a + a cos a) / (2 a^5)
inline double fifth_order(double x) {
  if (x < kSwitch) {
    return 1.0 / 120.0 +
           x * (-1.0 / 2520.0 + x * (1.0 / 120960.0 + x * (-1.0 / 9979200.0 + x / 1245404160.0)));
  }
  const double angle = std::sqrt(x);
  return (2.0 * angle - 3.0 * std::sin(angle) + angle * std::cos(angle)) / (2.0 * x * x * angle);
}

// (1 - (a / 2) cot(a / 2)) / a^2, finite up to a < 2 pi
inline double one_minus_half_cot(double x) {
  if (x < kSwitch) {
    return 1.0 / 12.0 + x * (1.0 / 720.0 + x * (1.0 / 30240.0 + x * (1.0 / 1209600.0 + x / 47900160.0)));
  }
  const double half = 0.5 * std::sqrt(x);
  return (1.0 - half / std::tan(half)) / x;
}

}  // namespace covey::rotation_series
