// SPDX-License-Identifier: BSD-3-Clause
#include "core/place/point_spread.h"

#include <Eigen/Eigenvalues>
#include <cmath>

namespace covey::place {
namespace {

template <int kDim>
class Cloud {
 public:
  using Vector = Eigen::Matrix<double, kDim, 1>;

  void add(const Vector& p) {
    ++n_;
    sum_ += p;
    squares_ += p * p.transpose();
  }
  int size() const { return n_; }
  Vector mean() const { return sum_ / n_; }
  // Along the axes, ascending.
  Vector deviations() const {
    const Vector m = mean();
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, kDim, kDim>> eigen(squares_ / n_ -
                                                                                 m * m.transpose());
    return eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt();
  }

 private:
  int n_ = 0;
  Vector sum_ = Vector::Zero();
  Eigen::Matrix<double, kDim, kDim> squares_ = Eigen::Matrix<double, kDim, kDim>::Zero();
};

}  // namespace

PointSpread spread_of(const FrameFeatures& c, const FrameFeatures& d,
                      const std::vector<std::pair<int, int>>& pairs, const SE3& T_C_D) {
  PointSpread spread;
  if (pairs.empty()) return spread;
  Cloud<2> in_c;
  Cloud<2> in_d;
  Cloud<3> points_C;
  double distances = 0.0;
  for (const auto& [first, second] : pairs) {
    const auto i = static_cast<std::size_t>(first);
    const auto j = static_cast<std::size_t>(second);
    in_c.add(c.direction(i));
    in_d.add(d.direction(j));
    if (!c.has_depth(i) && !d.has_depth(j)) continue;
    const Eigen::Vector3d p_C = c.has_depth(i) ? c.point(i) : Eigen::Vector3d(T_C_D * d.point(j));
    points_C.add(p_C);
    distances += p_C.norm();
  }
  const Eigen::Vector2d of_c = in_c.deviations();
  const Eigen::Vector2d of_d = in_d.deviations();
  const Eigen::Vector2d& narrow = of_c(0) < of_d(0) ? of_c : of_d;
  spread.across = narrow(0);
  spread.along = narrow(1);
  if (points_C.size() >= 3) spread.thickness = points_C.deviations()(0) * points_C.size() / distances;
  return spread;
}

}  // namespace covey::place
